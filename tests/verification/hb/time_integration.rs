//! Harmonic balance against explicit time integration of the same model with the contact law marched in time.
//!
//! Independent of the solver: central differences of uncoupled modal oscillators (Newmark's family with β = 0,
//! γ = 1/2), the contact forces taken at the known displacement, plain Coulomb sliders. The retention of the mean
//! in-plane position, which exists in harmonic 0 only, acts on the mean of the period before.

use super::invariants::settings;
use super::models::plane;
use crate::response::over_band;
use crate::two_blade::{RIG, contacts};
use faer::prelude::*;
use microslip::contact::FrictionLaw;
use microslip::harmonics::HarmonicSet;
use microslip::hb::newton::{Condition, Iterate, Point, solve};
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::linear::{ModalPart, Structure};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{Balance, LinearModel, NewtonSettings, Problem, SliderAnchor};
use microslip::linalg::split::SplitMat;
use microslip::model::ReducedModel;
use std::f64::consts::TAU;

/// Modal oscillators η with sliders w, marched in time.
pub(super) struct March<'a> {
    problem: &'a Problem<'a>,
    /// Rows of the contact matrix, one column of it per mode, mode-major.
    columns: Vec<Vec<f64>>,
    lambda: &'a [f64],
    damping: &'a [f64],
    /// Static load and the reaction of the retention, constant over a period.
    constant: Vec<f64>,
    level: f64,
    step: f64,
    n_steps: usize,
    omega: f64,
    now: Vec<f64>,
    before: Vec<f64>,
    sliders: Vec<[f64; 2]>,
    law: FrictionLaw,
    r: Vec<f64>,
    f: Vec<f64>,
    /// Samples that stick, slip, separate.
    states: [usize; 3],
}

impl<'a> March<'a> {
    /// Starts at the periodic solution, with the sliders that it has after two periods.
    pub(super) fn new(balance: &Balance<'a>, iterate: &Iterate<'_>, n_steps: usize) -> Self {
        let problem = balance.problem;
        let model = problem.model;
        let part = model.part(0);
        let Structure {
            lambda, damping, ..
        } = &part.structure;
        let omega = iterate.point.omega;
        let step = TAU / omega / n_steps as f64;
        let at = |i: f64| motion(iterate, i * step * omega);
        let n_pairs = model.n_contacts();
        let mut march = Self {
            problem,
            columns: (0..lambda.len())
                .map(|j| part.contact.real.col_as_slice(j).to_vec())
                .collect(),
            lambda,
            damping,
            constant: Vec::new(),
            level: iterate.point.level,
            step,
            n_steps,
            omega,
            now: at(0.0),
            before: at(-1.0),
            sliders: problem.contacts.iter().map(|c| c.anchor).collect(),
            law: balance.law(),
            r: vec![0.0; 3 * n_pairs],
            f: vec![0.0; 3 * n_pairs],
            states: [0; 3],
        };
        march.hold(&iterate.motion.rest);
        for i in 0..2 * n_steps {
            march.relative_at(&at((i % n_steps) as f64));
            march.contact_forces();
        }
        march
    }

    /// The same structure at rest under the static load.
    fn at_rest(mut self) -> Self {
        self.now.clone_from(&self.problem.stuck_static.eta);
        self.before.clone_from(&self.now);
        self.sliders = self.problem.contacts.iter().map(|c| c.anchor).collect();
        self.hold(&self.problem.stuck_static.eta);
        self
    }

    /// Sets the static load and the reaction of the retention to the mean position `mean`.
    fn hold(&mut self, mean: &[f64]) {
        let model = self.problem.model.part(0);
        self.constant.clone_from(&model.static_force);
        if let Some(k) = &model.retention {
            let held = &k.real * Col::from_fn(mean.len(), |i| mean[i]);
            for (f, h) in self.constant.iter_mut().zip(held.iter()) {
                *f -= h;
            }
        }
    }

    fn relative_at(&mut self, eta: &[f64]) {
        self.r.fill(0.0);
        for (column, eta) in self.columns.iter().zip(eta) {
            for (r, b) in self.r.iter_mut().zip(column) {
                *r += b * eta;
            }
        }
    }

    /// Contact forces at `r`; moves the sliders.
    fn contact_forces(&mut self) {
        let n = self.sliders.len();
        for (i, (c, w)) in self
            .problem
            .contacts
            .iter()
            .zip(&mut self.sliders)
            .enumerate()
        {
            let normal = (c.n_0 + c.k_n * self.r[2 * n + i]).max(0.0);
            let limit = c.mu * normal;
            let u = [self.r[i], self.r[n + i]];
            let trial = [0, 1].map(|d| c.k_t[d] * (u[d] - w[d]));
            let length = trial[0].hypot(trial[1]);
            let returned = match self.law {
                FrictionLaw::Box => trial.map(|t| t.clamp(-limit, limit)),
                FrictionLaw::Circle if length > limit => trial.map(|t| t * limit / length),
                FrictionLaw::Circle => trial,
            };
            let mut slips = false;
            for (d, t) in returned.into_iter().enumerate() {
                if t != trial[d] {
                    w[d] = u[d] - t / c.k_t[d];
                    slips = true;
                }
                self.f[d * n + i] = t;
            }
            self.f[2 * n + i] = normal;
            let state = if normal == 0.0 { 2 } else { usize::from(slips) };
            self.states[state] += 1;
        }
    }

