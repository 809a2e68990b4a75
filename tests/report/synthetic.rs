//! Outcomes with plausible numbers and no physics behind them, to look at reports.

use microslip::contact::{Events, FrictionLaw};
use microslip::ensemble::SolvedSample;
use microslip::ensemble::backend::BackendReport;
use microslip::ensemble::outcome::{
    AroundPeak, CurvePoint, LevelOutcome, Maximum, PeakRecord, SampleOutcome, SweepRecord,
};
use microslip::ensemble::store::{ATLAS_FILE, Provenance, SolvedFiles, StoredStudy};
use microslip::hb::{PeakRoute, SliderAnchor, Status};
use microslip::report::asked::Bands;
use microslip::report::asked::{
    Criterion, MarginBase, Operation, RequiredQuantity, Requirements, Stress,
};
use microslip::report::run::{
    DesignRecord, FileRecord, InputRecord, LinearRecord, StaticLoadRecord, TABLES,
};
use microslip::report::{self, ReportInput, RunRecord};
use microslip::sampling::{DesignKind, Distribution, Growth, SampleGroup, Shape};

pub(crate) const LEVELS: [f64; 8] = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0, 300.0];
const FREE: f64 = 2967.03;
const STUCK: f64 = 2973.95;
const FREE_AMPLITUDE: f64 = 3.80e-6;

/// What a [`ReportInput`] borrows.
pub(crate) struct SyntheticStudy {
    pub(crate) record: RunRecord,
    pub(crate) outcomes: Vec<SampleOutcome>,
    pub(crate) mixed: Vec<SampleOutcome>,
    pub(crate) control: Vec<SampleOutcome>,
}

impl SyntheticStudy {
    pub(crate) fn new(n_samples: u64) -> Self {
        Self {
            record: record(),
            outcomes: (0..n_samples)
                .map(|i| sample(i, point(i, [0.618_033_988_7, 0.414_213_562_4])))
                .collect(),
            mixed: Vec::new(),
            control: Vec::new(),
        }
    }

    /// A pick-freeze design of both inputs: rows of four samples.
    pub(crate) fn pick_freeze(rows: u64) -> Self {
        let mut study = Self::new(0);
        study.record.design.kind = DesignKind::PickFreeze;
        study.record.design.mixed_inputs = vec![0, 1];
        study.record.design.independent = false;
        for row in 0..rows {
            let a = point(row, [0.618_033_988_7, 0.414_213_562_4]);
            let b = point(row, [0.732_050_807_6, 0.236_067_977_5]);
            let inputs = [a, b, [b[0], a[1]], [a[0], b[1]]];
            for (place, inputs) in (0..).zip(inputs) {
                let mut outcome = sample(4 * row + place, inputs);
                outcome.group.place = Some(place as u32);
                match outcome.group.of_population() {
                    true => study.outcomes.push(outcome),
                    false => study.mixed.push(outcome),
                }
            }
        }
        study
    }

    pub(crate) fn input(&self) -> ReportInput<'_> {
        ReportInput {
            record: &self.record,
            outcomes: &self.outcomes,
            mixed: &self.mixed,
            control: &self.control,
            changed: &[],
            folder: "RESULTS",
        }
    }

    /// The page of a report.
    pub(crate) fn page(&self) -> String {
        let folder = tempfile::tempdir().unwrap();
        report::write(folder.path(), &self.input()).unwrap();
        std::fs::read_to_string(folder.path().join("report.html")).unwrap()
    }

    pub(crate) fn input_names(&self) -> Vec<String> {
        self.record.inputs.iter().map(|i| i.name.clone()).collect()
    }

    /// Writes what a run writes before its report.
    pub(crate) fn store(&mut self, folder: &std::path::Path) {
        let mut all = [self.outcomes.clone(), self.mixed.clone()].concat();
        all.sort_by_key(|outcome| outcome.index);
        self.write_tables(folder, &all);
        self.record.tables = TABLES
            .map(|name| FileRecord::in_folder(folder, name).unwrap())
            .to_vec();
        self.record.write(folder).unwrap();
    }

    /// Writes the tables of a run with these outcomes.
    pub(crate) fn write_tables(&self, folder: &std::path::Path, outcomes: &[SampleOutcome]) {
        let names = self.input_names();
        let group = outcomes.first().map(|outcome| outcome.group);
        let study = StoredStudy {
            text: String::new(),
            path: "study.toml".to_owned(),
        };
        let [samples, curves, anchors] =
            [TABLES[0], TABLES[1], ATLAS_FILE].map(|name| folder.join(name));
        let mut files = SolvedFiles::begin(
            [&samples, &curves, &anchors],
            &self.record.provenance,
            &names,
            group.unwrap_or_default(),
            &study,
        )
        .unwrap();
        for outcome in outcomes.iter().cloned() {
            let anchor = None;
            files.write(SolvedSample { outcome, anchor }).unwrap();
        }
        files.finish().unwrap();
    }

    /// Makes every solution one to be trusted, without numerical error: verdicts are those of the values.
    pub(crate) fn be_exact(&mut self) {
        for level in self.outcomes.iter_mut().flat_map(|o| &mut o.levels) {
            if let Some(peak) = &mut level.peak {
                level.status = Status::Converged;
                peak.truncation_error = Some(0.0).into();
                // no work, no share of it missing
                peak.work_input_j = 0.0;
            }
        }
    }

    /// Takes the solution of every sample at level `i`.
    pub(crate) fn fail_level(&mut self, i: usize) {
        for outcome in &mut self.outcomes {
            outcome.levels[i].status = Status::MaxIterations;
            outcome.levels[i].peak = None;
            outcome.levels[i].around.curve_mut().clear();
        }
    }
}

