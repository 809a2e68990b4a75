//! More harmonics for a solution until its stated truncation error is not above the threshold of the error alert.
//!
//! The error of a solution on one harmonic set is known in up to three ways, from the cheapest to the most expensive. The first
//! is the change of the amplitude from another set on which the solution was found before, the second one Newton step
//! onto twice the harmonics, the third a solve with twice the harmonics ([`super::alert`]). [`refined`] tries them in this order.

use super::alert::{AlertSets, TruncationEstimate};
use super::anchored::{AnchorInverse, anchored};
use super::more_harmonics::highest_on_more;
use super::predicted::{PeakPrediction, correct, maximum_near};
use super::search::{Located, PeakSettings, highest_beside};
use crate::harmonics::HarmonicSet;
use crate::hb::equations::balance::Balance;
use crate::hb::equations::balance::balance_on;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::{Condition, Iterate, solve};
use crate::hb::route::PeakRoute;
use crate::hb::settings::{HbSettings, NewtonSettings};
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use faer::prelude::c64;
use std::ops::ControlFlow;
use std::time::Instant;

/// Largest change of ŷ by more harmonics at a fixed frequency, over |ŷ|: a solution farther away is another answer.
const SAME_ANSWER: f64 = 0.5;

/// A maximum on a larger set that was searched around the one on fewer harmonics is at least so high beside it, if the error of that one
/// is known: a lower one belongs to another leg of the branch.
const LEAST_SHARE: f64 = 0.95;

/// What is held while harmonics are added.
#[derive(Debug, Clone, Copy)]
pub enum RefinementTarget {
    /// The frequency of the solution.
    Frequency,
    /// A maximum of |ŷ|: its frequency changes with the harmonics.
    Maximum(PeakSettings),
}

impl RefinementTarget {
    /// What closes the Newton steps of the alert at a solution whose response has the direction `phasor`.
    fn condition(self, phasor: c64) -> Condition<'static> {
        match self {
            Self::Frequency => Condition::FixedFrequency,
            Self::Maximum(_) => Condition::PhaseLocked(phasor),
        }
    }

    /// The solution on `balance` next to `start`.
    fn solved<'p>(
        self,
        balance: &Balance<'p>,
        start: PeakPrediction,
        newton: NewtonSettings,
    ) -> Result<Located<'p>, Status> {
        match self {
            Self::Frequency => {
                let fixed = Condition::FixedFrequency;
                let iterate = solve(balance, start.point, fixed, newton)?;
                Ok(iterate.into())
            }
            Self::Maximum(peak) => {
                let (_, found) = maximum_from(balance, start, peak, newton)?;
                Ok(highest_beside(balance, found, peak, newton))
            }
        }
    }

    /// The solution on `larger` harmonics, searched around the solution `found` of `balance`: for maxima only.
    fn searched_around<'p>(
        self,
        balance: &Balance<'p>,
        found: &Iterate<'p>,
        larger: &Balance<'p>,
        newton: NewtonSettings,
    ) -> Option<Located<'p>> {
        match self {
            Self::Frequency => None,
            Self::Maximum(peak) => highest_on_more(balance, found, larger, peak, newton),
        }
    }
}

/// Raises the harmonics of the solution `found` of `balance` as far as the alert asks; of maxima side by side it is the highest (`search::highest_beside`).
/// The first of `sets` has the harmonics of `balance`; without `sets` the solution stays as it is.
///
/// If the solution cannot be found on larger sets it stays on the smaller one, with [`Status::TruncationAboveThreshold`].
#[must_use]
pub fn refined<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    sets: Option<&AlertSets<'_, 'p>>,
    target: RefinementTarget,
    newton: NewtonSettings,
) -> Solution {
    let Some(sets) = sets else {
        return found.solution(balance);
    };
    let refinement = Refinement {
        sets,
        target,
        newton,
    };
    let begun = Instant::now();
    let mut at = OnSet { set: 0, found };
    let mut other = None;
    let error = loop {
        match refinement.checked(&at, other) {
            ControlFlow::Break(error) => break error,
            ControlFlow::Continue((larger, known)) => (at, other) = (larger, Some(known)),
        }
    };
    balance.problem.effort.add_alert_time(begun.elapsed());
    let solution = at.found.solution(sets.balance(at.set));
    sets.with_error(solution, error)
}

