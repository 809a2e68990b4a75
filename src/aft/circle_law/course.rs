//! Signals of one state of the circle law, and the events of its slider between two of their instants.
//!
//! In stick the slider z = k_t w rests until |s − z| reaches L, with s = k_t u and L = mu N; in slip the traction turns
//! as [`super::slip`] says until its slider would move backwards: λ = e·s' − L' falls to 0.

use super::slip::{HalfAngle, SlipStep};
use super::steady_cycle::{Hold, Touch, hold, tops};
use crate::aft::lanes::lane::{Components, LANES, Lane};
use crate::aft::lanes::workspace::Workspace;
use crate::aft::plan::AftPlan;
use crate::aft::signals::breakpoints::{Breakpoint, Signals, basis_row, signal_rates};
use crate::aft::signals::roots::{crossing_share, linear_share, turn_share, zero};
use crate::aft::vector::{dot, normal};
use crate::contact::ContactParameters;
use crate::contact::Real;
use std::f64::consts::TAU;

/// Newton steps to where the traction of a resting slider is largest over its limit.
const TOP_STEPS: usize = 3;

/// The signals at one phase.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Node<T> {
    /// The sample that this is; none for an event.
    pub sample: Option<usize>,
    pub theta: T,
    /// s (N), s' and s''; the last for events only.
    pub path: [T; 2],
    pub rate: [T; 2],
    pub bend: [T; 2],
    /// L (N), L' and L''; the last for events only.
    pub limit: T,
    pub limit_rate: T,
    pub limit_bend: T,
}

impl<T: Real> Node<T> {
    /// Sample i of a state of the group, for i up to Nt.
    #[inline(always)]
    pub(in crate::aft) fn sampled(
        (work, rates): (&Workspace<T>, &[Components<T>]),
        p: &ContactParameters<T>,
        lane: usize,
        i: usize,
    ) -> Self {
        let n = rates.len();
        let at = if i == n { 0 } else { i };
        let (s, rate) = (&work.samples[at], &rates[at]);
        Self {
            sample: Some(i),
            theta: T::from_f64(i as f64 * TAU / n as f64),
            path: [p.k_t[0] * s.u[0][lane], p.k_t[1] * s.u[1][lane]],
            rate: [p.k_t[0] * rate[lane], p.k_t[1] * rate[LANES + lane]],
            bend: [T::ZERO; 2],
            limit: p.mu * s.normal(lane),
            limit_rate: p.mu * (p.k_n * rate[2 * LANES + lane]),
            limit_bend: T::ZERO,
        }
    }

    /// Rate at which the slider moves along `e`.
    #[inline(always)]
    pub(in crate::aft) fn sliding(&self, e: [T; 2]) -> T {
        dot(e, self.rate) - self.limit_rate
    }

    /// Its change with the phase where `e` turns at the rate `turning`; for events only.
    #[inline(always)]
    pub(in crate::aft) fn sliding_rate(&self, e: [T; 2], turning: T) -> T {
        dot(normal(e), self.rate) * turning + dot(e, self.bend) - self.limit_bend
    }

    /// Change with the phase of this node of a number with these derivatives by the step that ends here.
    #[inline(always)]
    pub(in crate::aft) fn turning(&self, by: &SlipStep<T>) -> T {
        let limit_rate = T::from_f64(0.5) * self.limit_rate;
        dot(by.path, self.rate) + dot(by.rate, self.bend) + by.limit * limit_rate + by.length
    }

    /// Traction of a resting slider over its limit.
    fn touch(&self, slider: [T; 2]) -> Touch<T, T> {
        let t = [self.path[0] - slider[0], self.path[1] - slider[1]];
        Touch::of(self.theta, t, self.limit)
    }

    /// Square of the traction over its limit (N²), with its rate and curvature.
    #[inline(always)]
    fn excess(&self, slider: [T; 2]) -> [T; 3] {
        let t = [self.path[0] - slider[0], self.path[1] - slider[1]];
        let two = T::ONE + T::ONE;
        [
            dot(t, t) - self.limit * self.limit,
            two * (dot(t, self.rate) - self.limit * self.limit_rate),
            two * (dot(self.rate, self.rate) + dot(t, self.bend)
                - self.limit_rate * self.limit_rate
                - self.limit * self.limit_bend),
        ]
    }
}

