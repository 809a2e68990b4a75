//! `status`: what a result folder holds. `verify`: whether it is what was written.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::report::disk::{DISK_NUMBERS, order_faults};
use microslip::report::outdated;
use microslip::study::{FolderStatus, RunStatus, order_folders};
use microslip::units::count;

#[derive(Args)]
pub(super) struct StatusArguments {
    /// Folder of the results of a run.
    folder: PathBuf,
}

impl StatusArguments {
    pub(super) fn status(&self) -> Result<(), Error> {
        let found = self.read()?;
        let of_orders = self.order_faults()?;
        print(|out| {
            for (folder, status) in &found {
                if !self.is_alone(&found) {
                    writeln!(out, "{}:", folder.display())?;
                }
                show_folder(out, status)?;
            }
            for fault in &of_orders {
                writeln!(out, "fault: {fault}")?;
            }
            match self.lacks_page(&found) {
                true => writeln!(
                    out,
                    "{DISK_NUMBERS} does not exist: `run` has not come to the last engine order, or `disk` has not put these together"
                ),
                false => Ok(()),
            }
        })
    }

    /// Whether there are engine orders of a disk, and nothing that was made of all of them.
    fn lacks_page(&self, found: &[(PathBuf, FolderStatus)]) -> bool {
        !self.is_alone(found) && !self.folder.join(DISK_NUMBERS).exists()
    }

    pub(super) fn verify(&self) -> Result<(), Error> {
        let found = self.read()?;
        let of_orders = self.order_faults()?.into_iter();
        let of_orders = of_orders.map(|fault| Error::results(&self.folder, fault));
        let mut refused: Vec<Error> = of_orders.collect();
        print(|out| {
            for (folder, status) in &found {
                match whole(folder, status) {
                    Ok(words) if !self.is_alone(&found) => {
                        writeln!(out, "{}: {words}", folder.display())?
                    }
                    Ok(words) => writeln!(out, "{words}")?,
                    Err(error) => refused.push(error),
                }
            }
            Ok(())
        })?;
        match refused.len() {
            0 | 1 => refused.pop().map_or(Ok(()), Err),
            n => Err(Error::results(
                &self.folder,
                format!("{n} faults: {}", in_words(&refused)),
            )),
        }
    }

    /// What is wrong with the folders of engine orders beside what each holds.
    fn order_faults(&self) -> Result<Vec<String>, Error> {
        let orders = order_folders(&self.folder)?;
        Ok(order_faults(&self.folder, &orders)?)
    }

    /// Whether what was found is all in the folder itself, which need not be named then.
    fn is_alone(&self, found: &[(PathBuf, FolderStatus)]) -> bool {
        found.iter().all(|(folder, _)| *folder == self.folder)
    }

    /// What the folder holds, and each folder of an engine order in it; the folder itself is left out where it holds these alone.
    fn read(&self) -> Result<Vec<(PathBuf, FolderStatus)>, Error> {
        let own = FolderStatus::of(&self.folder)?;
        let mut found = vec![(self.folder.clone(), own)];
        for folder in order_folders(&self.folder)? {
            let status = FolderStatus::of(&folder)?;
            found.push((folder, status));
        }
        if found.len() > 1 && found[0].1.is_empty() {
            found.remove(0);
        }
        Ok(found)
    }
}

fn in_words(errors: &[Error]) -> String {
    let words: Vec<String> = errors.iter().map(Error::to_string).collect();
    words.join("; ")
}

/// What `verify` says of a folder in which tables, parts and report are what was written.
fn whole(folder: &Path, status: &FolderStatus) -> Result<String, Error> {
    let refused = |message: String| Error::results(folder, message);
    if let Some(fault) = status.faults.first() {
        let more = match status.faults.len() {
            1 => String::new(),
            n => format!(" (and {} more faults: `microslip status`)", n - 1),
        };
        return Err(refused(format!("{fault}{more}")));
    }
    if status.is_empty() {
        return Err(refused("holds no results and no parts of `run`".to_owned()));
    }
    if status.results.is_some()
        && let Some(name) = outdated(folder)?.first()
    {
        let message = "is not what this program makes of the tables: `report` writes it anew";
        return Err(refused(format!("{name} {message}")));
    }
    let parts = status.unfinished.as_ref().map_or(0, |run| run.parts);
    let results = match &status.results {
        Some(run) => format!("the results of {}", count(run.done, "sample")),
        None => "no whole results".to_owned(),
    };
    Ok(format!(
        "tables, parts and report are what was written: {results}, {}",
        count(parts, "part")
    ))
}

fn show_folder(out: &mut dyn Write, status: &FolderStatus) -> std::io::Result<()> {
    if let Some(run) = &status.results {
        show(out, "whole results", run)?;
    }
    if let Some(run) = &status.unfinished {
        show(out, "unfinished", run)?;
        match status.extends {
            true => writeln!(
                out,
                "`extend --samples {}` of this folder goes on",
                run.samples
            )?,
            false => {
                let study = run.study_file.display();
                writeln!(out, "the command that began it goes on; its study: {study}")?;
            }
        }
    }
    if status.is_empty() {
        writeln!(out, "no samples")?;
    }
    for fault in &status.faults {
        writeln!(out, "fault: {fault}")?;
    }
    Ok(())
}

fn show(out: &mut dyn Write, what: &str, run: &RunStatus) -> std::io::Result<()> {
    let program = run.identity.program.in_words();
    let (done, samples, failed) = (run.done, run.samples, run.failed);
    write!(
        out,
        "{what}: {done} of {}, {failed} without a solution at every level",
        count(samples, "sample")
    )?;
    if run.parts > 0 {
        write!(out, ", in {}", count(run.parts, "part"))?;
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