    /// One period; first harmonic of response 0.
    fn cycle(&mut self) -> c64 {
        let (y, mean) = self.period();
        self.hold(&mean);
        y
    }

    /// One period with the reaction of the retention as it is; first harmonic of response 0 and mean of η.
    pub(super) fn period(&mut self) -> (c64, Vec<f64>) {
        let model = self.problem.model.part(0);
        let mut y = c64::new(0.0, 0.0);
        let mut mean = vec![0.0; self.now.len()];
        self.states = [0; 3];
        for i in 0..self.n_steps {
            let (sin, cos) = (self.omega * self.step * i as f64).sin_cos();
            let now = std::mem::take(&mut self.now);
            self.relative_at(&now);
            self.contact_forces();
            let response: f64 = (0..now.len())
                .map(|j| model.response.real[(0, j)] * now[j])
                .sum();
            y += c64::new(cos, -sin) * (response * 2.0 / self.n_steps as f64);
            for j in 0..now.len() {
                mean[j] += now[j] / self.n_steps as f64;
                let push: f64 = self.columns[j]
                    .iter()
                    .zip(&self.f)
                    .map(|(b, f)| b * f)
                    .sum();
                let excitation = self.level * (model.force[j].re * cos - model.force[j].im * sin);
                let half = 0.5 * self.damping[j] * self.step;
                let load = self.constant[j] + excitation - push - self.lambda[j] * now[j];
                let old = (1.0 - half) * self.before[j];
                self.before[j] = (2.0 * now[j] - old + self.step * self.step * load) / (1.0 + half);
            }
            self.now = std::mem::replace(&mut self.before, now);
        }
        (y, mean)
    }

    /// Adds a disturbance of η, η̇ and sliders (pair, direction, m).
    pub(super) fn disturb(&mut self, eta: &[f64], rate: &[f64], sliders: &[([usize; 2], f64)]) {
        for (j, (x, v)) in eta.iter().zip(rate).enumerate() {
            self.now[j] += x;
            self.before[j] += x - self.step * v;
        }
        for &([pair, d], w) in sliders {
            self.sliders[pair][d] += w;
        }
    }

    /// η, η̇ and the displacements of `sliders` (pair, direction).
    pub(super) fn state(&self, sliders: &[[usize; 2]]) -> Vec<f64> {
        let rates = self.now.iter().zip(&self.before);
        let rates = rates.map(|(now, before)| (now - before) / self.step);
        let sliders = sliders.iter().map(|&[pair, d]| self.sliders[pair][d]);
        self.now
            .iter()
            .copied()
            .chain(rates)
            .chain(sliders)
            .collect()
    }
}

/// η(θ) of a periodic solution.
fn motion(iterate: &Iterate<'_>, theta: f64) -> Vec<f64> {
    let mut eta = iterate.motion.rest.clone();
    for (h, amplitude) in iterate
        .compliance
        .harmonics
        .iter()
        .zip(&iterate.motion.dynamic)
    {
        let (sin, cos) = (h.order as f64 * theta).sin_cos();
        for (eta, z) in eta.iter_mut().zip(amplitude) {
            *eta += z.re * cos - z.im * sin;
        }
    }
    eta
}

/// Where a march has arrived.
struct End {
    amplitude: f64,
    /// Relative change over the last tenth of the cycles.
    drift: f64,
    states: [usize; 3],
}

fn run(mut march: March<'_>, cycles: usize) -> End {
    let amplitudes: Vec<f64> = (0..cycles).map(|_| march.cycle().norm()).collect();
    let shown: Vec<String> = (0..8)
        .map(|i| format!("{:.4e}", amplitudes[(cycles - 1) * i / 7]))
        .collect();
    println!("cycle by cycle {}", shown.join(" "));
    let amplitude = amplitudes[cycles - 1];
    End {
        amplitude,
        drift: amplitude / amplitudes[cycles - cycles / 10] - 1.0,
        states: march.states,
    }
}

/// Amplitudes within the relative difference `allowed`, with slip in the last cycle.
fn compare(allowed: f64, balance: &Balance<'_>, end: &End, iterate: &Iterate<'_>) {
    let exact = iterate.response(balance).norm();
    let error = end.amplitude / exact - 1.0;
    println!(
        "{} N: harmonic balance {exact:.5e}, time {:.5e} ({error:.1e}), drift {:.1e}, {:?}",
        iterate.point.level, end.amplitude, end.drift, end.states
    );
    assert!(
        error.abs() < allowed && end.drift.abs() < 3e-3,
        "{error:e} {:e}",
        end.drift
    );
    assert!(end.states[1] > 0, "slips: {:?}", end.states);
}