/// The error alert on one solution.
struct Refinement<'r, 's, 'p> {
    sets: &'r AlertSets<'s, 'p>,
    target: RefinementTarget,
    newton: NewtonSettings,
}

/// The solution on one harmonic set.
struct OnSet<'p> {
    /// Index of the set in `AlertSets`.
    set: usize,
    found: Located<'p>,
}

/// The amplitude of the solution on another harmonic set.
#[derive(Clone, Copy)]
struct KnownAmplitude {
    /// Index of the set in `AlertSets`.
    set: usize,
    /// |ŷ| (m).
    amplitude: f64,
}

impl<'p> Refinement<'_, '_, 'p> {
    /// Checks a solution by its errors, the cheapest first. `other` is its amplitude on another set, if known. Breaks with the
    /// error if the solution stays on its set; else continues with the solution on a larger set, and its amplitude on another.
    fn checked(
        &self,
        at: &OnSet<'p>,
        other: Option<KnownAmplitude>,
    ) -> ControlFlow<f64, (OnSet<'p>, KnownAmplitude)> {
        let (sets, set, iterate) = (self.sets, at.set, &at.found.iterate);
        let response = iterate.response(sets.balance(set));
        let amplitude = response.norm();
        let phasor = response / amplitude;
        let condition = self.target.condition(phasor);
        let by_change = other.map(|other| {
            let change = other.amplitude / amplitude - 1.0;
            sets.error_by(set, other.set, change)
        });
        // two small sets may agree in what both leave out
        let told_by_change =
            by_change.filter(|_| other.is_some_and(|other| sets.is_enough(set.max(other.set))));
        let by_step = sets.estimate_by_step(set, iterate, condition);
        // one of the two may be small by accident; a solve with twice the harmonics costs more than all before
        if let (Some(other), Some(by_change)) = (other, by_change)
            && other.set > set
            && sets.is_enough(other.set)
            && sets.is_accepted(by_change.max(by_step.error))
        {
            return ControlFlow::Break(by_change.max(by_step.error));
        }
        let estimate = sets.estimate(set, iterate, by_step, condition);
        if let Some(larger) = self.on_larger_set(at, &estimate, phasor) {
            let known = match estimate.amplitude {
                Some(amplitude) if estimate.set > larger.set => KnownAmplitude {
                    set: estimate.set,
                    amplitude,
                },
                _ => KnownAmplitude { set, amplitude },
            };
            return ControlFlow::Continue((larger, known));
        }
        let estimate = sets.estimate_by_solve(set, iterate, estimate, condition);
        ControlFlow::Break(match told_by_change {
            Some(error) if estimate.error.is_infinite() => error,
            _ => estimate.error,
        })
    }

