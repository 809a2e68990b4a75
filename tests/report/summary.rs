//! The summary: stable names, sums that close, no dependence on the order of the samples.

use crate::synthetic::{LEVELS, SyntheticStudy};
use microslip::ensemble::outcome::AroundPeak;
use microslip::hb::Status;
use microslip::report::Summary;
use microslip::statistics::Limit;
use serde_json::Value;
use std::collections::BTreeSet;

fn key_paths(prefix: &str, value: &Value, into: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let path = format!("{prefix}.{key}");
                key_paths(&path, value, into);
                into.insert(path);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| key_paths(prefix, item, into)),
        _ => {}
    }
}

/// Programs read these names: a change here is a change of the file format.
/// Seen to fail with `failed` renamed.
#[test]
fn field_names_are_stable() {
    let study = SyntheticStudy::new(50);
    let summary = serde_json::to_value(Summary::of(&study.input())).unwrap();
    let mut paths = BTreeSet::new();
    key_paths("", &summary, &mut paths);
    let found: Vec<String> = paths
        .into_iter()
        .filter(|p| {
            !p.contains(".statuses.")
                && !p.contains(".routes.")
                && !p.contains(".highest_harmonics.")
        })
        .filter(|p| {
            !p.starts_with(".levels.amplitude") && !p.starts_with(".levels.truncation_error")
        })
        .collect();
    let expected = include_str!("summary_fields.txt");
    assert_eq!(found.join("\n"), expected.trim_end());
}

/// Seen to fail when only samples with a solution were counted, and with one route left out of the counts.
#[test]
fn statuses_add_up_to_the_samples() {
    let study = SyntheticStudy::new(333);
    let summary = Summary::of(&study.input());
    assert_eq!(summary.levels.len(), LEVELS.len());
    for level in &summary.levels {
        assert_eq!(level.statuses.values().sum::<usize>(), 333);
        assert_eq!(level.statuses.len(), Status::ALL.len());
        let found: usize = level.routes.values().sum();
        assert_eq!(found, 333 - level.failed);
        assert!(level.routes["predicted"] > level.routes["swept-on-one"]);
        assert_eq!(level.frequency_hz.valid + level.failed, 333);
        assert_eq!(
            level.highest_harmonics.values().sum::<usize>(),
            level.frequency_hz.valid
        );
    }
}

/// Curves of the highest level fold over, those of the others do not. Seen to fail with all samples counted as curves, and with the
/// ratio the other way round.
#[test]
fn curves_with_several_solutions_are_counted() {
    let mut study = SyntheticStudy::new(100);
    // a sample without a curve tells nothing
    let top = LEVELS.len() - 1;
    let without = &mut study.outcomes[3].levels[top].around;
    *without = AroundPeak::new(without.others().to_vec(), Vec::new(), None);
    let summary = Summary::of(&study.input());
    let known = |i: usize| {
        study
            .outcomes
            .iter()
            .filter(move |o| o.levels[i].around.sweeps().is_some())
    };
    for (i, level) in summary.levels.iter().enumerate() {
        let found = level.several_answers;
        let curves = known(i).count();
        let several = if i == top { curves } else { 0 };
        assert_eq!((found.curves, found.several), (curves, several), "{i}");
        let share = found.share.expect("curves");
        assert_eq!(share.estimate, several as f64 / curves as f64);
        assert!(share.lower < share.upper, "{share:?}");
        let ratio = if i == top { 0.9 } else { 1.0 };
        assert!(
            (found.lowest_ratio.expect("curves") - ratio).abs() < 1e-12,
            "{found:?}"
        );
        assert_eq!(found.widest_hz, (i == top).then_some(0.75));
    }
    assert!(known(top).count() < 100, "one sample has no curve");
}

/// A converged status with a number that is not finite is no solution.
/// Seen to fail with the status counted as it stands.
#[test]
fn a_solution_without_finite_numbers_counts_as_failed() {
    let mut study = SyntheticStudy::new(100);
    let before = Summary::of(&study.input()).levels[0].clone();
    if let Some(peak) = &mut study.outcomes[7].levels[0].peak {
        peak.frequency_hz = f64::NAN;
    }
    study.outcomes[8].levels[0].peak = None;
    let after = &Summary::of(&study.input()).levels[0];
    assert_eq!((before.failed, after.failed), (0, 2));
    assert_eq!(after.statuses["non-finite"], 2);
    assert_eq!(after.statuses["converged"], 98);
}

