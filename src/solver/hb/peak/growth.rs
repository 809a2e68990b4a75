//! Rules of the search for a predicted peak, whoever evaluates: fed with what an iterate tells, they choose the next
//! frequency. [`super::predicted`] tells the method.

use crate::hb::status::Status;
use faer::prelude::c64;

/// Residual over the dynamic displacement below which the growth of the amplitude is more reliable than the predicted phase.
const SETTLED: f64 = 1e-2;
/// Error of the growth, per residual over the dynamic displacement.
const GROWTH_ERROR: f64 = 5.0;
/// Longest step of the phase (rad) in one iteration.
const LONGEST_STEP: f64 = 0.5;
/// Two iterations measure the sharpness if their phases differ by more than this many times the sum of the errors of their
/// growths.
const RESOLUTION: f64 = 2.0;
/// Phases (rad) closer than this do not measure the sharpness: the difference is round-off.
const SHORTEST_SECANT: f64 = 1e-6;
/// Smallest sharpness that is assumed where it could not be measured.
const UNMEASURED: f64 = 0.1;
/// Range of the sharpness that a step may use. Friction makes flat peaks (0.03 has been seen).
const USABLE: std::ops::Range<f64> = 0.003..10.0;
/// A step is exact enough to be the last one if the error of the growth changes it by less than this share of the frequency
/// tolerance.
const CLOSE: f64 = 0.1;
/// Most iterations.
pub(crate) const MAX_ITERATIONS: usize = 20;
/// Iterations in a row that may fail to halve the residual (far from the branch) or the frequency step (close to it). If
/// samples change their contact state the growth jumps, and secants do not converge.
const PATIENCE: usize = 3;

/// How exactly a peak is searched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Largest residual of a solution.
    pub(crate) tolerance: f64,
    /// Dynamic displacement at the prediction over the scale of the residual, 1 at most.
    pub(crate) share: f64,
    /// Relative tolerance of the frequency.
    pub(crate) frequency: f64,
}

/// What the branch through one iterate tells, after the Newton correction at its frequency.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Growth {
    /// Frequency (rad/s).
    pub(crate) omega: f64,
    /// ŷ after the correction.
    pub(crate) response: c64,
    /// Derivative of its phase by the frequency (s).
    pub(crate) phase_rate: f64,
    /// Derivative of ln |ŷ| by the phase along the branch.
    pub(crate) growth: f64,
    /// Error of `growth`.
    pub(crate) error: f64,
}

/// The next step of a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PhaseStep {
    /// Length (rad).
    pub(crate) length: f64,
    /// Whether it leads to where the growth vanishes.
    pub(crate) by_growth: bool,
}

/// State of a search.
#[derive(Debug, Clone)]
pub(crate) struct PeakSearch {
    limits: Limits,
    /// Predicted phasor of the response.
    phasor: c64,
    /// The last iteration that stepped to where the growth vanishes.
    last: Option<Growth>,
    /// Sharpness −dg/dφ as predicted, and where it could be measured.
    predicted: Option<f64>,
    measured: Option<f64>,
    /// Whether a frequency step was within the tolerance: only the displacements are still to be solved.
    located: bool,
    /// Whether the residual is within the tolerance, too.
    closing: bool,
    /// Whether the last frequency step is done. The result must not depend on the iterations before it: so the step was by a
    /// growth that is exact enough, or it was one more step at a solved iterate.
    closed: bool,
    /// Smallest residual since the last frequency step.
    smallest_residual: Option<f64>,
    /// Smallest frequency step.
    smallest_step: Option<f64>,
    /// Iterations since one of the two was halved.
    worse: usize,
}

impl Limits {
    /// Residual below which an iterate is close to the branch.
    fn settled(&self) -> f64 {
        SETTLED * self.share
    }

    /// Error of the growth at an iterate with a residual of this `size`: it is as exact as the displacements.
    pub(crate) fn growth_error(&self, size: f64) -> f64 {
        GROWTH_ERROR * (size / self.share)
    }

    /// Tolerance of the frequency as a phase (rad).
    fn phase(&self, at: &Growth) -> f64 {
        self.frequency * at.omega * at.phase_rate.abs()
    }

    /// Whether the growth at an iterate with a residual of this `size` is exact enough to choose the frequency.
    fn trust(&self, at: &Growth, size: f64) -> bool {
        let trusted = 0.5 * at.growth.abs().max(self.phase(at));
        size <= self.settled() && at.error <= trusted
    }
}