fn record() -> RunRecord {
    let mut nominal = sample(0, [1.0, 0.4]);
    for level in &mut nominal.levels {
        level.status = Status::Converged;
    }
    RunRecord {
        provenance: provenance(),
        backend: BackendReport::default(),
        inputs: vec![
            input("contact stiffness scale", "log-uniform: low 0.1, high 10.0"),
            input("mu", "uniform: low 0.1, high 0.8"),
        ],
        design: DesignRecord {
            kind: DesignKind::MonteCarlo,
            description: "monte-carlo".to_owned(),
            independent: true,
            growth: Growth::Any,
            outer_points: 1,
            further_points: 0,
            mixed_inputs: Vec::new(),
            correlated: false,
        },
        frequency_tolerance: 3e-7,
        levels: LEVELS.to_vec(),
        curve_samples: 200,
        bands: Bands::default(),
        level_unit: "N".to_owned(),
        free: LinearRecord {
            frequency_hz: Some(FREE),
            curve: lorentz(FREE, FREE_AMPLITUDE, 0.6, 30.0),
        },
        stuck: LinearRecord {
            frequency_hz: Some(STUCK),
            curve: lorentz(STUCK, 3.30e-6, 0.68, 30.0),
        },
        nominal: Some(nominal),
        one_at_a_time: None,
        components: Vec::new(),
        contact_grid: None,
        finer_grid: None,
        disk: None,
        static_load: Some(StaticLoadRecord {
            load_n: 180.0,
            strip_thickness_mm: 0.4,
        }),
        requirements: requirements(),
        stopping: None,
        surrogate: None,
        control_variate: None,
        study_file: FileRecord::of("study.toml", b"name = \"synthetic\""),
        files: Vec::new(),
        tables: Vec::new(),
        wall_time_s: 143.2,
    }
}

fn input(name: &str, prior: &str) -> InputRecord {
    let (median, log_standard_deviation) = (1.0, 1.0);
    let law = Shape::Lognormal {
        median,
        log_standard_deviation,
    };
    InputRecord {
        name: name.to_owned(),
        prior: prior.to_owned(),
        origin: None,
        // none that is flat: such are judged as intervals, too
        distribution: Distribution::new(law, None).ok(),
    }
}

/// The range of speeds excites close to the resonance, the stress is close to the allowable one.
fn requirements() -> Requirements {
    let criterion = |name: &str, quantity, limit, level| Criterion {
        name: name.to_owned(),
        standard: Some("example".to_owned()),
        clause: Some("1.2".to_owned()),
        quantity,
        limit,
        level,
        share: None,
        confidence: None,
    };
    Requirements {
        operation: Some(Operation {
            speed_rpm: [2700.0, 3100.0],
            engine_orders: vec![6, 54, 60],
            dwell_rpm: vec![3000.0],
            margin_relative_to: MarginBase::EngineOrder,
        }),
        stress: Some(Stress {
            modal_stress_mpa_per_um: 1.5,
            mean_stress_mpa: 180.0,
            endurance_limit_mpa: 350.0,
            ultimate_strength_mpa: 900.0,
        }),
        criteria: vec![
            criterion(
                "margin",
                RequiredQuantity::FrequencyMarginPercent,
                5.0,
                None,
            ),
            criterion(
                "amplitude",
                RequiredQuantity::AmplitudeUm,
                100.0,
                Some(20.0),
            ),
            criterion("reserve", RequiredQuantity::ReserveFactor, 1.2, Some(50.0)),
            criterion(
                "risk",
                RequiredQuantity::ProbabilityOfExceedance,
                0.05,
                Some(50.0),
            ),
        ],
    }
}

