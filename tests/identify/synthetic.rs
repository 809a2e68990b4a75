//! Hysteresis tests made from equations, with the faults of a measurement.

use microslip::record::HysteresisRecord;
use microslip::sampling::stream::uniform;
use microslip::special::normal_quantile;
use std::f64::consts::TAU;

/// An elastic-Coulomb contact under a harmonic motion; in SI units.
#[derive(Debug, Clone)]
pub(crate) struct Bench {
    pub(crate) friction: f64,
    /// Stiffness while the displacement falls and while it rises (N/m).
    pub(crate) stiffness: [f64; 2],
    pub(crate) normal_force: f64,
    /// Amplitude of the normal force over its mean, at twice the frequency.
    pub(crate) normal_swing: f64,
    pub(crate) amplitude: f64,
    pub(crate) frequency: f64,
    pub(crate) per_cycle: f64,
    pub(crate) cycles: usize,
    /// Standard deviations of the noise: displacement (m), tangential force, normal force (N).
    pub(crate) noise: [f64; 3],
    /// Offsets of displacement and tangential force, and their drifts per cycle.
    pub(crate) offset: [f64; 2],
    pub(crate) drift: [f64; 2],
    /// The friction coefficient begins this share lower, and comes back with a time constant of three cycles.
    pub(crate) run_in: f64,
    /// Stiffness in series (N/m).
    pub(crate) series: Option<f64>,
    pub(crate) seed: u64,
}

impl Default for Bench {
    fn default() -> Self {
        Self {
            friction: 0.6,
            stiffness: [50e6; 2],
            normal_force: 100.0,
            normal_swing: 0.0,
            amplitude: 5e-6,
            frequency: 100.0,
            per_cycle: 400.0,
            cycles: 20,
            noise: [0.0; 3],
            offset: [0.0; 2],
            drift: [0.0; 2],
            run_in: 0.0,
            series: None,
            seed: 1,
        }
    }
}

/// Normal number of one place.
pub(crate) fn normal(seed: u64, place: u64, dimension: u32) -> f64 {
    normal_quantile(uniform(seed, place, dimension))
}

impl Bench {
    /// The record of the test; it begins somewhere in a cycle.
    pub(crate) fn record(&self) -> HysteresisRecord {
        let count = (self.per_cycle * (self.cycles as f64 + 0.6)) as usize;
        let (mut contact, mut before) = (0.0_f64, 0.0);
        let mut record = HysteresisRecord::empty(format!("bench {}", self.seed));
        for i in 0..count {
            let cycle = i as f64 / self.per_cycle;
            let motion = self.amplitude * (TAU * (cycle + 0.1)).sin();
            let normal_force =
                self.normal_force * (1.0 + self.normal_swing * (2.0 * TAU * cycle).cos());
            let run_in = 1.0 - self.run_in * (-cycle / 3.0).exp();
            let limit = self.friction * run_in * normal_force;
            let stiffness = self.stiffness[usize::from(motion > before)];
            contact = (contact + stiffness * (motion - before)).clamp(-limit, limit);
            before = motion;
            let rig = self.series.map_or(0.0, |series| contact / series);
            let noise = |k: u32| self.noise[k as usize] * normal(self.seed, i as u64, k);
            record.time.push(cycle / self.frequency);
            record
                .displacement
                .push(motion + rig + self.offset[0] + self.drift[0] * cycle + noise(0));
            record
                .tangential_force
                .push(contact + self.offset[1] + self.drift[1] * cycle + noise(1));
            record.normal_force.push(normal_force + noise(2));
        }
        record
    }
}
