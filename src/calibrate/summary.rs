//! Numbers of a calibration from its draws.

use super::chains::Chains;
use super::found::{
    Calibrated, CalibratedInput, Calibration, Checked, FoundDeviation, Origin, Quantiles, Round,
};
use super::posterior::{Deviation, Posterior};
use super::predictive::{below_measured, misfit};
use super::settings::CalibrationSettings;
use super::surrogate::{Surrogates, root_mean_square};
use super::warnings::{Judged, warnings};
use crate::sampling::stream::{CALIBRATION, uniform};
use crate::sampling::{Distribution, Input};
use crate::special::normal_quantile;
use crate::statistics::{mixing, rank_correlation};

/// Draws of the prior that say what it predicts.
const PRIOR_DRAWS: u64 = 2000;
/// Ends of the middle of a prior.
const MIDDLE: [f64; 2] = [0.02, 0.98];

/// The last round.
pub(super) struct Drawn<'a> {
    pub(super) posterior: &'a Posterior<'a>,
    pub(super) surrogates: &'a Surrogates,
    pub(super) chains: &'a Chains,
    /// Solver minus surrogate at draws of the posterior, in the order of the surrogates.
    pub(super) errors: &'a [Vec<f64>],
    pub(super) settings: &'a CalibrationSettings,
}

pub(super) fn summary(of: Origin, rounds: Vec<Round>, drawn: &Drawn<'_>) -> Calibrated {
    let (posterior, chains) = (drawn.posterior, drawn.chains);
    let prior = posterior.prior();
    let values = |position: &Vec<f64>| prior.values(&position[..posterior.scores()]);
    let draws: Vec<Vec<Vec<f64>>> = (chains.positions.iter())
        .map(|chain| chain.iter().map(values).collect())
        .collect();
    let inputs = inputs(drawn, &draws);
    let deviations = deviations(drawn);
    let observations = observations(drawn);
    let positions: Vec<&[f64]> = chains.all().collect();
    let misfit_probability = misfit(posterior, &positions);
    Calibrated {
        summary: Calibration {
            warnings: warnings(&Judged {
                inputs: &inputs,
                deviations: &deviations,
                observations: &observations,
                stated: posterior.observations().stated,
                levels: &of.levels,
                rounds: &rounds,
                misfit: misfit_probability,
            }),
            origin: of,
            settings: drawn.settings.clone(),
            rounds,
            rank_correlation: correlations(&draws),
            inputs,
            deviations,
            observations,
            misfit_probability,
            acceptance: chains.acceptance,
        },
        draws,
    }
}

fn inputs(drawn: &Drawn<'_>, draws: &[Vec<Vec<f64>>]) -> Vec<CalibratedInput> {
    let (posterior, chains) = (drawn.posterior, drawn.chains);
    let prior = posterior.prior();
    let scores = posterior.scores();
    let of = |(j, (input, law)): (usize, &(Input, Distribution))| {
        let values = draws.iter().flatten().map(|values| values[j]).collect();
        let place = |position: &[f64]| prior.probabilities(&position[..scores])[j];
        let places = chains.each(place);
        let outside = places
            .iter()
            .flatten()
            .filter(|u| **u < MIDDLE[0] || **u > MIDDLE[1]);
        CalibratedInput {
            name: input.name().to_owned(),
            distribution: law.to_string(),
            law: law.clone(),
            prior: Quantiles::by(|p| law.quantile(p)),
            posterior: Quantiles::of(values),
            beyond_prior: outside.count() as f64 / chains.all().count() as f64,
            mixing: mixing(&places),
        }
    };
    prior.inputs().iter().enumerate().map(of).collect()
}

fn deviations(drawn: &Drawn<'_>) -> Vec<FoundDeviation> {
    let posterior = drawn.posterior;
    let of = |(k, deviation): (usize, &Deviation)| {
        let found = drawn
            .chains
            .each(|position| posterior.deviation(position, k));
        FoundDeviation {
            quantity: deviation.quantity,
            posterior: Quantiles::of(found.concat()),
            mixing: mixing(&found),
        }
    };
    posterior.deviations().iter().enumerate().map(of).collect()
}

fn observations(drawn: &Drawn<'_>) -> Vec<Checked> {
    let posterior = drawn.posterior;
    let before = prior_positions(posterior, drawn.settings.seed);
    let after: Vec<&[f64]> = drawn.chains.all().collect();
    let predicted = |positions: &[&[f64]]| -> Vec<Vec<[f64; 2]>> {
        positions.iter().map(|p| posterior.predictions(p)).collect()
    };
    let before: Vec<&[f64]> = before.iter().map(Vec::as_slice).collect();
    let (of_prior, of_posterior) = (predicted(&before), predicted(&after));
    let below = [&before, &after].map(|positions| below_measured(posterior, positions));
    let quantiles = |all: &[Vec<[f64; 2]>], o: usize| {
        Quantiles::of(all.iter().map(|predicted| predicted[o][0]).collect())
    };
    let means = posterior.observations().means.iter().enumerate();
    means
        .map(|(o, observation)| {
            let surrogate = &drawn.surrogates.all[o];
            let errors = &drawn.errors[o];
            Checked {
                measured: *observation,
                held_out: surrogate.held_out,
                surrogate_deviation: surrogate.deviation,
                error_at_posterior: (!errors.is_empty()).then(|| root_mean_square(errors)),
                prior: quantiles(&of_prior, o),
                posterior: quantiles(&of_posterior, o),
                below_by_prior: below[0][o],
                below_by_posterior: below[1][o],
            }
        })
        .collect()
}

/// Draws of the prior, with every unknown standard deviation at its scale.
fn prior_positions(posterior: &Posterior<'_>, seed: u64) -> Vec<Vec<f64>> {
    // the first draws are those where chains may start
    let first = 1_u64 << 32;
    let position = |i: u64| {
        let scores = (CALIBRATION..).take(posterior.scores());
        let mut position: Vec<f64> = scores
            .map(|dimension| normal_quantile(uniform(seed, first + i, dimension)))
            .collect();
        position.resize(posterior.dimension(), 0.0);
        position
    };
    (0..PRIOR_DRAWS).map(position).collect()
}

/// Spearman's correlation of the inputs over all draws.
fn correlations(draws: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let all: Vec<&Vec<f64>> = draws.iter().flatten().collect();
    let n = all.first().map_or(0, |values| values.len());
    let column = |j: usize| all.iter().map(|values| values[j]).collect::<Vec<f64>>();
    let columns: Vec<Vec<f64>> = (0..n).map(column).collect();
    let of = |i: usize, j: usize| match i == j {
        true => 1.0,
        false => {
            let pairs = columns[i].iter().copied().zip(columns[j].iter().copied());
            rank_correlation(&pairs.collect::<Vec<_>>()).unwrap_or(0.0)
        }
    };
    (0..n).map(|i| (0..n).map(|j| of(i, j)).collect()).collect()
}
