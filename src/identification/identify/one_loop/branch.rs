//! The stick branch after a reversal: where it is, and its slope.

use super::half::Half;
use super::knee::Knee;
use super::slope::{Line, branch_line};
use crate::identify::cycles::mean_loop::{MeanLoop, median};
use crate::identify::cycles::scatter::Batches;

/// Part of a half in which the contact sticks, and how its slope is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct Window<'m> {
    /// First and last place of the half.
    pub(in crate::identify) places: [usize; 2],
    /// Share of the swing of T where it ends.
    pub(in crate::identify) end: f64,
    /// The knee that the branch has, where a part of it slips before the whole.
    pub(in crate::identify) straightened: Option<Straightened<'m>>,
    /// By how much the slope may be another one at the reversal than in the window, over the latter; 0 where nothing says so.
    pub(in crate::identify) apart: f64,
}

/// How the points of a branch with a knee are put on its first slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct Straightened<'m> {
    pub(in crate::identify) knee: Knee<'m>,
    /// T/N at the reversal before, against the motion, and at the end, along it.
    pub(super) levels: [f64; 2],
    /// Offset of T, which is not in these.
    pub(super) offset: f64,
    /// Mean slope over all knees that are possible, over that with this one.
    pub(super) mean: f64,
    /// Relative standard uncertainty of the slope by the choice of the knee.
    pub(super) model_error: f64,
}

/// Share of the swing of T, from a reversal to slip under the normal force of the instant, where a window begins.
const BEGIN: f64 = 0.1;
/// Where it ends: the first of these at which the branch is straight.
const ENDS: [f64; 3] = [0.6, 0.45, 0.3];
/// Window of a branch that has too few samples in the others.
const WIDE: [f64; 2] = [0.0, 0.85];
/// Samples below which the wide window is taken.
const FEW: usize = 4;
/// Fewest samples in which a bend is sought.
const LEAST_FOR_BEND: usize = 8;
/// A branch is bent if the slope of its second half is smaller by more than this share...
const BEND: f64 = 0.02;
/// ...and by more than so many standard errors. Less than two: a bend that is missed makes the stiffness too small.
const SURE_BEND: f64 = 1.5;
/// Largest bend that noise may hide in a branch that counts as straight.
const HIDDEN_BEND: f64 = 0.05;

/// The window of a half, from the share of the swing at each place; none where it has fewer than two samples. Without a knee it ends
/// where the branch is still straight.
pub(super) fn window<'m>(
    half: &Half,
    cycle: &MeanLoop,
    batches: Batches<'_>,
    share: &[Option<f64>],
    straightened: Option<Straightened<'m>>,
) -> Option<Window<'m>> {
    let last = ENDS.len() - 1;
    let found = ENDS.iter().enumerate().find_map(|(i, end)| {
        let places = between(share, [BEGIN, *end])?;
        let enough = places[1] + 1 - places[0] >= FEW;
        let take = straightened.is_some() || i == last || !bends(half, cycle, batches, places);
        (enough && take).then_some((places, *end))
    });
    let wide = || {
        between(share, WIDE)
            .filter(|p| p[1] > p[0])
            .map(|p| (p, WIDE[1]))
    };
    let (places, end) = found.or_else(wide)?;
    Some(Window {
        places,
        end,
        straightened,
        apart: 0.0,
    })
}

/// Places between two shares of the swing, around the place where the branch passes their middle.
pub(super) fn between(share: &[Option<f64>], [begin, end]: [f64; 2]) -> Option<[usize; 2]> {
    let level = |i: usize| {
        let near = &share[i.saturating_sub(1)..(i + 2).min(share.len())];
        median(&mut near.iter().copied().flatten().collect::<Vec<f64>>())
    };
    let middle = 0.5 * (begin + end);
    let passed = (0..share.len()).find(|i| level(*i).is_some_and(|s| s >= middle))?;
    let last = (passed..share.len()).find(|i| share[*i].is_none_or(|s| s > end));
    let last = last.unwrap_or(share.len()).checked_sub(1)?;
    let before = (0..passed)
        .rev()
        .find(|i| share[*i].is_none_or(|s| s < begin));
    let first = before.map_or(0, |i| i + 1);
    (first <= last).then_some([first, last])
}

/// Whether the slope falls inside the window.
fn bends(half: &Half, cycle: &MeanLoop, batches: Batches<'_>, places: [usize; 2]) -> bool {
    let fall = fall(half, cycle, batches, places);
    fall.is_some_and(|[fall, error]| fall > BEND && fall > SURE_BEND * error)
}

/// Whether the slope does not fall inside the window, and a bend that matters would be seen.
pub(super) fn is_straight(
    half: &Half,
    cycle: &MeanLoop,
    batches: Batches<'_>,
    window: &Window<'_>,
) -> bool {
    // from the middle of the window to the reversal, over the distance of the middles of its halves: the more, the shorter it is
    let beyond = |end: f64| (end + BEGIN) / (end - BEGIN);
    let beyond = beyond(window.end) / beyond(ENDS[0]);
    let fall = fall(half, cycle, batches, window.places);
    fall.map(|both| both.map(|of| beyond * of))
        .is_some_and(|[fall, error]| {
            SURE_BEND * error < HIDDEN_BEND && fall <= BEND.max(SURE_BEND * error)
        })
}

