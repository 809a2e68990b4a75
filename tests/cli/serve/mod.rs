//! The model as a function of its inputs: from code, over HTTP, and as a process.

mod evaluator;
mod process;
mod requests;

use std::path::Path;

use super::folder;
use microslip::ensemble::outcome::{AroundPeak, LevelOutcome};
use microslip::ensemble::stop::Stop;
use microslip::study::{Evaluator, Study};
use tempfile::TempDir;

/// A folder with the study of two masses, of so many samples at one level and without curves.
fn quick(samples: u64) -> TempDir {
    let study = folder(
        "study.toml",
        "samples = 10",
        &format!("samples = {samples}"),
    );
    let path = study.path().join("study.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let text = text.replace("levels = [1.0, 2.0]", "levels = [1.0]");
    std::fs::write(&path, text + "curve_samples = 0\n").unwrap();
    study
}

/// The model of the study of two masses in `folder`, without an error alert, started from so many samples.
fn model(folder: &Path, anchors: u64) -> Evaluator<'static> {
    let study = Study::read(&folder.join("study.toml")).unwrap();
    let prepared = study.into_prepared().unwrap();
    Evaluator::solved(prepared, anchors, &Stop::default(), |_| {}).unwrap()
}

/// All that must be the same to the bit.
fn bits(levels: &[LevelOutcome]) -> Vec<String> {
    let of = |level: &LevelOutcome| {
        let mut level = level.clone();
        level.around = AroundPeak::new(level.around.others().to_vec(), Vec::new(), None);
        serde_json::to_string(&level).unwrap()
    };
    levels.iter().map(of).collect()
}
