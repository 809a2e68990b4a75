//! Forced responses as most tests want them: solutions alone.

use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::response::forced_response::{self, CurveSettings, Response};
use microslip::hb::response::values::{self, SlowSweep};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{HbSettings, Problem, Solution};

/// Step of a dense curve.
const DENSE: f64 = 0.02;

/// What a slow sweep through the frequencies `omega` (rad/s) meets, from the lowest or from the highest; in their order.
pub(crate) fn at_frequencies(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    omega: &[f64],
    direction: SweepDirection,
) -> Vec<Solution> {
    let mut order: Vec<usize> = (0..omega.len()).collect();
    order.sort_by(|&i, &j| omega[i].total_cmp(&omega[j]));
    let ascending: Vec<f64> = order.iter().map(|&i| omega[i]).collect();
    let sweep = SlowSweep {
        band: Band {
            low: ascending[0],
            high: ascending[omega.len() - 1],
        },
        direction,
        omega: &ascending,
    };
    let found = values::at_frequencies(problem, settings, level, sweep, |_| ());
    let place = |i| order.iter().position(|&j| j == i);
    let solution = |i| place(i).map(|at| found.solutions[at].clone());
    (0..omega.len()).filter_map(solution).collect()
}

/// The response over `band` with solutions close together.
pub(crate) fn dense_curve(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    band: Band,
) -> Response {
    let curve = CurveSettings { band, step: DENSE };
    forced_response::over_band(problem, settings, level, curve, |_| ())
}

/// Solutions along the branch over `band`, close together.
pub(crate) fn over_band(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    band: Band,
) -> Vec<Solution> {
    dense_curve(problem, settings, level, band).solutions
}
