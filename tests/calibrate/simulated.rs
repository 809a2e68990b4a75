//! Simulation-based calibration: truths from the prior, data from the truths, and where the truths rank among the draws.

use super::{SAMPLES, normal, normal_prior, observed, surrogates};
use microslip::calibrate::settings::Discrepancy;
use microslip::calibrate::{CalibrationSettings, Chains, Posterior};

/// Calibrations.
const TRIALS: u64 = 60;
/// Draws of each that a rank is counted among, evenly over all of them.
const RANKED: usize = 10;

fn response(x: &[f64]) -> [f64; 2] {
    [
        100.0 + 4.0 * x[0] * x[0] - 2.0 * x[1],
        x[0] + (x[1] - 2.0) * x[0],
    ]
}

/// χ² of ranks in five classes: below 14.9 but for one case in 200 (Talts et al., arXiv 1804.06788).
fn chi_square(ranks: &[usize]) -> f64 {
    let mut classes = [0.0; 5];
    for rank in ranks {
        classes[(rank * 5) / (RANKED + 1)] += 1.0;
    }
    // ranks 0, 1, 2 | 3, 4 | 5, 6 | 7, 8 | 9, 10 of 0 ..= 10
    let shares = [3.0, 2.0, 2.0, 2.0, 2.0].map(|n| n / (RANKED + 1) as f64);
    let expected = shares.map(|share| share * ranks.len() as f64);
    classes
        .iter()
        .zip(expected)
        .map(|(n, e)| (n - e) * (n - e) / e)
        .sum()
}

/// The ranks of the truths are even.
///
/// Seen to fail with the measurement taken for 2.5 times as accurate as it is.
#[test]
fn truths_rank_evenly_among_the_draws() {
    let (prior, design) = normal_prior(0.4);
    let fitted = surrogates(&prior, &design, response);
    let deviations = [0.15, 0.03];
    let settings = CalibrationSettings {
        chains: 2,
        draws: 100,
        warm_up: 200,
        ..CalibrationSettings::default()
    };
    let mut ranks = [Vec::new(), Vec::new()];
    for trial in 0..TRIALS {
        let truth = design.sample(SAMPLES + 1000 + trial);
        let exact = response(&truth);
        let noise = [0, 1].map(|k| normal(trial, k) * deviations[k as usize]);
        let data = observed([exact[0] + noise[0], exact[1] + noise[1]], deviations);
        let posterior = Posterior::new(&prior, &fitted, &data, Discrepancy::default());
        let settings = CalibrationSettings {
            seed: trial,
            ..settings.clone()
        };
        let chains = Chains::draw(&posterior, &settings).unwrap();
        for (j, ranks) in ranks.iter_mut().enumerate() {
            let step = chains.all().count() / RANKED;
            let draws = chains.all().step_by(step).take(RANKED);
            let below = draws.filter(|position| prior.values(position)[j] < truth[j]);
            ranks.push(below.count());
        }
    }
    for (j, ranks) in ranks.iter().enumerate() {
        let found = chi_square(ranks);
        assert!(
            found < 14.9,
            "input {j}: chi-square {found}, ranks {ranks:?}"
        );
    }
}
