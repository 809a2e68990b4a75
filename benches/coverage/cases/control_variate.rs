//! Intervals of means and probabilities by control variate.
#![expect(
    clippy::unwrap_used,
    reason = "a case without an interval is a broken case and must end the count"
)]

use super::super::functions::Numbers;
use super::case::{CONFIDENCE, Cases};
use super::independent::exponential;
use microslip::statistics::{ControlledSamples, Interval};

/// Result and control of one sample.
type Law = fn(&mut Numbers) -> (f64, f64);

/// Mean 0, correlation 0.995.
fn normal(numbers: &mut Numbers) -> (f64, f64) {
    let z = numbers.normal();
    (z + 0.1 * numbers.normal(), 2.0 * z)
}

/// Mean 1, skewed; a control that bends.
fn skewed(numbers: &mut Numbers) -> (f64, f64) {
    let x = exponential(numbers);
    (x, x.powf(0.8) + 0.1 * numbers.normal())
}

/// Mean 1, skewed; a control of no use.
fn useless(numbers: &mut Numbers) -> (f64, f64) {
    (exponential(numbers), numbers.normal())
}

/// Uniform, with an error of the control of up to 5 %.
fn uniform(numbers: &mut Numbers) -> (f64, f64) {
    let u = numbers.uniform();
    (u, 3.0 * u + 0.3 * (numbers.uniform() - 0.5))
}

/// Results and controls of `n` samples, and controls of `further` ones.
fn draw(numbers: &mut Numbers, law: Law, n: usize, further: usize) -> [Vec<f64>; 3] {
    let (results, controls) = (0..n).map(|_| law(numbers)).unzip();
    [
        results,
        controls,
        (0..further).map(|_| law(numbers).1).collect(),
    ]
}

fn samples([results, controls, further]: &[Vec<f64>; 3]) -> ControlledSamples<'_> {
    ControlledSamples {
        results,
        controls,
        further,
    }
}

pub(crate) fn control_variates(cases: &mut Cases) {
    let open = Interval::UNBOUNDED;
    let laws: [(&str, Law, f64); 3] = [
        ("normal", normal, 0.0),
        ("exponential", skewed, 1.0),
        ("useless control", useless, 1.0),
    ];
    for (name, law, truth) in laws {
        for (n, further) in [(20, 200), (64, 192), (64, 4000), (200, 4000)] {
            let text = format!("{n} independent, {further} further, {name}");
            cases.add("mean by control variate", text, move |numbers, _| {
                let drawn = draw(numbers, law, n, further);
                let found = samples(&drawn).mean(open, CONFIDENCE).unwrap();
                found.interval.contains(truth)
            });
        }
    }
    for p in [0.02, 0.1, 0.5] {
        for (n, further) in [(64, 192), (64, 4000), (200, 4000)] {
            let text = format!("{n} independent, {further} further, p = {p}");
            cases.add("exceedance by control variate", text, move |numbers, _| {
                let drawn = draw(numbers, uniform, n, further);
                let found = samples(&drawn).exceedance(1.0 - p, CONFIDENCE).unwrap();
                found.probability.lower <= p && p <= found.probability.upper
            });
        }
    }
}
