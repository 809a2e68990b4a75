//! What one nonlinear solve returns.

use super::route::PeakRoute;
use super::settings::{HbSettings, StabilityScope};
use super::stability::period_map::PeriodicMotion;
use super::stability::{Stability, assess};
use super::status::Status;
use crate::aft::StateCounts;
use crate::harmonics::{HarmonicSet, phases};
use crate::hb::equations::balance::Balance;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::{Iterate, Point};
use crate::hb::structure::linear::LinearModel;
use faer::prelude::c64;
use std::f64::consts::PI;
use std::time::Instant;

/// Shares of (pair, time) in each contact state; they add up to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, schemars::JsonSchema)]
pub struct ContactFractions {
    /// Sticking.
    pub stick: f64,
    /// Slipping in at least one direction.
    pub slip: f64,
    /// Separated.
    pub separated: f64,
}

/// Work per cycle (J).
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, schemars::JsonSchema)]
pub struct CycleWork {
    /// Done by the excitation.
    pub input: f64,
    /// Dissipated by the damping matrix.
    pub viscous: f64,
    /// Dissipated by the contacts.
    pub friction: f64,
}

/// One periodic solution of the balance equations, or the last iterate of a failed solve.
#[derive(Debug, Clone)]
pub struct Solution {
    /// How the solve ended.
    pub status: Status,
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Excitation level.
    pub level: f64,
    /// Harmonics of the solution.
    pub harmonics: HarmonicSet,
    /// Relative contact displacements (m). Shape: `[n_coefficients][3 · n_contacts]`: t1 of every pair, t2, n.
    pub relative: Vec<f64>,
    /// Total contact forces (N). Shape as `relative`.
    pub force: Vec<f64>,
    /// Response coordinates (m). Shape: `[n_coefficients][n_responses]`.
    pub responses: Vec<f64>,
    /// Largest residual component over the displacement scale.
    pub residual: f64,
    /// Contact states.
    pub contact: ContactFractions,
    /// Share of time in which no pair at all is closed: the strip flies.
    pub flight_fraction: f64,
    /// Energy balance.
    pub work: CycleWork,
    /// Kinetic energy of the first harmonic (J): twice its mean over the cycle, which for a vibration in one phase is the
    /// largest. See [`Solution::damping_ratio`].
    pub kinetic_energy: f64,
    /// Stated error of the amplitude by the harmonics left out: relative, not below the change by twice the harmonics
    /// ([`super::peak::alert`]). `None` without an alert, or where no solution was found with more harmonics.
    pub truncation_error: Option<f64>,
    /// Stability; `None` where it was not assessed.
    pub stability: Option<Stability>,
    /// Sharpness of a peak (see [`crate::hb::peak::search::Located`]).
    pub sharpness: Option<f64>,
    /// How a peak was found; `None` where the frequency was given.
    pub route: Option<PeakRoute>,
}

/// Share of (pair, time) out of contact above which the strip bounces.
const MOST_SEPARATED: f64 = 0.6;

impl Solution {
    /// Everything reported of a solved iterate (or of the last iterate of a failed solve).
    #[must_use]
    pub fn new(balance: &Balance<'_>, iterate: &Iterate<'_>, status: Status) -> Self {
        let model = balance.problem.model;
        let rest: Vec<c64> = iterate
            .motion
            .rest
            .iter()
            .map(|x| c64::new(*x, 0.0))
            .collect();
        let mut responses: Vec<f64> = (model.part(0).responses(&rest).iter())
            .map(|y| y.re)
            .collect();
        for (h, eta) in iterate
            .compliance
            .harmonics
            .iter()
            .zip(&iterate.motion.dynamic)
        {
            let y = h.part.responses(eta);
            responses.extend(y.iter().map(|y| y.re));
            responses.extend(y.iter().map(|y| -y.im));
        }
        let mut solution = Self {
            status,
            omega: iterate.point.omega,
            level: iterate.point.level,
            harmonics: balance.harmonics.clone(),
            relative: iterate.point.r.clone(),
            force: iterate.contact.force.clone(),
            responses,
            residual: iterate.relative_residual(balance),
            contact: ContactFractions::new(&iterate.contact.counts),
            flight_fraction: flight_fraction(balance, iterate),
            work: CycleWork::new(balance, iterate),
            kinetic_energy: kinetic_energy(iterate),
            truncation_error: None,
            stability: None,
            sharpness: None,
            route: None,
        };
        if status.has_solution() && solution.bounces(model) {
            solution.status = Status::BouncingContact;
        }
        solution
    }

