//! Epistemic inputs: no statistic over all samples passes for a probability.

use crate::synthetic::SyntheticStudy;
use microslip::report::epistemic::Extreme;
use microslip::report::population::{Bound, Quantiles};
use microslip::report::{self, Assessment, Summary};
use microslip::statistics::{Judgement, Limit, Observed, Side, quantile_estimate, tolerance_bound};

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

/// Margins, reserves and bounds are the outermost of the points, and the sections say nothing of pooled samples; the region of
/// both results, which would be of all samples, is absent. Seen to fail with all samples as one population.
#[test]
fn margins_and_reserves_are_those_of_the_points() {
    let mut study = nested(270);
    for outcome in study
        .outcomes
        .iter_mut()
        .filter(|o| o.group.outer == Some(2))
    {
        let peaks = outcome.levels.iter_mut().filter_map(|l| l.peak.as_mut());
        peaks.for_each(|p| p.frequency_hz *= 0.98);
    }
    let summary = Summary::of(&study.input());
    let assessment = Assessment::of(&study.input(), &summary);
    let by_point = |value: &dyn Fn(f64, f64) -> f64| -> Vec<Observed> {
        let of_point = |outer: u64| {
            let outcomes = study
                .outcomes
                .iter()
                .filter(|o| o.group.outer == Some(outer));
            let peaks = outcomes.map(|o| o.levels[2].peak.unwrap());
            Observed::of(peaks.map(|p| value(p.frequency_hz, p.amplitude_m)))
        };
        (0..3).map(of_point).collect()
    };
    let lowest = |points: &[Observed], of: &dyn Fn(&Observed) -> f64| {
        let values: Vec<f64> = points.iter().map(of).collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let outer = values.iter().position(|v| *v == least).unwrap() as u64;
        (Limit::Value(least), outer)
    };
    let q05 = |o: &Observed| quantile_estimate(o, 0.05, 0.95).unwrap().estimate;
    let bound = |o: &Observed| {
        let bound = tolerance_bound(o, Side::Lower, 0.95, 0.95);
        bound.limit.value().unwrap()
    };
    let level = &assessment.levels[2];
    assert!(level.joint_region.is_none());
    let reserve = level.reserve.as_ref().unwrap();
    // Goodman allows 280 MPa, at 1.5 MPa/µm
    let factors = by_point(&|_, a| 280.0 / 1.5 / (1e6 * a));
    let margins = by_point(&|f, _| (f - 2790.0).abs() / 2790.0);
    let order = &level.margins[1];
    assert_eq!(order.engine_order, 54);
    for (found, found_bound, points) in [
        (&reserve.factor, reserve.factor_bound, factors),
        (&order.range, order.range_bound, margins),
    ] {
        let (Quantiles::Points(found), Bound::Points(found_bound)) = (found, found_bound) else {
            panic!("all samples as one population")
        };
        let close = |found: Extreme, expected: (Limit, u64)| {
            let ratio = found.value.value().unwrap() / expected.0.value().unwrap();
            assert!((ratio - 1.0).abs() < 1e-9, "{found:?}, not {expected:?}");
            assert_eq!(found.outer, expected.1);
        };
        close(found[0].range.lowest, lowest(&points, &q05));
        close(found_bound, lowest(&points, &bound));
    }
    let folder = tempfile::tempdir().unwrap();
    report::write(folder.path(), &study.input()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    for (id, pooled) in [("campbell", 1), ("stress", 1), ("performance", 1)] {
        let section = page
            .split(&format!("<section id=\"{id}\">"))
            .nth(1)
            .unwrap();
        let section = section.split("</section>").next().unwrap();
        assert_eq!(section.matches("are no population").count(), pooled, "{id}");
        assert_eq!(section.contains("at points "), id != "performance", "{id}");
    }
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
