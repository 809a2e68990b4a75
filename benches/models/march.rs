//! Time integration of a random model: an independent code that says whether the structure vibrates with the period of the
//! excitation, which is what harmonic balance seeks.

use crate::random::RandomModel;
use microslip::contact::FrictionLaw;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Exponent of the decay of what a start from rest leaves: 1e-3.
const DECAY: f64 = 7.0;
/// Change per period, over the largest displacement, above which a vibration is not periodic.
const NOT_PERIODIC: f64 = 1e-2;
/// Phase of the fastest stuck mode per time step (rad), and the least steps per period.
const STEP: f64 = 0.05;
const LEAST_STEPS: usize = 400;
/// Frequencies tried, from `LOWEST` times the lowest free mode to `HIGHEST` times the highest stuck one, the band of the search.
const FREQUENCIES: usize = 12;
/// The same of a sweep.
const SWEPT: usize = 400;
const LOWEST: f64 = 0.6;
const HIGHEST: f64 = 1.2;

/// The model in motion, by the velocity Verlet method.
struct Motion<'a> {
    model: &'a RandomModel,
    /// Frequency of the excitation (rad/s).
    omega: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    /// Displacements of the sliders of each contact.
    sliders: Vec<[f64; 2]>,
}

/// The first frequency tried (rad/s) at which the structure, excited from rest, does not vibrate with the period of the
/// excitation, and the change per period there.
pub(crate) fn not_periodic(model: &RandomModel) -> Option<(f64, f64)> {
    let frequencies = frequencies(model, FREQUENCIES).into_iter();
    let change = |omega| (omega, vibration(model, omega).change);
    frequencies.map(change).find(is_not_periodic)
}

/// The same at the highest vibration of a sweep.
pub(crate) fn not_periodic_at_its_highest(model: &RandomModel) -> Option<(f64, f64)> {
    let (omega, highest) = highest(sweep(model))?;
    Some((omega, highest.change)).filter(is_not_periodic)
}

fn is_not_periodic(&(_, change): &(f64, f64)) -> bool {
    change > NOT_PERIODIC
}

/// The vibrations at many frequencies (rad/s).
pub(crate) fn sweep(model: &RandomModel) -> Vec<(f64, Vibration)> {
    let frequencies = frequencies(model, SWEPT).into_par_iter();
    let swept = frequencies.map(|omega| (omega, vibration(model, omega)));
    swept.collect()
}

/// The vibration of the largest amplitude, and its frequency (rad/s).
pub(crate) fn highest(swept: Vec<(f64, Vibration)>) -> Option<(f64, Vibration)> {
    let swept = swept.into_iter();
    swept.max_by(|a, b| a.1.amplitude.total_cmp(&b.1.amplitude))
}

/// Frequencies (rad/s) at equal ratios.
fn frequencies(model: &RandomModel, count: usize) -> Vec<f64> {
    let [free, stuck] = model.frequencies();
    let (low, high) = (LOWEST * free[0], HIGHEST * stuck[stuck.len() - 1]);
    let frequency = |k: usize| low * (high / low).powf(k as f64 / (count - 1) as f64);
    (0..count).map(frequency).collect()
}

/// What is left of a start from rest after many periods.
pub(crate) struct Vibration {
    /// Half of the range of the first mass in a period (m).
    pub(crate) amplitude: f64,
    /// Change of the state within the period, over the largest displacement in it.
    pub(crate) change: f64,
}

/// The vibration under the excitation of the frequency `omega` (rad/s).
fn vibration(model: &RandomModel, omega: f64) -> Vibration {
    let [_, stuck] = model.frequencies();
    let fastest = stuck[stuck.len() - 1];
    let n = model.reduced.mass.nrows();
    let mut motion = Motion {
        model,
        omega,
        displacement: vec![0.0; n],
        velocity: vec![0.0; n],
        acceleration: vec![0.0; n],
        sliders: vec![[0.0; 2]; model.contacts.len()],
    };
    let steps = ((TAU / omega * fastest / STEP) as usize).max(LEAST_STEPS);
    motion.acceleration = motion.accelerated(0.0);
    // the damping matrix is zeta (M + K), so that linear vibrations decay at least as fast as exp(-zeta t / 2)
    let reduced = &model.reduced;
    let zeta = reduced.damping[(0, 0)] / (reduced.mass[(0, 0)] + reduced.stiffness[(0, 0)]);
    let periods = (2.0 * DECAY / zeta * omega / TAU).ceil() as usize;
    for _ in 0..periods {
        motion.period(steps);
    }
    let before = motion.state();
    let Range { largest, first } = motion.period(steps);
    let apart = before.iter().zip(motion.state());
    Vibration {
        amplitude: 0.5 * (first[1] - first[0]),
        change: apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest,
    }
}

