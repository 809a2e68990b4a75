//! A slow frequency sweep: the branch is followed through a band from the end where the sweep begins.
//!
//! Steps along the branch depend on the branch alone, so what is asked for never changes what is found. At a frequency the
//! sweep meets the first point of the branch that has it. Past a fold in the direction of the sweep the branch runs back;
//! the next frequency is met where it has come forward again, which is where a slow sweep jumps to.

use super::branch_point::BranchPoint;
use super::continuation::{Predictor, StepSettings, WalkEnd, on_if, walk};
use super::stretch::CLOSE;
use crate::contact::Events;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::Iterate;
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Band;
use std::ops::ControlFlow;

/// Shortest steps: around a sharp bend where a gap begins to close in every period, and where events are not located.
const SMALLEST: f64 = 1e-9;
const SMALLEST_RAGGED: f64 = 1e-6;
/// Share of the band's frequencies by which a branch that overhangs the end where the sweep began may leave the band.
const OVERHANG: f64 = 0.5;

/// Which way the frequencies go, and so which solution is met where there are several.
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

    /// The other one.
    #[must_use]
    pub fn opposite(self) -> Self {
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

/// The way of a sweep through a band.
#[derive(Debug, Clone, Copy)]
pub struct Route {
    /// The band.
    pub band: Band,
    /// Where it begins, and which way it goes.
    pub direction: SweepDirection,
    /// Largest relative change of the displacements per step.
    pub largest_step: f64,
    /// Largest change of the frequency per step, over the band.
    pub largest_advance: f64,
}

impl Route {
    fn steps(self, events: Events) -> StepSettings {
        let width = self.band.width();
        StepSettings {
            smallest: match events {
                Events::Located => SMALLEST,
                // shorter steps would follow what the time points make ragged
                Events::Sampled | Events::Interpolated => SMALLEST_RAGGED,
            },
            first: self.largest_step.min(0.05),
            largest: self.largest_step,
            omega_scale: width * self.largest_advance / self.largest_step,
            max_steps: usize::MAX,
            closeness: CLOSE,
            predictor: Predictor::Parabola,
        }
    }
}

/// Follows the branch from `start` along `route` until it leaves the band at its far end, or `visit` breaks; it is given
/// the ends of every step.
///
/// The status of the end is [`Status::Converged`] if the far end was reached or `visit` has ended the walk,
/// [`Status::LeftBand`] if the branch went far back behind the end where it began.
pub fn follow<'p>(
    balance: &Balance<'p>,
    start: Iterate<'p>,
    route: Route,
    newton: NewtonSettings,
    mut visit: impl FnMut(BranchPoint<'p>, &BranchPoint<'p>) -> ControlFlow<()>,
) -> WalkEnd<'p> {
    let steps = route.steps(balance.events());
    let sign = route.direction.sign();
    let [begin, far_end] = route.direction.ends(route.band);
    let first = BranchPoint::new(balance, start, steps.omega_scale, None, None).towards(sign);
    let mut left = false;
    let mut end = walk(balance, first, newton, steps, |from, to, _| {
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
