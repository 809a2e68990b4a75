//! Intervals of independent samples.
#![expect(
    clippy::unwrap_used,
    reason = "a case without an interval is a broken case and must end the count"
)]

use super::super::functions::{Numbers, z};
use super::case::{CONFIDENCE, Cases};
use microslip::statistics::{
    Better, CurveSet, Enclosed, Interval, MissingPoints, Observed, Side, compare, depth_band,
    exceedance, joint_region, moment_estimate, quantile_estimate, simultaneous_band,
    tolerance_bound, weighted_exceedance, weighted_quantile,
};
use std::f64::consts::TAU;

/// A skewed law with mean and standard deviation 1.
pub(crate) fn exponential(numbers: &mut Numbers) -> f64 {
    -numbers.uniform().ln()
}

/// Uniform samples, the first `failed` of them unknown.
fn observed(numbers: &mut Numbers, n: usize, failed: usize) -> Observed {
    Observed::of((0..n).map(|i| match (numbers.uniform(), i < failed) {
        (_, true) => f64::NAN,
        (u, false) => u,
    }))
}

pub(crate) fn order_statistics(cases: &mut Cases) {
    for (n, p) in [(100, 0.5), (200, 0.95), (60, 0.1)] {
        for failed in [0, 3] {
            let samples = format!("{n} independent, {failed} failed, p = {p}");
            cases.add("quantile", samples, move |numbers, _| {
                let found = quantile_estimate(&observed(numbers, n, failed), p, CONFIDENCE);
                found.unwrap().interval.contains(p)
            });
        }
    }
    for (n, content) in [(59, 0.95), (200, 0.95), (46, 0.9)] {
        let samples = format!("{n} independent, content {content}");
        cases.add("tolerance bound", samples, move |numbers, _| {
            let all = observed(numbers, n, 0);
            let bound = tolerance_bound(&all, Side::Upper, content, CONFIDENCE);
            bound.limit.value().is_none_or(|limit| limit >= content)
        });
    }
    for (n, p) in [(50, 0.1), (200, 0.5), (100, 0.02)] {
        let samples = format!("{n} independent, p = {p}");
        cases.add("exceedance probability", samples, move |numbers, _| {
            let found = exceedance(&observed(numbers, n, 0), 1.0 - p, CONFIDENCE).unwrap();
            found.probability.lower <= p && p <= found.probability.upper
        });
    }
}

/// Intervals of pairs of numbers: the region that holds most pairs, and the comparison of two designs.
pub(crate) fn pairs(cases: &mut Cases) {
    for n in [153, 300] {
        let samples = format!("{n} independent pairs, content 0.95");
        cases.add("joint tolerance region", samples, move |numbers, _| {
            let pairs: Vec<_> = (0..n)
                .map(|_| (numbers.uniform(), numbers.uniform()))
                .collect();
            let region = joint_region(&pairs, 0.95, CONFIDENCE);
            let end = |side: Interval| {
                [
                    side.lower.value().unwrap_or(0.0),
                    side.upper.value().unwrap_or(1.0),
                ]
            };
            let ([a, b], [c, d]) = (end(region.x), end(region.y));
            (b - a) * (d - c) >= 0.95
        });
    }
    let differences = |numbers: &mut Numbers| {
        let common: Vec<f64> = (0..200).map(|_| 10.0 * numbers.normal()).collect();
        let one = common.iter().map(|c| c + 0.2 + numbers.normal());
        let one: Vec<Enclosed> = one.map(Enclosed::exact).collect();
        let common: Vec<Enclosed> = common.iter().copied().map(Enclosed::exact).collect();
        compare(&one, &common, Better::Smaller, CONFIDENCE).unwrap()
    };
    let samples = "200 pairs of two designs".to_owned();
    cases.add("median difference", samples.clone(), move |numbers, _| {
        let median = differences(numbers).median_difference.unwrap();
        median.interval.contains(0.2)
    });
    cases.add("share of better samples", samples, move |numbers, _| {
        let better = differences(numbers).a_better;
        better.lower <= 0.420_740_29 && 0.420_740_29 <= better.upper // Φ(−0.2)
    });
}

/// Mean and standard deviation of exp(s z), z standard normal.
fn of_lognormal(s: f64) -> [f64; 2] {
    let square = s.powi(2);
    [
        (square / 2.0).exp(),
        (square.exp_m1() * square.exp()).sqrt(),
    ]
}

