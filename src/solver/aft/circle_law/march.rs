//! Steady cycle of the coupled (circle) law with events decided or interpolated at the samples.
//!
//! Lanes march together; [`super::steady_cycle`] searches for the cycle of each.

use super::steady_cycle::{Hold, LapEnd, Next, Origin, Search, Touch, classify, hold, tops};
use crate::aft::forces::Periodicity;
use crate::aft::lanes::lane::{LANES, Lane};
use crate::aft::lanes::workspace::{LapCount, LapPosition, Workspace, flag};
use crate::aft::plan::AftPlan;
use crate::aft::settings::Laps;
use crate::aft::vector::{dot, normal};
use crate::contact::Real;
use crate::contact::law::{anchored_at_closing, circle_step};

/// How the lanes were marched.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Cycle<T> {
    /// Counts of the last lap.
    pub count: LapCount<T>,
    /// Sliders at the start of the last lap (m).
    pub start: [Lane<T>; 2],
    /// Laps of each state.
    pub laps: [u32; LANES],
    /// Periodicity of each state.
    pub periodicity: [Periodicity; LANES],
    /// What the derivative is that of.
    pub origin: [Origin<usize, T>; LANES],
    /// In contact and stuck all the time.
    pub stuck: [bool; LANES],
}

/// 2 × 2 identity for every lane.
#[inline(always)]
pub(in crate::aft) fn identity<T: Real>() -> [Lane<T>; 4] {
    [
        [T::ONE; LANES],
        [T::ZERO; LANES],
        [T::ZERO; LANES],
        [T::ONE; LANES],
    ]
}

/// Marches the lanes of `work`; their tractions are then those of the last lap.
#[inline(always)]
pub(in crate::aft) fn march_circle<T: Real>(
    plan: &AftPlan<T>,
    work: &mut Workspace<T>,
) -> Cycle<T> {
    let mut w = work.parameters.anchor;
    let mut monodromy = identity();
    let count = work.circle_lap(&mut w, &mut monodromy, LapPosition::First);
    let mut cycle = Cycle {
        stuck: std::array::from_fn(|l| count.slip[l] == T::ZERO && work.separated[l] == T::ZERO),
        count,
        start: work.parameters.anchor,
        laps: [1; LANES],
        periodicity: [Periodicity::DependsOnAnchor; LANES],
        origin: [Origin::Anchor; LANES],
    };
    if cycle.stuck.iter().all(|&s| s) {
        return cycle;
    }
    match plan.settings().laps {
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
            self.count = work.circle_lap(&mut w, &mut monodromy, LapPosition::Later);
        }
        for l in 0..LANES {
            if !self.stuck[l] {
                self.laps[l] = u32::try_from(laps).unwrap_or(u32::MAX);
            }
            let periodic = self.end(work, l, &w, &monodromy).is_periodic();
            self.periodicity[l] = classify(periodic, lane4(&monodromy, l));
        }
    }

    /// Steady cycle of every lane, from the sliders at the end of the first lap. Lanes that have found theirs repeat it.
    #[inline(always)]
    fn steady(&mut self, work: &mut Workspace<T>, w: [Lane<T>; 2]) {
        self.start = w;
        let path = |work: &Workspace<T>, w: &[Lane<T>; 2], l| {
            let k_t = lane2(&work.parameters.k_t, l);
            [k_t[0] * w[0][l], k_t[1] * w[1][l]]
        };
        let mut search: [Search<usize, T>; LANES] =
            std::array::from_fn(|l| Search::new(path(work, &w, l)));
        let mut searching = self.stuck.map(|stuck| !stuck);
        while searching.contains(&true) {
            let (mut end, mut monodromy) = (self.start, identity());
            self.count = work.circle_lap(&mut end, &mut monodromy, LapPosition::Later);
            for (l, searching) in searching.iter_mut().enumerate().filter(|(_, s)| **s) {
                let lap = self.end(work, l, &end, &monodromy);
                let next = search[l].take(lap, |slider| held(work, l, slider));
                for d in 0..2 {
                    self.start[d][l] = match next {
                        Next::Plain => end[d][l],
                        Next::From(z) => z[d] * work.parameters.flexibility[d][l],
                        Next::Nothing => self.start[d][l],
                    };
                }
                *searching = next != Next::Nothing;
            }
        }
        for (l, search) in search.iter().enumerate().filter(|&(l, _)| !self.stuck[l]) {
            self.laps[l] = search.laps;
            self.periodicity[l] = search.periodicity;
            self.origin[l] = search.origin;
        }
    }

    /// The last lap of a lane, which ended at the sliders `end`.
    #[inline(always)]
    fn end(
        &self,
        work: &Workspace<T>,
        l: usize,
        end: &[Lane<T>; 2],
        monodromy: &[Lane<T>; 4],
    ) -> LapEnd<T> {
        let k_t = lane2(&work.parameters.k_t, l);
        let path = |w: &[Lane<T>; 2]| [k_t[0] * w[0][l], k_t[1] * w[1][l]];
        LapEnd {
            start: path(&self.start),
            end: path(end),
            monodromy: lane4(monodromy, l),
            longest_slip: self.count.largest_slip_squared[l].sqrt(),
            tolerance: work.tolerance[l],
        }
    }
}

