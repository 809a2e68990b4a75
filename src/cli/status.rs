//! `status`: what a result folder holds. `verify`: whether it is what was written.

use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::study::{FolderStatus, RunStatus};

#[derive(Args)]
pub(super) struct StatusArguments {
    /// Folder of the results of a run.
    folder: PathBuf,
}

impl StatusArguments {
    pub(super) fn status(&self) -> Result<(), Error> {
        let status = FolderStatus::of(&self.folder)?;
        print(|out| {
            if let Some(run) = &status.results {
                show(out, "whole results", run)?;
            }
            if let Some(run) = &status.unfinished {
                show(out, "unfinished", run)?;
                let study = run.study_file.display();
                writeln!(out, "the command that began it goes on; its study: {study}")?;
            }
            if status.results.is_none() && status.unfinished.is_none() {
                writeln!(out, "no samples")?;
            }
            for fault in &status.faults {
                writeln!(out, "fault: {fault}")?;
            }
            Ok(())
        })
    }

    pub(super) fn verify(&self) -> Result<(), Error> {
        let status = FolderStatus::of(&self.folder)?;
        if let Some(fault) = status.faults.first() {
            let more = match status.faults.len() {
                1 => String::new(),
                n => format!(" (and {} more faults: `microslip status`)", n - 1),
            };
            return Err(Error::Results {
                folder: self.folder.clone(),
                message: format!("{fault}{more}"),
            });
        }
        if status.results.is_none() && status.unfinished.is_none() {
            return Err(Error::Results {
                folder: self.folder.clone(),
                message: "holds no results and no parts of `run`".to_owned(),
            });
        }
        print(|out| {
            let parts = status.unfinished.map_or(0, |run| run.parts);
            let results = match status.results {
                Some(run) => format!("the results of {} samples", run.done),
                None => "no whole results".to_owned(),
            };
            writeln!(
                out,
                "every file is what was written: {results}, {parts} parts"
            )
        })
    }
}

fn show(out: &mut dyn Write, what: &str, run: &RunStatus) -> std::io::Result<()> {
    let program = run.identity.program.in_words();
    let (done, samples, failed) = (run.done, run.samples, run.failed);
    write!(
        out,
        "{what}: {done} of {samples} samples, {failed} without a solution at every level"
    )?;
    if run.parts > 0 {
        write!(out, ", in {} parts", run.parts)?;
    }
    let age = |time: SystemTime| time.elapsed().unwrap_or(Duration::ZERO).as_secs();
    if let Some(newest) = run.newest {
        let age = humantime::format_duration(Duration::from_secs(age(newest)));
        write!(out, ", the newest written {age} ago")?;
    }
    writeln!(out, ", by {program}")?;
    if !run.missing.is_empty() {
        writeln!(out, "missing: {}", run.missing_in_words())?;
    }
    Ok(())
}