/// By how much the slope at the reversal may be above that of a window, over the latter, by a bend that is surely inside it, though too
/// small for a knee: by the line through both halves.
pub(super) fn bend_to_reversal(
    half: &Half,
    cycle: &MeanLoop,
    batches: Batches<'_>,
    window: &Window<'_>,
) -> f64 {
    let beyond = (window.end + BEGIN) / (window.end - BEGIN);
    let fall = fall(half, cycle, batches, window.places);
    let sure = fall.filter(|[fall, error]| *fall > SURE_BEND * error);
    sure.map_or(0.0, |[fall, _]| beyond * fall)
}

/// By how much the slope of the second half of a window is smaller than that of the first one, and the standard error, both over
/// the latter. The error is that by the scatter of the batches where it is larger: noise of a displacement that was put on a smooth
/// motion is no scatter about a line.
fn fall(
    half: &Half,
    cycle: &MeanLoop,
    batches: Batches<'_>,
    [first, last]: [usize; 2],
) -> Option<[f64; 2]> {
    let (count, middle) = (last + 1 - first, usize::midpoint(first, last + 1));
    let lines = |cycle: &MeanLoop| {
        let (x, y) = (half.displacement(cycle), half.force(cycle));
        let line = |from: usize, to: usize| branch_line(&x[from..to], &y[from..to]);
        line(first, middle).zip(line(middle, last + 1))
    };
    let ([early, late], error) = two_slopes(cycle, batches, lines)?;
    (count >= LEAST_FOR_BEND && early > 0.0).then(|| [(early - late) / early, error])
}

/// Slopes of two lines of a branch, the earlier one first, and the standard error of their difference over the earlier one. Noise of the
/// displacement is even in the compliance: the fall of the slope is the rise of the compliance over that of the later line.
pub(super) fn two_slopes(
    cycle: &MeanLoop,
    batches: Batches<'_>,
    lines: impl Fn(&MeanLoop) -> Option<(Line, Line)>,
) -> Option<([f64; 2], f64)> {
    let (early, late) = lines(cycle)?;
    let inside = early.standard_error?.hypot(late.standard_error?) / early.slope;
    let rise = |(early, late): (Line, Line)| 1.0 / late.slope - 1.0 / early.slope;
    let of_batches = batches.error(|one| lines(one).map(rise));
    let of_batches = of_batches.map(|error| late.slope.abs() * error.standard_error);
    let error = of_batches.map_or(inside, |error| error.max(inside));
    Some(([early.slope, late.slope], error))
}

/// The line of the branch in its window, force in the direction of the motion over the displacement since the reversal. With a knee its
/// slope is the mean over all knees; it turns about the middle of the window.
pub(super) fn slope(half: &Half, cycle: &MeanLoop, window: &Window<'_>) -> Option<Line> {
    let [first, last] = window.places;
    let (x, mut y) = (half.displacement(cycle), half.force(cycle));
    if let Some(straightened) = &window.straightened {
        let (start, swings) = half.swings(cycle, straightened.levels);
        let start = start - half.sign * straightened.offset;
        for (place, force) in y.iter_mut().enumerate().take(last + 1).skip(first) {
            let share = (*force + start) / swings[place];
            if share > 0.0 {
                *force = (*force + start) * straightened.knee.elastic(share) / share - start;
            }
        }
    }
    let line = branch_line(&x[first..=last], &y[first..=last])?;
    // any slope up to that distance is as probable
    let of_start = window.apart / 3_f64.sqrt();
    let Some(straightened) = &window.straightened else {
        return Some(Line {
            model_error: of_start * line.slope.abs(),
            ..line
        });
    };
    let middle = 0.5 * (x[first] + x[last]);
    let slope = straightened.mean * line.slope;
    Some(Line {
        slope,
        intercept: line.intercept + (line.slope - slope) * middle,
        standard_error: line.standard_error.map(|error| straightened.mean * error),
        model_error: straightened.model_error.hypot(of_start) * slope.abs(),
        ..line
    })
}

/// Displacement after the reversal, and place, where the branch lies below its line for good; none where it never does.
pub(in crate::identify) fn leaves_line(
    half: &Half,
    cycle: &MeanLoop,
    line: &Line,
) -> Option<(f64, usize)> {
    let (x, y) = (half.displacement(cycle), half.force(cycle));
    let swing = y[y.len() - 1] - y[0];
    let far = (SURE_LEAVE * line.deviation).max(LEAVE * swing);
    let below = |i: &usize| line.intercept + line.slope * x[*i] - y[*i] > far;
    let on = (0..y.len()).rev().find(|i| !below(i));
    let place = on.map_or(0, |i| i + 1);
    (place < y.len()).then(|| (x[place], place))
}

/// Distance from its line, over the swing of T, at which a branch has left it...
const LEAVE: f64 = 0.02;
/// ...and in standard deviations of its points.
const SURE_LEAVE: f64 = 4.0;