/// Where the structure has been in a period.
struct Range {
    /// Largest displacement of all masses (m).
    largest: f64,
    /// Lowest and highest displacement of the first mass (m).
    first: [f64; 2],
}

impl Motion<'_> {
    /// Displacements, and velocities over the frequency.
    fn state(&self) -> Vec<f64> {
        let velocities = self.velocity.iter().map(|v| v / self.omega);
        self.displacement
            .iter()
            .copied()
            .chain(velocities)
            .collect()
    }

    /// One period of the excitation in time steps.
    fn period(&mut self, steps: usize) -> Range {
        let dt = TAU / self.omega / steps as f64;
        let mut largest = 0.0f64;
        let mut first = [f64::INFINITY, f64::NEG_INFINITY];
        for step in 1..=steps {
            self.push(0.5 * dt);
            for (x, v) in self.displacement.iter_mut().zip(&self.velocity) {
                *x += dt * v;
                largest = largest.max(x.abs());
            }
            self.acceleration = self.accelerated(TAU * step as f64 / steps as f64);
            self.push(0.5 * dt);
            let x = self.displacement[0];
            first = [first[0].min(x), first[1].max(x)];
        }
        Range { largest, first }
    }

    /// Lets the acceleration act for a time.
    fn push(&mut self, dt: f64) {
        for (v, a) in self.velocity.iter_mut().zip(&self.acceleration) {
            *v += dt * a;
        }
    }

    /// Accelerations at a phase of the excitation; moves the sliders.
    fn accelerated(&mut self, phase: f64) -> Vec<f64> {
        let (model, reduced) = (self.model, &self.model.reduced);
        let (x, v) = (&self.displacement, &self.velocity);
        let n = x.len();
        let inner = |i| {
            let of = |j| reduced.stiffness[(i, j)] * x[j] + reduced.damping[(i, j)] * v[j];
            (0..n).map(of).sum::<f64>()
        };
        let mut force: Vec<f64> = (0..n)
            .map(|i| {
                let excited = model.level * reduced.cosine_force[i] * phase.cos();
                reduced.static_force[i] + excited - inner(i)
            })
            .collect();
        let contacts = reduced.contacts.iter().zip(&model.contacts);
        for ((pair, contact), slider) in contacts.zip(&mut self.sliders) {
            let along = |row: &[(usize, f64)]| row.iter().map(|&(i, a)| a * x[i]).sum::<f64>();
            let normal = (contact.n_0 + contact.k_n * along(&pair.n)).max(0.0);
            let limit = contact.mu * normal;
            let moved = [along(&pair.t1), along(&pair.t2)];
            let stuck = [0, 1].map(|d| contact.k_t[d] * (moved[d] - slider[d]));
            let friction = match model.law {
                FrictionLaw::Box => stuck.map(|t| t.clamp(-limit, limit)),
                FrictionLaw::Circle => {
                    let size = stuck[0].hypot(stuck[1]);
                    stuck.map(|t| if size > limit { t * limit / size } else { t })
                }
            };
            for d in [0, 1].into_iter().filter(|&d| contact.k_t[d] > 0.0) {
                slider[d] = moved[d] - friction[d] / contact.k_t[d];
            }
            let parts = [
                (&pair.t1, friction[0]),
                (&pair.t2, friction[1]),
                (&pair.n, normal),
            ];
            for (row, f) in parts {
                row.iter().for_each(|&(i, a)| force[i] -= a * f);
            }
        }
        for (i, f) in force.iter_mut().enumerate() {
            *f /= reduced.mass[(i, i)];
        }
        force
    }
}
