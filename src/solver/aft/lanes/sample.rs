//! One time point, and the contact parameters, of the lanes.

use super::lane::{Components, LANES, Lane};
use crate::contact::law::normal_force;
use crate::contact::{ContactParameters, Real};

/// Everything known of one time point.
///
/// Aligned to the lines of the cache: a vector that crosses them takes two accesses.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub(in crate::aft) struct Sample<T> {
    /// Tangential displacements (m).
    pub u: [Lane<T>; 2],
    /// Gap function n_0 + k_n v (N).
    pub gap: Lane<T>,
    /// Tractions (N).
    pub traction: [Lane<T>; 2],
}

impl<T: Real> Sample<T> {
    /// Normal force of one lane (N).
    #[inline(always)]
    pub(in crate::aft) fn normal(&self, lane: usize) -> T {
        normal_force(self.gap[lane])
    }

    /// Displacements; the approach goes into `gap`.
    #[inline(always)]
    pub(in crate::aft) fn set_signals(&mut self, signals: Components<T>) {
        for l in 0..LANES {
            self.u[0][l] = signals[l];
            self.u[1][l] = signals[LANES + l];
            self.gap[l] = signals[2 * LANES + l];
        }
    }

    /// Tractions and normal force.
    #[inline(always)]
    pub(in crate::aft) fn forces(&self) -> Components<T> {
        let mut forces = [T::ZERO; 3 * LANES];
        for l in 0..LANES {
            forces[l] = self.traction[0][l];
            forces[LANES + l] = self.traction[1][l];
            forces[2 * LANES + l] = self.normal(l);
        }
        forces
    }
}

/// Contact parameters of the lanes.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::aft) struct LaneParameters<T> {
    pub k_n: Lane<T>,
    pub n_0: Lane<T>,
    pub mu: Lane<T>,
    pub k_t: [Lane<T>; 2],
    /// 1/k_t, or 0 for an absent spring.
    pub flexibility: [Lane<T>; 2],
    pub anchor: [Lane<T>; 2],
}

impl<T: Real> LaneParameters<T> {
    /// Parameters of one lane.
    #[inline(always)]
    pub(in crate::aft) fn of(&self, lane: usize) -> ContactParameters<T> {
        ContactParameters {
            k_n: self.k_n[lane],
            k_t: [self.k_t[0][lane], self.k_t[1][lane]],
            mu: self.mu[lane],
            n_0: self.n_0[lane],
            anchor: [self.anchor[0][lane], self.anchor[1][lane]],
        }
    }

    #[inline(always)]
    pub(in crate::aft) fn set(&mut self, lane: usize, p: &ContactParameters<T>) {
        self.k_n[lane] = p.k_n;
        self.n_0[lane] = p.n_0;
        self.mu[lane] = p.mu;
        for d in 0..2 {
            self.k_t[d][lane] = p.k_t[d];
            self.flexibility[d][lane] = if p.k_t[d] > T::ZERO {
                T::ONE / p.k_t[d]
            } else {
                T::ZERO
            };
            self.anchor[d][lane] = p.anchor[d];
        }
    }
}
