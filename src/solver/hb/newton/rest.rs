//! The structure at rest: static equilibrium under loads, preloads and friction, and its linear response about it.
//!
//! Contacts may be open or have slipped under the static load, so the stuck structure is only a start.

use super::damping::{Damping, is_shorter};
use super::iterate::{Iterate, negated};
use super::point::{Direction, Point};
use crate::aft::AftSettings;
use crate::harmonics::HarmonicSet;
use crate::hb::equations::balance::Balance;
use crate::hb::equations::jacobian::EXACT;
use crate::hb::equations::problem::{Problem, ROUND_OFF};
use crate::hb::status::Status;
use crate::hb::structure::compliance::Compliance;
use crate::linalg::vector::norm;
use faer::prelude::c64;

/// Newton iterations; 400 random models took at most 23.
const MOST_ITERATIONS: usize = 200;
/// Last step over the largest displacement.
const TOLERANCE: f64 = 1e-10;
/// Damping of the steps. A shortened step says little about the next one, so the factor recovers as after any other step.
const DAMPING: Damping = Damping {
    smallest: 1e-3,
    recovery: 4.0,
    caution: 4.0,
};
/// Level over the slip onset at which pairs stick for sure.
const BELOW_ONSET: f64 = 0.5;
/// Margin of the traction to the Coulomb limit, as a share of that limit, up to which a pair at rest counts as having slipped.
const NO_MARGIN: f64 = 1e-9;

/// Static equilibrium, and how it answers a small excitation at one frequency.
pub(in crate::hb) struct Rest {
    at: Point,
    /// Rate of the displacements with the level (m).
    by_level: Vec<f64>,
    /// Stiffness of the contacts for small vibrations (N/m): stuck where closed, else 0. Shape as K_c.
    pub(in crate::hb) stiffness: Vec<f64>,
}

/// Stiffness of the contacts at rest (N/m), of the stuck ones if no equilibrium is found. Shape: `[3·n_contacts]`.
#[must_use]
pub fn stiffness_at_rest(problem: &Problem<'_>, aft: AftSettings, omega: f64) -> Vec<f64> {
    let balance = Balance::new(problem, HarmonicSet::up_to(1), aft);
    match Rest::new(&balance, omega) {
        Ok(rest) => rest.stiffness,
        Err(_) => problem.stuck_stiffness.clone(),
    }
}

impl Rest {
    /// Solves for the equilibrium by Newton's method with damped steps (`damping`).
    ///
    /// # Errors
    /// The status that says why not.
    pub(in crate::hb) fn new(balance: &Balance<'_>, omega: f64) -> Result<Self, Status> {
        let n = balance.layout.n_relative();
        let mut r = vec![0.0; balance.layout.n_unknowns()];
        r[..n].copy_from_slice(&balance.problem.stuck_static.preloaded);
        let level = 0.0;
        let mut iterate = Iterate::new(balance, Point { r, omega, level });
        // where preloads balance the load, nothing is displaced
        let round_off = ROUND_OFF * norm(&balance.problem.stuck_static.balanced);
        let mut damping = 1.0;
        let effort = &balance.problem.effort;
        for _ in 0..MOST_ITERATIONS {
            if effort.is_spent() {
                return Err(Status::BudgetSpent);
            }
            (iterate, damping) = {
                let jacobian = iterate.jacobian_within(balance, EXACT);
                effort.spend(jacobian.factorizations());
                let step = Direction {
                    r: negated(&jacobian.solve(&iterate.residual)),
                    omega: 0.0,
                };
                let length = norm(&step.r);
                if !length.is_finite() {
                    return Err(Status::NonFinite);
                }
                if length <= f64::max(TOLERANCE * norm(&iterate.point.r), round_off) {
                    let rest = Self {
                        at: iterate.point.clone(),
                        by_level: iterate.level_rate(balance, &jacobian),
                        stiffness: closed_stiffness(balance, &iterate),
                    };
                    return Ok(rest);
                }
                let trial = |factor| Iterate::new(balance, iterate.point.moved(&step, factor));
                DAMPING.damped(damping, trial, |trial, factor| {
                    is_shorter(norm(&jacobian.solve(&trial.residual)), length, factor)
                })
            };
        }
        Err(Status::MaxIterations)
    }

    /// Level at which every pair that sticks at rest still does.
    pub(in crate::hb) fn stuck_level(&self, problem: &Problem<'_>) -> f64 {
        BELOW_ONSET * self.slip_onset(problem)
    }

    /// Level at which a pair that sticks at rest first breaks the Coulomb limit or opens, while the response is linear. Pairs
    /// that are open or slip at rest never stick.
    fn slip_onset(&self, problem: &Problem<'_>) -> f64 {
        let n_c = problem.contacts.len();
        let n = 3 * n_c;
        let (at, rate) = (&self.at.r, &self.by_level);
        let dynamic = |i: usize| libm::hypot(rate[n + i], rate[2 * n + i]);
        (problem.contacts.iter().enumerate())
            .map(|(pair, c)| {
                let preload = (c.n_0 + c.k_n * at[2 * n_c + pair]).max(0.0);
                let traction = |axis: usize| c.k_t[axis] * (at[axis * n_c + pair] - c.anchor[axis]);
                let limit = c.mu * preload;
                let margin = limit - libm::hypot(traction(0), traction(1));
                if margin <= NO_MARGIN * limit {
                    return f64::INFINITY;
                }
                let [t1, t2] = [0, 1].map(|axis| c.k_t[axis] * dynamic(axis * n_c + pair));
                let normal = c.k_n * dynamic(2 * n_c + pair);
                (margin / (libm::hypot(t1, t2) + c.mu * normal)).min(preload / normal)
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Stiffness of the contacts (N/m) where those that are closed slide without friction. Shape as K_c.
    pub(in crate::hb) fn sliding_stiffness(&self) -> Vec<f64> {
        let mut stiffness = self.stiffness.clone();
        let n_tangential = stiffness.len() / 3 * 2;
        stiffness[..n_tangential].fill(0.0);
        stiffness
    }

    /// The response at `level` and the frequency `omega` (rad/s) of the structure with the contact stiffness of [`Self::sliding_stiffness`],
    /// about the rest.
    pub(in crate::hb) fn sliding(&self, balance: &Balance<'_>, omega: f64, level: f64) -> Point {
        let stiffness = self.sliding_stiffness();
        let at = Compliance::new(balance.problem.model, &stiffness, &[0, 1], omega);
        let first = &at.harmonics[0];
        let load: Vec<c64> = first.part.force.iter().map(|f| f * level).collect();
        let moved = first.part.relative(&first.solve(&load));
        let mut r = self.at.r.clone();
        balance.store(0, &moved, 1.0, &mut r);
        Point { r, omega, level }
    }

    /// The response at `level`, linear about the rest.
    pub(in crate::hb) fn excited(&self, level: f64) -> Point {
        let mut point = self.at.clone();
        (point.r.iter_mut().zip(&self.by_level)).for_each(|(r, rate)| *r += level * rate);
        point.level = level;
        point
    }
}

fn closed_stiffness(balance: &Balance<'_>, rest: &Iterate<'_>) -> Vec<f64> {
    let n_pairs = balance.layout.n_pairs;
    let is_open = |pair: usize| rest.contact.counts[pair].separated > 0;
    (balance.problem.stuck_stiffness.iter().enumerate())
        .map(|(i, k)| if is_open(i % n_pairs) { 0.0 } else { *k })
        .collect()
}
