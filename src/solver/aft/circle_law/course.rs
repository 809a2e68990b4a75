//! The signals of one state over the period, and the events of its slider between two phases.
//!
//! Stick ends where |s − z| reaches L, with the slider z = k_t w, s = k_t u and L = mu N. In slip the traction turns as
//! [`super::slip`] says, until its slider would move backwards: slip ends where λ = e·s' − L' falls to 0.

use super::between::Between;
use super::node::{At, Node, slip_step};
use super::sensitivity::Basis;
use super::slip::HalfAngle;
use super::steady_cycle::{Hold, hold, tops};
use crate::aft::lanes::lane::Lane;
use crate::aft::lanes::workspace::Workspace;
use crate::aft::plan::AftPlan;
use crate::aft::signals::breakpoints::{Breakpoint, Signals, first_sample_from};
use crate::aft::signals::polynomial::{basis_row, signal_rates};
use crate::aft::signals::roots::{crossing_share, linear_share, turn_share, zero};
use crate::contact::{ContactParameters, Real};
use std::f64::consts::TAU;

/// Newton steps towards the phase at which the traction of a resting slider exceeds its limit most.
const TOP_STEPS: usize = 3;

/// Largest error of the cubic between two nodes, as a share of its rise above the ends: where it leaves the maximum of the excess
/// this far below the limit, the slider rests. Of a motion cos kθ the cubic misses about (kh)²/12 of the rise in a step h.
const CUBIC_ERROR: f64 = 0.25;

/// The signals of one state of a group.
#[derive(Clone, Copy)]
pub(in crate::aft) struct Course<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub work: &'a Workspace<T>,
    /// The samples. Shape: `[time + 1]`.
    pub nodes: &'a [Node<T>],
    /// Nodes between the samples, if there are any.
    pub between: Option<&'a Between<T>>,
    /// Matrices of the slip from each sample to the next one. Shape: `[time]`.
    pub maps: &'a [[Lane<T>; 4]],
    pub lane: usize,
    pub p: &'a ContactParameters<T>,
    pub signals: &'a Signals<T>,
    pub points: &'a [Breakpoint<T>],
}

impl<'a, T: Real> Course<'a, T> {
    /// The same with nodes between the samples.
    #[inline(always)]
    pub(in crate::aft) fn with(self, between: Option<&'a Between<T>>) -> Self {
        Self { between, ..self }
    }

    /// The sample i; i = Nt is sample 0 a period later.
    #[inline(always)]
    pub(in crate::aft) fn sample(&self, i: usize) -> Node<T> {
        self.nodes[i]
    }

    /// A sample or a node between samples.
    #[inline(always)]
    pub(in crate::aft) fn node(&self, at: At) -> Option<&Node<T>> {
        match at {
            At::Event => None,
            At::Sample(i) => Some(&self.nodes[i]),
            At::Between(k) => self.between.map(|between| &between.nodes[k]),
        }
    }

    #[inline(always)]
    pub(in crate::aft) fn phase(&self, i: usize) -> T {
        self.nodes[i].theta
    }

    /// The signals at a phase, and the basis row there.
    #[inline(never)]
    pub(in crate::aft) fn event_node(&self, theta: T, row: &mut Vec<T>) -> Node<T> {
        let (plan, p) = (self.plan, self.p);
        row.resize(plan.m, T::ONE);
        basis_row(plan, theta, row);
        let [first, second] = [0, 1].map(|d| {
            let k = p.k_t[d];
            signal_rates(plan, row, &self.signals.u[d]).map(|x| k * x)
        });
        let limit = signal_rates(plan, row, &self.signals.gap).map(|x| p.mu * x);
        Node {
            at: At::Event,
            theta,
            path: [first[0], second[0]],
            rate: [first[1], second[1]],
            bend: [first[2], second[2]],
            jerk: [first[3], second[3]],
            limit: limit[0],
            limit_rate: limit[1],
            limit_bend: limit[2],
            limit_jerk: limit[3],
        }
    }

