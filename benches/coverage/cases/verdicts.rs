//! Verdicts over a box, and studies that stop as soon as they may.
#![expect(
    clippy::unwrap_used,
    reason = "a case without an interval is a broken case and must end the count"
)]

use super::case::{CONFIDENCE, Cases};
use super::independent::exponential;
use microslip::report::asked::{Criterion, RequiredQuantity};
use microslip::sampling::rectangles::seek_largest;
use microslip::statistics::{
    Interval, Observed, Sorted, confidence_at, looks, quantile, quantile_estimate,
};

/// Verdicts on a number that keeps its limit at every place of a box, and no better than it must: false FAILs at the points of
/// a search. Each place has the samples u of all, turned by `turns` times its distance from 0.
pub(crate) fn verdicts_over_a_box(cases: &mut Cases) {
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
        quantity: RequiredQuantity::AmplitudeUm,
        limit: 0.95,
        level: None,
        share: None,
        confidence: None,
    }
}

/// Studies that stop at a look: at the first interval without the truth, which is the worst that a rule can do; at a PASS or
/// a FAIL of a limit that is kept, just so; and at an interval that is narrow enough.
pub(crate) fn stopped_studies(cases: &mut Cases) {
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
