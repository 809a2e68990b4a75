//! Sobol' indices of a pick-freeze design: from its rows, and no other number counts the mixed samples.

use crate::synthetic::SyntheticStudy;
use microslip::hb::Status;
use microslip::report::sensitivity::IndexResult;
use microslip::report::{self, Assessment, StoredRun, Summary};
use microslip::statistics::{Influence, SobolIndex};

fn frequency_indices(study: &SyntheticStudy, level: usize) -> Vec<IndexResult> {
    let summary = Summary::of(&study.input());
    let assessment = Assessment::of(&study.input(), &summary);
    let influences = assessment.levels[level].influences.iter();
    influences.map(|i| i.frequency.clone()).collect()
}

fn found(index: &IndexResult) -> SobolIndex {
    match index {
        IndexResult::PickFreeze(index) => *index,
        other => panic!("no index of a pick-freeze design: {other:?}"),
    }
}

fn page(study: &SyntheticStudy) -> String {
    let folder = tempfile::tempdir().unwrap();
    report::write(folder.path(), &study.input()).unwrap();
    std::fs::read_to_string(folder.path().join("report.html")).unwrap()
}

/// At 0.1 N the frequency of the synthetic study is a function of the stiffness alone, but for noise of 0.05 Hz.
#[test]
fn indices_come_from_the_rows() {
    let study = SyntheticStudy::pick_freeze(128);
    let indices = frequency_indices(&study, 0);
    let (stiffness, friction) = (found(&indices[0]), found(&indices[1]));
    for index in [stiffness.first, stiffness.total] {
        assert!((index.estimate - 1.0).abs() < 0.05, "{stiffness:?}");
        assert_eq!(index.influence, Influence::Distinct);
    }
    assert!(friction.total.estimate < 0.05, "{friction:?}");
    assert_eq!(friction.first.influence, Influence::NotDistinguishable);
    let page = page(&study);
    for words in [
        "First-order and total indices",
        "not distinguishable from 0",
        "256 further samples share inputs with these",
    ] {
        assert!(page.contains(words), "{words:?} is not in the page");
    }
    assert!(!page.contains("NaN"));
}

/// The summary of a pick-freeze design is that of its rows A and B.
#[test]
fn mixed_samples_are_in_no_other_number() {
    let mut study = SyntheticStudy::pick_freeze(64);
    for peak in
        (study.mixed.iter_mut()).flat_map(|o| o.levels.iter_mut().filter_map(|l| l.peak.as_mut()))
    {
        peak.frequency_hz *= 2.0;
        peak.amplitude_m *= 1e3;
    }
    let mut with = Summary::of(&study.input());
    let folder = tempfile::tempdir().unwrap();
    study.store(folder.path());
    let stored = StoredRun::read(folder.path()).unwrap();
    let read = serde_json::to_string(&Summary::of(&stored.input())).unwrap();
    assert_eq!(read, serde_json::to_string(&with).unwrap());
    assert_eq!((stored.outcomes.len(), stored.mixed.len()), (128, 128));
    for level in &mut with.levels {
        let mixed = level.mixed.take().unwrap();
        assert_eq!(mixed.statuses.values().sum::<usize>(), 128);
    }
    study.mixed.clear();
    let without = Summary::of(&study.input());
    assert_eq!(without.samples, 128);
    let json = |summary: &Summary| serde_json::to_string(summary).unwrap();
    assert_eq!(json(&with), json(&without));
}

/// One failed mixed sample refuses the indices of its level, with the reason in the page; other levels keep theirs.
#[test]
fn a_failed_sample_refuses_the_indices() {
    let mut study = SyntheticStudy::pick_freeze(32);
    study.mixed[5].levels[0].status = Status::MaxIterations;
    study.mixed[5].levels[0].peak = None;
    for index in frequency_indices(&study, 0) {
        let IndexResult::Refused(reason) = index else {
            panic!("an index in spite of a failed sample: {index:?}");
        };
        assert!(
            reason.starts_with("1 of 128 evaluations failed"),
            "{reason}"
        );
    }
    found(&frequency_indices(&study, 1)[0]);
    let summary = Summary::of(&study.input());
    assert_eq!(summary.levels[0].failed, 0);
    assert_eq!(summary.levels[0].mixed.as_ref().unwrap().failed, 1);
    let page = page(&study);
    for words in ["1 of 128 evaluations failed", "have no solution"] {
        assert!(page.contains(words), "{words:?} is not in the page");
    }
}

/// An input with one value has no index, and neither have too few rows.
#[test]
fn what_cannot_have_an_index_says_so() {
    let reason = |study: &SyntheticStudy, j: usize| match &frequency_indices(study, 0)[j] {
        IndexResult::Refused(reason) => reason.clone(),
        other => panic!("{other:?}"),
    };
    let few = SyntheticStudy::pick_freeze(8);
    assert!(reason(&few, 0).contains("too few"));
    let mut fixed = SyntheticStudy::pick_freeze(32);
    fixed.record.design.mixed_inputs = vec![0];
    fixed.mixed.retain(|o| o.group.place == Some(2));
    assert_eq!(reason(&fixed, 1), "the input is fixed");
    found(&frequency_indices(&fixed, 0)[0]);
}