/// One state of a group.
#[derive(Clone, Copy)]
pub(in crate::aft) struct Course<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub work: &'a Workspace<T>,
    /// The samples. Shape: `[time + 1]`.
    pub nodes: &'a [Node<T>],
    /// Slip from each sample to the next one.
    pub maps: &'a [[Lane<T>; 4]],
    pub lane: usize,
    pub p: &'a ContactParameters<T>,
    pub signals: &'a Signals<T>,
    pub points: &'a [Breakpoint<T>],
}

impl<T: Real> Course<'_, T> {
    /// The sample i; i = Nt is sample 0 a period later.
    #[inline(always)]
    pub(in crate::aft) fn sample(&self, i: usize) -> Node<T> {
        self.nodes[i]
    }

    #[inline(always)]
    pub(in crate::aft) fn phase(&self, i: usize) -> T {
        self.nodes[i].theta
    }

    /// The signals at a phase, and the basis row there.
    #[inline(never)]
    pub(in crate::aft) fn instant(&self, theta: T, row: &mut Vec<T>) -> Node<T> {
        let (plan, p) = (self.plan, self.p);
        row.resize(plan.m, T::ONE);
        basis_row(plan, theta, row);
        let [first, second] = [0, 1].map(|d| {
            let k = p.k_t[d];
            signal_rates(plan, row, &self.signals.u[d]).map(|x| k * x)
        });
        let limit = signal_rates(plan, row, &self.signals.gap).map(|x| p.mu * x);
        Node {
            sample: None,
            theta,
            path: [first[0], second[0]],
            rate: [first[1], second[1]],
            bend: [first[2], second[2]],
            limit: limit[0],
            limit_rate: limit[1],
            limit_bend: limit[2],
        }
    }

    /// A root of the gap function.
    #[inline(always)]
    pub(in crate::aft) fn gap_root(&self, theta: T, row: &mut Vec<T>) -> Node<T> {
        Node {
            limit: T::ZERO,
            ..self.instant(theta, row)
        }
    }

    /// Where a slider that rests from `here` on begins to slip before `next`.
    #[inline(always)]
    pub(in crate::aft) fn slip_start(
        &self,
        [here, next]: [&Node<T>; 2],
        slider: [T; 2],
        row: &mut Vec<T>,
    ) -> Option<Node<T>> {
        let [end, end_rate, _] = next.excess(slider);
        let margin = self.work.tolerance[self.lane];
        let least = margin * (next.limit + next.limit + margin);
        if end <= least && (end_rate >= T::ZERO || here.excess(slider)[1] <= T::ZERO) {
            return None;
        }
        self.crossing([here, next], slider, least, row)
    }

    /// The same after the first look: the slider slips at `next`, or it may do so before.
    #[inline(never)]
    fn crossing(
        &self,
        [here, next]: [&Node<T>; 2],
        slider: [T; 2],
        least: T,
        row: &mut Vec<T>,
    ) -> Option<Node<T>> {
        let margin = self.work.tolerance[self.lane];
        let [end, end_rate, _] = next.excess(slider);
        let [start, start_rate, start_bend] = here.excess(slider);
        let width = next.theta - here.theta;
        let rates = [width * start_rate, width * end_rate];
        let mut high = next.theta;
        let guess = if end > least {
            let half = T::from_f64(0.5);
            let held = margin * (here.limit + here.limit + margin);
            if here.sample.is_none() && start_bend < T::ZERO {
                // Slip ended at `here`, or the contact closed: a double zero, and a cubic beyond it, or a quartic where the
                // motion goes straight back. The quartic's guess is the larger one: from there the search comes down and
                // never meets the rounding around the double zero.
                let fall = -(half * start_bend) * width * width;
                (fall / (end + fall)).sqrt()
            } else if start >= -held && start_rate < T::ZERO {
                // At the limit at the start of the lap: a zero, and a parabola beyond it.
                rates[0] / (rates[0] - end)
            } else {
                crossing_share([start, end], rates)
            }
        } else {
            // Inside at both ends, and perhaps not between them.
            let share = turn_share(end - start, rates);
            let rest = T::ONE - share;
            let [start_part, end_part] = [rest * rest, share * share];
            let top = start_part * (T::ONE + share + share) * start
                + end_part * (T::ONE + rest + rest) * end
                + share * rest * (rest * rates[0] - share * rates[1]);
            if top <= T::ZERO {
                return None;
            }
            let ends = [here.theta, next.theta];
            let guess = here.theta + width * share;
            high = zero(ends, false, guess, T::EPSILON.sqrt(), |theta| {
                let [_, rate, bend] = self.instant(theta, row).excess(slider);
                [rate, bend, T::ZERO]
            });
            let top = self.instant(high, row).excess(slider)[0];
            if top <= least {
                return None;
            }
            share * linear_share(start, top)
        };
        let ends = [here.theta, high];
        let guess = here.theta + width * guess;
        let theta = zero(ends, true, guess, T::EPSILON, |theta| {
            self.instant(theta, row).excess(slider)
        });
        Some(self.instant(theta, row))
    }

    /// Where slip from `here` in the direction `half` ends before `next`, where it would be negative.
    pub(in crate::aft) fn slip_end(
        &self,
        [here, next]: [&Node<T>; 2],
        half: HalfAngle<T>,
        after: HalfAngle<T>,
        row: &mut Vec<T>,
    ) -> Node<T> {
        let before = here.sliding(half.e);
        let share = linear_share(before, next.sliding(after.e));
        let guess = here.theta + share * (next.theta - here.theta);
        let ends = [here.theta, next.theta];
        let theta = zero(ends, false, guess, T::EPSILON, |theta| {
            let node = self.instant(theta, row);
            let step = slip_step(here, &node);
            let e = half.after(step.map()).e;
            let turning = node.turning(&step.angle_rates(half));
            [node.sliding(e), node.sliding_rate(e, turning), T::ZERO]
        });
        self.instant(theta, row)
    }

    /// The point towards which the slider creeps, from where it is.
    #[inline(never)]
    pub(in crate::aft) fn held(&self, slider: [T; 2]) -> Option<Hold<T, T>> {
        let step = T::from_f64(TAU / self.plan.n_time() as f64);
        let near = |theta: T, slider: [T; 2]| {
            let mut row = Vec::new();
            let mut node = self.instant(theta, &mut row);
            for _ in 0..TOP_STEPS {
                let [_, rate, bend] = node.excess(slider);
                let way = -(rate / bend);
                if bend < T::ZERO && way.abs() <= step {
                    node = self.instant(node.theta + way, &mut row);
                }
            }
            node.touch(slider)
        };
        let peaks = |slider| {
            let tops = tops(self.plan.n_time(), |i| self.nodes[i].touch(slider).excess);
            tops.into_iter()
                .map(|i| near(self.phase(i), slider))
                .collect()
        };
        hold(slider, self.work.tolerance[self.lane], near, peaks)
    }

    /// Matrix of the slip from `here` to `next`.
    #[inline(always)]
    pub(in crate::aft) fn map(&self, here: &Node<T>, next: &Node<T>) -> [T; 4] {
        match (here.sample, next.sample) {
            (Some(i), Some(_)) => std::array::from_fn(|k| self.maps[i][k][self.lane]),
            _ => slip_step(here, next).map(),
        }
    }
}

/// The step between two nodes.
#[inline(always)]
pub(in crate::aft) fn slip_step<T: Real>(here: &Node<T>, next: &Node<T>) -> SlipStep<T> {
    SlipStep {
        path: [0, 1].map(|d| next.path[d] - here.path[d]),
        rate: next.rate,
        limit: T::from_f64(0.5) * (here.limit + next.limit),
        length: next.theta - here.theta,
    }
}
