//! Steady cycle of the coupled (circle) law.
//!
//! One lap maps the two slider positions at its start to those at its end. The map shortens distances, so laps
//! converge, but slowly where little slips; Newton's method on the two end tractions converges in a few laps. Where
//! the map is the identity (no slip over a lap) every slider position is steady, and the one that plain laps reach
//! from the anchor counts.

use super::batch::Periodicity;
use super::march::{LANES, Lane, LapCount, Workspace, slip_monodromy};
use super::plan::AftPlan;
use super::settings::Laps;
use crate::contact::Real;
use crate::contact::law::{anchored_at_closing, circle_step};

/// Laps with Newton steps before the march goes on with plain laps.
pub(super) const NEWTON_LAPS: u32 = 30;
/// Laps after which a cycle counts as not periodic.
pub(super) const MAX_LAPS: u32 = 200;

/// How the lanes were marched.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cycle<T> {
    /// Counts of the last lap.
    pub count: LapCount<T>,
    /// Sliders at the start of the last lap (m).
    pub start: [Lane<T>; 2],
    /// Laps of each state.
    pub laps: [u32; LANES],
    /// Periodicity of each state.
    pub periodicity: [Periodicity; LANES],
    /// Whether the derivative is that of plain laps from the anchor, not that of the steady cycle.
    pub from_anchor: [bool; LANES],
    /// In contact and stuck all the time.
    pub stuck: [bool; LANES],
}

/// 2 × 2 identity for every lane.
#[inline(always)]
pub(super) fn identity<T: Real>() -> [Lane<T>; 4] {
    [
        [T::ONE; LANES],
        [T::ZERO; LANES],
        [T::ZERO; LANES],
        [T::ONE; LANES],
    ]
}

/// Marches the lanes of `work`; their tractions are then those of the last lap.
#[inline(always)]
pub(super) fn march<T: Real>(plan: &AftPlan<T>, work: &mut Workspace<T>) -> Cycle<T> {
    let mut w = work.parameters.anchor;
    let mut monodromy = identity();
    let count = work.circle_lap(&mut w, &mut monodromy, true);
    let mut cycle = Cycle {
        stuck: std::array::from_fn(|l| count.slip[l] == T::ZERO && work.separated[l] == T::ZERO),
        count,
        start: work.parameters.anchor,
        laps: [1; LANES],
        periodicity: [Periodicity::DependsOnAnchor; LANES],
        from_anchor: [true; LANES],
    };
    if cycle.stuck.iter().all(|&s| s) {
        return cycle;
    }
    match plan.settings.laps {
        Laps::Fixed(n) => cycle.fixed(work, n, w, monodromy),
        Laps::Periodic => cycle.steady(work, w),
    }
    cycle
}

impl<T: Real> Cycle<T> {
    /// The laps after the first one, which ended at `w`.
    #[inline(always)]
    fn fixed(
        &mut self,
        work: &mut Workspace<T>,
        laps: usize,
        mut w: [Lane<T>; 2],
        mut monodromy: [Lane<T>; 4],
    ) {
        for _ in 1..laps {
            self.start = w;
            monodromy = identity();
            self.count = work.circle_lap(&mut w, &mut monodromy, false);
        }
        for l in 0..LANES {
            if !self.stuck[l] {
                self.laps[l] = u32::try_from(laps).unwrap_or(u32::MAX);
            }
            let change = change_over_lap(work, l, lane2(&self.start, l), lane2(&w, l));
            let periodic = size(change) <= work.tolerance[l];
            self.periodicity[l] = classify(periodic, lane4(&monodromy, l));
        }
    }

