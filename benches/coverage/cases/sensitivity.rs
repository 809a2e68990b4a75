//! Intervals of designs with a structure, of Sobol' indices and of surrogates.
#![expect(
    clippy::unwrap_used,
    reason = "a case without an interval is a broken case and must end the count"
)]

use super::super::functions::{Function, G, ISHIGAMI, KINK, LOGNORMAL, Numbers, ONE, SUM};
use super::case::{CONFIDENCE, Cases, per_input};
use microslip::sampling::pick_freeze::PickFreeze;
use microslip::sampling::sobol::Sobol;
use microslip::statistics::{
    Bootstrap, ChaosSettings, GivenData, HoldOutSettings, Index, Polynomials, SobolIndex,
    SurrogateSamples, cross_fit, first_order_index, replicate_mean, replicate_quantile,
    sobol_indices,
};

/// Scrambled Sobol' points with the number of their replicate.
fn sobol_points(function: &Function, seed: u64, n: u64, replicates: u64) -> Vec<(u64, Vec<f64>)> {
    let sequence = Sobol::new(function.dimensions);
    let point = |i: u64| sequence.scrambled(seed, i % replicates, 2 << 16, i / replicates);
    (0..n).map(|i| (i % replicates, point(i))).collect()
}

pub(crate) fn replicates(cases: &mut Cases) {
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

pub(crate) fn given_data(cases: &mut Cases) {
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

pub(crate) fn pick_freeze(cases: &mut Cases) {
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

pub(crate) fn surrogates(cases: &mut Cases) {
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
