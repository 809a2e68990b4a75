//! Epistemic inputs: no statistic over all samples passes for a probability.

use crate::synthetic::SyntheticStudy;
use microslip::ensemble::outcome::{AroundPeak, SampleOutcome, SweepRecord};
use microslip::report::numbers::Extreme;
use microslip::report::numbers::IndexResult;
use microslip::report::numbers::{Bound, Quantiles};
use microslip::report::{Assessment, Summary};
use microslip::statistics::{
    GivenData, Index, Judgement, Limit, Observed, Side, first_order_index, quantile_estimate,
    rank_correlation, tolerance_bound,
};

const STIFFNESS: [f64; 3] = [0.1, 1.0, 10.0];

/// The synthetic study at three values of the stiffness, amplitudes at the second 60 % higher.
fn nested(samples: u64) -> SyntheticStudy {
    let mut study = SyntheticStudy::new(samples);
    study.record.design.outer_points = 3;
    for (i, outcome) in study.outcomes.iter_mut().enumerate() {
        let outer = i % 3;
        outcome.group.outer = Some(outer as u32);
        outcome.inputs[0] = STIFFNESS[outer];
        for peak in outcome.levels.iter_mut().filter_map(|l| l.peak.as_mut()) {
            peak.amplitude_m *= if outer == 1 { 1.6 } else { 1.0 };
        }
    }
    study
}

/// Sections with statistics.
const SECTIONS: [&str; 7] = [
    "campbell",
    "stress",
    "performance",
    "response",
    "influence",
    "error-budget",
    "failures",
];

/// A section of a page.
fn section<'p>(page: &'p str, id: &str) -> &'p str {
    let start = format!("<section id=\"{id}\">");
    let section = page.split(&start).nth(1).unwrap();
    section.split("</section>").next().unwrap()
}

/// Each end of a range is the quantile of its point's samples, and so are rates and means. Seen to fail with the samples of two
/// points together, and with the contact states of all.
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
            .filter(|o| o.group.outer.map(u64::from) == Some(outer));
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
    for (outer, point) in (0..).zip(&epistemic.levels[7].points) {
        let of_point = |o: &&SampleOutcome| o.group.outer.map(u64::from) == Some(outer);
        let levels = study.outcomes.iter().filter(of_point).map(|o| &o.levels[7]);
        let sticks: Vec<f64> = levels
            .filter_map(|l| Some(l.peak?.stick_fraction))
            .collect();
        let failed = 60 - sticks.len();
        assert_eq!(point.failure_rate.unwrap().estimate, failed as f64 / 60.0);
        let stick = sticks.iter().sum::<f64>() / sticks.len() as f64;
        let found = point.mean_contact_fractions.unwrap().stick;
        assert!((found / stick - 1.0).abs() < 1e-12, "{found}, not {stick}");
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
    let page = study.page();
    assert!(page.contains("Ranges over the epistemic inputs") && page.contains("at points "));
    for absent in [
        "NaN",
        "Histograms",
        "id=\"envelopes\"",
        "Bounds: each holds for 95 % of the assumed prior with 95 % confidence<",
    ] {
        assert!(!page.contains(absent), "{absent}");
    }
    for id in SECTIONS {
        let words = section(&page, id).matches("are no population").count();
        // the condition of every probability says so, and nothing else needs to
        let expected = usize::from(["campbell", "stress"].contains(&id));
        assert_eq!(words, expected, "{id}");
    }
    let plain = SyntheticStudy::new(90);
    let summary = Summary::of(&plain.input());
    assert!(summary.epistemic.is_none() && summary.levels[0].frequency_hz.quantiles.len() == 3);
    let json = serde_json::to_string(&summary).unwrap();
    assert!(!json.contains("epistemic"));
}

/// The lowest number of the outer points, and at which it is.
fn lowest(points: &[Observed], of: &dyn Fn(&Observed) -> f64) -> (Limit, u64) {
    let values: Vec<f64> = points.iter().map(of).collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let outer = values.iter().position(|v| *v == least).unwrap() as u64;
    (Limit::Value(least), outer)
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
                .filter(|o| o.group.outer.map(u64::from) == Some(outer));
            let peaks = outcomes.map(|o| o.levels[2].peak.unwrap());
            Observed::of(peaks.map(|p| value(p.frequency_hz, p.amplitude_m)))
        };
        (0..3).map(of_point).collect()
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
    let page = study.page();
    for id in ["campbell", "stress"] {
        assert!(section(&page, id).contains("at points "), "{id}");
    }
}

