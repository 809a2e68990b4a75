//! `run`: all samples, statistics and report.

use std::io::Write;
use std::path::Path;

use super::device_layer;
use super::disk::gather;
use super::levels::{show_profile, show_result};
use super::log::Event;
use super::run_control::RunControl;
use super::shares::{Shares, Work, local_rank};
use super::study_arguments::StudyArguments;
use super::terminal::{Bar, print};
use clap::Args;
use microslip::Error;
use microslip::ensemble::backend::{BackendChoice, BackendSettings};
use microslip::gpu::GpuSettings;
use microslip::report::Summary;
use microslip::report::run::order_folder;
use microslip::study::{
    OutputFolder, RunSettings, ShareResult, Study, check_band, check_folder, join, run, solve_share,
};
use serde_json::json;

#[derive(Args)]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub study: StudyArguments,
    /// Whether a GPU improves the predicted peaks. `auto` takes what is faster: at present always the processor alone.
    #[arg(long, value_enum, default_value = "cpu")]
    backend: BackendName,
    /// Adapter of the GPU: index, PCI address or part of its name, as `devices` lists them. One that is software must be
    /// named. Where several fit, processes that Slurm or MPI start on one node take one each.
    #[arg(long)]
    adapter: Option<String>,
    /// Share of the GPU's peaks that the processor searches again without it.
    #[arg(long, default_value_t = 0.01, value_parser = share)]
    audit: f64,
    /// Show at the end where the time went.
    #[arg(long)]
    profile: bool,
    /// Solve those samples again that an earlier process left without a solution.
    #[arg(long)]
    retry_failed: bool,
    #[command(flatten)]
    control: RunControl,
    #[command(flatten)]
    shares: Shares,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum BackendName {
    Cpu,
    Gpu,
    Auto,
}

impl RunArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let Self { study: common, .. } = self;
        if !matches!(self.backend, BackendName::Cpu) {
            device_layer::leave_out();
        }
        common.threads.start()?;
        let study = Study::read(&common.study)?;
        let messages = &common.messages;
        messages.log.warn(&study.warnings);
        let folder = common.output_folder(&study)?;
        messages.log.write(&Event::Started(json!({
            "study": common.study.display().to_string(),
            "folder": folder.path().display().to_string(),
            "version": env!("CARGO_PKG_VERSION"),
            "process": std::process::id(),
        })));
        let settings = RunSettings {
            backend: self.backend(),
            retry_failed: self.retry_failed,
            ..self.control.settings(folder.path(), messages.log)?
        };
        let Some(orders) = study.several_engine_orders() else {
            self.check(&study, &folder, &settings)?;
            return self.one(&study, &folder, &settings).map(|_| ());
        };
        let of_order = |&order: &u32| {
            let own = folder.path().join(order_folder(order));
            let (study, folder) = (study.of_engine_order(order)?, OutputFolder::open(&own)?);
            // the last order is not to be refused after hours for the others
            self.check(&study, &folder, &settings)?;
            check_band(&study)?;
            Ok((study, folder))
        };
        let studies: Vec<_> = orders.iter().map(of_order).collect::<Result<_, Error>>()?;
        let mut solved = Vec::new();
        for (study, folder) in &studies {
            if self.one(study, folder, &settings)? {
                solved.push(folder.path());
            }
        }
        // shares of the samples make no results yet
        if solved.len() < orders.len() {
            return Ok(());
        }
        gather(&solved, &folder, messages.quiet)
    }

    /// Refuses a folder, and warns of what will be replaced in it, before anything is solved.
    fn check(
        &self,
        study: &Study,
        folder: &OutputFolder,
        settings: &RunSettings,
    ) -> Result<(), Error> {
        let warnings = check_folder(study, folder, settings)?;
        // a share replaces nothing yet
        if !matches!(self.shares.work()?, Work::Share(_)) {
            self.study.messages.log.warn(&warnings);
        }
        Ok(())
    }

    /// One study; whether its results are there.
    fn one(
        &self,
        study: &Study,
        folder: &OutputFolder,
        settings: &RunSettings,
    ) -> Result<bool, Error> {
        let messages = &self.study.messages;
        let bar = Bar::new(messages);
        let progress = |progress| bar.show(progress);
        let result = match self.shares.work()? {
            Work::Alone => run(study, folder, settings, progress)?,
            Work::Together(rank) => join(study, folder, rank, settings, progress)?,
            Work::Share(share) => {
                let kept = solve_share(study, folder, share, settings, progress)?;
                bar.clear();
                self.show_share(&kept, folder.path())?;
                return Ok(false);
            }
        };
        bar.clear();
        show_result(&result, folder.path(), messages)?;
        if !messages.quiet {
            print(|out| {
                show_gpu(out, &result.summary)?;
                match self.profile {
                    true => show_profile(out, &result.profile),
                    false => Ok(()),
                }
            })?;
        }
        Ok(true)
    }

    fn show_share(&self, share: &ShareResult, folder: &Path) -> Result<(), Error> {
        self.study.messages.log.warn(&share.notes);
        self.study.messages.log.write(&Event::Finished(json!({
            "folder": folder.display().to_string(),
            "samples": share.samples,
            "taken_over": share.taken_over,
        })));
        if self.study.messages.quiet {
            return Ok(());
        }
        let (samples, of, before) = (share.samples, share.of, share.taken_over);
        let parts = folder.join("parts");
        print(|out| {
            writeln!(
                out,
                "{samples} of {of} samples, {before} of them solved before, are kept in {}; once all shares are solved `merge`, or `run` without a share, writes the results",
                parts.display()
            )
        })
    }

    fn backend(&self) -> BackendSettings {
        BackendSettings {
            choice: match self.backend {
                BackendName::Cpu => BackendChoice::Cpu,
                BackendName::Gpu => BackendChoice::Gpu,
                BackendName::Auto => BackendChoice::Auto,
            },
            gpu: GpuSettings {
                adapter: self.adapter.clone(),
                local_rank: local_rank(),
                audit: self.audit,
                ..GpuSettings::default()
            },
        }
    }
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("must be from 0 to 1".to_owned()),
    }
}

/// What the GPU did.
fn show_gpu(out: &mut dyn Write, summary: &Summary) -> std::io::Result<()> {
    let Some(gpu) = &summary.backend.gpu else {
        return Ok(());
    };
    writeln!(
        out,
        "{}: {} of {} predicted peaks improved, {} searched again without it, largest differences {:.1e} of a frequency and {:.1e} of an amplitude",
        gpu.adapter.name,
        gpu.lanes - gpu.lanes_lost,
        gpu.lanes,
        gpu.peaks_compared,
        gpu.largest_frequency_difference,
        gpu.largest_amplitude_difference
    )
}
