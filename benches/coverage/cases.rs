//! One case per interval, law and number of samples: does the interval of a repetition hold the truth?
#![expect(
    clippy::unwrap_used,
    reason = "a case without an interval is a broken case and must end the count"
)]

use super::functions::{Function, G, ISHIGAMI, KINK, LOGNORMAL, Numbers, ONE, SUM, z};
use microslip::report::asked::{Criterion, Quantity};
use microslip::sampling::pick_freeze::PickFreeze;
use microslip::sampling::rectangles::seek_largest;
use microslip::sampling::sobol::Sobol;
use microslip::statistics::{
    Better, Bootstrap, ChaosSettings, CurveSet, GivenData, HoldOutSettings, Index, Interval,
    MissingPoints, Observed, Polynomials, Side, SobolIndex, Sorted, SurrogateSamples, compare,
    confidence_at, cross_fit, depth_band, exceedance, first_order_index, joint_region, looks,
    moment_estimate, quantile, quantile_estimate, replicate_mean, replicate_quantile,
    simultaneous_band, sobol_indices, tolerance_bound, weighted_exceedance, weighted_quantile,
};
use std::f64::consts::TAU;

/// Confidence of the intervals but where a case says otherwise.
const CONFIDENCE: f64 = 0.95;

/// What is said of samples of one kind: one interval or several.
pub(crate) struct Case {
    /// Which intervals, in the order of [`Case::covers`].
    pub(crate) statements: Vec<Statement>,
    covers: Box<dyn Fn(u64) -> Vec<bool> + Sync>,
}

/// An interval on samples of a kind.
#[derive(Debug, Clone)]
pub(crate) struct Statement {
    /// Which interval.
    pub(crate) interval: &'static str,
    /// Law, number and design of the samples.
    pub(crate) samples: String,
    /// Coverage that is promised.
    pub(crate) stated: f64,
}

impl Case {
    /// Whether each interval of a repetition holds the truth.
    pub(crate) fn covers(&self, seed: u64) -> Vec<bool> {
        (self.covers)(seed)
    }
}

/// Adds cases of one stated coverage.
struct Cases(Vec<Case>);

impl Cases {
    fn add(
        &mut self,
        interval: &'static str,
        samples: String,
        covers: impl Fn(&mut Numbers, u64) -> bool + Sync + 'static,
    ) {
        let one = move |numbers: &mut Numbers, seed| vec![covers(numbers, seed)];
        self.add_several(vec![(interval, samples)], one);
    }