#[inline(always)]
pub(in crate::aft) fn lane2<T: Copy>(x: &[Lane<T>; 2], l: usize) -> [T; 2] {
    [x[0][l], x[1][l]]
}

#[inline(always)]
fn lane4<T: Copy>(x: &[Lane<T>; 4], l: usize) -> [T; 4] {
    [x[0][l], x[1][l], x[2][l], x[3][l]]
}

/// The point k_t w towards which the slider of a lane creeps, from where it is.
#[inline(never)]
fn held<T: Real>(work: &Workspace<T>, l: usize, slider: [T; 2]) -> Option<Hold<usize, T>> {
    let touch = |i: usize, slider: [T; 2]| {
        let (p, s) = (&work.parameters, &work.samples[i]);
        let t = [0, 1].map(|d| p.k_t[d][l] * s.u[d][l] - slider[d]);
        Touch::of(i, t, p.mu[l] * s.normal(l))
    };
    let peaks = |slider| {
        let tops = tops(work.samples.len(), |i| touch(i, slider).excess);
        tops.into_iter().map(|i| touch(i, slider)).collect()
    };
    hold(slider, work.tolerance[l], touch, peaks)
}

impl<T: Real> Workspace<T> {
    /// One lap of the circle law from the sliders `w`, which end where the lap ends. `monodromy` (2 × 2, row-major) is
    /// multiplied by the derivative of the end traction by the start traction.
    #[inline(always)]
    pub(in crate::aft) fn circle_lap(
        &mut self,
        w: &mut [Lane<T>; 2],
        monodromy: &mut [Lane<T>; 4],
        lap: LapPosition,
    ) -> LapCount<T> {
        let margin: Lane<T> = std::array::from_fn(|l| self.touch_margin(l));
        let p = &self.parameters;
        let mut count = LapCount::<T>::default();
        for i in 0..self.samples.len() {
            let closing: Option<Lane<T>> = self
                .closes(i, lap)
                .then(|| std::array::from_fn(|l| self.closing(i, l, lap)));
            let s = &mut self.samples[i];
            for l in 0..LANES {
                let u = [s.u[0][l], s.u[1][l]];
                let start = match closing {
                    Some(instant) => [
                        anchored_at_closing(w[0][l], u[0], instant[l]),
                        anchored_at_closing(w[1][l], u[1], instant[l]),
                    ],
                    None => [w[0][l], w[1][l]],
                };
                let k_t = [p.k_t[0][l], p.k_t[1][l]];
                let flexibility = [p.flexibility[0][l], p.flexibility[1][l]];
                let limit = p.mu[l] * s.normal(l);
                let step = circle_step(k_t, flexibility, limit, margin[l], u, start);
                [s.traction[0][l], s.traction[1][l]] = step.traction;
                [w[0][l], w[1][l]] = step.slider;
                let contact = s.gap[l] > T::ZERO;
                count.slip[l] += flag(step.slips & contact);
                let missing = T::ONE - step.ratio;
                let square = step.trial[0] * step.trial[0] + step.trial[1] * step.trial[1];
                count.largest_slip_squared[l] =
                    count.largest_slip_squared[l].or_larger(missing * missing * square);
                // entry by entry: with a closure this loop is no vector code
                let factor = [
                    monodromy[0][l],
                    monodromy[1][l],
                    monodromy[2][l],
                    monodromy[3][l],
                ];
                let turned = slip_monodromy(step.trial, step.ratio, factor);
                for (entry, (&old, new)) in monodromy.iter_mut().zip(factor.iter().zip(turned)) {
                    let sliding = if step.touches { new } else { old };
                    entry[l] = if contact { sliding } else { T::ZERO };
                }
            }
        }
        count
    }
}

/// Derivative of a slip step, a p pᵀ, times the 2 × 2 matrix `factor`; p is normal to the trial traction.
#[inline(always)]
pub(in crate::aft) fn slip_monodromy<T: Real>(trial: [T; 2], ratio: T, factor: [T; 4]) -> [T; 4] {
    let scale = ratio / dot(trial, trial);
    let normal = normal(trial);
    let row = [
        scale * (normal[0] * factor[0] + normal[1] * factor[2]),
        scale * (normal[0] * factor[1] + normal[1] * factor[3]),
    ];
    [
        normal[0] * row[0],
        normal[0] * row[1],
        normal[1] * row[0],
        normal[1] * row[1],
    ]
}
