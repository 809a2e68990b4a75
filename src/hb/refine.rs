//! More harmonics for a located peak until the error alert is silent.

use super::alert::{enlarged, time_points, truncation_error};
use super::balance::Balance;
use super::newton::{Condition, Iterate, WorkCount};
use super::peak::PeakSettings;
use super::predicted::{PeakPrediction, correct, maximum_near};
use super::problem::Problem;
use super::settings::HbSettings;
use super::solution::Solution;
use super::status::Status;
use crate::harmonics::HarmonicSet;

/// Raises the harmonics of the peak `iterate` of `balance` as far as `settings.alert` asks; `count` is the work before.
///
/// Each larger set starts from the peak on the smaller one. A peak that cannot be located on the larger set stays on the
/// smaller one, with [`Status::TruncationAboveThreshold`].
#[must_use]
pub fn refined<'p>(
    balance: &Balance<'p>,
    iterate: Iterate<'p>,
    settings: &HbSettings,
    peak: PeakSettings,
    mut count: WorkCount,
) -> Solution {
    let Some(alert) = settings.alert else {
        return Solution::new(balance, &iterate, Status::Converged, count);
    };
    let mut raised: Option<Balance<'p>> = None;
    let mut iterate = iterate;
    loop {
        let balance = raised.as_ref().unwrap_or(balance);
        let below_cap = balance.harmonics.highest() < alert.highest_harmonic;
        let cap = below_cap.then_some(alert.highest_harmonic);
        let larger = on(balance.problem, enlarged(&balance.harmonics, cap), settings);
        let prediction = PeakPrediction::on_other_harmonics(balance, &iterate, &larger);
        let locked = Condition::PhaseLocked(prediction.phasor);
        let error = truncation_error(balance, &iterate, &larger, locked);
        count += WorkCount {
            iterations: 1,
            factorizations: 1,
        };
        let silent = error <= alert.threshold;
        let next = (!silent && below_cap)
            .then(|| maximum_near(&larger, prediction, peak, settings.newton, &mut count).ok())
            .flatten();
        let Some(next) = next else {
            let status = match silent {
                true => Status::Converged,
                false => Status::TruncationAboveThreshold,
            };
            let mut solution = Solution::new(balance, &iterate, status, count);
            solution.truncation_error = Some(error);
            return solution;
        };
        iterate = next;
        raised = Some(larger);
    }
}

/// The peak next to a prediction on `harmonics`, refined from there.
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
    let (iterate, count) = correct(&balance, prediction, peak, settings.newton)?;
    Ok(refined(&balance, iterate, settings, peak, count))
}

/// `problem` on the harmonics of the study, or on others with time points to match.
#[must_use]
pub fn on<'p>(
    problem: &'p Problem<'p>,
    harmonics: HarmonicSet,
    settings: &HbSettings,
) -> Balance<'p> {
    let aft = match harmonics == settings.harmonics {
        true => settings.aft,
        false => time_points(settings.aft, &harmonics),
    };
    Balance::new(problem, harmonics, aft)
}
