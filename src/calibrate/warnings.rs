//! What to look at before the result of a calibration is used.

use super::check::largest_ratio;
use super::found::{CalibratedInput, Checked, FoundDeviation, Round};
use super::observation::{ObservedQuantity, StatedCheck};
use super::surrogate::FEWEST_LOCAL;
use crate::page::display::with_digits;
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
/// Smallest probability of the scatter of repetitions at which stated deviations count as right.
const LEAST_STATED: f64 = 0.01;

/// How to find why draws have no solution.
const WHY_UNSOLVED: &str = "a run whose design is posterior.csv tells the status of each (the band of [frequency] may end too near)";

/// What the warnings are about.
pub(super) struct Judged<'a> {
    pub(super) inputs: &'a [CalibratedInput],
    pub(super) deviations: &'a [FoundDeviation],
    pub(super) observations: &'a [Checked],
    pub(super) stated: [Option<StatedCheck>; 2],
    pub(super) levels: &'a [f64],
    pub(super) rounds: &'a [Round],
    pub(super) misfit: f64,
}

/// All warnings, the most serious kind first.
pub(super) fn warnings(of: &Judged<'_>) -> Vec<String> {
    let mut found = Vec::new();
    found.extend(of.rounds.last().and_then(unsolved));
    found.extend(
        of.observations
            .iter()
            .filter_map(|o| beyond_prior(o, of.levels)),
    );
    let stated = ObservedQuantity::ALL.into_iter().zip(of.stated);
    found.extend(stated.filter_map(|(quantity, check)| understated(quantity, check?)));
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
    found
}

/// Name of an observation.
pub(super) fn name_of(checked: &Checked, levels: &[f64]) -> String {
    let quantity = name_of_quantity(checked.measured.quantity);
    format!("{quantity} at level {}", levels[checked.measured.level])
}

fn name_of_quantity(quantity: ObservedQuantity) -> &'static str {
    match quantity {
        ObservedQuantity::Frequency => "resonance frequency",
        ObservedQuantity::LogAmplitude => "amplitude",
    }
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

/// Stated deviations that the repetitions contradict.
fn understated(quantity: ObservedQuantity, check: StatedCheck) -> Option<String> {
    let column = match quantity {
        ObservedQuantity::Frequency => "frequency deviation",
        ObservedQuantity::LogAmplitude => "amplitude deviation",
    };
    (check.probability < LEAST_STATED).then(|| {
        format!(
            "repetitions of the {} scatter {} times as much as their stated deviations. The stated ones were used, so the intervals are \
             too narrow: state larger ones, or leave the column {column} out, so that the scatter counts",
            name_of_quantity(quantity),
            with_digits(check.factor, 2)
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
    let ratio = last.worst_ratio?;
    (ratio > largest_ratio(last.solved())).then(|| {
        format!(
            "the surrogate errs {ratio:.1} times as much at the posterior as the likelihood takes it for, after all rounds: more \
             samples (--samples)"
        )
    })
}

/// Draws of the posterior at which the model has no answer.
fn unsolved(last: &Round) -> Option<String> {
    let Round {
        checked, failed, ..
    } = *last;
    let means = match (failed, last.solved()) {
        (0, _) => return None,
        (_, 0) => {
            return Some(format!(
                "none of {checked} draws of the posterior has a solution: it rests on surrogates that nothing checks, and must not be \
                 used; {WHY_UNSOLVED}"
            ));
        }
        (_, solved) if solved < FEWEST_LOCAL => "too few are left to check the surrogates",
        _ => "where they lie nothing checks the surrogates",
    };
    let have = if failed == 1 { "has" } else { "have" };
    Some(format!(
        "{failed} of {checked} draws of the posterior {have} no solution: {means}; {WHY_UNSOLVED}"
    ))
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