/// 3 failures in 100: the 95 % quantile is bounded by ranks 92 and 95 of the 97, the estimate is rank 93.
/// Seen to fail with no failures passed on to the bounds.
#[test]
fn failures_widen_the_quantiles() {
    let mut study = SyntheticStudy::new(100);
    for outcome in &mut study.outcomes[..3] {
        outcome.levels[0].status = Status::StepTooSmall;
    }
    let mut valid: Vec<f64> = study.outcomes[3..]
        .iter()
        .map(|o| o.levels[0].peak.unwrap().frequency_hz)
        .collect();
    valid.sort_by(f64::total_cmp);
    let summary = Summary::of(&study.input());
    let q95 = summary.levels[0].frequency_hz.quantiles[2];
    assert_eq!(q95.estimate, valid[92]);
    assert_eq!(q95.failure_bounds.lower.value(), Some(valid[91]));
    assert_eq!(q95.failure_bounds.upper.value(), Some(valid[94]));
    let rate = summary.levels[0].failure_rate.unwrap();
    assert!(rate.lower < 0.03 && 0.03 < rate.upper);
}

/// Three replicates, one sample of the second failed: means by hand, in the file and on the page; none without replicates.
/// Seen to fail with the failed sample at the mean of zero.
#[test]
fn replicates_show_the_error_of_the_mean() {
    let mut study = SyntheticStudy::new(12);
    let plain = serde_json::to_value(Summary::of(&study.input())).unwrap();
    assert!(plain["levels"][0].get("replicate_means").is_none());
    for (i, outcome) in study.outcomes.iter_mut().enumerate() {
        outcome.group.replicate = Some(i as u32 % 3);
        outcome.levels[0].peak.as_mut().unwrap().frequency_hz = 100.0 + i as f64;
    }
    study.outcomes[10].levels[0].status = Status::MaxIterations;
    // means of 0, 3, 6, 9 and 1, 4, 7 and 2, 5, 8, 11
    let means = [104.5, 104.0, 106.5];
    let mean = means.iter().sum::<f64>() / 3.0;
    let squares: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
    let summary = Summary::of(&study.input());
    let found = summary.levels[0].replicate_means.unwrap().frequency_hz;
    assert!((found.mean - mean).abs() < 1e-12, "{found:?}");
    assert!(
        (found.standard_error - (squares / 6.0).sqrt()).abs() < 1e-12,
        "{found:?}"
    );
    assert_eq!((found.replicates, found.failed), (3, 1));
    let folder = tempfile::tempdir().unwrap();
    microslip::report::write(folder.path(), &study.input()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Means over the replicates") && page.contains("105.0000"));
}

/// Means 1, 1 and 100 of three replicates: Student's interval of the amplitude goes on below 0, where no amplitude is. Seen to fail with
/// the program before, whose interval did.
#[test]
fn the_mean_of_an_amplitude_is_not_negative() {
    let mut study = SyntheticStudy::new(12);
    for (i, outcome) in study.outcomes.iter_mut().enumerate() {
        outcome.group.replicate = Some(i as u32 % 3);
        let peak = outcome.levels[0].peak.as_mut().unwrap();
        peak.amplitude_m = [1e-6, 1e-6, 1e-4][i % 3];
    }
    let summary = Summary::of(&study.input());
    let found = summary.levels[0].replicate_means.unwrap().amplitude_m;
    assert_eq!(found.interval.lower, Limit::Value(0.0));
    assert!(found.interval.upper.value() > Some(1e-4), "{found:?}");
}

/// The same samples in another order give the same bits. Seen to fail without the sort of the values.
#[test]
fn the_order_of_the_samples_does_not_matter() {
    let mut study = SyntheticStudy::new(500);
    let forward = serde_json::to_string(&Summary::of(&study.input())).unwrap();
    study.outcomes.reverse();
    let backward = serde_json::to_string(&Summary::of(&study.input())).unwrap();
    assert_eq!(forward, backward);
}
