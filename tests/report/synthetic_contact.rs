//! Tests of a contact with plausible numbers, as an identification could have found them, to look at its report.

use microslip::file::FileRecord;
use microslip::identify::found::pooled_result::{PooledParameter, Trend, TrendOver};
use microslip::identify::found::result::{
    Cycles, Friction, LoopFigure, LoopResult, LoopScatter, LoopValue, Misfit, Tangential,
    TestEstimate, TestStatus,
};
use microslip::identify::{
    ContactParameter, Identified, IdentifiedInput, IdentifySettings, Pooled, TestResult, Uncertain,
};
use microslip::record::TestConditions;
use microslip::sampling::Shape;
use std::f64::consts::TAU;

const SAMPLES: usize = 400;
const CYCLES: usize = 60;
const RUN_IN: usize = 12;
const CONFIDENCE: f64 = 0.95;

/// Number in (−1, 1) that looks random.
fn noise(i: usize, seed: usize) -> f64 {
    let x = (i as f64 * 0.618_033_988_7 + seed as f64 * 0.414_213_562_4).fract();
    2.0 * ((x * 7919.0).fract()) - 1.0
}

fn uncertain(value: f64, relative: f64) -> Uncertain {
    Uncertain::new(value, [relative * value, 0.0], 20.0, CONFIDENCE)
}

/// An identification from `n` tests that slip.
pub(crate) fn identified(n: usize) -> Identified {
    Identified {
        format: 1,
        inputs: inputs(),
        correlation: vec![vec![1.0, 0.3], vec![0.3, 1.0]],
        notes: vec![
            "The offset of the normal force is not known from loops of one load.".to_owned(),
        ],
        settings: Some(IdentifySettings::default()),
        pressure_map: None,
        pooled: Some(pooled(n)),
        tests: (0..n).map(test).collect(),
        files: vec![FileRecord::of("tests.csv", b"tests")],
        version: "0.1.0".to_owned(),
    }
}

fn inputs() -> Vec<IdentifiedInput> {
    let lognormal = |median, log_standard_deviation| Shape::Lognormal {
        median,
        log_standard_deviation,
    };
    vec![
        IdentifiedInput {
            parameter: ContactParameter::FrictionCoefficient,
            shape: lognormal(0.6, 0.1),
        },
        IdentifiedInput {
            parameter: ContactParameter::TangentialStiffnessNPerUm,
            shape: lognormal(35.0, 0.25),
        },
    ]
}

fn pooled(n: usize) -> Pooled {
    let parameter = |parameter, value: f64, scatter: f64| PooledParameter {
        parameter,
        tests: n,
        specimens: n,
        median: uncertain(value, 0.3 * scatter),
        log_scatter: (n > 1).then_some(scatter),
        predictive_log_standard_deviation: 1.1 * scatter,
        few_tests_factor: 1.1,
        further_contact: [-2.2, 2.2].map(|z: f64| value * (z * scatter).exp()),
    };
    Pooled {
        parameters: vec![
            parameter(ContactParameter::FrictionCoefficient, 0.6, 0.1),
            parameter(ContactParameter::TangentialStiffnessNPerUm, 35.0, 0.25),
        ],
        correlation: vec![vec![1.0, 0.3], vec![0.3, 1.0]],
        specimens: n,
        trends: vec![Trend {
            parameter: ContactParameter::TangentialStiffnessNPerUm,
            over: TrendOver::NormalForce,
            tests: n,
            exponent: 0.31,
            interval: [0.12, 0.5],
        }],
        ..Pooled::default()
    }
}

/// Test `i`, which slips.
fn test(i: usize) -> TestResult {
    let friction = 0.6 * (0.1 * noise(i, 1)).exp();
    let stiffness = 35.0 * (0.4 * noise(i, 2)).exp();
    let load = [17.0, 87.0, 150.0][i % 3];
    TestResult {
        name: format!("pair-{}_run-{i}", i / 3),
        conditions: TestConditions {
            frequency_hz: Some(100.0),
            specimen: Some(format!("pair {}", i / 3)),
            ..TestConditions::default()
        },
        status: TestStatus::Slips,
        cycles: Some(Cycles {
            frequency_hz: 100.0,
            frequency_stated: true,
            whole: CYCLES,
            run_in: RUN_IN,
            steady: CYCLES - RUN_IN,
            samples_per_cycle: SAMPLES as f64,
            displacement_drift_m_per_s: 0.0,
            tangential_force_drift_n_per_s: 0.0,
            spikes: 0,
            force_resonance: None,
        }),
        estimate: Some(estimate(i, friction, stiffness, load)),
        loops: (0..CYCLES)
            .map(|k| cycle(i, k, friction, stiffness, load))
            .collect(),
        figure: Some(figure(i, friction, stiffness, load)),
        notes: Vec::new(),
    }
}

