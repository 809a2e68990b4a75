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

/// The signals at one phase.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Node<T> {
    /// Number of the sample; none for an event.
    pub sample: Option<usize>,
    pub theta: T,
    /// s (N), and its derivatives s', s'' and s''' by the phase; s'' and s''' for events only.
    pub path: [T; 2],
    pub rate: [T; 2],
    pub bend: [T; 2],
    pub jerk: [T; 2],
    /// L (N), L', L'' and L'''; L'' and L''' for events only.
    pub limit: T,
    pub limit_rate: T,
    pub limit_bend: T,
    pub limit_jerk: T,
}

impl<T: Real> Node<T> {
    /// Sample i of one state of the group; i = Nt is sample 0 one period later.
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