    fn add_several(
        &mut self,
        statements: Vec<(&'static str, String)>,
        covers: impl Fn(&mut Numbers, u64) -> Vec<bool> + Sync + 'static,
    ) {
        let statement = |(interval, samples)| Statement {
            interval,
            samples,
            stated: CONFIDENCE,
        };
        self.0.push(Case {
            statements: statements.into_iter().map(statement).collect(),
            covers: Box::new(move |seed| covers(&mut Numbers::of(seed), seed)),
        });
    }
}

/// A statement per input of a function.
fn per_input(
    interval: &'static str,
    samples: &str,
    function: &Function,
) -> Vec<(&'static str, String)> {
    let input = |j: usize| {
        (
            interval,
            format!("{samples}, {}, input {}", function.name, j + 1),
        )
    };
    (0..function.dimensions).map(input).collect()
}

/// All cases.
pub(crate) fn all() -> Vec<Case> {
    let mut cases = Cases(Vec::new());
    order_statistics(&mut cases);
    moments(&mut cases);
    curves(&mut cases);
    weights(&mut cases);
    replicates(&mut cases);
    given_data(&mut cases);
    pick_freeze(&mut cases);
    surrogates(&mut cases);
    verdicts_over_a_box(&mut cases);
    stopped_studies(&mut cases);
    cases.0
}

/// Verdicts on a number that keeps its limit at every place of a box, and no better than it must: false FAILs at the points of
/// a search. Each place has the samples u of all, turned by `turns` times its distance from 0.
fn verdicts_over_a_box(cases: &mut Cases) {
    for turns in [0.5, 7.3] {
        let samples = format!("100 independent at the points of a search, {turns} turns");
        cases.add("no false FAIL over a box", samples, move |numbers, _| {
            let u = numbers.uniforms(100);
            let mut broken = Vec::new();
            seek_largest(1, 9, |points| {
                let at = |point: &Vec<f64>| {
                    let turned = u.iter().map(|u| (u + turns * point[0]).fract());
                    let sorted = Sorted::finite(turned);
                    broken.push(sorted.values().iter().filter(|v| **v > 0.95).count());
                    quantile(&sorted, 0.95).unwrap()
                };
                points.iter().map(at).collect()
            });
            let demonstration = below_95_percent().demonstration(broken.len(), 0);
            let least = demonstration.rejection(u.len());
            broken.iter().all(|&broken| broken < least)
        });
    }
}

/// 95 % of uniform numbers stay below the limit, and no more.
fn below_95_percent() -> Criterion {
    Criterion {
        name: "uniform".to_owned(),
        standard: None,
        clause: None,
        quantity: Quantity::AmplitudeUm,
        limit: 0.95,
        level: None,
        share: None,
        confidence: None,
    }
}

/// Studies that stop at a look: at the first interval without the truth, which is the worst that a rule can do; at a PASS or
/// a FAIL of a limit that is kept, just so; and at an interval that is narrow enough.
fn stopped_studies(cases: &mut Cases) {
    for p in [0.5, 0.95] {
        let samples = format!("at most 4096 independent, p = {p}");
        let interval = "quantile, study stops where it misses the truth";
        cases.add(interval, samples, move |numbers, _| {
            let mut values = Vec::new();
            looks(32, 4096).into_iter().zip(1..).all(|(n, look)| {
                values.resize_with(n as usize, || numbers.uniform());
                let all = Observed::of(values.iter().copied());
                let found = quantile_estimate(&all, p, confidence_at(look, CONFIDENCE));
                found.unwrap().interval.contains(p)
            })
        });
    }
    let samples = || "at most 4096 independent, limit at the quantile".to_owned();
    for (verdict, pass) in [
        ("no false PASS where a study stops", true),
        ("no false FAIL where a study stops", false),
    ] {
        cases.add(verdict, samples(), move |numbers, _| {
            let (mut broken, mut drawn) = (0, 0);
            looks(32, 4096).into_iter().zip(1..).all(|(n, look)| {
                let new = numbers.uniforms(n as usize - drawn);
                drawn = n as usize;
                broken += new.iter().filter(|u| **u > 0.95).count();
                let demonstration = below_95_percent().demonstration(1, look);
                match pass {
                    true => broken >= demonstration.acceptance(drawn),
                    false => broken < demonstration.rejection(drawn),
                }
            })
        });
    }
    let samples = "at most 4096 independent, exponential, median to 20 %".to_owned();
    cases.add(
        "quantile, study stops where it is narrow",
        samples,
        |numbers, _| {
            let mut values = Vec::new();
            let mut last = Interval::UNBOUNDED;
            for (n, look) in looks(32, 4096).into_iter().zip(1..) {
                values.resize_with(n as usize, || exponential(numbers));
                let all = Observed::of(values.iter().copied());
                let found = quantile_estimate(&all, 0.5, confidence_at(look, CONFIDENCE)).unwrap();
                last = found.interval;
                let width = last
                    .upper
                    .value()
                    .zip(last.lower.value())
                    .map(|(b, a)| b - a);
                if width.is_some_and(|width| width <= 0.2 * found.estimate) {
                    break;
                }
            }
            last.contains(2_f64.ln())
        },
    );
}

/// A skewed law with mean and standard deviation 1.
fn exponential(numbers: &mut Numbers) -> f64 {
    -numbers.uniform().ln()
}

/// Uniform samples, the first `failed` of them unknown.
fn observed(numbers: &mut Numbers, n: usize, failed: usize) -> Observed {
    Observed::of((0..n).map(|i| match (numbers.uniform(), i < failed) {
        (_, true) => f64::NAN,
        (u, false) => u,
    }))
}

fn order_statistics(cases: &mut Cases) {
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
        compare(
            &one.collect::<Vec<_>>(),
            &common,
            Better::Smaller,
            CONFIDENCE,
        )
        .unwrap()
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

fn moments(cases: &mut Cases) {
    type Draw = fn(&mut Numbers) -> f64;
    let lognormal = |numbers: &mut Numbers| (0.56 * numbers.normal()).exp();
    let square = 0.56_f64.powi(2);
    let of_lognormal = (square.exp_m1() * square.exp()).sqrt();
    let laws: [(&str, Draw, f64, f64); 4] = [
        ("normal", Numbers::normal, 0.0, 1.0),
        ("uniform", Numbers::uniform, 0.5, 1.0 / 12_f64.sqrt()),
        ("exponential", exponential, 1.0, 1.0),
        (
            "lognormal, s = 0.56",
            lognormal,
            (square / 2.0).exp(),
            of_lognormal,
        ),
    ];
    for (name, draw, mean, deviation) in laws {
        for n in [8, 20, 40, 200] {
            let estimate = move |numbers: &mut Numbers| {
                let all = Observed::of((0..n).map(|_| draw(numbers)));
                moment_estimate(&all, Interval::UNBOUNDED, CONFIDENCE).unwrap()
            };
            let samples = format!("{n} independent, {name}");
            cases.add("mean", samples.clone(), move |numbers, _| {
                estimate(numbers).mean.contains(mean)
            });
            // fewer have no interval of the standard deviation
            if n >= 40 {
                cases.add("standard deviation", samples, move |numbers, _| {
                    estimate(numbers).standard_deviation.contains(deviation)
                });
            }
        }
    }
}

/// a cos t + b sin t at six places, as the curves that bands are formed of.
fn curve(numbers: &mut Numbers) -> Vec<f64> {
    let (a, b) = (numbers.normal(), numbers.normal());
    let at = |i: i32| TAU * f64::from(i) / 6.0;
    (0..6).map(|i| a * at(i).cos() + b * at(i).sin()).collect()
}

fn curves(cases: &mut Cases) {
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
fn weights(cases: &mut Cases) {
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

/// Scrambled Sobol' points with the number of their replicate.
fn sobol_points(function: &Function, seed: u64, n: u64, replicates: u64) -> Vec<(u64, Vec<f64>)> {
    let sequence = Sobol::new(function.dimensions);
    let point = |i: u64| sequence.scrambled(seed, i % replicates, 2 << 16, i / replicates);
    (0..n).map(|i| (i % replicates, point(i))).collect()
}

fn replicates(cases: &mut Cases) {
    // means: 3/4, 1/2, 7/2, e^{5/32}, 3/2 · 0.29, 1
    let means = [0.75, 3.5, (5.0_f64 / 32.0).exp(), 0.435, 1.0];
    let functions = [SUM, ISHIGAMI, LOGNORMAL, KINK, G];
    for (function, mean) in functions.into_iter().zip(means) {
        for (replicates, points) in [(4, 64), (8, 64), (16, 16)] {
            let values = move |seed: u64| -> Vec<(u64, f64)> {
                let points = sobol_points(&function, seed, replicates * points, replicates);
                let value = |(replicate, u): (u64, Vec<f64>)| (replicate, (function.value)(&u));
                points.into_iter().map(value).collect()
            };
            let samples = format!(
                "{replicates} replicates of {points} Sobol' points, {}",
                function.name
            );
            cases.add("mean of replicates", samples.clone(), move |_, seed| {
                let found = replicate_mean(values(seed), CONFIDENCE).unwrap();
                found.interval.contains(mean)
            });
            cases.add("quantile of replicates", samples, move |_, seed| {
                let found = replicate_quantile(values(seed), 0.9, CONFIDENCE).unwrap();
                found.interval.contains(function.q90)
            });
        }
    }
}

fn given_data(cases: &mut Cases) {
    let interval = "first-order index by ranks";
    for function in [SUM, ONE, ISHIGAMI, LOGNORMAL, KINK] {
        for n in [160, 1000] {
            let statements = per_input(interval, &format!("{n} independent"), &function);
            cases.add_several(statements, move |numbers, seed| {
                let points = numbers.points(n, function.dimensions);
                let points: Vec<_> = points.into_iter().map(|u| (0, u)).collect();
                let index = |j| rank_index(&function, &points, None, (j, seed));
                each_holds(function.first, index)
            });
        }
        let statements = per_input(interval, "8 x 64 Sobol' points", &function);
        cases.add_several(statements, move |_, seed| {
            let points = sobol_points(&function, seed, 512, 8);
            let replicates: Vec<u64> = points.iter().map(|(r, _)| *r).collect();
            let index = |j| rank_index(&function, &points, Some(&replicates), (j, seed));
            each_holds(function.first, index)
        });
    }
}

/// Whether the index of each input holds its truth, but for rounding: a surrogate may be exact.
fn each_holds(truths: &[f64], index: impl Fn(usize) -> Index) -> Vec<bool> {
    let holds = |(j, truth): (usize, &f64)| {
        let found = index(j);
        found.lower - 1e-9 <= *truth && *truth <= found.upper + 1e-9
    };
    truths.iter().enumerate().map(holds).collect()
}

fn rank_index(
    function: &Function,
    points: &[(u64, Vec<f64>)],
    replicates: Option<&[u64]>,
    (j, seed): (usize, u64),
) -> Index {
    let inputs: Vec<f64> = points.iter().map(|(_, u)| u[j]).collect();
    let results: Vec<f64> = points.iter().map(|(_, u)| (function.value)(u)).collect();
    let data = GivenData {
        inputs: &inputs,
        results: &results,
        replicates,
        seed,
        confidence: CONFIDENCE,
    };
    first_order_index(&data).unwrap().index
}

fn pick_freeze(cases: &mut Cases) {
    for function in [SUM, ISHIGAMI, G, KINK] {
        let kinds = ["first-order index, pick-freeze", "total index, pick-freeze"];
        let statements = kinds.map(|kind| per_input(kind, "64 rows", &function));
        cases.add_several(statements.concat(), move |_, seed| {
            let design = PickFreeze::new(function.dimensions);
            let value = |i| (function.value)(&design.point(seed, i));
            let results: Vec<f64> = (0..64 * design.row()).map(value).collect();
            let found = row_indices(&results, &function, seed);
            let first = each_holds(function.first, |j| found[j].first);
            [first, each_holds(function.total, |j| found[j].total)].concat()
        });
    }
}

fn row_indices(results: &[f64], function: &Function, seed: u64) -> Vec<SobolIndex> {
    let bootstrap = Bootstrap {
        seed,
        replicates: 200,
        confidence: CONFIDENCE,
    };
    sobol_indices(results, function.dimensions, &bootstrap).unwrap()
}

fn surrogates(cases: &mut Cases) {
    for function in [SUM, ISHIGAMI, LOGNORMAL, KINK, G] {
        for n in [60, 200] {
            let samples = format!("{n} independent");
            let exceedance = (
                "exceedance by surrogate",
                format!("{samples}, {}", function.name),
            );
            let kinds = ["first-order index by surrogate", "total index by surrogate"];
            let [first, total] = kinds.map(|kind| per_input(kind, &samples, &function));
            let statements = [vec![exceedance], first, total].concat();
            cases.add_several(statements, move |numbers, seed| {
                surrogate_holds(&function, n, (numbers, seed))
            });
        }
    }
}

/// Exceedance probability, first and total indices of a surrogate of n samples.
fn surrogate_holds(
    function: &Function,
    n: usize,
    (numbers, seed): (&mut Numbers, u64),
) -> Vec<bool> {
    let basis = match function.name {
        "lognormal" => Polynomials::Hermite,
        _ => Polynomials::Legendre,
    };
    let coordinates =
        |u: &Vec<f64>| -> Vec<f64> { u.iter().map(|u| basis.coordinate(*u)).collect() };
    let points = numbers.points(n, function.dimensions);
    let samples = SurrogateSamples {
        basis: &vec![basis; function.dimensions],
        inputs: &points.iter().map(coordinates).collect::<Vec<_>>(),
        results: &points
            .iter()
            .map(|u| (function.value)(u))
            .collect::<Vec<_>>(),
    };
    let hold_out = HoldOutSettings {
        parts: 5,
        most_fitted: 2000,
        seed,
    };
    let fit = cross_fit(&samples, &hold_out, &ChaosSettings::default()).unwrap();
    let points = numbers.points(4000, function.dimensions);
    let points = points.iter().map(coordinates);
    let share = fit
        .exceedance(points, function.q90, CONFIDENCE)
        .unwrap()
        .probability;
    let indices = fit.indices(CONFIDENCE);
    [
        vec![share.lower <= 0.1 && 0.1 <= share.upper],
        each_holds(function.first, |j| indices[j].first),
        each_holds(function.total, |j| indices[j].total),
    ]
    .concat()
}