fn estimate(i: usize, friction: f64, stiffness: f64, load: f64) -> TestEstimate {
    TestEstimate {
        normal_force_n: load,
        normal_force_range_n: [0.97 * load, 1.04 * load],
        displacement_amplitude_m: amplitude(friction, stiffness, load),
        tangential_force_amplitude_n: friction * load,
        friction: Some(Friction {
            coefficient: uncertain(friction, 0.01),
            sides: [1.01 * friction, 0.99 * friction],
            tangential_offset_n: 0.2,
            from_energy: Some(1.02 * friction),
            energy_difference: Some(0.02),
            slip_distance_m: 2e-5,
        }),
        friction_at_least: None,
        tangential: Tangential {
            stiffness_n_per_um: uncertain(stiffness, 0.05),
            sides_n_per_um: [0.98, 1.02].map(|side| Some(uncertain(side * stiffness, 0.07))),
            measured_n_per_um: stiffness,
            samples: [40, 40],
            window_end: [0.6, 0.6],
            bent: [false; 2],
        },
        normal_stiffness_n_per_um: None,
        energy_j: uncertain(1e-4, 0.01),
        onset: None,
        loop_scatter: Some(LoopScatter {
            friction_coefficient: Some(0.008),
            tangential_stiffness: Some(0.03),
            energy: Some(0.006),
        }),
        error_correlation: 0.1,
        misfit: Misfit {
            relative_rms: 0.01 + 0.002 * i as f64,
            large: false,
        },
    }
}

/// Three times the elastic limit.
fn amplitude(friction: f64, stiffness: f64, load: f64) -> f64 {
    3.0 * friction * load / (stiffness * 1e6)
}

fn cycle(i: usize, k: usize, friction: f64, stiffness: f64, load: f64) -> LoopResult {
    let settled = 1.0 - 0.2 * (-(k as f64) / 4.0).exp();
    let value = |value: f64, relative: f64, seed: usize| LoopValue {
        value: settled * value * (1.0 + relative * noise(k, seed + i)),
        standard_error: (k % 20 != 9).then_some(0.5 * relative * value),
    };
    LoopResult {
        cycle: k,
        start_s: k as f64 / 100.0,
        steady: k >= RUN_IN,
        normal_force_n: load,
        friction_coefficient: (k % 20 != 7).then(|| value(friction, 0.02, 3)),
        friction_from_energy: Some(friction),
        tangential_stiffness_n_per_um: [4, 5].map(|seed| Some(value(stiffness, 0.1, seed))),
        normal_stiffness_n_per_um: None,
        energy_j: 1e-4,
    }
}

/// The loop of an elastic-Coulomb contact, and the same with noise.
fn figure(i: usize, friction: f64, stiffness: f64, load: f64) -> LoopFigure {
    let amplitude = amplitude(friction, stiffness, load);
    let angle = |k: usize| TAU * k as f64 / SAMPLES as f64;
    let displacement: Vec<f64> = (0..SAMPLES).map(|k| amplitude * angle(k).cos()).collect();
    let limit = friction * load;
    let mut force = limit;
    let fitted: Vec<f64> = (0..SAMPLES)
        .map(|k| {
            let before = displacement[k.saturating_sub(1)];
            force = (force + 1e6 * stiffness * (displacement[k] - before)).clamp(-limit, limit);
            force
        })
        .collect();
    let residual: Vec<f64> = (0..SAMPLES)
        .map(|k| 0.01 * limit * noise(k, 9 + i))
        .collect();
    let measured: Vec<f64> = fitted.iter().zip(&residual).map(|(f, r)| f + r).collect();
    let stick_windows = [Some([10, 50]), Some([210, 250])];
    let line = |ends: [usize; 2]| ends.map(|k| [displacement[k], fitted[k]]);
    let stick_lines = stick_windows.map(|window| window.map(line));
    LoopFigure {
        displacement_m: displacement,
        force_ratio: measured.iter().map(|t| t / load).collect(),
        normal_force_n: vec![load; SAMPLES],
        tangential_force_n: measured,
        fitted_force_n: Some(fitted),
        residual_n: Some(residual),
        stick_windows,
        plateaus: [Some([140, 190]), Some([340, 390])],
        stick_lines,
        approach_m: None,
    }
}

/// The whole contact never slips: a lower bound of the friction coefficient, and nothing fitted to slip.
pub(crate) fn stick(test: &mut TestResult) {
    test.status = TestStatus::NoSlip;
    if let Some(estimate) = &mut test.estimate {
        estimate.friction = None;
        estimate.friction_at_least = Some(0.43);
    }
    if let Some(figure) = &mut test.figure {
        (figure.fitted_force_n, figure.residual_n) = (None, None);
        figure.plateaus = [None; 2];
    }
    for found in &mut test.loops {
        (found.friction_coefficient, found.friction_from_energy) = (None, None);
    }
}

/// Nothing can be taken from the test.
pub(crate) fn spoil(test: &mut TestResult, reason: &str) {
    test.status = TestStatus::Unusable(reason.to_owned());
    (test.estimate, test.figure, test.cycles) = (None, None, None);
    test.loops.clear();
}
