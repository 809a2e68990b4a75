//! How a run ends early, and what it takes over from an earlier one.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::STOPPED;
use super::log::{Event, Log};
use clap::Args;
use microslip::Error;
use microslip::ensemble::parts::PartFolder;
use microslip::ensemble::stop::Stop;
use microslip::study::{RunSettings, order_folders};

/// From the wish to stop to the end of the process: time for samples that are nearly solved, and for the last part.
const GRACE: Duration = Duration::from_secs(4);

#[derive(Args)]
pub(super) struct RunControl {
    /// Stop after this time, such as 23h or 90min: what is solved is kept, and the same command goes on.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    stop_after: Option<Duration>,
    /// How often what is solved is written to the disk.
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = humantime::parse_duration)]
    flush_every: Duration,
    /// Take over samples of another version of the program or another instruction set; the report names it.
    #[arg(long)]
    any_program: bool,
}

impl RunControl {
    /// The settings of a run in `folder` that ends on a signal or after the time asked for.
    pub(super) fn settings(&self, folder: &Path, log: Log) -> Result<RunSettings, Error> {
        let stop = Stop::default();
        let ending = Ending {
            stop: stop.clone(),
            folder: folder.to_owned(),
            log,
        };
        if let Some(time) = self.stop_after {
            let ending = ending.clone();
            std::thread::spawn(move || {
                std::thread::sleep(time);
                ending.end();
            });
        }
        let handled = ctrlc::set_handler(move || ending.end());
        handled.map_err(|error| Error::Threads(format!("signals cannot be taken: {error}")))?;
        Ok(RunSettings {
            stop,
            flush_every: self.flush_every,
            any_program: self.any_program,
            ..RunSettings::default()
        })
    }
}

/// What ends the process.
#[derive(Clone)]
struct Ending {
    stop: Stop,
    folder: PathBuf,
    log: Log,
}

impl Ending {
    /// Asks the run to stop, and ends the process where a sample does not end in time. Samples that are solved are written at
    /// once from the first moment on.
    fn end(&self) {
        self.stop.ask();
        std::thread::sleep(GRACE);
        let message = match keeps_samples(&self.folder) {
            true => format!(
                "stopped in the middle of samples; all others are kept in {}, and the same command goes on",
                self.folder.display()
            ),
            false => "stopped before a sample was solved: the same command begins anew".to_owned(),
        };
        self.log.write(&Event::Stopped(&message));
        std::process::exit(i32::from(STOPPED));
    }
}

/// Whether the folder of a run, or that of one of its engine orders, holds parts.
fn keeps_samples(folder: &Path) -> bool {
    let orders = order_folders(folder).unwrap_or_default();
    let has_parts = |folder: &Path| {
        let parts = PartFolder::of(folder).tables();
        parts.is_ok_and(|tables| !tables.is_empty())
    };
    has_parts(folder) || orders.iter().any(|order| has_parts(order))
}

/// Ends the process on a signal, as a run ends: for commands that keep nothing on the way. Where signals cannot be taken they end it
/// in their own way.
pub(super) fn end_on_signal(log: Log) {
    let _ = ctrlc::set_handler(move || {
        let message =
            "stopped before the end: what was computed is lost, and the same command begins anew";
        log.write(&Event::Stopped(message));
        std::process::exit(i32::from(STOPPED));
    });
}
