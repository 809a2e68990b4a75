//! Predicted peaks, brought close to the peaks themselves by a device.
//!
//! A lane is led by the rules that the search on the processor has (`hb::peak::growth`), down to what single precision can
//! tell, and ends as soon as it is close to its peak. Its point is then the prediction from which the processor searches in double
//! precision. A device may decide which of several solutions side by side is found; every other error of it costs time alone.

use super::system::{Lane, LaneSystem};
use crate::hb::Status;
use crate::hb::equations::balance::Balance;
use crate::hb::equations::free::FreeBalance;
use crate::hb::equations::inverse::InverseJacobian;
use crate::hb::newton::Point;
use crate::hb::peak::anchored::AnchorInverse;
use crate::hb::peak::growth::{Growth, Limits, PeakSearch};
use crate::hb::peak::predicted::{PeakPrediction, limits};
use crate::hb::peak::search::PeakSettings;
use crate::hb::settings::NewtonSettings;
use crate::hb::structure::resonance::Band;
use faer::c64;

/// Residual over the dynamic displacement at which a lane is close enough. Single precision leaves 1e-6 to 2e-4 where contacts are
/// stiff against a light mode; the processor's next Newton step leaves the square.
const CLOSE: f64 = 3e-4;
/// Relative distance of the frequency from the peak at which a lane is close enough: what such a residual can tell.
const CLOSE_FREQUENCY: f64 = 3e-6;

/// What a lane tells of an iteration, at the point where it began.
#[derive(Debug, Clone, Copy)]
pub struct Told {
    /// Largest entry of P R (m).
    pub size: f64,
    /// Lengths of the right-hand sides of correction and tangent, multiplied by P.
    pub right: [f64; 2],
    /// What is left of them.
    pub left: [f64; 2],
    /// Complex amplitude of the response (m).
    pub response: c64,
    /// Its derivative along the correction (m).
    pub by_correction: c64,
    /// Its derivative along the tangent (m per rad/s).
    pub by_tangent: c64,
    /// Whether the device left a contact state undecided.
    pub undecided: bool,
    /// Frequency (rad/s).
    pub omega: f64,
}

/// A predicted peak and the lane that searches it.
#[derive(Debug)]
pub struct LaneSearch<'a> {
    pub(super) lane: Lane,
    pub(super) inverse: &'a InverseJacobian,
    prediction: PeakPrediction,
    limits: Limits,
    search: PeakSearch,
    band: Band,
    /// Displacement (m) that residuals are divided by.
    scale: f64,
}

impl<'a> LaneSearch<'a> {
    /// The search of the peak of `balance` close to `prediction`, preconditioned by `anchor`; none where the equations have no free form
    /// or the inverse another size.
    #[must_use]
    pub fn new(
        system: &LaneSystem,
        balance: &Balance<'_>,
        anchor: AnchorInverse<'a>,
        prediction: PeakPrediction,
        settings: PeakSettings,
        newton: NewtonSettings,
    ) -> Option<Self> {
        let free = FreeBalance::new(balance, anchor.reference)?;
        let lane = system.lane(&free, &prediction.point);
        let same_size = anchor.inverse.size() == balance.layout.n_unknowns();
        let wanted = limits(balance, &prediction.point, settings, newton);
        let limits = Limits {
            tolerance: wanted.tolerance.max(CLOSE * wanted.share),
            frequency: wanted.frequency.max(CLOSE_FREQUENCY),
            ..wanted
        };
        (same_size && lane.is_finite()).then(|| Self {
            lane,
            inverse: anchor.inverse,
            limits,
            search: PeakSearch::new(limits, prediction.phasor, prediction.sharpness),
            band: settings.band,
            scale: balance.problem.displacement_scale(prediction.point.level),
            prediction,
        })
    }

    /// Begins anew, from the prediction.
    pub(super) fn begin(&mut self) {
        let PeakPrediction {
            phasor, sharpness, ..
        } = self.prediction;
        self.search = PeakSearch::new(self.limits, phasor, sharpness);
    }

    /// The next step of the frequency (rad/s), none if the search has ended.
    pub(super) fn next_step(&mut self, told: &Told) -> Result<Option<f64>, Status> {
        let size = told.size / self.scale;
        // undecided: more events than the device can hold, or no steady cycle found; both count as a slider without steady cycle
        if self.search.ends(size, !told.undecided)? || self.search.is_close() {
            return Ok(None);
        }
        let response = told.response + told.by_correction;
        let error = self.limits.growth_error(size);
        let here = Growth::new(told.omega, response, told.by_tangent, error);
        let step = self.search.step(size, here)?.length / here.phase_rate;
        match self.band.contains(told.omega + step) {
            true => Ok(Some(step)),
            false => Err(Status::NoPeakInBand),
        }
    }

    /// The prediction at the point that the lane has come to.
    pub(super) fn improved(&self, r: Vec<f64>, omega: f64) -> Option<PeakPrediction> {
        let finite = omega.is_finite() && r.iter().all(|x| x.is_finite());
        finite.then(|| PeakPrediction {
            point: Point {
                r,
                omega,
                level: self.prediction.point.level,
            },
            phasor: self.prediction.phasor,
            sharpness: self.search.sharpness(),
        })
    }
}