    /// Steady cycle of every lane, from the sliders at the end of the first lap.
    #[inline(always)]
    fn steady(&mut self, work: &mut Workspace<T>, w: [Lane<T>; 2]) {
        self.start = w;
        let mut search = [Search::default(); LANES];
        for (search, &stuck) in search.iter_mut().zip(&self.stuck) {
            search.done = stuck;
        }
        for lap in 2..=MAX_LAPS {
            let (mut end, mut monodromy) = (self.start, identity());
            self.count = work.circle_lap(&mut end, &mut monodromy, false);
            for (l, search) in search.iter_mut().enumerate().filter(|(_, s)| !s.done) {
                self.laps[l] = lap;
                let change = change_over_lap(work, l, lane2(&self.start, l), lane2(&end, l));
                let tolerance = work.tolerance[l];
                let m = lane4(&monodromy, l);
                if search.settled(change, m, tolerance) || lap == MAX_LAPS {
                    search.done = true;
                    self.periodicity[l] = classify(size(change) <= tolerance, m);
                    self.from_anchor[l] = is_singular(m);
                } else {
                    let step = search.step(change, m, lap);
                    for (d, start) in self.start.iter_mut().enumerate() {
                        start[l] += step[d] * work.parameters.flexibility[d][l];
                    }
                }
            }
            if search.iter().all(|s| s.done) {
                break;
            }
        }
        for (l, search) in search.iter().enumerate() {
            let rests = self.count.overshoot[l] <= T::EPSILON.sqrt();
            if search.newton && rests {
                self.plain_laps(work, l);
            }
        }
    }

    /// Plain laps of one lane from the anchor, where Newton's method ended in a cycle without slip, which is not
    /// unique. Where they creep, their limit is where several samples hold the slider, which Newton's method finds
    /// from their end; if it does not, the cycle that it found before stays.
    fn plain_laps(&mut self, work: &mut Workspace<T>, l: usize) {
        let found = lane2(&self.start, l);
        let mut w = lane2(&work.parameters.anchor, l);
        for lap in 1..=MAX_LAPS {
            let start = w;
            let (slip, _) = lap_of_lane(work, l, &mut w, lap == 1);
            let change = change_over_lap(work, l, start, w);
            if lap > 1 && size(change) <= work.tolerance[l] {
                (self.start[0][l], self.start[1][l]) = (start[0], start[1]);
                (self.laps[l], self.count.slip[l]) = (lap, slip);
                self.periodicity[l] = Periodicity::DependsOnAnchor;
                self.from_anchor[l] = true;
                return;
            }
        }
        let held = held_slider(work, l, w);
        if held.is_some() {
            self.periodicity[l] = Periodicity::DependsOnAnchor;
            self.from_anchor[l] = false;
        }
        w = held.unwrap_or(found);
        (self.start[0][l], self.start[1][l]) = (w[0], w[1]);
        (self.count.slip[l], _) = lap_of_lane(work, l, &mut w, false);
    }
}

/// Search for the steady slider of one lane.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Search<T> {
    done: bool,
    /// Whether a Newton step was made.
    pub newton: bool,
    /// Change over the lap before, while Newton steps are tried.
    last: Option<T>,
}

impl<T: Real> Search<T> {
    /// Whether the distance to the steady slider, as Newton's method sees it, is within rounding; if I − M is nearly
    /// singular it stays larger, and the search ends when the change over a lap no longer falls.
    #[inline(always)]
    pub(super) fn settled(&self, change: [T; 2], m: [T; 4], tolerance: T) -> bool {
        let distance = if is_singular(m) {
            change
        } else {
            solve_identity_minus(m, change)
        };
        size(distance) <= tolerance || (size(change) <= tolerance && self.failed(change))
    }

    /// Whether the last Newton step failed to halve the change over a lap.
    #[inline(always)]
    fn failed(&self, change: [T; 2]) -> bool {
        let now = size(change);
        self.last.is_some_and(|last| now + now > last)
    }

    /// Change of k_t w for the next lap: a Newton step if it can be made and the last one did not fail.
    #[inline(always)]
    pub(super) fn step(&mut self, change: [T; 2], m: [T; 4], lap: u32) -> [T; 2] {
        let now = size(change);
        if self.failed(change) || lap > NEWTON_LAPS || is_singular(m) {
            self.last = None;
            return change;
        }
        (self.last, self.newton) = (Some(now), true);
        solve_identity_minus(m, change)
    }
}

