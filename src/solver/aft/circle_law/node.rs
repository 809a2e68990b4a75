//! The signals of one contact at one phase.
//!
//! s = k_t u is the elastic traction that a slider at 0 would have, L = mu N the friction limit. The contact sticks while the
//! slider z = k_t w rests and |s − z| ≤ L.

use super::slip::SlipStep;
use super::steady_cycle::Touch;
use crate::aft::lanes::lane::{Components, LANES};
use crate::aft::lanes::workspace::Workspace;
use crate::aft::vector::{dot, normal};
use crate::contact::{ContactParameters, Real};
use std::f64::consts::TAU;

/// Cosine of the angle by which the velocity may turn in a step: half a radian.
const TURN: f64 = 0.8776;
/// Way in a step, over the friction limit, that is short: there one step of slip resolves the turn.
const SHORT: f64 = 0.5;
/// Way across the path in a step, over the friction limit, below which the motion counts as straight.
const ACROSS: f64 = 1e-3;

/// What a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::aft) enum At {
    /// An event of the slider or of the gap; its phase depends on the motion.
    Event,
    /// The sample of this number.
    Sample(usize),
    /// The node of this number between samples ([`super::between`]).
    Between(usize),
}

/// The signals at one phase.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Node<T> {
    pub at: At,
    pub theta: T,
    /// s (N), and its derivatives s', s'' and s''' by the phase; s'' and s''' not for samples.
    pub path: [T; 2],
    pub rate: [T; 2],
    pub bend: [T; 2],
    pub jerk: [T; 2],
    /// L (N), L', L'' and L'''; L'' and L''' not for samples.
    pub limit: T,
    pub limit_rate: T,
    pub limit_bend: T,
    pub limit_jerk: T,
}

impl<T: Real> Node<T> {
    /// Sample i of one state of the group; i = Nt is sample 0 one period later.
    #[inline(always)]
    pub(in crate::aft) fn sampled(
        work: &Workspace<T>,
        rates: &[Components<T>],
        p: &ContactParameters<T>,
        lane: usize,
        i: usize,
    ) -> Self {
        let n = rates.len();
        let at = if i == n { 0 } else { i };
        let (s, rate) = (&work.samples[at], &rates[at]);
        Self {
            at: At::Sample(i),
            theta: T::from_f64(i as f64 * TAU / n as f64),
            path: [p.k_t[0] * s.u[0][lane], p.k_t[1] * s.u[1][lane]],
            rate: [p.k_t[0] * rate[lane], p.k_t[1] * rate[LANES + lane]],
            bend: [T::ZERO; 2],
            jerk: [T::ZERO; 2],
            limit: p.mu * s.normal(lane),
            limit_rate: p.mu * (p.k_n * rate[2 * LANES + lane]),
            limit_bend: T::ZERO,
            limit_jerk: T::ZERO,
        }
    }

    /// Rate λ = e·s' − L' at which the slider moves along the direction `e` of the traction.
    #[inline(always)]
    pub(in crate::aft) fn sliding(&self, e: [T; 2]) -> T {
        dot(e, self.rate) - self.limit_rate
    }

    /// Derivative of λ by the phase where `e` turns at the rate `turning`; for events only.
    #[inline(always)]
    pub(in crate::aft) fn sliding_rate(&self, e: [T; 2], turning: T) -> T {
        dot(normal(e), self.rate) * turning + self.bending(e)
    }

    /// The part e·s'' − L'' of that which does not come from the turn of `e`.
    #[inline(always)]
    pub(in crate::aft) fn bending(&self, e: [T; 2]) -> T {
        dot(e, self.bend) - self.limit_bend
    }

    /// Whether the velocity turns by more than half a radian in the step to `next`, the contact moves far, and its path is not straight.
    #[inline(always)]
    pub(in crate::aft) fn turns_around(&self, next: &Self) -> bool {
        let number = T::from_f64;
        let across = (self.rate[0] * next.rate[1] - self.rate[1] * next.rate[0]).abs();
        let length = next.theta - self.theta;
        let speeds = [self.rate, next.rate].map(|v| dot(v, v).sqrt());
        let limit = number(0.5) * (self.limit + next.limit);
        let both = speeds[0] + speeds[1];
        dot(self.rate, next.rate) < number(TURN) * speeds[0] * speeds[1]
            && both * length > number(2.0 * SHORT) * limit
            && across * length > number(ACROSS) * limit * both
    }

    /// A number depends on the step that ends here, with the derivatives `by`: its derivative by the phase of this node.
    #[inline(always)]
    pub(in crate::aft) fn turning(&self, by: &SlipStep<T>) -> T {
        let limit_rate = T::from_f64(0.5) * self.limit_rate;
        dot(by.path, self.rate) + dot(by.rate, self.bend) + by.limit * limit_rate + by.length
    }

    /// How far the traction of a resting slider exceeds its limit.
    pub(super) fn touch(&self, slider: [T; 2]) -> Touch<T, T> {
        let t = [self.path[0] - slider[0], self.path[1] - slider[1]];
        Touch::of(self.theta, t, self.limit)
    }

    /// Square of the traction minus the square of its limit (N²), with its first and second derivative by the phase.
    #[inline(always)]
    pub(super) fn excess(&self, slider: [T; 2]) -> [T; 3] {
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

/// What a step of slip between two nodes depends on.
#[inline(always)]
pub(in crate::aft) fn slip_step<T: Real>(here: &Node<T>, next: &Node<T>) -> SlipStep<T> {
    SlipStep {
        path: [0, 1].map(|d| next.path[d] - here.path[d]),
        rate: next.rate,
        limit: T::from_f64(0.5) * (here.limit + next.limit),
        length: next.theta - here.theta,
    }
}
