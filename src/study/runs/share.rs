//! A part of a run that one of several processes solves.
//!
//! The samples of a generation start from those before it, and all after the atlas from the atlas alone. So processes need
//! nothing of each other but the parts of earlier generations, and whoever solves a sample writes the same bits.

use super::progress::{Meter, Progress};
use super::replacement::{admitted, refuse_own_inputs};
use super::resume::resumed;
use super::run_settings::RunSettings;
use super::session::{Begun, at_work};
use crate::Error;
use crate::ensemble::Known;
use crate::ensemble::runner::MOST_ANCHORS;
use crate::file::FolderLock;
use crate::study::output::OutputFolder;
use crate::study::settings::read::Study;

/// Samples of a block: what a process takes at once after the atlas.
pub(super) const BLOCK: u64 = 64;

/// What a process solves of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleShare {
    /// The samples from which all others start: the first 1024.
    Atlas,
    /// These, unless they are solved already, and of the blocks after them every one whose number leaves this rest.
    Shard {
        /// Number of the shard, from 0.
        number: u64,
        /// Number of shards.
        of: u64,
    },
}

impl SampleShare {
    /// The samples after the atlas that are in this share, of 0 … `samples` − 1.
    fn after_atlas(self, samples: u64) -> impl Iterator<Item = u64> {
        (MOST_ANCHORS..samples).filter(move |index| match self {
            Self::Atlas => false,
            Self::Shard { number, of } => (index - MOST_ANCHORS) / BLOCK % of == number,
        })
    }
}

/// What a share gives: parts, and no results yet.
#[derive(Debug)]
pub struct ShareResult {
    /// Samples of this share.
    pub samples: u64,
    /// Those that were solved before.
    pub taken_over: u64,
    /// Samples of the whole run.
    pub of: u64,
    /// What a user should know of the taking over, one line each.
    pub notes: Vec<String>,
}

/// Solves a share of a study's samples and keeps them as parts in `folder`. Once all shares are there, in this folder or gathered
/// by [`super::merge::merge`], [`super::run::run`] makes the results.
///
/// # Errors
/// As [`super::run::run`], and [`Error::Unfit`] where the number of samples comes out of the results.
pub fn solve_share(
    study: &Study,
    folder: &OutputFolder,
    share: SampleShare,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<ShareResult, Error> {
    refuse_looks(study)?;
    refuse_own_inputs(study, folder)?;
    let _lock = FolderLock::shared(folder.path())?;
    let identity = admitted(study, folder)?;
    let mut resumed = resumed(study, folder, &identity, settings)?;
    let begun = Begun::with(&resumed, study, folder, settings, identity);
    let anchors = study.samples.min(MOST_ANCHORS);
    let others = |known: &Known| -> Vec<u64> {
        let after = share.after_atlas(study.samples);
        after.filter(|i| !known.indices.contains(i)).collect()
    };
    let missing = |known: &Known| {
        let there = known.indices.range(..anchors).count() as u64;
        anchors - there + others(known).len() as u64
    };
    let samples = anchors + share.after_atlas(study.samples).count() as u64;
    let taken_over = samples - missing(&resumed.known);
    let meter = Meter::start(taken_over, samples, progress);
    let notes = at_work(begun, meter, |session| {
        session.kept(&mut resumed, missing, |known, watch| {
            session.ensemble.extend(known, anchors, watch)?;
            let from = known.anchors_before(anchors);
            session.ensemble.solve_from(&from, &others(known), watch)
        })?;
        Ok(session.notes.clone())
    })?;
    Ok(ShareResult {
        samples,
        taken_over,
        of: study.samples,
        notes: [notes, resumed.notes].concat(),
    })
}

/// Refuses a study whose samples are judged on the way, in order.
pub(super) fn refuse_looks(study: &Study) -> Result<(), Error> {
    match study.stopping {
        None => Ok(()),
        Some(_) => Err(Error::unfit(
            &study.path,
            "samples: a run that decides its own number of samples cannot be shared; give a number",
        )),
    }
}
