//! A slow frequency sweep: the branch is followed through a band from the end where the sweep begins.
//!
//! Steps along the branch depend on the branch alone, so the frequencies that are asked for never change the solutions. The
//! solution at a frequency is the first point of the branch with that frequency. Past a fold the branch runs back against
//! the direction of the sweep. The next frequency has its solution where the branch has come forward again: a slow sweep
//! jumps to there.

use super::branch_point::BranchPoint;
use super::branch_segment::CLOSE;
use super::continuation::{ContinuationEnd, Predictor, StepSettings, continue_branch, on_if};
use crate::contact::Events;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::Iterate;
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Band;
use std::ops::ControlFlow;

/// Shortest step with located events: around a sharp bend, where a gap begins to close in every period.
const SMALLEST: f64 = 1e-9;
/// Shortest step where events are not located, and the branch is ragged.
const SMALLEST_RAGGED: f64 = 1e-6;
/// A branch may overhang the end of the band where the sweep began, by this share of the frequency there.
const OVERHANG: f64 = 0.5;

/// Direction of a sweep. It decides which solution is met where there are several.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum SweepDirection {
    /// From the lower end of the band upwards.
    #[default]
    Upward,
    /// From the upper end of the band downwards.
    Downward,
}

impl SweepDirection {
    /// Name in study files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Upward => "upward",
            Self::Downward => "downward",
        }
    }

    /// 1 upward, −1 downward.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Upward => 1.0,
            Self::Downward => -1.0,
        }
    }

    /// The other direction.
    #[must_use]
    pub(crate) fn opposite(self) -> Self {
        match self {
            Self::Upward => Self::Downward,
            Self::Downward => Self::Upward,
        }
    }

    /// The ends of `band` where a sweep begins and where it ends (rad/s).
    #[must_use]
    pub fn ends(self, band: Band) -> [f64; 2] {
        match self {
            Self::Upward => [band.low, band.high],
            Self::Downward => [band.high, band.low],
        }
    }
}

/// How a band is swept.
#[derive(Debug, Clone, Copy)]
pub struct SweepSettings {
    /// The band.
    pub band: Band,
    /// Direction of the sweep, and so the end of the band where it begins.
    pub direction: SweepDirection,
    /// Largest relative change of the displacements per step.
    pub largest_step: f64,
    /// Largest change of the frequency per step, over the band.
    pub largest_advance: f64,
}

/// Shortest step along a branch.
pub(in crate::hb) fn smallest_step(events: Events) -> f64 {
    match events {
        Events::Located => SMALLEST,
        // shorter steps would follow the raggedness that the time points make
        Events::Sampled | Events::Interpolated => SMALLEST_RAGGED,
    }
}

impl SweepSettings {
    fn steps(self, events: Events) -> StepSettings {
        let width = self.band.width();
        StepSettings {
            smallest: smallest_step(events),
            first: self.largest_step.min(0.05),
            largest: self.largest_step,
            omega_scale: width * self.largest_advance / self.largest_step,
            max_steps: usize::MAX,
            closeness: CLOSE,
            predictor: Predictor::Parabola,
        }
    }
}

/// Follows the branch from `start` through the band of `sweep`, until it leaves the band at the far end or `visit` breaks.
/// `visit` is given both ends of every step.
///
/// The status of the end is [`Status::Converged`] if the far end was reached or `visit` has ended the sweep, and
/// [`Status::LeftBand`] if the branch left the band far behind the end where the sweep began.
pub fn follow<'p>(
    balance: &Balance<'p>,
    start: Iterate<'p>,
    sweep: SweepSettings,
    newton: NewtonSettings,
    mut visit: impl FnMut(BranchPoint<'p>, &BranchPoint<'p>) -> ControlFlow<()>,
) -> ContinuationEnd<'p> {
    let steps = sweep.steps(balance.events());
    let sign = sweep.direction.sign();
    let [begin, far_end] = sweep.direction.ends(sweep.band);
    let first = BranchPoint::new(balance, start, steps.omega_scale).towards(sign);
    let mut left = false;
    let mut end = continue_branch(balance, first, newton, steps, |from, to, _| {
        let wanted = visit(from, to).is_continue();
        let omega = to.iterate.point.omega;
        left = wanted && sign * (omega - begin) < -OVERHANG * begin;
        on_if(wanted && !left && sign * (far_end - omega) > 0.0)
    });
    if left {
        end.status = Status::LeftBand;
    }
    end
}