impl Growth {
    /// `response`: ŷ after the correction; `by_omega`: its derivative along the tangent, by the frequency.
    pub(crate) fn new(omega: f64, response: c64, by_omega: c64, error: f64) -> Self {
        let rate = by_omega / response;
        Self {
            omega,
            response,
            phase_rate: rate.im,
            growth: rate.re / rate.im,
            error,
        }
    }

    /// Phase (rad) that `other` is behind.
    pub(crate) fn ahead_of(&self, other: &Self) -> f64 {
        (self.response / other.response).arg()
    }

    /// Whether the growth falls from this iterate to `further`, an iterate further along the branch, at a rate that belongs to a maximum.
    /// The signs of both growths do not count.
    pub(crate) fn falls_to(&self, further: &Self) -> bool {
        usable(&((self.growth - further.growth) / further.ahead_of(self)))
    }
}

/// Whether a step may use this sharpness: it belongs to a maximum, and not to a kink.
fn usable(sharpness: &f64) -> bool {
    USABLE.contains(sharpness)
}

impl PeakSearch {
    /// A search for a peak with the predicted `phasor` of the response, and with the predicted `sharpness`.
    pub(crate) fn new(limits: Limits, phasor: c64, sharpness: Option<f64>) -> Self {
        Self {
            limits,
            phasor,
            last: None,
            predicted: sharpness,
            measured: None,
            located: false,
            closing: false,
            closed: false,
            smallest_residual: None,
            smallest_step: None,
            worse: 0,
        }
    }

    /// Whether the search has ended at an iterate with a residual of this `size`; `steady` says whether every slider has
    /// its steady cycle there.
    ///
    /// # Errors
    /// [`Status::NonFinite`]; [`Status::NoSteadyCycle`] at a solution without.
    pub(crate) fn ends(&mut self, size: f64, steady: bool) -> Result<bool, Status> {
        if !size.is_finite() {
            return Err(Status::NonFinite);
        }
        let solved = size <= self.limits.tolerance;
        if solved && !steady {
            return Err(Status::NoSteadyCycle);
        }
        self.closing = solved && self.located;
        Ok(self.closing && self.closed)
    }

    /// Whether the last iterate asked about was within both tolerances. The peak there depends on the iterations before, so it is no
    /// result but a start.
    pub(crate) fn is_close(&self) -> bool {
        self.closing
    }

    /// The step from `here`, an iterate with a residual of this `size`, at which the search has not ended.
    ///
    /// # Errors
    /// [`Status::MaxIterations`] if the iterations do not converge.
    pub(crate) fn step(&mut self, size: f64, here: Growth) -> Result<PhaseStep, Status> {
        // an exacter growth may take back what a less exact one has located
        let is_known = self.located && self.is_located(&here);
        let by_growth = self.closing || (!is_known && self.limits.trust(&here, size));
        let length = if by_growth {
            self.growth_step(&here)
        } else if self.last.is_none() && size > self.limits.settled() {
            (self.phasor / here.response).arg()
        } else {
            0.0
        };
        if self.stalls(size, by_growth.then_some(length / here.phase_rate)) {
            return Err(Status::MaxIterations);
        }
        if by_growth {
            self.closed = self.closing || self.is_last_step(&here);
            self.last = Some(here);
        }
        Ok(PhaseStep {
            length: length.clamp(-LONGEST_STEP, LONGEST_STEP),
            by_growth,
        })
    }

    /// Sharpness of the peak that was found, for those who predict others from it.
    pub(crate) fn sharpness(&self) -> Option<f64> {
        self.measured.or(self.predicted).filter(usable)
    }

    /// Whether the iterations have measured that the growth falls where it vanishes: the peak is a maximum.
    pub(crate) fn has_measured_maximum(&self) -> bool {
        self.measured.as_ref().is_some_and(usable)
    }

    /// The smallest sharpness that is possible after the iterations so far.
    fn flattest(&self) -> f64 {
        let measured = self.measured.filter(usable);
        measured.map_or(UNMEASURED, |sharpness| sharpness.min(1.0))
    }

    /// Whether the growth vanishes within the tolerance of the frequency from `here`.
    fn is_located(&self, here: &Growth) -> bool {
        let farthest = here.growth.abs().max(here.error) / self.flattest();
        farthest <= self.limits.phase(here)
    }