    /// The basis row at a node; `row` is that of an event.
    #[inline(always)]
    pub(in crate::aft) fn basis<'b>(&self, node: &Node<T>, row: &'b [T]) -> Basis<'b, T>
    where
        Self: 'b,
    {
        match (node.at, self.between) {
            (At::Sample(i), _) if i == self.plan.n_time() => Basis::Sample(0),
            (At::Sample(i), _) => Basis::Sample(i),
            (At::Between(k), Some(between)) => Basis::Event(between.row(k)),
            _ => Basis::Event(row),
        }
    }

    /// The next sample after a sample or a root of the gap, and the next node between samples: the interval of a root has none.
    #[inline(always)]
    pub(in crate::aft) fn after(&self, node: &Node<T>) -> (usize, usize) {
        let (from, next) = match node.at {
            At::Sample(i) => (i, i + 1),
            _ => {
                let i = first_sample_from(node.theta.to_f64(), self.plan.n_time() as f64);
                (i, i)
            }
        };
        (next, self.between.map_or(0, |nodes| nodes.before[from]))
    }

    /// First phase and length of the cell before sample i whose end is node k between the samples or, where there is none before
    /// that sample, the sample itself; nothing if the whole interval is one cell.
    #[inline(always)]
    pub(in crate::aft) fn cell(&self, i: usize, k: usize) -> Option<[T; 2]> {
        let between = self.between?;
        let before = between.before[i.saturating_sub(1)];
        if before == between.before[i] {
            return None;
        }
        let start = match k > before {
            true => between.nodes[k - 1].theta,
            false => self.phase(i - 1),
        };
        let end = match k < between.before[i] {
            true => between.nodes[k].theta,
            false => self.phase(i),
        };
        Some([start, end - start])
    }

    /// The signals at a root of the gap function, where the limit is exactly 0.
    #[inline(always)]
    pub(in crate::aft) fn gap_root(&self, theta: T, row: &mut Vec<T>) -> Node<T> {
        Node {
            limit: T::ZERO,
            ..self.event_node(theta, row)
        }
    }

    /// Where a slider that rests from `here` on begins to slip, if that is before `next`; the basis row there.
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

    /// The same after the cheap test: the traction exceeds its limit at `next`, or may do so between the two nodes.
    #[inline(never)]
    fn crossing(
        &self,
        [here, next]: [&Node<T>; 2],
        slider: [T; 2],
        least: T,
        row: &mut Vec<T>,
    ) -> Option<Node<T>> {
        let [end, end_rate, _] = next.excess(slider);
        let at_start = here.excess(slider);
        let [start, start_rate, _] = at_start;
        let width = next.theta - here.theta;
        let rates = [width * start_rate, width * end_rate];
        let mut high = next.theta;
        let guess = if end > least {
            self.guess_of_start(here, at_start, [end, end_rate], width)
        } else {
            // Inside at both ends, and perhaps not between them.
            let share = turn_share(end - start, rates);
            let rest = T::ONE - share;
            let [start_part, end_part] = [rest * rest, share * share];
            let top = start_part * (T::ONE + share + share) * start
                + end_part * (T::ONE + rest + rest) * end
                + share * rest * (rest * rates[0] - share * rates[1]);
            // Where slip ended at `here` the traction falls from its limit: the cubic starts from an exact maximum.
            let error = match here.at {
                At::Event => T::ZERO,
                _ => T::from_f64(CUBIC_ERROR) * (top - start).or_larger(top - end),
            };
            if top + error <= T::ZERO {
                return None;
            }
            let ends = [here.theta, next.theta];
            let guess = here.theta + width * share;
            high = zero(ends, false, guess, T::EPSILON.sqrt(), |theta| {
                let [_, rate, bend] = self.event_node(theta, row).excess(slider);
                [rate, bend, T::ZERO]
            });
            let top = self.event_node(high, row).excess(slider)[0];
            if top <= least {
                return None;
            }
            share * linear_share(start, top)
        };
        let ends = [here.theta, high];
        let guess = here.theta + width * guess;
        let theta = zero(ends, true, guess, T::EPSILON, |theta| {
            self.event_node(theta, row).excess(slider)
        });
        Some(self.event_node(theta, row))
    }

    /// First guess, as a share of the step, of where a resting slider begins to slip: from the excess with its derivatives
    /// at `here`, and with its rate at the end, where the traction is over its limit. `width` is the length of the step.
    #[inline(always)]
    fn guess_of_start(
        &self,
        here: &Node<T>,
        [start, start_rate, start_bend]: [T; 3],
        [end, end_rate]: [T; 2],
        width: T,
    ) -> T {
        let margin = self.work.tolerance[self.lane];
        let rates = [width * start_rate, width * end_rate];
        let half = T::from_f64(0.5);
        let held = margin * (here.limit + here.limit + margin);
        if here.at == At::Event && start_bend < T::ZERO {
            // Slip ended at `here`, or the contact closed: a double zero, and a cubic beyond it, or a quartic where the
            // motion goes straight back. The quartic's guess is the larger one. From there the search comes down and never
            // meets the rounding around the double zero.
            let fall = -(half * start_bend) * width * width;
            (fall / (end + fall)).sqrt()
        } else if start >= -held && start_rate < T::ZERO {
            // At the limit at the start of the lap: a zero, and a parabola beyond it.
            rates[0] / (rates[0] - end)
        } else {
            crossing_share([start, end], rates)
        }
    }

    /// Where slip from `here` on, in the direction `half`, ends before `next`: at `next` its rate would be negative, in the
    /// direction `after`.
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
            let node = self.event_node(theta, row);
            let step = slip_step(here, &node);
            let e = half.after(step.map()).e;
            let turning = node.turning(&step.angle_rates(half));
            [node.sliding(e), node.sliding_rate(e, turning), T::ZERO]
        });
        self.event_node(theta, row)
    }

    /// The point towards which the slider creeps from lap to lap, if two phases hold it there.
    #[inline(never)]
    pub(in crate::aft) fn held(&self, slider: [T; 2]) -> Option<Hold<T, T>> {
        let step = T::from_f64(TAU / self.plan.n_time() as f64);
        let near = |theta: T, slider: [T; 2]| {
            let mut row = Vec::new();
            let mut node = self.event_node(theta, &mut row);
            for _ in 0..TOP_STEPS {
                let [_, rate, bend] = node.excess(slider);
                let offset = -(rate / bend);
                if bend < T::ZERO && offset.abs() <= step {
                    node = self.event_node(node.theta + offset, &mut row);
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
        match (here.at, next.at) {
            (At::Sample(i), At::Sample(_)) => std::array::from_fn(|k| self.maps[i][k][self.lane]),
            _ => slip_step(here, next).map(),
        }
    }
}
