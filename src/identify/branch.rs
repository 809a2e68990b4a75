//! The stick branch after a reversal: where it is, and its slope.

use super::half::Half;
use super::mean_loop::{MeanLoop, median};
use super::slope::{Line, pairwise_line, slope_at_start};

/// Part of a half in which the contact sticks, and how its slope is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    /// First and last place of the half.
    pub(super) places: [usize; 2],
    /// Share of the swing of T/N where it ends.
    pub(super) end: f64,
    /// Whether the branch bends from its start.
    pub(super) bent: bool,
}

/// Share of the swing of T/N after a reversal where a window begins.
const BEGIN: f64 = 0.1;
/// Where it ends: the first of these at which the branch is straight.
const ENDS: [f64; 3] = [0.6, 0.45, 0.3];
/// Where the window of a bent branch begins and ends.
const BENT: [f64; 2] = [0.03, 0.6];
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

/// The window of a half, from the share of the swing at each place; none where it has fewer than two samples.
pub(super) fn window(half: &Half, cycle: &MeanLoop, share: &[Option<f64>]) -> Option<Window> {
    let straight = ENDS.iter().find_map(|end| {
        let places = between(share, [BEGIN, *end])?;
        (places[1] + 1 - places[0] >= FEW && !bends(half, cycle, places)).then_some(Window {
            places,
            end: *end,
            bent: false,
        })
    });
    straight
        .or_else(|| {
            let places = between(share, BENT).filter(|p| p[1] + 1 - p[0] >= LEAST_FOR_BEND);
            places.map(|places| Window {
                places,
                end: BENT[1],
                bent: true,
            })
        })
        .or_else(|| {
            let places = between(share, WIDE).filter(|p| p[1] > p[0])?;
            Some(Window {
                places,
                end: WIDE[1],
                bent: false,
            })
        })
}

/// Places between two shares of the swing, around the place where the branch passes their middle.
fn between(share: &[Option<f64>], [begin, end]: [f64; 2]) -> Option<[usize; 2]> {
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
fn bends(half: &Half, cycle: &MeanLoop, [first, last]: [usize; 2]) -> bool {
    let (x, y) = (half.displacement(cycle), half.force(cycle));
    let (count, middle) = (last + 1 - first, usize::midpoint(first, last + 1));
    let line = |from: usize, to: usize| pairwise_line(&x[from..to], &y[from..to]);
    let (Some(early), Some(late)) = (line(first, middle), line(middle, last + 1)) else {
        return false;
    };
    let (Some(a), Some(b)) = (early.standard_error, late.standard_error) else {
        return false;
    };
    let fall = early.slope - late.slope;
    count >= LEAST_FOR_BEND && fall > BEND * early.slope && fall > SURE_BEND * a.hypot(b)
}

/// The line of the branch in its window, over the displacement since the reversal.
pub(super) fn slope(half: &Half, cycle: &MeanLoop, window: &Window) -> Option<Line> {
    let [first, last] = window.places;
    let (x, y) = (half.displacement(cycle), half.force(cycle));
    let (x, y) = (&x[first..=last], &y[first..=last]);
    let line = pairwise_line(x, y)?;
    if !window.bent {
        return Some(line);
    }
    let [intercept, slope] = slope_at_start(x, y)?;
    // least squares of three unknowns: the variance at the end of the window is sixteen times that of a straight line
    let standard_error = line.standard_error.map(|error| 4.0 * error);
    Some(Line {
        slope,
        intercept,
        standard_error,
        ..line
    })
}

/// Displacement after the reversal, and place, where the branch lies below its line for good; none where it never does.
pub(super) fn leaves_line(half: &Half, cycle: &MeanLoop, line: &Line) -> Option<(f64, usize)> {
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