/// Two blades in the plane, slip (10 N) and slip with partial lift-off (40 N), from the periodic solution and from
/// rest. The strip is damped: without, it bounces for ever at 40 N. It resonates on its contacts near harmonic 33, so
/// 40 N need as many (15 are off by 0.4 %). Seen to fail with: a lower limit of −0.9 mu N in the solver.
#[test]
fn time_integration_of_the_lumped_blades_agrees() {
    let mut case = plane(-1.0);
    for (dof, mass) in [(2, 1.58e-3), (3, 1.58e-3), (4, 1.58e-3 * 1e-4 / 12.0)] {
        case.model.damping[(dof, dof)] = 2000.0 * mass;
    }
    let linear = LinearModel::new(&case.model).expect("definite");
    let anchor = SliderAnchor::Unloaded;
    let problem = Problem::new(&linear, case.contacts, 1.0, anchor).expect("held");
    for (level, hertz) in [(10.0, 417.0), (40.0, 380.0)] {
        let mut settings = settings(3, FrictionLaw::Box);
        settings.aft.n_time = 1024;
        settings.newton.tolerance = 1e-9;
        // Along the branch, as a cold start at this frequency may fail.
        let band = Band {
            low: 320.0 * TAU,
            high: (hertz + 1.0) * TAU,
        };
        let curve = over_band(&problem, &settings, level, band);
        let near = curve
            .iter()
            .rfind(|s| s.omega < hertz * TAU)
            .expect("on the curve");
        let fixed = Condition::FixedFrequency;
        let start = Point {
            r: near.relative.clone(),
            omega: near.omega,
            level,
        };
        let mut balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
        let mut iterate = solve(&balance, start, fixed, settings.newton).expect("a solution");
        for highest in [9, 15, 24, 36, 48] {
            let larger = Balance::new(&problem, HarmonicSet::up_to(highest), settings.aft);
            let padded = iterate.point.padded(&balance, &larger);
            iterate = solve(&larger, padded, fixed, settings.newton).expect("a solution");
            balance = larger;
        }
        for rest in [false, true] {
            let march = March::new(&balance, &iterate, 8000);
            let march = if rest { march.at_rest() } else { march };
            let end = run(march, 400);
            assert!(level < 20.0 || end.states[2] > 0, "separates at 40 N");
            assert!(end.drift.abs() < 1e-6, "steady: {:e}", end.drift);
            compare(1e-4, &balance, &end, &iterate);
        }
    }
}

/// A rig without its modes above `hertz`.
pub(super) fn truncated(model: &ReducedModel, hertz: f64) -> LinearModel {
    let full = LinearModel::new(model).expect("definite");
    let part = full.part(0);
    let Structure {
        lambda,
        damping,
        coupling,
    } = &part.structure;
    let n = lambda
        .iter()
        .filter(|l| **l < (TAU * hertz).powi(2))
        .count();
    let columns = |a: &SplitMat| SplitMat::from(a.real.subcols(0, n).to_owned());
    let square = |k: &SplitMat| SplitMat::from(k.real.submatrix(0, 0, n, n).to_owned());
    let truncated = ModalPart {
        structure: Structure {
            lambda: lambda[..n].to_vec(),
            damping: damping[..n].to_vec(),
            coupling: coupling.clone(),
        },
        retention: part.retention.as_ref().map(square),
        contact: columns(&part.contact),
        multiplicity: part.multiplicity,
        response: columns(&part.response),
        static_force: part.static_force[..n].to_vec(),
        loads: Vec::new(),
        force: part.force[..n].to_vec(),
    };
    LinearModel {
        parts: vec![truncated],
        ..full
    }
}

/// The two-blade rig without modes above 60 kHz, at its peak at 50 N, where contacts slip and a few separate.
///
/// The march leaves the periodic solution slowly for one with other mean tractions of the pairs that stick: these are
/// not unique.
/// Seen to fail with: a lower limit of −0.9 mu N in the solver.
#[test]
fn time_integration_of_the_rig_agrees() {
    let linear = truncated(&RIG.reduced, 60e3);
    let contacts = contacts(&RIG.reduced, 1.0, 0.6);
    let anchor = SliderAnchor::Unloaded;
    let problem = Problem::new(&linear, contacts, 1.0, anchor).expect("held");
    let mut settings = settings(3, FrictionLaw::Box);
    settings.aft.n_time = 256;
    settings.newton = NewtonSettings::default();
    let peak = PeakSettings {
        band: Band {
            low: 2600.0 * TAU,
            high: 2640.0 * TAU,
        },
        frequency_tolerance: 1e-6,
    };
    let found = track_peaks(&problem, &settings, peak, &[20.0, 50.0]).expect("modes");
    let solution = found[1].solution.as_ref().expect("a peak");
    let first = Balance::new(&problem, solution.harmonics.clone(), settings.aft);
    let start = Point {
        r: solution.relative.clone(),
        omega: solution.omega,
        level: solution.level,
    };
    let balance = Balance::new(&problem, HarmonicSet::up_to(12), settings.aft);
    let padded = start.padded(&first, &balance);
    let fixed = Condition::FixedFrequency;
    let iterate = solve(&balance, padded, fixed, settings.newton).expect("a solution");
    let end = run(March::new(&balance, &iterate, 2000), 700);
    compare(0.01, &balance, &end, &iterate);
}
