//! A run that any number of processes solve together in one folder.
//!
//! Generation by generation, each process takes blocks of samples that nobody has claimed, and reads what the others have written.
//! When nothing is missing, one of them makes the results. A process that dies leaves its parts and a claim that is void soon.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use super::progress::{Meter, Progress};
use super::replacement::{admitted, refuse_own_inputs};
use super::resume::{accepted_part, has_results, resumed};
use super::run::run_alone;
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use super::session::{Begun, Session, at_work, unwritten};
use super::share::{BLOCK, refuse_looks};
use crate::Error;
use crate::ensemble::Known;
use crate::ensemble::atlas::Anchor;
use crate::ensemble::parts::{Claims, Merged, MergedSource, RunIdentity, StoredPart};
use crate::ensemble::runner::generations;
use crate::file::{FileError, FolderLock};
use crate::study::output::OutputFolder;
use crate::study::settings::read::Study;

/// How often a process that waits for others looks at the folder.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Blocks of a generation of the atlas: enough for as many processes.
const BLOCKS: u64 = 16;

/// Solves a study together with other processes that call the same, on any node that sees `folder`, started at any time. `rank` tells
/// processes that start at once to begin at different blocks.
///
/// # Errors
/// As [`super::run::run`], and [`Error::Unfit`] where the number of samples comes out of the results.
pub fn join(
    study: &Study,
    folder: &OutputFolder,
    rank: u64,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    refuse_looks(study)?;
    refuse_own_inputs(study, folder)?;
    let shared = FolderLock::shared(folder.path())?;
    let identity = admitted(study, folder)?;
    if !has_results(folder, &identity, settings) {
        solve_together(study, folder, identity, rank, settings, &progress)?;
    }
    drop(shared);
    // the others find the results of the first one that comes to this
    loop {
        if let Some(_alone) = FolderLock::try_alone(folder.path())? {
            return run_alone(study, folder, settings, progress);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Solves until no sample is missing.
fn solve_together(
    study: &Study,
    folder: &OutputFolder,
    identity: RunIdentity,
    rank: u64,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<(), Error> {
    let resumed = resumed(study, folder, &identity, settings)?;
    let begun = Begun::with(&resumed, study, folder, settings, identity);
    let mut shared = SharedSamples {
        study,
        settings,
        tables: resumed.tables(),
        known: resumed.known,
    };
    let meter = Meter::start(shared.known.indices.len() as u64, study.samples, progress);
    at_work(begun, meter, |session| session.together(rank, &mut shared))
}

impl<F: Fn(Progress) + Sync> Session<'_, F> {
    /// Solves generation by generation until no sample is missing.
    fn together(&self, rank: u64, shared: &mut SharedSamples) -> Result<(), Error> {
        let mut claims = Claims::of(&self.parts).map_err(unwritten)?;
        for generation in generations(self.prepared.study.samples) {
            let anchors = shared.known.anchors_before(generation.start);
            while !shared.has(&generation) {
                let taken = self.one_round(&generation, rank, &anchors, &mut claims, shared)?;
                if !taken {
                    std::thread::sleep(LOOK_EVERY);
                }
                shared.refresh(self)?;
            }
        }
        Ok(())
    }

    /// Solves each block of the generation that nobody has claimed; says whether there was one.
    fn one_round(
        &self,
        generation: &Range<u64>,
        rank: u64,
        anchors: &[Anchor],
        claims: &mut Claims,
        shared: &mut SharedSamples,
    ) -> Result<bool, Error> {
        let mut blocks: Vec<Range<u64>> = blocks(generation).collect();
        let first = rank as usize % blocks.len().max(1);
        blocks.rotate_left(first);
        let mut taken = false;
        for block in blocks {
            if self.settings.stop.asked() {
                return Err(self.stopped());
            }
            if shared.has(&block) {
                continue;
            }
            let claim = claims.take(&format!("{:010}", block.start));
            let Some(claim) = claim.map_err(unwritten)? else {
                continue;
            };
            // somebody may have ended with it since the last look
            shared.refresh(self)?;
            let missing = shared.missing(&block);
            if missing.is_empty() {
                continue;
            }
            taken = true;
            claim.hold(|| {
                self.written(|watch| self.ensemble.solve_from(anchors, &missing, watch))
            })?;
            shared.refresh(self)?;
        }
        Ok(taken)
    }
}

/// Blocks of a generation: what a process claims at once.
fn blocks(generation: &Range<u64>) -> impl Iterator<Item = Range<u64>> {
    let Range { start, end } = *generation;
    let size = ((end - start) / BLOCKS).clamp(1, BLOCK);
    (start..end)
        .step_by(size as usize)
        .map(move |first| first..(first + size).min(end))
}

/// What all processes have written so far.
struct SharedSamples<'a> {
    study: &'a Study,
    settings: &'a RunSettings,
    /// Tables that were read.
    tables: BTreeSet<PathBuf>,
    /// What they hold.
    known: Known,
}

impl SharedSamples<'_> {
    /// Reads the parts that have come since the last look.
    fn refresh<F>(&mut self, session: &Session<'_, F>) -> Result<(), Error> {
        for part in session.parts.unseen(&mut self.tables)? {
            accepted_part(&session.parts, &part, &session.head.identity, self.settings)?;
            match self.read(&part) {
                // somebody took it away since it was opened: its samples are solved again
                Err(error) if error.is_absence() => {
                    self.tables.remove(&part.paths()[0]);
                }
                read => read?,
            }
        }
        Ok(())
    }

    /// Reads the samples of a part and, where it has them, their anchors.
    fn read(&mut self, part: &StoredPart) -> Result<(), FileError> {
        let mut samples = Merged::new(vec![MergedSource::of(part)], &self.study.design);
        let mut anchors = Vec::new();
        while let Some(sample) = samples.take()? {
            let Some(anchor) = sample.anchor else {
                break;
            };
            anchors.push((sample.outcome.index, anchor));
        }
        let indices = part.samples.iter().map(|(index, _)| index);
        self.known.indices.extend(indices);
        self.known.anchors.extend(anchors);
        Ok(())
    }

    fn has(&self, range: &Range<u64>) -> bool {
        range
            .clone()
            .all(|index| self.known.indices.contains(&index))
    }

    fn missing(&self, range: &Range<u64>) -> Vec<u64> {
        let missing = |index: &u64| !self.known.indices.contains(index);
        range.clone().filter(missing).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::blocks;

    /// Seen to fail with blocks that overlap the end of the generation.
    #[test]
    fn blocks_cover_a_generation_once() {
        for range in [0..5, 5..7, 108..162, 1024..5000] {
            let all: Vec<u64> = blocks(&range).flatten().collect();
            assert_eq!(all, range.collect::<Vec<_>>());
        }
    }
}
