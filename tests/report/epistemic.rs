//! Epistemic inputs: no statistic over all samples passes for a probability.

use crate::synthetic::SyntheticStudy;
use microslip::report::{self, Assessment, Summary};
use microslip::statistics::{Judgement, Limit, Observed, quantile_estimate};

const STIFFNESS: [f64; 3] = [0.1, 1.0, 10.0];

/// The synthetic study at three values of the stiffness, amplitudes at the second 60 % higher.
fn nested(samples: u64) -> SyntheticStudy {
    let mut study = SyntheticStudy::new(samples);
    study.record.design.outer_points = 3;
    for (i, outcome) in study.outcomes.iter_mut().enumerate() {
        let outer = i % 3;
        outcome.group.outer = Some(outer as u64);
        outcome.inputs[0] = STIFFNESS[outer];
        for peak in outcome.levels.iter_mut().filter_map(|l| l.peak.as_mut()) {
            peak.amplitude_m *= if outer == 1 { 1.6 } else { 1.0 };
        }
    }
    study
}

/// Each end of a range is the quantile of its point's samples. Seen to fail with the samples of two points together.
#[test]
fn ranges_are_those_of_the_points() {
    let study = nested(180);
    let summary = Summary::of(&study.input());
    let epistemic = summary.epistemic.unwrap();
    assert_eq!(epistemic.inputs, ["contact stiffness scale"]);
    let values: Vec<f64> = epistemic.points.iter().map(|p| p.values[0]).collect();
    assert_eq!(values, STIFFNESS);
    let median = |outer: u64, i: usize| {
        let of_point = study
            .outcomes
            .iter()
            .filter(|o| o.group.outer == Some(outer));
        let amplitudes = of_point.map(|o| o.levels[i].peak.map_or(f64::NAN, |p| p.amplitude_m));
        quantile_estimate(&Observed::of(amplitudes), 0.5, 0.95)
            .unwrap()
            .estimate
    };
    for (i, level) in epistemic.levels.iter().take(7).enumerate() {
        let medians: Vec<f64> = (0..3).map(|outer| median(outer, i)).collect();
        let range = level.amplitude_m[1].range;
        let highest = medians.iter().copied().fold(0.0, f64::max);
        assert_eq!(range.highest.value, Limit::Value(highest));
        assert_eq!(range.highest.outer, 1, "level {i}");
        let lowest = medians.iter().copied().fold(1.0, f64::min);
        assert_eq!(range.lowest.value, Limit::Value(lowest));
        assert_eq!(level.points[2].amplitude_m.valid, 60);
    }
}

/// Quantiles over all samples are absent from the summary, words stand in the report, and a study without outer points
/// has neither. Seen to fail with the quantiles kept.
#[test]
fn pooled_statistics_are_no_probabilities() {
    let study = nested(90);
    let summary = Summary::of(&study.input());
    assert!(summary.levels[0].frequency_hz.quantiles.is_empty());
    assert!(
        summary.levels[0]
            .amplitude_per_unit_level_m
            .quantiles
            .is_empty()
    );
    let assessment = Assessment::of(&study.input(), &summary);
    assert!(
        assessment
            .condition
            .contains("contact stiffness scale is only known to an interval")
    );
    let folder = tempfile::tempdir().unwrap();
    report::write(folder.path(), &study.input()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Ranges over the epistemic inputs") && page.contains("at points "));
    for absent in [
        "NaN",
        "Histograms",
        "id=\"envelopes\"",
        "Bounds: each holds for 95 % of the blades with 95 % confidence<",
    ] {
        assert!(!page.contains(absent), "{absent}");
    }
    assert!(
        page.matches("are no population").count() >= 5,
        "sections without a word"
    );
    let plain = SyntheticStudy::new(90);
    let summary = Summary::of(&plain.input());
    assert!(summary.epistemic.is_none() && summary.levels[0].frequency_hz.quantiles.len() == 3);
    let json = serde_json::to_string(&summary).unwrap();
    assert!(!json.contains("epistemic"));
}

/// Replicates are those of a point: none over all samples. Seen to fail with the samples of all points at each.
#[test]
fn replicates_are_those_of_the_points() {
    let mut study = nested(180);
    for (i, outcome) in study.outcomes.iter_mut().enumerate() {
        outcome.group.replicate = Some(i as u64 / 3 % 4);
    }
    let summary = Summary::of(&study.input());
    assert!(summary.levels[0].replicate_means.is_none());
    let points = &summary.epistemic.as_ref().unwrap().levels[2].points;
    for (outer, point) in points.iter().enumerate() {
        let mut sums = [0.0; 4];
        for (i, outcome) in study
            .outcomes
            .iter()
            .enumerate()
            .filter(|(i, _)| i % 3 == outer)
        {
            sums[i / 3 % 4] += outcome.levels[2].peak.unwrap().amplitude_m / 15.0;
        }
        let found = point.replicate_means.unwrap().amplitude_m;
        let mean = sums.iter().sum::<f64>() / 4.0;
        assert!((found.mean / mean - 1.0).abs() < 1e-12, "{found:?}");
    }
    assert_eq!(summary.replicate_means().len(), 3 * summary.levels.len());
    let folder = tempfile::tempdir().unwrap();
    report::write(folder.path(), &study.input()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Means over the replicates"));
}

/// A criterion that fails at one point alone fails, and names it. Seen to fail with all samples judged together.
#[test]
fn a_criterion_must_hold_at_every_point() {
    let mut study = nested(180);
    let amplitudes = |outer: u64| {
        let of_point = study
            .outcomes
            .iter()
            .filter(|o| o.group.outer == Some(outer));
        let values: Vec<f64> = of_point
            .filter_map(|o| Some(o.levels[2].peak?.amplitude_m))
            .collect();
        values
    };
    let least_bad = amplitudes(1).into_iter().fold(f64::INFINITY, f64::min);
    let most_good = [amplitudes(0), amplitudes(2)]
        .concat()
        .into_iter()
        .fold(0.0, f64::max);
    assert!(most_good < least_bad, "{most_good} {least_bad}");
    study
        .record
        .requirements
        .criteria
        .retain(|c| c.name == "amplitude");
    let criterion = &mut study.record.requirements.criteria[0];
    criterion.level = Some(5.0);
    criterion.limit = 1e6 * 0.5 * (most_good + least_bad);
    criterion.share = Some(0.5);
    let summary = Summary::of(&study.input());
    let limit = summary.epistemic.as_ref().unwrap().levels[2].exceedances[0];
    assert_eq!(
        (limit.range.lowest.value, limit.range.highest.value),
        (Limit::Value(0.0), Limit::Value(1.0))
    );
    let result = &Assessment::of(&study.input(), &summary).criteria[0];
    assert_eq!(
        (result.judgement, result.levels[0].outer),
        (Judgement::Fail, Some(1))
    );
}
