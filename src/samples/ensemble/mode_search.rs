//! The maximum of one mode of a sample, from the samples solved before it.
//!
//! The maximum is predicted from the atlas and corrected by Newton steps: undamped ones, in large studies at first with the
//! inverse Jacobian of an anchor ([`super::with_inverse`]), or else damped ones. If that fails, it is followed from the
//! nearest anchor along the straight line between the inputs. If that fails too, it is tracked over the levels from the stuck
//! structure, as without an atlas. [`crate::hb::PeakRoute`] lists all routes.

use super::atlas::{AnchorPeak, Atlas, AtlasPrediction, NearAnchor, PathPeak, Place};
use super::shared::Ensemble;
use crate::hb::peak::attribution::ModeShapes;
use crate::hb::peak::level_peak::{LevelPeak, ModeSearch};
use crate::hb::peak::maxima::{Maxima, PeakChoice};
use crate::hb::peak::predicted::correct;
use crate::hb::peak::refine::{refined_anchored, refined_near};
use crate::hb::peak::search::PeakSettings;
use crate::hb::peak::track::{Locating, track_mode};
use crate::hb::structure::resonance::Candidate;
use crate::hb::{NewtonSettings, PeakRoute, Problem, Solution, Status};
use std::cell::OnceCell;

/// If the found amplitude differs from the predicted one by this relative distance or more, the solution may lie on another
/// branch and is not accepted.
const SURPRISE: f64 = 0.2;
/// From this relative distance on it may be another maximum of the branch than that of the other samples: the branch is followed.
const DOUBT: f64 = 0.03;
/// First and smallest step from an anchor towards a sample, as a share of their distance.
const STEPS: [f64; 2] = [0.5, 1.0 / 64.0];
/// Relative tolerance of frequency and residual at the peaks between an anchor and a sample: they are only starts for the next
/// ones.
const INTERMEDIATE_TOLERANCE: f64 = 1e-3;

/// One mode of a sample.
pub(super) struct ModeOfSample<'a> {
    pub problem: &'a Problem<'a>,
    pub mode: &'a Candidate,
    /// Stiffness of the contacts at rest.
    pub stiffness: &'a [f64],
    /// The sample's own levels.
    pub levels: &'a [f64],
    /// Values of its inputs' distribution functions.
    pub place: &'a [f64],
    /// Maxima found so far, of other modes. Shape: `[levels]`.
    pub known: &'a [Maxima],
}

impl ModeOfSample<'_> {
    /// Place in the atlas of the peak at level number `level`.
    fn at(&self, level: usize) -> Place<'_> {
        Place {
            inputs: self.place,
            level,
            mode: self.mode.mode,
        }
    }

    /// Whether a peak at level number `level` is the one that was predicted with this `amplitude`.
    fn expects(&self, level: usize, found: &Solution, amplitude: f64) -> bool {
        !surprising(found.amplitude(0), amplitude)
            && !self.known[level].is_of_another(self.mode.mode, found)
    }
}

