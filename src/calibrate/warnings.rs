//! What to look at before the result of a calibration is used.

use super::found::{CalibratedInput, Checked, FoundDeviation, Round};
use super::observation::Quantity;
use crate::statistics::Mixing;

/// Largest R̂ of chains that agree, and fewest effective draws: Vehtari et al. 2021.
const LARGEST_R_HAT: f64 = 1.01;
const FEWEST_EFFECTIVE: f64 = 400.0;
/// Largest share of a posterior beyond the outer 4 % of its prior, ten times what it is where nothing was learnt.
const MOST_BEYOND: f64 = 0.4;
/// Smallest probability of either side at which a measured number still counts as predicted.
const LEAST_SIDE: f64 = 0.005;
/// Smallest p-value at which the model counts as one that can have given the measurement.
const LEAST_MISFIT: f64 = 0.01;
/// Largest share of draws whose path diverged.
const MOST_DIVERGENT: f64 = 0.01;

/// What the warnings are about.
pub(super) struct Judged<'a> {
    pub(super) inputs: &'a [CalibratedInput],
    pub(super) deviations: &'a [FoundDeviation],
    pub(super) observations: &'a [Checked],
    pub(super) levels: &'a [f64],
    pub(super) rounds: &'a [Round],
    pub(super) misfit: f64,
    pub(super) divergent: f64,
}

/// All warnings, the most serious kind first.
pub(super) fn warnings(of: &Judged<'_>) -> Vec<String> {
    let mut found = Vec::new();
    found.extend(
        of.observations
            .iter()
            .filter_map(|o| beyond_prior(o, of.levels)),
    );
    found.extend(of.inputs.iter().filter_map(at_the_edge));
    if of.misfit < LEAST_MISFIT {
        found.push(format!(
            "the calibrated model does not reproduce the measurement: p = {:.2e}; what it lacks is no input of the study, or the \
             stated deviations are too small (--discrepancy-hz, --discrepancy-percent)",
            of.misfit
        ));
    }
    found.extend(of.rounds.last().and_then(unchecked));
    let of_inputs = of.inputs.iter().map(|i| (i.name.clone(), i.mixing));
    let name = |_: &FoundDeviation| "the discrepancy".to_owned();
    let of_deviations = of.deviations.iter().map(|d| (name(d), d.mixing));
    found.extend(
        of_inputs
            .chain(of_deviations)
            .filter_map(|(name, m)| unmixed(&name, m)),
    );
    if of.divergent > MOST_DIVERGENT {
        let percent = 100.0 * of.divergent;
        found.push(format!("the paths of {percent:.1} % of the draws diverged: the tails of the posterior may be missing"));
    }
    found
}

/// Name of an observation.
pub(super) fn name_of(checked: &Checked, levels: &[f64]) -> String {
    let quantity = match checked.measured.quantity {
        Quantity::Frequency => "resonance frequency",
        Quantity::LogAmplitude => "amplitude",
    };
    format!("{quantity} at level {}", levels[checked.measured.level])
}

fn beyond_prior(checked: &Checked, levels: &[f64]) -> Option<String> {
    let p = checked.below_by_prior;
    (!(LEAST_SIDE..=1.0 - LEAST_SIDE).contains(&p)).then(|| {
        let side = if p < 0.5 { "below" } else { "above" };
        format!(
            "the measured {} lies {side} what the prior can give: widen the distributions, or look for what the model lacks",
            name_of(checked, levels)
        )
    })
}

fn at_the_edge(input: &CalibratedInput) -> Option<String> {
    (input.beyond_prior > MOST_BEYOND).then(|| {
        format!(
            "{:.0} % of the posterior of {} lie beyond the 2 % or the 98 % quantile of its prior: the prior decides it; widen {}",
            100.0 * input.beyond_prior,
            input.name,
            input.distribution
        )
    })
}

fn unchecked(last: &Round) -> Option<String> {
    (last.worst_ratio > largest_ratio(last.checked)).then(|| {
        format!(
            "the surrogate errs {:.1} times as much at the posterior as the likelihood takes it for, after all rounds: more samples \
             (--samples)",
            last.worst_ratio
        )
    })
}

/// Largest ratio of the error at `n` checked draws to the one that it was taken for that their own scatter explains: two standard
/// deviations of a root mean square.
#[must_use]
pub(super) fn largest_ratio(n: usize) -> f64 {
    1.0 + 2.0 / (2.0 * n.max(1) as f64).sqrt()
}

fn unmixed(name: &str, mixing: Option<Mixing>) -> Option<String> {
    let Some(mixing) = mixing else {
        return Some(format!("the chains of {name} do not move"));
    };
    let effective = mixing.bulk_effective.min(mixing.tail_effective);
    let mixed = mixing.r_hat <= LARGEST_R_HAT && effective >= FEWEST_EFFECTIVE;
    (!mixed).then(|| {
        format!(
            "the chains of {name} do not agree well: R-hat = {:.3} (at most {LARGEST_R_HAT}), {effective:.0} effective draws (at least \
             {FEWEST_EFFECTIVE:.0}); more draws (--draws)",
            mixing.r_hat
        )
    })
}