    /// Whether the contacts of a part that only they hold bounce so much that a response with the period of the
    /// excitation is not to be trusted, as far as that can be told without its stability. They do so where the strip flies, or the
    /// pairs are open for most of the time. Time integration of the rig settles to one period up to
    /// shares of about one half (100 N) and does not any more at 300 N, where it is two thirds and more.
    #[must_use]
    pub fn bounces(&self, model: &LinearModel) -> bool {
        model.floats && (self.flight_fraction > 0.0 || self.contact.separated > MOST_SEPARATED)
    }

    /// The same with its stability, where `settings` ask for it and it can be assessed, and with the status that follows.
    #[must_use]
    pub fn with_stability(mut self, problem: &Problem<'_>, settings: &HbSettings) -> Self {
        let ContactFractions {
            slip, separated, ..
        } = self.contact;
        let wanted = match settings.stability {
            StabilityScope::Off => false,
            StabilityScope::Bouncing => self.bounces(problem.model) || separated > MOST_SEPARATED,
            StabilityScope::LiftOff => separated > 0.0,
            StabilityScope::All => slip > 0.0 || separated > 0.0,
        };
        if !wanted || !self.status.has_solution() {
            return self;
        }
        let motion = PeriodicMotion {
            harmonics: &self.harmonics,
            relative: &self.relative,
            omega: self.omega,
            law: settings.aft.law,
        };
        let begun = Instant::now();
        self.stability = assess(problem, &motion);
        problem.effort.add_stability_time(begun.elapsed());
        let Some(stability) = self.stability else {
            return self;
        };
        let certified = settings.alert.is_none_or(|alert| {
            self.truncation_error
                .is_some_and(|error| alert.accepts(error))
        });
        self.status = match (stability.is_stable(), certified) {
            (false, _) => Status::Unstable,
            (true, false) => Status::TruncationAboveThreshold,
            (true, true) => Status::Converged,
        };
        self
    }

    /// Unknowns, frequency and level: a start for others.
    #[must_use]
    pub fn point(&self) -> Point {
        Point {
            r: self.relative.clone(),
            omega: self.omega,
            level: self.level,
        }
    }

    /// First harmonic q̂₁ of response `i` (m); q = Re q̂₁ exp(iωt).
    #[must_use]
    pub fn first_harmonic(&self, i: usize) -> c64 {
        let n = self.responses.len() / self.harmonics.n_coefficients();
        c64::new(self.responses[n + i], -self.responses[2 * n + i])
    }

    /// Amplitude |q̂₁| of the first harmonic of response `i` (m).
    #[must_use]
    pub fn amplitude(&self, i: usize) -> f64 {
        self.first_harmonic(i).norm()
    }

    /// Equivalent damping ratio of a resonance: ζ = W / (4π E) with the work W that damping matrix and contacts dissipate
    /// per cycle, by all harmonics, and the kinetic energy E of the first one. `None` where nothing moves or nothing is
    /// dissipated.
    ///
    /// A linear oscillator has W = π c ω X² and E = ½ m ω² X², so that ζ = c / (2 m ω): its damping ratio, exactly at phase
    /// resonance, and too large by the share ζ² at the maximum of the displacement. Other modes, which vibrate by the share ζ
    /// beside the resonant one, add ζ² likewise. The kinetic energy stands for the elastic one, which is the same at resonance, because
    /// that of contacts that slip and open depends on their history. Source: the loss factor as dissipated over
    /// stored energy, Ungar & Kerwin 1962, J. Acoust. Soc. Am. 34, 954–957.
    #[must_use]
    pub fn damping_ratio(&self) -> Option<f64> {
        let dissipated = self.work.viscous + self.work.friction;
        let ratio = dissipated / (4.0 * PI * self.kinetic_energy);
        (ratio.is_finite() && ratio > 0.0).then_some(ratio)
    }
}

