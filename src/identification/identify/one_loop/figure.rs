//! Columns and lines of the figures of a test.

use super::loop_estimate::LoopNumbers;
use super::loop_shape::LoopShape;
use crate::identify::cycles::mean_loop::MeanLoop;
use crate::identify::found::result::LoopFigure;

/// Most points of a figure.
const MOST_POINTS: usize = 500;

/// Figure of the mean loop with the force that was fitted to it and the rest, all as measured; the offset of T is taken out here.
pub(in crate::identify) fn figure(
    cycle: &MeanLoop,
    shape: &LoopShape<'_>,
    numbers: &LoopNumbers,
    fitted: &[f64],
    rest: &[f64],
) -> LoopFigure {
    let n = cycle.samples();
    let step = n.div_ceil(MOST_POINTS);
    let thin = |values: &[f64]| values.iter().step_by(step).copied().collect::<Vec<f64>>();
    let offset = numbers.friction.map_or(0.0, |plateaus| plateaus.offset);
    let top = cycle.displacement[0];
    let bottom = cycle.displacement[shape.halves[1].sample(0, cycle)];
    let middle = 0.5 * (top + bottom);
    let less =
        |values: &[f64], what: f64| thin(values).iter().map(|v| v - what).collect::<Vec<f64>>();
    let tangential = less(&cycle.tangential, offset);
    let normal = thin(&cycle.normal);
    let ratio = |(t, n): (&f64, &f64)| if *n > shape.least_normal { t / n } else { 0.0 };
    let sides = [0, 1];
    let span = |side: usize, [first, last]: [usize; 2]| {
        [first, last].map(|place| shape.halves[side].sample(place, cycle).min(n - 1) / step)
    };
    LoopFigure {
        displacement_m: less(&cycle.displacement, middle),
        force_ratio: tangential.iter().zip(&normal).map(ratio).collect(),
        tangential_force_n: tangential,
        normal_force_n: normal,
        approach_m: cycle.approach.as_deref().map(thin),
        fitted_force_n: Some(less(fitted, offset)),
        residual_n: Some(thin(rest)),
        stick_windows: sides.map(|side| shape.windows[side].map(|w| span(side, w.places))),
        plateaus: sides.map(|side| shape.plateaus.map(|places| span(side, places[side]))),
        stick_lines: sides.map(|side| {
            let (line, window) = (numbers.lines[side]?, shape.windows[side]?);
            let half = &shape.halves[side];
            let start = [top, bottom][side] - middle;
            let end = half.displacement(cycle)[window.places[1]];
            let at = |x: f64| {
                [
                    start + half.sign * x,
                    half.sign * (line.intercept + line.slope * x) - offset,
                ]
            };
            Some([at(0.0), at(end)])
        }),
    }
}
