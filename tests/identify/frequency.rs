//! A frequency that is stated wrongly is found from the record, and told.

use crate::synthetic::Bench;
use microslip::identify::{IdentifySettings, TestResult, identify_test};

/// 10 Hz, so many cycles, 50 N/um.
fn found(cycles: usize, stated: f64) -> TestResult {
    let mut record = Bench {
        frequency: 10.0,
        cycles,
        noise: [1e-8, 0.1, 0.1],
        ..Bench::default()
    }
    .record();
    record.conditions.frequency_hz = Some(stated);
    identify_test(&record, &IdentifySettings::default())
}

/// The search reached half of the inverse of the record's length: another wrong frequency was used, 9.967 Hz for 9.8 stated, and samples were "replaced"
/// as spikes.
///
/// Seen to fail with the program before.
#[test]
fn a_wrong_stated_frequency_is_found_and_told() {
    for cycles in [10, 15, 30] {
        for stated in [5.0, 9.3, 9.7, 9.8, 9.9, 10.2, 10.5, 11.0, 20.0] {
            let found = found(cycles, stated);
            let case = format!("{cycles} cycles, {stated} Hz: {:?}", found.notes);
            let used = found.cycles.unwrap();
            assert!((used.frequency_hz / 10.0 - 1.0).abs() < 1e-4, "{case}");
            assert_eq!(used.spikes, 0, "{case}");
            let wrong = |note: &String| note.starts_with("the stated frequency is wrong");
            assert!(found.notes.iter().any(wrong), "{case}");
            let stiffness = found.estimate.unwrap().tangential.stiffness_n_per_um;
            assert!((stiffness.value / 50.0 - 1.0).abs() < 0.02, "{case}");
        }
    }
}

/// A right one is kept as it is stated, and one that differs as clocks do is corrected without being called wrong.
#[test]
fn clocks_that_differ_are_no_wrong_frequency() {
    let right = found(30, 10.0);
    assert!(right.cycles.unwrap().frequency_hz == 10.0, "kept");
    let told = |result: &TestResult, words: &str| result.notes.iter().any(|n| n.contains(words));
    assert!(!told(&right, "stated"), "{:?}", right.notes);
    let clocks = found(30, 10.006);
    assert!(
        told(&clocks, "is stated as 10.006 Hz"),
        "{:?}",
        clocks.notes
    );
    assert!(!told(&clocks, "wrong"), "{:?}", clocks.notes);
}
