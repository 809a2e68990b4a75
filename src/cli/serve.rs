//! `serve`: the model of a study for programs in other languages.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use super::log::Event;
use super::process::Process;
use super::terminal::{Bar, print};
use clap::Args;
use microslip::Error;
use microslip::ensemble::runner::MOST_ANCHORS;
use microslip::serve::{MODEL, Server};
use microslip::study::{EvaluationError, Evaluator, Study};
use serde_json::json;

/// From the wish to end to the end of the process: time for points that are nearly solved.
const GRACE: Duration = Duration::from_secs(4);

#[derive(Args)]
pub(super) struct ServeArguments {
    /// The study file.
    study: PathBuf,
    /// Port where clients ask; 0 takes a free one.
    #[arg(long, default_value_t = 4242)]
    port: u16,
    /// Address where clients ask. The protocol has no passwords: with another than the machine's own anybody there can ask.
    #[arg(long, value_name = "ADDRESS", default_value_t = Ipv4Addr::LOCALHOST.into())]
    bind: IpAddr,
    /// Samples of the study, the first so many, that every search starts from.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(0..=MOST_ANCHORS))]
    anchors: u64,
    /// Take these samples from the results of a run of this study, in place of solving them first.
    #[arg(long, value_name = "FOLDER")]
    results: Option<PathBuf>,
    #[command(flatten)]
    pub process: Process,
}

impl ServeArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        self.process.threads.start()?;
        let study = Study::read(&self.study)?;
        self.process.messages.log.warn(&study.warnings);
        let server = Server::bind(SocketAddr::new(self.bind, self.port))?;
        let ending = server.ending();
        let handled = ctrlc::set_handler(move || {
            ending.end();
            std::thread::sleep(GRACE);
            std::process::exit(0);
        });
        handled.map_err(|error| Error::Threads(format!("signals cannot be taken: {error}")))?;
        if let Some(model) = self.model(study, &server)? {
            self.say(&server, &model)?;
            server.run(&model);
        }
        self.process.messages.log.write(&Event::Finished(json!({
            "study": self.study.display().to_string(),
        })));
        Ok(())
    }

    /// The model; nothing if the server is told to end before it is there.
    fn model(&self, study: Study, server: &Server) -> Result<Option<Evaluator<'static>>, Error> {
        let prepared = study.into_prepared()?;
        if let Some(folder) = &self.results {
            return Evaluator::stored(prepared, folder, self.anchors).map(Some);
        }
        let bar = Bar::new(&self.process.messages);
        let ending = server.ending();
        let stop = ending.stop();
        let solved = Evaluator::solved(prepared, self.anchors, stop, |done| bar.show(done));
        bar.clear();
        match solved {
            Ok(model) => Ok(Some(model)),
            Err(EvaluationError::Stopped) => Ok(None),
            Err(error) => Err(Error::Threads(error.to_string())),
        }
    }

    fn say(&self, server: &Server, model: &Evaluator<'_>) -> Result<(), Error> {
        let (names, levels) = (model.input_names(), model.levels());
        let url = format!("http://{}", server.address());
        self.process.messages.log.write(&Event::Started(json!({
            "url": url, "model": MODEL, "inputs": names, "levels": levels,
        })));
        if self.process.messages.quiet {
            return Ok(());
        }
        let levels: Vec<_> = levels.iter().map(f64::to_string).collect();
        let levels = levels.join(", ");
        // at once: a reader may be content with the first line
        let text = format!(
            "model {MODEL:?} of {} at {url}\n   input   {}\n   output  frequency (Hz), amplitude (m) at level {levels}\n",
            self.study.display(),
            names.join(", "),
        );
        print(|out| out.write_all(text.as_bytes()))
    }
}
