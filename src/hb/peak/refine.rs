//! More harmonics for a solution until the error alert is silent.

use super::alert::AlertSets;
use super::predicted::{PeakPrediction, correct, maximum_near};
use super::search::{Located, PeakSettings, highest_aside};
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

/// What a solution remains on more harmonics.
#[derive(Debug, Clone, Copy)]
pub enum Kept {
    /// The solution at its frequency.
    Frequency,
    /// A maximum of |ŷ|.
    Maximum(PeakSettings),
}

impl Kept {
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
            Self::Maximum(peak) => maximum_near(balance, start, peak, newton),
        }
    }

    /// The solution on `larger` beside one on fewer harmonics, where none was found next to it.
    fn aside<'p>(
        self,
        from: (&Balance<'p>, &Iterate<'p>),
        larger: &Balance<'p>,
        newton: NewtonSettings,
    ) -> Option<Located<'p>> {
        match self {
            Self::Frequency => None,
            Self::Maximum(peak) => highest_aside(from, larger, peak, newton),
        }
    }
}

/// Raises the harmonics of the solution `found` of `balance` as far as the alert of `sets` asks, which begin with those
/// of `balance`.
///
/// A solution that cannot be found on larger sets stays on the smaller one, with
/// [`Status::TruncationAboveThreshold`].
#[must_use]
pub fn refined<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    sets: Option<&AlertSets<'_, 'p>>,
    (kept, newton): (Kept, NewtonSettings),
) -> Solution {
    let Some(sets) = sets else {
        return found.solution(balance);
    };
    let (mut at, mut found) = (0, found);
    // another set and the amplitude on it
    let mut seen: Option<(usize, f64)> = None;
    loop {
        let balance = sets.balance(at);
        let Located { iterate, sharpness } = &found;
        let response = iterate.response(balance);
        let phasor = response / response.norm();
        let condition = kept.condition(phasor);
        let by_seen = seen.map(|(other, amplitude)| {
            let change = amplitude / response.norm() - 1.0;
            (other, sets.error_by(at, other, change))
        });
        let step = sets.step(at, iterate, condition);
        // one alone may be small by accident; a solve with twice the harmonics costs more than all before
        if let Some((other, error)) = by_seen
            && other > at
            && sets.is_silent(error.max(step.error))
        {
            return sets.judged(found.solution(balance), error.max(step.error));
        }
        let outlook = sets.outlook(at, iterate, step, condition);
        let twice = sets.balance(sets.twice(at));
        let starts = [(twice, &outlook.point), (balance, &iterate.point)];
        let raised = |to: usize| {
            let larger = sets.balance(to);
            starts.into_iter().find_map(|(from, point)| {
                let start = PeakPrediction {
                    point: point.padded(from, larger),
                    phasor,
                    sharpness: *sharpness,
                };
                let solved = kept.solved(larger, start, newton);
                Some((to, solved.ok()?))
            })
        };
        let next = if sets.is_silent(outlook.error) {
            None
        } else if outlook.error.is_finite() {
            sets.above(at, outlook.error).into_iter().find_map(raised)
        } else {
            // the smallest set is the least work, and the alert judges it again
            sets.larger(at).into_iter().find_map(|to| {
                let from = (balance, iterate);
                let found = kept.aside(from, sets.balance(to), newton)?;
                Some((to, found))
            })
        };
        if let Some(larger) = next {
            let (twice, to) = (sets.twice(at), larger.0);
            seen = match outlook.amplitude {
                Some(amplitude) if twice > to => Some((twice, amplitude)),
                _ => Some((at, response.norm())),
            };
            (at, found) = larger;
            continue;
        }
        let outlook = sets.decided(at, iterate, outlook, condition);
        let error = match by_seen {
            Some((_, error)) if outlook.error.is_infinite() => error,
            _ => outlook.error,
        };
        return sets.judged(found.solution(balance), error);
    }
}

/// The peak next to a prediction on `harmonics`, reached by undamped steps or else by damped ones, refined from there.
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
    let (route, found) = match correct(&balance, prediction.clone(), peak, newton) {
        Ok(found) => (PeakRoute::Predicted, found),
        Err(_) => (
            PeakRoute::Damped,
            maximum_near(&balance, prediction, peak, newton)?,
        ),
    };
    let sets = AlertSets::new(problem, harmonics, settings);
    let kept = (Kept::Maximum(peak), newton);
    Ok(Solution {
        route: Some(route),
        ..refined(&balance, found, sets.as_ref(), kept)
    })
}