    /// Whether the step from `here`, by the growth, is within the tolerance, and its error far below.
    fn is_last_step(&self, here: &Growth) -> bool {
        self.located && here.error <= CLOSE * self.limits.phase(here) * self.flattest()
    }

    /// Phase step to the point where the growth vanishes.
    fn growth_step(&mut self, here: &Growth) -> f64 {
        if let Some(last) = &self.last {
            let apart = here.ahead_of(last);
            let errors = here.error + last.error;
            if apart.abs() > SHORTEST_SECANT.max(RESOLUTION * errors) {
                self.measured = Some((last.growth - here.growth) / apart);
            }
        }
        self.located = self.is_located(here);
        let sharpness = self.measured.filter(usable);
        let sharpness = sharpness.or(self.predicted.filter(usable));
        here.growth / sharpness.unwrap_or(1.0)
    }

    /// Whether neither the residual nor the frequency steps by the growth have been halved for [`PATIENCE`] iterations. Each
    /// such step may raise the residual.
    fn stalls(&mut self, size: f64, growth_step: Option<f64>) -> bool {
        let (smallest, now) = match growth_step {
            Some(step) => {
                self.smallest_residual = None;
                (&mut self.smallest_step, step.abs())
            }
            None => (&mut self.smallest_residual, size),
        };
        let before = smallest.unwrap_or(f64::INFINITY);
        *smallest = Some(before.min(now));
        self.worse = match now <= 0.5 * before {
            true => 0,
            false => self.worse + 1,
        };
        self.worse >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        tolerance: 1e-11,
        share: 1.0,
        frequency: 1e-9,
    };

    /// The branch at the phase `phase` (rad) behind a maximum of this `sharpness`, known up to `size`.
    fn at(phase: f64, sharpness: f64, size: f64) -> Growth {
        Growth {
            omega: 1e3,
            response: c64::new(phase.cos(), phase.sin()),
            phase_rate: -1.0,
            growth: -sharpness * phase,
            error: LIMITS.growth_error(size),
        }
    }

    /// A maximum is found where its growth vanishes, and its sharpness is measured on the way, if residuals fall with the square
    /// or by a factor. Seen to fail with the opposite sign of the sharpness.
    #[test]
    fn a_parabola_is_climbed_to_its_maximum() {
        for (power, factor) in [(2.0, 1.0), (1.0, 1e-2)] {
            let mut search = PeakSearch::new(LIMITS, c64::new(1.0, 0.0), None);
            let (mut phase, mut size) = (0.2, 1e-3);
            let mut iterations = 0;
            while !search.ends(size, true).unwrap() {
                phase += search.step(size, at(phase, 0.4, size)).unwrap().length;
                size = factor * f64::powf(size, power);
                iterations += 1;
            }
            let tolerance = 1e-9 * 1e3;
            assert!(phase.abs() < tolerance, "{phase:e}");
            assert!((search.sharpness().unwrap() - 0.4).abs() < 0.02);
            assert!(
                search.has_measured_maximum() && iterations < 9,
                "{iterations}"
            );
        }
    }

    /// What a growth has located that errs by more than it states is taken back by the next one. Seen to fail without that: the
    /// search ends five times the tolerance beside the peak.
    #[test]
    fn a_location_is_checked_by_exacter_growths() {
        let mut search = PeakSearch::new(LIMITS, c64::new(1.0, 0.0), Some(1.0));
        let (mut phase, mut size) = (5e-6, 2e-10);
        let wrong = Growth {
            growth: -5e-8,
            ..at(phase, 1.0, size)
        };
        phase += search.step(size, wrong).unwrap().length;
        while !search.ends(size, true).unwrap() {
            size *= 0.2;
            phase += search.step(size, at(phase, 1.0, size)).unwrap().length;
        }
        assert!(phase.abs() < 1e-6, "{phase:e}");
    }

    /// Seen to fail without the look at the steadiness, and with a patience of 100 iterations.
    #[test]
    fn searches_that_lead_nowhere_end() {
        let new = || PeakSearch::new(LIMITS, c64::new(1.0, 0.0), None);
        assert_eq!(new().ends(1e-12, false), Err(Status::NoSteadyCycle));
        assert_eq!(new().ends(f64::NAN, true), Err(Status::NonFinite));
        let mut search = new();
        let mut steps = (0..MAX_ITERATIONS).map(|_| search.step(0.1, at(0.3, 1.0, 0.1)));
        assert!(steps.any(|step| matches!(step, Err(Status::MaxIterations))));
    }
}
