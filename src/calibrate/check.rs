//! Whether the solver agrees with the surrogates where the posterior is.

use super::chains::Chains;
use super::found::Round;
use super::observation::Observations;
use super::posterior::Posterior;
use super::surrogate::{FEWEST_LOCAL, Surrogates, root_mean_square};

/// Share of the measurement's standard deviation below which an error of a surrogate moves no posterior: it adds 1 % to the
/// variance.
const NEGLIGIBLE: f64 = 0.1;

impl Round {
    /// Checked draws with a solution at every measured level.
    #[must_use]
    pub fn solved(&self) -> usize {
        self.checked - self.failed
    }

    /// Whether the surrogates err no more than the likelihood takes them for, at draws enough to say so. Draws without a solution
    /// say nothing: the error of none is not a small one.
    pub(super) fn is_enough(&self) -> bool {
        let solved = self.solved();
        let known = solved >= FEWEST_LOCAL.min(self.checked);
        known && (self.worst_ratio).is_some_and(|ratio| ratio <= largest_ratio(solved))
    }
}

/// Largest ratio of the error at `n` checked draws to the one that it was taken for that their own scatter explains: two standard
/// deviations of a root mean square.
#[must_use]
pub(super) fn largest_ratio(n: usize) -> f64 {
    1.0 + 2.0 / (2.0 * n.max(1) as f64).sqrt()
}

/// Scores of `wanted` draws, evenly over all chains.
pub(super) fn spread(chains: &Chains, wanted: usize, scores: usize) -> Vec<Vec<f64>> {
    let all: Vec<&[f64]> = chains.all().collect();
    let place = |k: usize| k * all.len() / wanted;
    (0..wanted.min(all.len()))
        .map(|k| all[place(k)][..scores].to_vec())
        .collect()
}

/// Solver minus surrogate at draws of the posterior, in the order of the surrogates; of the draws that have a solution at every
/// measured level alone, so that all are as long. Shape of `results`: draws × levels of the study, NaN without a solution.
pub(super) fn errors(
    posterior: &Posterior<'_>,
    surrogates: &Surrogates,
    scores: &[Vec<f64>],
    results: &[Vec<[f64; 2]>],
) -> Vec<Vec<f64>> {
    let mut errors = vec![Vec::new(); surrogates.all.len()];
    for (scores, results) in scores.iter().zip(results) {
        let predicted = surrogates.predict(&posterior.prior().coordinates(scores));
        let each = predicted.iter().zip(&surrogates.all);
        let of_draw = each.map(|(predicted, surrogate)| {
            results[surrogate.level][surrogate.quantity as usize] - predicted
        });
        let of_draw: Vec<f64> = of_draw.collect();
        if of_draw.iter().all(|error| error.is_finite()) {
            for (slot, error) in errors.iter_mut().zip(of_draw) {
                slot.push(error);
            }
        }
    }
    errors
}

/// What `checked` draws say of surrogates that `points` shaped.
pub(super) fn round(
    points: usize,
    checked: usize,
    posterior: &Posterior<'_>,
    surrogates: &Surrogates,
    errors: &[Vec<f64>],
) -> Round {
    Round {
        points,
        checked,
        failed: checked - errors.first().map_or(0, Vec::len),
        worst_ratio: worst_ratio(surrogates, posterior.observations(), errors),
    }
}

/// Largest error of a surrogate at draws of the posterior over what enters the likelihood for it; none of no draws. An error far
/// below that of the measurement moves no posterior, so that a share of the latter counts as known.
fn worst_ratio(
    surrogates: &Surrogates,
    observations: &Observations,
    errors: &[Vec<f64>],
) -> Option<f64> {
    let known = surrogates.all.iter().zip(&observations.means);
    let known = known.map(|(s, o)| s.deviation.hypot(NEGLIGIBLE * o.variance.sqrt()));
    let ratios = errors.iter().zip(known);
    let ratios = ratios.filter(|(errors, _)| !errors.is_empty());
    ratios
        .map(|(errors, known)| root_mean_square(errors) / known)
        .reduce(f64::max)
}

#[cfg(test)]
mod unit_tests {
    use super::*;

    /// Draws without a solution are not taken for draws without an error, and a few say too little.
    #[test]
    fn draws_without_a_solution_confirm_nothing() {
        let round = |failed, worst_ratio| Round {
            points: 128,
            checked: 32,
            failed,
            worst_ratio,
        };
        assert!(round(0, Some(0.5)).is_enough(), "all agree");
        assert!(round(24, Some(0.5)).is_enough(), "eight agree");
        assert!(!round(25, Some(0.5)).is_enough(), "seven say too little");
        assert!(!round(32, None).is_enough(), "none says anything");
        assert!(!round(0, Some(2.0)).is_enough(), "none agrees");
        // 1 + 2/√(2 · 8) = 1.5 and 1 + 2/√(2 · 32) = 1.25
        assert!(round(24, Some(1.4)).is_enough(), "scatter of eight");
        assert!(!round(0, Some(1.4)).is_enough(), "scatter of thirty-two");
    }
}
