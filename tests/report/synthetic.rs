//! Outcomes with plausible numbers and no physics behind them, to look at reports.

use microslip::contact::{Events, FrictionLaw};
use microslip::ensemble::backend::BackendReport;
use microslip::ensemble::outcome::{CurvePoint, LevelOutcome, PeakRecord, SampleOutcome};
use microslip::ensemble::store::Provenance;
use microslip::hb::{SliderAnchor, Status};
use microslip::report::ReportInput;
use microslip::sampling::SampleGroup;

pub(crate) const LEVELS: [f64; 8] = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0, 300.0];
const FREE: f64 = 2967.03;
const STUCK: f64 = 2973.95;
const FREE_AMPLITUDE: f64 = 3.80e-6;

/// What a [`ReportInput`] borrows.
pub(crate) struct SyntheticStudy {
    pub(crate) provenance: Provenance,
    pub(crate) input_names: Vec<String>,
    pub(crate) levels: Vec<f64>,
    pub(crate) free_curve: Vec<CurvePoint>,
    pub(crate) stuck_curve: Vec<CurvePoint>,
    pub(crate) nominal: SampleOutcome,
    pub(crate) outcomes: Vec<SampleOutcome>,
    pub(crate) backend: BackendReport,
}

impl SyntheticStudy {
    pub(crate) fn new(n_samples: u64) -> Self {
        let corner = |i: u64| {
            let (u, v) = (fraction(i, 0.618_033_988_7), fraction(i, 0.414_213_562_4));
            sample(i, [10f64.powf(2.0 * u - 1.0), 0.1 + 0.7 * v])
        };
        let mut nominal = sample(0, [1.0, 0.4]);
        for level in &mut nominal.levels {
            level.status = Status::Converged;
        }
        Self {
            provenance: provenance(),
            input_names: vec!["contact stiffness scale".to_owned(), "mu".to_owned()],
            levels: LEVELS.to_vec(),
            free_curve: lorentz(FREE, FREE_AMPLITUDE, 0.6, 30.0),
            stuck_curve: lorentz(STUCK, 3.30e-6, 0.68, 30.0),
            nominal,
            outcomes: (0..n_samples).map(corner).collect(),
            backend: BackendReport::default(),
        }
    }

    pub(crate) fn input(&self) -> ReportInput<'_> {
        ReportInput {
            provenance: &self.provenance,
            input_names: &self.input_names,
            levels: &self.levels,
            level_unit: "N",
            free_frequency_hz: FREE,
            stuck_frequency_hz: STUCK,
            free_curve: &self.free_curve,
            stuck_curve: &self.stuck_curve,
            nominal: Some(&self.nominal),
            outcomes: &self.outcomes,
            wall_time_s: 143.2,
            backend: &self.backend,
        }
    }

    /// Takes the solution of every sample at level `i`.
    pub(crate) fn fail_level(&mut self, i: usize) {
        for outcome in &mut self.outcomes {
            outcome.levels[i].status = Status::MaxIterations;
            outcome.levels[i].peak = None;
            outcome.levels[i].curve.clear();
        }
    }
}

pub(crate) fn provenance() -> Provenance {
    Provenance {
        study: "Two blades with a strip".to_owned(),
        seed: 20_260_731,
        version: "0.1.0".to_owned(),
        model: "two-blade rig, 4 x 7 pairs per interface".to_owned(),
        law: FrictionLaw::Box,
        events: Events::Interpolated,
        anchor: SliderAnchor::StaticEquilibrium,
        harmonics: vec![0, 1, 2, 3],
        time_points: 256,
        folded: true,
        truncation_threshold: Some(0.01),
        highest_harmonic: Some(9),
    }
}

/// Additive recurrence in [0, 1): evenly spread, reproducible.
fn fraction(i: u64, step: f64) -> f64 {
    (0.5 + (i + 1) as f64 * step).fract()
}

fn sample(index: u64, inputs: [f64; 2]) -> SampleOutcome {
    SampleOutcome {
        index,
        group: SampleGroup::default(),
        inputs: inputs.to_vec(),
        levels: (0..LEVELS.len()).map(|i| level(index, inputs, i)).collect(),
    }
}

fn level(index: u64, [scale, mu]: [f64; 2], i: usize) -> LevelOutcome {
    let force = LEVELS[i];
    let noise = fraction(index * 8 + i as u64, 0.754_877_666_2);
    let stick = 1.0 / (1.0 + (force / (12.0 * mu + 2.0)).powi(2));
    let shift = 6.9 * scale.powf(0.33).min(2.2) * stick.powf(0.8);
    let frequency = FREE + shift + 0.05 * (noise - 0.5);
    let damping = mu * (1.0 - stick) * stick.powf(0.3) * 12.0 / (1.0 + (force / 60.0).powi(2));
    let amplitude =
        FREE_AMPLITUDE * (1.0 - 0.13 * stick) / (1.0 + 0.5 * damping) * (0.98 + 0.04 * noise);
    let failed = i == 7 && scale > 3.0 && mu > 0.5;
    let status = if failed {
        Status::MaxIterations
    } else if i == 7 && noise > 0.9 {
        Status::BouncingContact
    } else if i > 3 && noise > 0.985 {
        Status::TruncationAboveThreshold
    } else {
        Status::Converged
    };
    let width = 0.6 * FREE_AMPLITUDE / amplitude;
    LevelOutcome {
        level: force,
        status,
        peak: (!failed).then(|| peak(force, frequency, amplitude * force, stick, noise)),
        curve: if failed {
            Vec::new()
        } else {
            lorentz(frequency, amplitude * force, width, 14.0)
        },
        newton_iterations: 8 + (noise * 20.0) as usize + if failed { 60 } else { 0 },
        factorizations: 4 + (noise * 9.0) as usize,
    }
}

fn peak(force: f64, frequency_hz: f64, amplitude_m: f64, stick: f64, noise: f64) -> PeakRecord {
    let separated = (1.0 - stick) * (0.3 + 0.6 * (force / 300.0).sqrt());
    let work = 1e-3 * force * amplitude_m;
    PeakRecord {
        frequency_hz,
        amplitude_m,
        truncation_error: Some(1e-4 * 10f64.powf(1.9 * noise + 0.3 * (1.0 - stick))),
        highest_harmonic: if noise > 0.7 { 5 } else { 3 },
        stick_fraction: stick,
        slip_fraction: 1.0 - stick - separated,
        separated_fraction: separated,
        work_input_j: work,
        work_viscous_j: 0.6 * work,
        work_friction_j: 0.4 * work * (1.0 - 1e-9 * noise),
        residual: 1e-11,
    }
}

fn lorentz(resonance: f64, amplitude: f64, half_width: f64, reach: f64) -> Vec<CurvePoint> {
    let place = |j: i32| {
        let t = f64::from(j) / 30.0;
        resonance + reach * t * t.abs()
    };
    let point = |frequency_hz: f64| CurvePoint {
        frequency_hz,
        amplitude_m: amplitude / (1.0 + ((frequency_hz - resonance) / half_width).powi(2)).sqrt(),
    };
    (-30..=30).map(place).map(point).collect()
}
