//! The highest maximum in a band, if no track leads to it: next to the resonances of the structure that slides without
//! friction, or on the branch through the whole band.

use super::search::{Located, PeakSettings, find_peak, higher, maximum_on};
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::sweep::{SweepDirection, SweepSettings, follow};
use crate::hb::branch::sweep_start::first_solution;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::rest::Rest;
use crate::hb::newton::{Condition, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use crate::hb::structure::resonance::linear_resonances;
use std::ops::ControlFlow;

/// Largest relative change of the displacements per step of a sweep.
const SWEEP_STEP: f64 = 0.3;
/// Largest change of the frequency per step, as a share of the band.
const SWEEP_ADVANCE: f64 = 0.025;

/// The highest maximum at `level` next to the resonances of the structure that slides without friction about its `rest`:
/// friction far below the level hardly moves it. Maxima below `least` per unit level (m) do not count.
///
/// # Errors
/// [`Status::NoPeakInBand`] where there is none, [`Status::NonFinite`] where the resonances cannot be found.
pub(super) fn sliding_maximum<'p>(
    balance: &Balance<'p>,
    rest: &Rest,
    least: f64,
    level: f64,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let stiffness = rest.sliding_stiffness();
    let resonances = linear_resonances(balance.problem.model, &stiffness, peak.band, least);
    let resonances = resonances.map_err(|_| Status::NonFinite)?;
    let maxima = resonances.into_iter().filter_map(|resonance| {
        let start = rest.sliding(balance, resonance.omega, level);
        let start = solve(balance, start, Condition::FixedFrequency, newton).ok()?;
        find_peak(balance, start, peak, newton).ok()
    });
    maxima
        .reduce(|best, other| higher(balance, best, other))
        .filter(|best| best.iterate.response(balance).norm() > least * level)
        .ok_or(Status::NoPeakInBand)
}

/// The highest maximum at `level` on the branch through the whole band, upwards or else downwards, on the harmonics of the
/// last of `rungs`.
///
/// # Errors
/// [`Status::NoPeakInBand`] if the branch has none, else the status of the sweep that failed: a sweep that stopped inside the
/// band says nothing about the rest of the band.
pub(super) fn swept_maximum<'p>(
    rungs: &[Balance<'p>],
    level: f64,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let swept = |direction| highest_on_sweep(rungs, level, direction, peak, newton);
    let highest = swept(SweepDirection::Upward).or_else(|_| swept(SweepDirection::Downward))?;
    highest.ok_or(Status::NoPeakInBand)
}

/// The highest maximum that one sweep through the band passes.
fn highest_on_sweep<'p>(
    rungs: &[Balance<'p>],
    level: f64,
    direction: SweepDirection,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<Option<Located<'p>>, Status> {
    let balance = &rungs[rungs.len() - 1];
    let [omega, _] = direction.ends(peak.band);
    let first = first_solution(rungs, newton, level, omega, direction)?;
    let sweep = SweepSettings {
        band: peak.band,
        direction,
        largest_step: SWEEP_STEP,
        largest_advance: SWEEP_ADVANCE,
    };
    let mut maxima = Vec::new();
    let end = follow(balance, first, sweep, newton, |from, to| {
        let segment = BranchSegment::new(balance, &from, to);
        maxima.extend(maximum_on(&segment, balance, peak, newton));
        ControlFlow::Continue(())
    });
    match end.status {
        Status::Converged => {
            Ok((maxima.into_iter()).reduce(|best, other| higher(balance, best, other)))
        }
        status => Err(status),
    }
}