/// x of (I − M) x = b.
#[inline(always)]
pub(super) fn solve_identity_minus<T: Real>(m: [T; 4], b: [T; 2]) -> [T; 2] {
    let determinant = determinant_of_identity_minus(m);
    let (a, d) = (T::ONE - m[0], T::ONE - m[3]);
    [
        (d * b[0] + m[1] * b[1]) / determinant,
        (a * b[1] + m[2] * b[0]) / determinant,
    ]
}

#[inline(always)]
fn determinant_of_identity_minus<T: Real>(m: [T; 4]) -> T {
    (T::ONE - m[0]) * (T::ONE - m[3]) - m[1] * m[2]
}

#[inline(always)]
pub(super) fn is_singular<T: Real>(m: [T; 4]) -> bool {
    determinant_of_identity_minus(m) <= T::EPSILON.sqrt()
}

#[inline(always)]
pub(super) fn classify<T: Real>(periodic: bool, monodromy: [T; 4]) -> Periodicity {
    match (periodic, is_singular(monodromy)) {
        (false, _) => Periodicity::NotPeriodic,
        (true, true) => Periodicity::DependsOnAnchor,
        (true, false) => Periodicity::Unique,
    }
}

/// Change of k_t w over a lap (N).
#[inline(always)]
pub(super) fn change_over_lap<T: Real>(
    work: &Workspace<T>,
    l: usize,
    start: [T; 2],
    end: [T; 2],
) -> [T; 2] {
    let k_t = work.parameters.of(l).k_t;
    [k_t[0] * (end[0] - start[0]), k_t[1] * (end[1] - start[1])]
}

#[inline(always)]
pub(super) fn size<T: Real>(x: [T; 2]) -> T {
    (x[0] * x[0] + x[1] * x[1]).sqrt()
}

#[inline(always)]
pub(super) fn lane2<T: Copy>(x: &[Lane<T>; 2], l: usize) -> [T; 2] {
    [x[0][l], x[1][l]]
}

#[inline(always)]
fn lane4<T: Copy>(x: &[Lane<T>; 4], l: usize) -> [T; 4] {
    [x[0][l], x[1][l], x[2][l], x[3][l]]
}

/// Slider at the start of a lap on which several samples hold it, by Newton's method from `w`.
fn held_slider<T: Real>(work: &mut Workspace<T>, l: usize, mut w: [T; 2]) -> Option<[T; 2]> {
    for _ in 0..NEWTON_LAPS {
        let start = w;
        let (_, m) = lap_of_lane(work, l, &mut w, false);
        if is_singular(m) {
            return None;
        }
        let step = solve_identity_minus(m, change_over_lap(work, l, start, w));
        if size(step) <= work.tolerance[l] {
            return Some(start);
        }
        w = std::array::from_fn(|d| start[d] + step[d] * work.parameters.flexibility[d][l]);
    }
    None
}

/// One lap of one lane; returns the number of samples that slip and the derivative of the end traction by the start
/// traction.
fn lap_of_lane<T: Real>(
    work: &mut Workspace<T>,
    l: usize,
    w: &mut [T; 2],
    first: bool,
) -> (T, [T; 4]) {
    let mut monodromy = lane4(&identity(), l);
    let margin = work.touch_margin(l);
    let p = work.parameters;
    let mut slip = T::ZERO;
    for i in 0..work.samples.len() {
        let closing = work.closing(i, l, first);
        let s = &mut work.samples[i];
        let u = [s.u[0][l], s.u[1][l]];
        let start = [
            anchored_at_closing(w[0], u[0], closing),
            anchored_at_closing(w[1], u[1], closing),
        ];
        let limit = p.mu[l] * s.normal(l);
        let (k_t, flexibility) = (lane2(&p.k_t, l), lane2(&p.flexibility, l));
        let step = circle_step(k_t, flexibility, (limit, margin), u, start);
        *w = step.slider;
        [s.traction[0][l], s.traction[1][l]] = step.traction;
        if s.gap[l] <= T::ZERO {
            monodromy = [T::ZERO; 4];
        } else if step.touches {
            monodromy = slip_monodromy(step.trial, step.ratio, monodromy);
        }
        if step.slips && s.gap[l] > T::ZERO {
            slip += T::ONE;
        }
    }
    (slip, monodromy)
}