pub(crate) fn moments(cases: &mut Cases) {
    type Draw = fn(&mut Numbers) -> f64;
    let lognormal = |numbers: &mut Numbers| (0.56 * numbers.normal()).exp();
    let laws: [(&str, Draw, [f64; 2]); 4] = [
        ("normal", Numbers::normal, [0.0, 1.0]),
        ("uniform", Numbers::uniform, [0.5, 1.0 / 12_f64.sqrt()]),
        ("exponential", exponential, [1.0, 1.0]),
        ("lognormal, s = 0.56", lognormal, of_lognormal(0.56)),
    ];
    let mut add = |intervals: [&'static str; 2],
                   name: &str,
                   draw: Draw,
                   n: usize,
                   [mean, deviation]: [f64; 2]| {
        let estimate = move |numbers: &mut Numbers| {
            let all = Observed::of((0..n).map(|_| draw(numbers)));
            moment_estimate(&all, Interval::UNBOUNDED, CONFIDENCE).unwrap()
        };
        let samples = format!("{n} independent, {name}");
        cases.add(intervals[0], samples.clone(), move |numbers, _| {
            estimate(numbers).mean.contains(mean)
        });
        // fewer have no interval of the standard deviation
        if n >= 40 {
            cases.add(intervals[1], samples, move |numbers, _| {
                estimate(numbers).standard_deviation.contains(deviation)
            });
        }
    };
    for (name, draw, truth) in laws {
        for n in [8, 20, 40, 200] {
            add(["mean", "standard deviation"], name, draw, n, truth);
        }
    }
    // what no interval from samples alone holds for
    let skewed = ["mean, skewness 6", "standard deviation, skewness 6"];
    let exp = |numbers: &mut Numbers| numbers.normal().exp();
    add(skewed, "exp(z)", exp, 200, of_lognormal(1.0));
}

/// a cos t + b sin t at six places, as the curves that bands are formed of.
fn curve(numbers: &mut Numbers) -> Vec<f64> {
    let (a, b) = (numbers.normal(), numbers.normal());
    let at = |i: i32| TAU * f64::from(i) / 6.0;
    (0..6).map(|i| a * at(i).cos() + b * at(i).sin()).collect()
}

pub(crate) fn curves(cases: &mut Cases) {
    for (interval, n, level) in [("simultaneous band", 58, 0.85), ("depth band", 158, 0.8)] {
        for failed in [0, 4] {
            let samples = format!("{n} curves, {failed} failed, one more");
            cases.add(interval, samples, move |numbers, _| {
                let rows = (0..n).map(|i| Some(curve(numbers)).filter(|_| i >= failed));
                let set = CurveSet::from_rows((0..6).map(f64::from).collect(), rows.collect());
                let band = match interval {
                    "simultaneous band" => {
                        simultaneous_band(&set, level, 0.95, MissingPoints::Outside)
                    }
                    _ => depth_band(&set, level, 0.95, MissingPoints::Outside),
                };
                let fresh = curve(numbers);
                // A refusal is a band without edges.
                band.is_err()
                    || band
                        .unwrap()
                        .points
                        .iter()
                        .zip(&fresh)
                        .all(|(point, y)| point.is_none_or(|p| p.lower <= *y && *y <= p.upper))
            });
            if let Some(case) = cases.0.last_mut() {
                case.statements[0].stated = level;
            }
        }
    }
}

/// z of N(0, 1) made to stand for N(shift, 1): a tail to the right carries the weight.
pub(crate) fn weights(cases: &mut Cases) {
    let cases_of_shift = [
        (100, 0.6),
        (400, 0.6),
        (400, 1.0),
        (2000, 1.0),
        (2000, 1.4),
        (2000, 1.8),
    ];
    for (n, shift) in cases_of_shift {
        let draw = move |numbers: &mut Numbers| {
            let z = numbers.normals(n);
            let weights: Vec<f64> = z.iter().map(|z| (shift * z).exp()).collect();
            (z, weights)
        };
        for p in [0.02, 0.05, 0.1, 0.2, 0.5, 0.95] {
            let samples = format!("{n} independent, shift {shift}, p = {p}");
            let limit = shift + z(1.0 - p);
            cases.add("re-weighted exceedance", samples, move |numbers, _| {
                let (values, weights) = draw(numbers);
                let found = weighted_exceedance(&values, &weights, limit, CONFIDENCE).unwrap();
                found.lower <= p && p <= found.upper
            });
            let samples = format!("{n} independent, shift {shift}, p = {:.2}", 1.0 - p);
            cases.add("re-weighted quantile", samples, move |numbers, _| {
                let (values, weights) = draw(numbers);
                let found = weighted_quantile(&values, &weights, 1.0 - p, CONFIDENCE).unwrap();
                found.interval.contains(limit)
            });
        }
    }
}
