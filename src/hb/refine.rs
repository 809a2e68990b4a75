//! More harmonics for a solution until the error alert is silent.

use super::alert::{AlertSets, on, pad};
use super::balance::Balance;
use super::newton::{Condition, WorkCount, solve};
use super::peak::{Located, PeakSettings};
use super::predicted::{PeakPrediction, correct, maximum_near};
use super::problem::Problem;
use super::settings::{HbSettings, NewtonSettings};
use super::solution::Solution;
use super::status::Status;
use crate::harmonics::HarmonicSet;
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
        count: &mut WorkCount,
    ) -> Result<Located<'p>, Status> {
        match self {
            Self::Frequency => {
                let fixed = Condition::FixedFrequency;
                let iterate = count.tally(solve(balance, start.point, fixed, newton))?;
                Ok(iterate.into())
            }
            Self::Maximum(peak) => maximum_near(balance, start, peak, newton, count),
        }
    }
}

/// Raises the harmonics of the solution `found` of `balance` as far as the alert of `sets` asks, which begin with those
/// of `balance`; `count` is the work before.
///
/// A solution that cannot be found on larger sets stays on the smaller one, with
/// [`Status::TruncationAboveThreshold`].
#[must_use]
pub fn refined<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    sets: Option<&AlertSets<'_, 'p>>,
    (kept, newton): (Kept, NewtonSettings),
    mut count: WorkCount,
) -> Solution {
    let Some(sets) = sets else {
        return found.solution(balance, count);
    };
    let (mut at, mut found) = (0, found);
    loop {
        let balance = sets.balance(at);
        let Located { iterate, sharpness } = &found;
        let response = iterate.response(balance);
        let phasor = response / response.norm();
        let condition = kept.condition(phasor);
        let outlook = sets.outlook(at, iterate, condition);
        let twice = sets.balance(sets.twice(at));
        let starts = [(twice, &outlook.point), (balance, &iterate.point)];
        let mut raised = |to: usize| {
            let larger = sets.balance(to);
            starts.into_iter().find_map(|(from, point)| {
                let start = PeakPrediction {
                    point: pad(from, point, larger),
                    phasor,
                    sharpness: *sharpness,
                };
                let solved = kept.solved(larger, start, newton, &mut count);
                Some((to, solved.ok()?))
            })
        };
        let next = match sets.is_silent(outlook.error) {
            true => None,
            false => (sets.above(at, outlook.error).into_iter()).find_map(&mut raised),
        };
        if let Some(larger) = next {
            count += outlook.count;
            (at, found) = larger;
            continue;
        }
        let outlook = sets.decided(at, iterate, outlook, condition);
        count += outlook.count;
        return sets.judged(found.solution(balance, count), outlook.error);
    }
}

/// The peak next to a prediction on `harmonics`, reached by undamped steps or else by damped ones, refined from there.
///
/// # Errors
/// How the solve at the prediction ended; its work comes with either.
pub fn refined_near(
    problem: &Problem<'_>,
    harmonics: &HarmonicSet,
    prediction: PeakPrediction,
    settings: &HbSettings,
    peak: PeakSettings,
) -> Result<Solution, (Status, WorkCount)> {
    let balance = on(problem, harmonics.clone(), settings);
    let newton = settings.newton;
    let mut count = WorkCount::default();
    let undamped = count.tally(correct(&balance, prediction.clone(), peak, newton));
    let found = undamped.or_else(|_| maximum_near(&balance, prediction, peak, newton, &mut count));
    let found = found.map_err(|status| (status, count))?;
    let sets = AlertSets::new(problem, harmonics, settings);
    let kept = (Kept::Maximum(peak), newton);
    Ok(refined(&balance, found, sets.as_ref(), kept, count))
}
