//! The maximum of one mode of a sample, from the samples solved before it.
//!
//! It is predicted from the atlas and corrected, by damped steps where undamped ones fail. Where that fails it is followed from
//! the nearest anchor along the straight line between the inputs, and where that fails too the mode's own track from the
//! stuck state decides. [`crate::hb::PeakRoute`] lists all routes.

use super::Ensemble;
use super::atlas::{AnchorPeak, Atlas, AtlasPrediction, Place};
use crate::hb::equations::balance::balance_on;
use crate::hb::peak::level_peak::LevelPeak;
use crate::hb::peak::maxima::{Maxima, ModeSearch};
use crate::hb::peak::predicted::correct;
use crate::hb::peak::refine::refined_near;
use crate::hb::peak::search::PeakSettings;
use crate::hb::peak::track::track_mode;
use crate::hb::structure::resonance::Candidate;
use crate::hb::{NewtonSettings, PeakRoute, Problem, Solution, Status};

/// Relative distance between the predicted and the found amplitude from which the prediction is not trusted to have
/// led to the same branch.
const SURPRISE: f64 = 0.2;
/// First and smallest share of the way from an anchor to a sample in one step.
const STEPS: [f64; 2] = [0.5, 1.0 / 64.0];
/// Relative tolerance of frequency and residual at the peaks between an anchor and a sample: they only lead on.
const WAYPOINT_TOLERANCE: f64 = 1e-3;

/// One mode of a sample.
pub(super) struct ModeOfSample<'a> {
    pub problem: &'a Problem<'a>,
    pub mode: &'a Candidate,
    /// The sample's own levels, and its place among the others.
    pub levels: &'a [f64],
    pub place: &'a [f64],
    /// What was found of other modes. Shape: `[levels]`.
    pub known: &'a [Maxima],
}

impl ModeOfSample<'_> {
    /// Where the atlas is asked for level number `level`.
    fn at(&self, level: usize) -> Place<'_> {
        Place {
            inputs: self.place,
            level,
            mode: self.mode.mode,
        }
    }
}

impl Ensemble<'_> {
    /// Maxima of one mode at the `wanted` levels: from the atlas where that leads to what it promised, the others by the
    /// track of the mode.
    pub(super) fn of_mode(
        &self,
        of: &ModeOfSample<'_>,
        wanted: &[usize],
        atlas: &Atlas,
    ) -> Vec<ModeSearch> {
        let mut searches: Vec<ModeSearch> = (wanted.iter())
            .map(|&level| self.led_by_atlas(of, level, atlas))
            .collect();
        let missing: Vec<&mut LevelPeak> = (searches.iter_mut().map(|search| &mut search.peak))
            .filter(|peak| peak.solution.is_none())
            .collect();
        if !missing.is_empty() {
            let levels: Vec<f64> = missing.iter().map(|peak| peak.level).collect();
            let tracked = track_mode(of.problem, self.settings, self.peak, of.mode, &levels);
            for (peak, mut tracked) in missing.into_iter().zip(tracked) {
                tracked.count += peak.count;
                *peak = tracked;
            }
        }
        searches
    }

    /// The maximum to which the atlas leads at a level (its number), if any.
    fn led_by_atlas(&self, of: &ModeOfSample<'_>, level: usize, atlas: &Atlas) -> ModeSearch {
        let effort = &of.problem.effort;
        effort.grant(self.settings.newton.budget);
        let before = effort.count();
        let at = of.at(level);
        let mut others = Vec::new();
        let found = atlas.predict(&at).and_then(|prediction| {
            let prediction = prediction.at_level(of.levels[level]);
            let predicted = self.predicted(of, level, prediction, &mut others);
            predicted.or_else(|| self.followed(of, level, atlas.nearest(&at)?, &mut others))
        });
        let count = effort.count().since(before);
        let peak = match found {
            Some(solution) => LevelPeak::found(solution, count),
            None => LevelPeak::failed(of.levels[level], Status::StepTooSmall, count),
        };
        ModeSearch { peak, others }
    }

    /// The peak that a prediction leads to, unless that is not what it promised, or the maximum of another mode: then it is
    /// put `others`.
    fn predicted(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        prediction: AtlasPrediction,
        others: &mut Vec<Solution>,
    ) -> Option<Solution> {
        let AtlasPrediction {
            harmonics,
            peak,
            amplitude,
        } = prediction;
        let found = refined_near(of.problem, &harmonics, peak, self.settings, self.peak).ok()?;
        let is_expected = !surprising(found.amplitude(0), amplitude)
            && !of.known[level].is_of_another(of.mode.mode, &found);
        if !is_expected {
            others.push(found);
            return None;
        }
        Some(found)
    }

    /// The peak at a level (its number), reached from an anchor by steps along the straight line between their places.
    fn followed(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        (start, anchor): (&[f64], &AnchorPeak),
        others: &mut Vec<Solution>,
    ) -> Option<Solution> {
        let (mut before, mut at) = (None, (0.0, anchor.clone()));
        let mut step = STEPS[0];
        loop {
            let share = 1.0f64.min(at.0 + step);
            let prediction = match &before {
                Some(before) => AnchorPeak::extrapolated(before, &at, share),
                None => at.1.as_prediction(),
            };
            if share == 1.0 {
                let prediction = prediction.at_level(of.levels[level]);
                if let Some(peak) = self.predicted(of, level, prediction, others) {
                    return Some(Solution {
                        route: Some(PeakRoute::Followed),
                        ..peak
                    });
                }
            } else if let Some(next) = self.waypoint(of, level, (start, share), prediction) {
                before = Some(std::mem::replace(&mut at, (share, next)));
                step *= 2.0;
                continue;
            }
            step = 0.5 * (share - at.0);
            if step < STEPS[1] {
                return None;
            }
        }
    }

    /// The peak at level number `level` at a share of the way from the place `start` to that of the sample, on the harmonics
    /// of the prediction.
    fn waypoint(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        (start, share): (&[f64], f64),
        prediction: AtlasPrediction,
    ) -> Option<AnchorPeak> {
        let inputs: Vec<f64> = (self.design.inputs().iter().zip(start.iter().zip(of.place)))
            .map(|((_, distribution), (a, b))| distribution.quantile(a + share * (b - a)))
            .collect();
        let applied = self.applied(&inputs).ok()?;
        let prediction = prediction.at_level(self.applied_levels(&applied)[level]);
        let problem = applied.problem(self.settings.anchor).ok()?;
        let balance = balance_on(&problem, prediction.harmonics, self.settings);
        let amplitude = prediction.amplitude;
        let peak = PeakSettings {
            frequency_tolerance: self.peak.frequency_tolerance.max(WAYPOINT_TOLERANCE),
            ..self.peak
        };
        let newton = NewtonSettings {
            tolerance: self.settings.newton.tolerance.max(WAYPOINT_TOLERANCE),
            ..self.settings.newton
        };
        let corrected = correct(&balance, prediction.peak, peak, newton);
        of.problem.effort.add(problem.effort.count());
        let found = corrected.ok()?.solution(&balance);
        (!surprising(found.amplitude(0), amplitude)).then(|| AnchorPeak::new(&found))
    }
}

/// Whether an amplitude is too far from the predicted one to lie on the same branch.
fn surprising(found: f64, predicted: f64) -> bool {
    (found / predicted - 1.0).abs() >= SURPRISE
}