impl ContactFractions {
    /// Shares of the samples of all pairs.
    fn new(pairs: &[StateCounts]) -> Self {
        let sum = |of: fn(&StateCounts) -> u32| f64::from(pairs.iter().map(of).sum::<u32>());
        let total = sum(|counts| counts.total()).max(1.0);
        Self {
            stick: sum(|counts| counts.stick) / total,
            slip: sum(|counts| counts.slip) / total,
            separated: sum(|counts| counts.separated) / total,
        }
    }
}

/// Share of the phases at which every pair is open, and every image of one.
fn flight_fraction(balance: &Balance<'_>, iterate: &Iterate<'_>) -> f64 {
    if (iterate.contact.counts.iter()).any(|counts| counts.separated == 0) {
        return 0.0;
    }
    let (contacts, r) = (&balance.problem.contacts, &iterate.point.r);
    let normal = 2 * contacts.len();
    let open = |theta: f64| {
        let basis = balance.harmonics.basis(theta);
        contacts.iter().enumerate().all(|(pair, c)| {
            let coefficients = r.chunks_exact(balance.layout.n_relative());
            let approach: f64 = (basis.iter().zip(coefficients))
                .map(|(b, r)| b * r[normal + pair])
                .sum();
            c.n_0 + c.k_n * approach <= 0.0
        })
    };
    let phases = phases(balance.n_time());
    let alternates = balance.problem.model.alternates;
    let n_open = phases
        .iter()
        .filter(|theta| open(**theta) && (!alternates || open(**theta + PI)))
        .count();
    n_open as f64 / phases.len() as f64
}

impl CycleWork {
    /// ∮ f·q̇ dt of the excitation, ∮ q̇ᵀCq̇ dt, and ∮ F·ṙ dt of the contacts.
    #[must_use]
    pub fn new(balance: &Balance<'_>, iterate: &Iterate<'_>) -> Self {
        let level = iterate.point.level;
        let mut work = Self::default();
        for (i, (h, eta)) in iterate
            .compliance
            .harmonics
            .iter()
            .zip(&iterate.motion.dynamic)
            .enumerate()
        {
            let k = h.order as f64;
            if h.order == 1 {
                work.input = PI * level * power(&h.part.force, eta);
            }
            let damping: f64 = (h.part.structure.damp(eta).iter().zip(eta))
                .map(|(c_eta, eta)| (eta.conj() * c_eta).re)
                .sum();
            work.viscous += PI * k * k * iterate.point.omega * damping;
            let force = balance.complex(i, &iterate.contact.force);
            let relative = balance.complex(i, &iterate.point.r);
            work.friction += PI * k * h.part.multiplicity * power(&force, &relative);
        }
        work
    }
}

/// ½ ω² η̂₁ᴴ η̂₁, for modes of unit mass (J).
fn kinetic_energy(iterate: &Iterate<'_>) -> f64 {
    let dynamic = (iterate.compliance.harmonics.iter()).zip(&iterate.motion.dynamic);
    let first = dynamic.filter(|(h, _)| h.order == 1);
    let squares = first.flat_map(|(_, eta)| eta.iter().map(|eta| eta.norm_sqr()));
    0.5 * iterate.point.omega.powi(2) * squares.sum::<f64>()
}

/// Im(f̂* · x̂)·(−1): work per cycle over π of the force f̂ on the displacement x̂ with q = Re q̂ e^{ikωt}.
fn power(force: &[c64], displacement: &[c64]) -> f64 {
    force
        .iter()
        .zip(displacement)
        .map(|(f, x)| -(f.conj() * x).im)
        .sum()
}