pub(crate) fn provenance() -> Provenance {
    Provenance {
        study: "Two blades with a strip".to_owned(),
        seed: 20_260_731,
        version: "0.1.0".to_owned(),
        commit: None,
        instruction_set: "avx2".to_owned(),
        other_programs: Vec::new(),
        model: "two-blade rig, 4 x 7 pairs per interface".to_owned(),
        law: FrictionLaw::Box,
        events: Events::Interpolated,
        anchor: SliderAnchor::StaticEquilibrium,
        harmonics: vec![0, 1, 2, 3],
        time_points: 256,
        folded: true,
        truncation_threshold: Some(0.01),
        highest_harmonic: Some(9),
        compared_with: Some(20),
        followed_modes: Vec::new(),
        peak_mode: None,
    }
}

/// Additive recurrence in [0, 1): evenly spread, reproducible.
fn fraction(i: u64, step: f64) -> f64 {
    (0.5 + (i + 1) as f64 * step).fract()
}

/// Inputs of a point of the recurrence with these steps.
fn point(i: u64, steps: [f64; 2]) -> [f64; 2] {
    let [u, v] = steps.map(|step| fraction(i, step));
    [10f64.powf(2.0 * u - 1.0), 0.1 + 0.7 * v]
}

fn sample(index: u64, inputs: [f64; 2]) -> SampleOutcome {
    SampleOutcome {
        index,
        group: SampleGroup::default(),
        inputs: inputs.into(),
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
        around: match failed {
            true => AroundPeak::default(),
            false => AroundPeak::new(
                others(index, frequency, amplitude),
                lorentz(frequency, amplitude * force, width, 14.0),
                Some(sweeps(i, frequency, amplitude * force)),
            ),
        },
        newton_iterations: 8 + (noise * 20.0) as u32 + if failed { 60 } else { 0 },
        factorizations: 4 + (noise * 9.0) as u32,
    }
}

/// At the highest level every curve leans to low frequencies, and the sweep upwards meets nine tenths of the peak.
fn sweeps(i: usize, frequency_hz: f64, amplitude_m: f64) -> SweepRecord {
    let peak = Maximum {
        frequency_hz,
        amplitude_m,
    };
    let folds = i + 1 == LEVELS.len();
    SweepRecord {
        upward: match folds {
            true => Maximum {
                frequency_hz: frequency_hz + 0.5,
                amplitude_m: 0.9 * amplitude_m,
            },
            false => peak,
        },
        downward: peak,
        several_hz: folds.then_some([frequency_hz - 0.25, frequency_hz + 0.5]),
    }
}

/// None, one or two lower maxima.
fn others(index: u64, frequency_hz: f64, amplitude_m: f64) -> Vec<Maximum> {
    let other = |j| Maximum {
        frequency_hz: frequency_hz - 10.0 * j as f64,
        amplitude_m: amplitude_m / (1.0 + j as f64),
    };
    (1..=index % 3).map(other).collect()
}

/// Most peaks are predicted, some are tracked, few come from a sweep through the band.
fn route_of(noise: f64) -> PeakRoute {
    match noise {
        n if n > 0.95 => PeakRoute::SweptOnOne,
        n if n > 0.8 => PeakRoute::Tracked,
        _ => PeakRoute::Predicted,
    }
}

fn peak(force: f64, frequency_hz: f64, amplitude_m: f64, stick: f64, noise: f64) -> PeakRecord {
    let separated = (1.0 - stick) * (0.3 + 0.6 * (force / 300.0).sqrt());
    let work = 1e-3 * force * amplitude_m;
    // the synthetic structure has its free amplitude at a Q factor of 2500
    let q_factor = 2500.0 * amplitude_m / force / FREE_AMPLITUDE;
    PeakRecord {
        frequency_hz,
        amplitude_m,
        route: Some(route_of(noise)),
        multiplier_real: (noise > 0.3).then_some(0.95 - 0.3 * noise).into(),
        multiplier_imaginary: (noise > 0.3).then_some(0.2).into(),
        truncation_error: Some(1e-4 * 10f64.powf(1.9 * noise + 0.3 * (1.0 - stick))).into(),
        highest_harmonic: if noise > 0.7 { 5 } else { 3 },
        stick_fraction: stick,
        slip_fraction: 1.0 - stick - separated,
        separated_fraction: separated,
        work_input_j: work,
        work_viscous_j: 0.6 * work,
        work_friction_j: 0.4 * work * (1.0 - 1e-9 * noise),
        damping_ratio: Some(0.5 / q_factor).into(),
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
        unstable: None,
    };
    (-30..=30).map(place).map(point).collect()
}