    /// The solution on a larger set, if the estimated error asks for one and the solution is found there.
    fn on_larger_set(
        &self,
        at: &OnSet<'p>,
        estimate: &TruncationEstimate,
        phasor: c64,
    ) -> Option<OnSet<'p>> {
        let sets = self.sets;
        if sets.is_accepted(estimate.error) {
            return None;
        }
        let wanted = match estimate.error.is_finite() {
            true => sets.above(at.set, estimate.error),
            false => Vec::new(),
        };
        let next_to =
            (wanted.into_iter()).find_map(|set| self.found_next_to(at, estimate, phasor, set));
        next_to.or_else(|| self.found_around(at, estimate))
    }

    /// The solution on the smallest larger set on which a search around the solution finds one: a maximum that more harmonics split or
    /// move far. The smallest set is the least work, and the alert checks the solution on it again.
    fn found_around(&self, at: &OnSet<'p>, estimate: &TruncationEstimate) -> Option<OnSet<'p>> {
        let sets = self.sets;
        let (balance, iterate) = (sets.balance(at.set), &at.found.iterate);
        let least = match estimate.error.is_finite() {
            true => LEAST_SHARE * iterate.response(balance).norm(),
            false => 0.0,
        };
        let mut larger = sets.larger(at.set).into_iter();
        larger.find_map(|set| {
            let larger = sets.balance(set);
            let found = (self.target).searched_around(balance, iterate, larger, self.newton)?;
            let is_enough = found.iterate.response(larger).norm() >= least;
            is_enough.then_some(OnSet { set, found })
        })
    }

    /// The solution on `set`, started at the point of the estimate, or else at the solution itself.
    fn found_next_to(
        &self,
        at: &OnSet<'p>,
        estimate: &TruncationEstimate,
        phasor: c64,
        set: usize,
    ) -> Option<OnSet<'p>> {
        let sets = self.sets;
        let larger = sets.balance(set);
        let starts = [
            (sets.balance(estimate.set), &estimate.point),
            (sets.balance(at.set), &at.found.iterate.point),
        ];
        starts.into_iter().find_map(|(from, point)| {
            let start = PeakPrediction {
                point: point.padded(from, larger),
                phasor,
                sharpness: at.found.sharpness,
            };
            let found = self.target.solved(larger, start, self.newton).ok()?;
            let found = OnSet { set, found };
            self.is_same_answer(at, &found).then_some(found)
        })
    }

    /// Whether the solution on the `larger` set is that of the `smaller` one with more harmonics. At a fixed frequency next to a fold of the
    /// branch Newton's method may find another one; a maximum may be any one on the branch.
    fn is_same_answer(&self, smaller: &OnSet<'p>, larger: &OnSet<'p>) -> bool {
        let response = |at: &OnSet<'p>| at.found.iterate.response(self.sets.balance(at.set));
        let (before, after) = (response(smaller), response(larger));
        match self.target {
            RefinementTarget::Frequency => (after - before).norm() <= SAME_ANSWER * before.norm(),
            RefinementTarget::Maximum(_) => true,
        }
    }
}

/// The maximum next to a prediction by undamped Newton steps, or else by damped ones.
fn maximum_from<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<(PeakRoute, Located<'p>), Status> {
    if let Ok(found) = correct(balance, prediction.clone(), peak, newton) {
        return Ok((PeakRoute::Predicted, found));
    }
    let found = maximum_near(balance, prediction, peak, newton)?;
    Ok((PeakRoute::Damped, found))
}

/// The peak next to a prediction on `harmonics`: by undamped Newton steps, or else by damped ones. Then harmonics are added.
///
/// # Errors
/// How the solve at the prediction ended.
pub fn refined_near(
    problem: &Problem<'_>,
    harmonics: &HarmonicSet,
    prediction: PeakPrediction,
    settings: &HbSettings,
    peak: PeakSettings,
) -> Result<Solution, Status> {
    let balance = balance_on(problem, harmonics.clone(), settings);
    let newton = settings.newton;
    let (route, found) = maximum_from(&balance, prediction, peak, newton)?;
    Ok(Solution {
        route: Some(route),
        ..refined_maximum(&balance, found, settings, peak)
    })
}

/// The same by undamped Newton steps that take the inverse Jacobian of another sample's peak as preconditioner.
///
/// # Errors
/// The statuses of [`anchored`].
pub fn refined_anchored(
    problem: &Problem<'_>,
    harmonics: &HarmonicSet,
    prediction: PeakPrediction,
    inverse: AnchorInverse<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
) -> Result<Solution, Status> {
    let balance = balance_on(problem, harmonics.clone(), settings);
    let found = anchored(&balance, inverse, prediction, peak, settings.newton)?;
    Ok(Solution {
        route: Some(PeakRoute::Predicted),
        ..on_enough_harmonics(&balance, found, settings, peak)
    })
}

/// What is reported of the maximum `found` of `balance`: the highest one beside it ([`highest_beside`]), with as many harmonics as the
/// alert asks for.
pub(super) fn refined_maximum<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    settings: &HbSettings,
    peak: PeakSettings,
) -> Solution {
    let found = highest_beside(balance, found, peak, settings.newton);
    on_enough_harmonics(balance, found, settings, peak)
}

/// The maximum `found` of `balance` with as many harmonics as the alert asks for.
fn on_enough_harmonics<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    settings: &HbSettings,
    peak: PeakSettings,
) -> Solution {
    let sets = AlertSets::new(balance.problem, &balance.harmonics, settings);
    let target = RefinementTarget::Maximum(peak);
    refined(balance, found, sets.as_ref(), target, settings.newton)
}
