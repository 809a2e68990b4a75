//! Whether a branch is steeper at its start than where its slope is taken: then a part of the contact has slipped before.

use super::branch::{Window, between, slope, two_slopes};
use super::half::Half;
use crate::identify::cycles::mean_loop::MeanLoop;
use crate::identify::cycles::scatter::Batches;

/// Share of the swing of T from which on a start is...
const FIRST: f64 = 0.02;
/// ...and those up to which it is: so far into the window that it has samples; shorter ones show parts that slip still earlier.
const LAST: [f64; 3] = [0.15, 0.1, 0.06];
/// Samples after the reversal that are none of the branch: the corner of the loop lies between two samples, or is found one too early.
const CORNER: usize = 2;
/// Fewest samples of a start that tells its slope.
const LEAST_FOR_START: usize = 4;
/// Difference of both slopes, over that of the window, that counts...
const APART: f64 = 0.005;
/// ...and in standard errors: each of three starts is tried on two sides, and few batches tell an error.
const SURELY_APART: f64 = 3.0;

/// Difference from which on a start is no branch, but the rounded turn of the motion, and no start says anything: more than half of a
/// contact does not slip so early.
const STEEPEST: f64 = 1.0;
/// Change of the force that goes with the normal force, over its whole change in a start, from which on its slope says nothing.
const BY_LOAD: f64 = 0.1;

/// By how much the slope of a start is above that of the window, over the latter: of the start that differs most from it, and surely; none
/// where all are alike or have too few samples.
pub(super) fn steeper(
    half: &Half,
    cycle: &MeanLoop,
    batches: Batches<'_>,
    share: &[Option<f64>],
    window: &Window<'_>,
) -> Option<f64> {
    let starts = LAST
        .iter()
        .filter_map(|last| between(share, [FIRST, *last]));
    let starts = starts.map(|[first, last]| [first.max(CORNER), last]);
    let told = starts.filter(|[first, last]| {
        last + 1 >= first + LEAST_FOR_START && follows_motion(half, cycle, [*first, *last])
    });
    let found = told.filter_map(|places| {
        let start = Window { places, ..*window };
        difference(half, cycle, batches, [&start, window])
    });
    let found: Vec<[f64; 2]> = found.collect();
    if found.iter().any(|[excess, _]| *excess > STEEPEST) {
        return None;
    }
    let sure = found
        .iter()
        .filter(|[excess, error]| excess.abs() > APART.max(SURELY_APART * error));
    // what the error hides may be there, too
    sure.map(|[excess, error]| excess + error.copysign(*excess))
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// Whether the force changes there by the motion: under a normal force that falls the contact goes on slipping after the reversal.
fn follows_motion(half: &Half, cycle: &MeanLoop, places: [usize; 2]) -> bool {
    let force = half.force(cycle);
    let [first, last] = places.map(|place| cycle.normal[half.sample(place, cycle)]);
    let by_load = (last - first) / first * force[places[0]];
    let by_motion = force[places[1]] - force[places[0]];
    by_load.abs() < BY_LOAD * by_motion
}

/// Difference of the slopes in two windows over that of the second one, and its standard error.
fn difference(
    half: &Half,
    cycle: &MeanLoop,
    batches: Batches<'_>,
    [start, window]: [&Window<'_>; 2],
) -> Option<[f64; 2]> {
    let lines = |cycle: &MeanLoop| slope(half, cycle, start).zip(slope(half, cycle, window));
    let ([early, late], error) = two_slopes(cycle, batches, lines)?;
    (late > 0.0 && early > 0.0).then(|| [early / late - 1.0, error])
}