/// Replicates are those of a point: none over all samples. Seen to fail with the samples of all points at each.
#[test]
fn replicates_are_those_of_the_points() {
    let mut study = nested(180);
    for (i, outcome) in study.outcomes.iter_mut().enumerate() {
        outcome.group.replicate = Some(i as u32 / 3 % 4);
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
    let page = study.page();
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
            .filter(|o| o.group.outer.map(u64::from) == Some(outer));
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

/// An outer point that stands twice is the same box: no figure and no table of a statistic moves, where one of all samples
/// together would. Seen to fail with all samples as one population in the fans alone and in all figures of peaks, and with the
/// curves of all samples together.
#[test]
fn a_point_that_stands_twice_moves_no_range() {
    let once = nested(180);
    let mut twice = nested(180);
    let again = twice.outcomes.iter().filter(|o| o.group.outer == Some(1));
    let mut again: Vec<_> = again.cloned().collect();
    for outcome in &mut again {
        outcome.group.outer = Some(3);
    }
    twice.outcomes.extend(again);
    let pages = [once.page(), twice.page()];
    for id in ["stress", "performance"] {
        let [once, twice] = [0, 1].map(|k| section(&pages[k], id));
        // the condition counts the outer points
        let once = once.replace("all 3 outer points", "all 4 outer points");
        assert!(once == twice, "{id}");
    }
    for (id, class) in [("campbell", "class=\""), ("response", "class=\"band")] {
        let marks = |page: &str| -> Vec<String> {
            let paths = section(page, id).split("<path ").skip(1);
            let path = |p: &str| p.split("/>").next().unwrap().to_owned();
            paths.map(path).filter(|p| p.starts_with(class)).collect()
        };
        let [once, twice] = [0, 1].map(|k| marks(&pages[k]));
        assert!(once.len() > 8 && once == twice, "{id}");
    }
    assert!(section(&pages[0], "response").contains("curves of 3 outer points"));
}

/// The point with the largest share of several answers counts, not that with most of them. Seen to fail with the most, and with all points
/// together in the words.
#[test]
fn several_answers_are_those_of_the_worst_point() {
    let mut study = nested(180);
    // several answers and curves of each point
    let counts = [(0, 60), (3, 10), (4, 60)];
    let (at, sweeps) = (2, *study.outcomes[0].levels[2].around.sweeps().unwrap());
    for (i, outcome) in study.outcomes.iter_mut().enumerate() {
        let (several, curves) = counts[i % 3];
        let around = &mut outcome.levels[at].around;
        let sweeps = (i / 3 < curves).then_some(SweepRecord {
            several_hz: (i / 3 < several).then_some([2600.0, 2601.0]),
            ..sweeps
        });
        *around = AroundPeak::new(around.others().to_vec(), Vec::new(), sweeps);
    }
    let found = Summary::of(&study.input()).levels[at].several_answers;
    assert_eq!((found.curves, found.several, found.share), (130, 7, None));
    let worst = found.worst_point.unwrap();
    assert_eq!((worst.outer, worst.curves, worst.several), (1, 10, 3));
    let words = "several answers on 3 of 10 curves of the worst outer point";
    for id in ["campbell", "stress"] {
        assert!(section(&study.page(), id).contains(words), "{id}");
    }
}

/// Indices and rank correlations are those of the samples of each point, an interval has none, and nothing of all samples
/// together is left in the numbers. Seen to fail with the samples of all points at each.
#[test]
fn influence_is_that_of_the_points() {
    let study = nested(600);
    let summary = Summary::of(&study.input());
    let assessment = Assessment::of(&study.input(), &summary);
    let i = 2;
    let of_point = |outer: u64| -> Vec<(f64, f64)> {
        let outcomes = study.outcomes.iter();
        let outcomes = outcomes.filter(|o| o.group.outer.map(u64::from) == Some(outer));
        let pair = |o: &SampleOutcome| (o.inputs[1], o.levels[i].peak.unwrap().amplitude_m);
        outcomes.map(pair).collect()
    };
    let indices = [0, 1, 2].map(|outer| {
        let (x, y): (Vec<f64>, Vec<f64>) = of_point(outer).into_iter().unzip();
        let data = GivenData {
            inputs: &x,
            results: &y,
            replicates: None,
            seed: study.record.provenance.seed,
            confidence: 0.95,
        };
        first_order_index(&data).unwrap().index
    });
    let level = &assessment.levels[i];
    let IndexResult::Points(range) = &level.influences[1].amplitude else {
        panic!("{:?}", level.influences[1].amplitude)
    };
    let least = |of: fn(&Index) -> f64| indices.iter().map(of).fold(f64::INFINITY, f64::min);
    let most = |of: fn(&Index) -> f64| indices.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(range.lowest.value, Limit::Value(least(|x| x.estimate)));
    assert_eq!(range.highest.value, Limit::Value(most(|x| x.estimate)));
    assert_eq!(range.interval.lower, Limit::Value(least(|x| x.lower)));
    assert_eq!(range.interval.upper, Limit::Value(most(|x| x.upper)));
    let IndexResult::Refused(reason) = &level.influences[0].amplitude else {
        panic!("an index of an interval")
    };
    assert!(reason.contains("no variance"), "{reason}");
    let points = &summary.epistemic.as_ref().unwrap().levels[i].points;
    for (outer, point) in (0..).zip(points) {
        let [interval, random] = &point.rank_correlations[..] else {
            panic!("one entry per input")
        };
        assert_eq!(random.amplitude, rank_correlation(&of_point(outer)));
        assert_eq!(interval.amplitude, None);
    }
    let pooled = &summary.levels[i];
    let none = pooled
        .rank_correlations
        .iter()
        .all(|c| c.amplitude.is_none());
    assert!(none && pooled.failure_rate.is_none() && pooled.amplitude_m.moments.is_none());
    assert!(pooled.mean_contact_fractions.is_none() && pooled.amplitude_m.valid == 600);
    assert!(level.amplitude_q95_m.is_empty() && level.frequency_q50_hz.is_empty());
    assert!(level.influences[1].amplitude_means_m.is_empty());
}

/// The error by the number of samples is that of the worst outer point. Seen to fail with that of all samples, which is said
/// to be unknown.
#[test]
fn the_error_budget_knows_the_points() {
    let study = nested(600);
    let summary = Summary::of(&study.input());
    let points = summary.epistemic.as_ref().unwrap().levels.iter();
    let widths = points.flat_map(|l| &l.points).filter_map(|point| {
        let q95 = point.frequency_hz.quantiles.last()?.interval;
        Some(0.5 * (q95.upper.value()? - q95.lower.value()?))
    });
    let assessment = Assessment::of(&study.input(), &summary);
    let line = &assessment.error_budget[0];
    assert_eq!(line.frequency_hz, widths.reduce(f64::max));
    assert!(line.frequency_hz.is_some() && line.amplitude_relative.is_some());
}

/// What a criterion judges stands over each epistemic input: a ring per outer point of the study, a cross per point of the search,
/// and one worst point. Seen to fail with all points as rings, and without the mark of the worst.
#[test]
fn the_worst_case_is_drawn_at_the_points() {
    let mut study = nested(180);
    study.record.design.outer_points = 2;
    study.record.design.further_points = 1;
    let page = study.page();
    let section = section(&page, "epistemic");
    let mut figures = section.split("<figure>");
    let figure = figures.find(|f| f.contains("\"worst-case-0-0.svg\""));
    let figure = figure.unwrap().split("<figcaption>").next().unwrap();
    let count = |what: &str| figure.matches(what).count();
    assert_eq!(count("<circle class=\"ring"), 2);
    let crosses = figure.split("class=\"cross ").nth(1).unwrap();
    assert_eq!(
        crosses.split("/>").next().unwrap().matches('M').count(),
        1,
        "{crosses}"
    );
    assert_eq!(count("class=\"mark "), 1);
    assert!(section.contains("the search for the worst case has met"));
}
