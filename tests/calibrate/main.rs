//! Calibration: the posterior against closed forms, against data drawn from the prior, and against a solver.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its case fails"
)]

mod command;
#[path = "../common/described.rs"]
mod described;
#[path = "../common/function_case.rs"]
mod function_case;
mod linear;
mod measured;
#[path = "../common/page_rules.rs"]
mod page_rules;
#[path = "../common/program.rs"]
mod program;
mod simulated;

use microslip::calibrate::observation::{Observation, Observations};
use microslip::calibrate::surrogate::SolvedPoints;
use microslip::calibrate::{ObservedQuantity, Prior, Surrogates};
use microslip::sampling::Uncertainty;
use microslip::sampling::stream::uniform;
use microslip::sampling::{Design, DesignSettings, Distribution, Input, KnownCorrelation, Shape};
use microslip::special::normal_quantile;

/// Samples that shape the surrogates of these tests.
const SAMPLES: u64 = 60;

/// Two normal inputs, correlated by `rho`: damping 1 ± 0.1 and excitation 2 ± 0.2.
fn normal_prior(rho: f64) -> (Prior, Design) {
    let normal = |mean: f64, standard_deviation: f64| {
        let shape = Shape::Normal {
            mean,
            standard_deviation,
        };
        // a factor must be positive: cut ten standard deviations away
        let cut = Some([1e-6, 10.0 * mean]);
        Uncertainty::Aleatory(Distribution::new(shape, cut).unwrap())
    };
    let inputs = vec![Input::DampingScale, Input::ExcitationScale];
    let settings = DesignSettings {
        seed: 5,
        samples: Some(SAMPLES),
        inputs: vec![(inputs[0], normal(1.0, 0.1)), (inputs[1], normal(2.0, 0.2))],
        known_correlation: Some(KnownCorrelation {
            origin: "test".to_owned(),
            inputs,
            matrix: vec![vec![1.0, rho], vec![rho, 1.0]],
        }),
        ..DesignSettings::default()
    };
    let design = settings.build().unwrap();
    (Prior::of(&design).unwrap(), design)
}

/// Surrogates of a response that is known: frequency and ln amplitude of one level by the values of the inputs.
fn surrogates(prior: &Prior, design: &Design, response: impl Fn(&[f64]) -> [f64; 2]) -> Surrogates {
    let inputs: Vec<Vec<f64>> = (0..SAMPLES).map(|i| design.sample(i)).collect();
    let points = SolvedPoints {
        results: inputs.iter().map(|values| vec![response(values)]).collect(),
        inputs,
        of_prior: SAMPLES as usize,
    };
    Surrogates::fit(prior, &points, &[0], 1).unwrap()
}

/// Both quantities of one level with stated standard deviations.
fn observed(values: [f64; 2], deviations: [f64; 2]) -> Observations {
    let one = |(quantity, (mean, deviation)): (ObservedQuantity, (f64, f64))| Observation {
        level: 0,
        quantity,
        mean,
        repetitions: 1,
        variance: deviation * deviation,
    };
    let pairs = values.into_iter().zip(deviations);
    Observations {
        means: ObservedQuantity::ALL
            .into_iter()
            .zip(pairs)
            .map(one)
            .collect(),
        scatter: [None; 2],
        stated: [None; 2],
    }
}

/// Number `k` of a stream of standard normal numbers.
fn normal(seed: u64, k: u32) -> f64 {
    normal_quantile(uniform(seed, 0, k))
}