impl Ensemble<'_> {
    /// Maxima of one mode at the `wanted` levels. A maximum is taken from the atlas if the atlas leads to the predicted peak; the
    /// others are tracked over the levels.
    pub(super) fn of_mode(
        &self,
        of: &ModeOfSample<'_>,
        wanted: &[usize],
        atlas: &Atlas,
    ) -> Vec<ModeSearch> {
        let mut searches: Vec<ModeSearch> = (wanted.iter())
            .map(|&level| self.found_from_atlas(of, level, atlas))
            .collect();
        let missing: Vec<&mut ModeSearch> = (searches.iter_mut())
            .filter(|search| search.peak.solution.is_none())
            .collect();
        if !missing.is_empty() {
            let levels: Vec<f64> = missing.iter().map(|search| search.peak.level).collect();
            let tracked = self.tracked(of, &levels, Locating::Newton);
            let shapes = OnceCell::new();
            for (search, tracked) in missing.into_iter().zip(tracked) {
                let (mut peak, is_own) = self.of_this_mode(of, tracked, &shapes);
                peak.count += search.peak.count;
                search.is_own = is_own;
                search.peak = peak;
            }
        }
        searches
    }

    fn tracked(&self, of: &ModeOfSample<'_>, levels: &[f64], how: Locating) -> Vec<LevelPeak> {
        track_mode(of.problem, self.settings, self.peak, of.mode, levels, how)
    }

    /// The maximum that `tracked` has led to, and whether it is known to be that of the mode. Where the study names modes, a maximum
    /// whose vibration is that of another one is searched again uphill along the branch.
    fn of_this_mode(
        &self,
        of: &ModeOfSample<'_>,
        mut tracked: LevelPeak,
        shapes: &OnceCell<Option<ModeShapes>>,
    ) -> (LevelPeak, bool) {
        let Some(solution) = &tracked.solution else {
            return (tracked, true);
        };
        let of_any = solution.route.is_some_and(PeakRoute::is_of_any_mode);
        if !of_any && self.choice == PeakChoice::Highest {
            return (tracked, true);
        }
        let shapes = shapes.get_or_init(|| ModeShapes::new(of.problem.model, of.stiffness).ok());
        let resembles = |found: &Solution| {
            let shapes = shapes.as_ref();
            shapes.is_some_and(|s| s.resembles(of.problem, found, of.mode.mode))
        };
        let is_own = resembles(solution);
        if of_any || is_own {
            return (tracked, is_own);
        }
        for mut uphill in self.tracked(of, &[tracked.level], Locating::Uphill) {
            if uphill.solution.as_ref().is_some_and(resembles) {
                uphill.count += tracked.count;
                return (uphill, true);
            }
            tracked.count += uphill.count;
        }
        // two modes may end in one maximum, which is then that of one of them alone
        (tracked, self.choice == PeakChoice::All)
    }

    /// The maximum that is found from the atlas at level number `level`, if any.
    pub(super) fn found_from_atlas(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        atlas: &Atlas,
    ) -> ModeSearch {
        let effort = &of.problem.effort;
        effort.grant(self.settings.newton.budget);
        let before = effort.count();
        let at = of.at(level);
        let (mut others, mut expected) = (Vec::new(), None);
        let found = atlas.predict(&at).and_then(|prediction| {
            let prediction = prediction.at_level(of.levels[level]);
            expected = Some(prediction.amplitude);
            let anchored = self.anchored_from_lane(of, &at, atlas, &prediction);
            let predicted = anchored.or_else(|| self.predicted(of, level, prediction, &mut others));
            predicted.or_else(|| self.followed(of, level, atlas.nearest(&at)?, &mut others))
        });
        let count = effort.count().since(before);
        let expected = found.as_ref().zip(expected);
        let is_doubtful = expected
            .is_some_and(|(found, amplitude)| apart(found.amplitude(0), amplitude) >= DOUBT);
        let peak = match found {
            Some(solution) => LevelPeak::found(solution, count),
            None => LevelPeak::failed(of.levels[level], Status::StepTooSmall, count),
        };
        ModeSearch {
            others,
            is_doubtful,
            ..ModeSearch::from(peak)
        }
    }

    /// The peak found with the inverse Jacobian of an anchor, from where a device has come to if one has; a peak of another
    /// branch than the one predicted counts as none.
    fn anchored_from_lane(
        &self,
        of: &ModeOfSample<'_>,
        at: &Place<'_>,
        atlas: &Atlas,
        prediction: &AtlasPrediction,
    ) -> Option<Solution> {
        let again = || self.anchored(of, at, atlas, prediction);
        let from_lane = atlas.inverses().start(&at.key()).and_then(|peak| {
            let start = AtlasPrediction {
                peak,
                ..prediction.clone()
            };
            self.anchored(of, at, atlas, &start)
        });
        match from_lane {
            Some(found) => self.compared(at, found, again),
            None => again(),
        }
    }

    /// The peak found from a prediction with the inverse Jacobian of an anchor: the one that is found without, for less
    /// time. None if there is no inverse, or if the peak is none that [`Self::predicted`] would take.
    fn anchored(
        &self,
        of: &ModeOfSample<'_>,
        at: &Place<'_>,
        atlas: &Atlas,
        prediction: &AtlasPrediction,
    ) -> Option<Solution> {
        let found = self.with_inverse(atlas, at, prediction, |inverse| {
            let (harmonics, peak) = (&prediction.harmonics, prediction.peak.clone());
            refined_anchored(
                of.problem,
                harmonics,
                peak,
                inverse,
                self.settings,
                self.peak,
            )
            .ok()
        })?;
        (of.expects(at.level, &found, prediction.amplitude)).then_some(found)
    }

    /// The peak found from a prediction. If its amplitude is too far from the predicted one, or if it is the maximum of another
    /// mode, it is added to `others` instead.
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
        if !of.expects(level, &found, amplitude) {
            others.push(found);
            return None;
        }
        Some(found)
    }

    /// The peak at level number `level`, followed from an anchor by steps along the straight line between their inputs.
    fn followed(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        anchor: NearAnchor<'_>,
        others: &mut Vec<Solution>,
    ) -> Option<Solution> {
        let mut before = None;
        let mut at = PathPeak {
            share: 0.0,
            peak: anchor.peak.clone(),
        };
        let mut step = STEPS[0];
        loop {
            let share = 1.0f64.min(at.share + step);
            let prediction = at.extrapolated(before.as_ref(), share);
            if share == 1.0 {
                let prediction = prediction.at_level(of.levels[level]);
                if let Some(peak) = self.predicted(of, level, prediction, others) {
                    return Some(Solution {
                        route: Some(PeakRoute::Followed),
                        ..peak
                    });
                }
            } else if let Some(peak) =
                self.intermediate_peak(of, level, anchor.place, share, prediction)
            {
                before = Some(std::mem::replace(&mut at, PathPeak { share, peak }));
                step *= 2.0;
                continue;
            }
            step = 0.5 * (share - at.share);
            if step < STEPS[1] {
                return None;
            }
        }
    }

    /// The peak at level number `level` for inputs at a `share` of the distance from the place `start` to that of the sample, on
    /// the harmonics of the prediction.
    fn intermediate_peak(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        start: &[f64],
        share: f64,
        prediction: AtlasPrediction,
    ) -> Option<AnchorPeak> {
        let place: Vec<f64> = (start.iter().zip(of.place))
            .map(|(a, b)| a + share * (b - a))
            .collect();
        let amplitude = prediction.amplitude;
        let peak = PeakSettings {
            frequency_tolerance: self.peak.frequency_tolerance.max(INTERMEDIATE_TOLERANCE),
            ..self.peak
        };
        let newton = NewtonSettings {
            tolerance: self.settings.newton.tolerance.max(INTERMEDIATE_TOLERANCE),
            ..self.settings.newton
        };
        let inputs = self.design.values_at(&place);
        let found = self.search_at(&inputs, level, prediction, |balance, start| {
            let corrected = correct(balance, start, peak, newton);
            of.problem.effort.add(balance.problem.effort.count());
            Some(corrected.ok()?.solution(balance))
        })?;
        (!surprising(found.amplitude(0), amplitude)).then(|| AnchorPeak::new(&found))
    }
}

/// Whether an amplitude is too far from the predicted one to lie on the same branch.
fn surprising(found: f64, predicted: f64) -> bool {
    apart(found, predicted) >= SURPRISE
}

/// Relative distance of an amplitude from the predicted one.
fn apart(found: f64, predicted: f64) -> f64 {
    (found / predicted - 1.0).abs()
}
