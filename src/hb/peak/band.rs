//! The highest maximum in a band where no track leads to it: next to the resonances of the structure that slides without
//! friction, or on the branch through the whole band.

use super::search::{Located, PeakSettings, find_peak, higher, maximum_on};
use crate::hb::branch::run_in::first_solution;
use crate::hb::branch::stretch::Stretch;
use crate::hb::branch::sweep::{Route, SweepDirection, follow};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::rest::Rest;
use crate::hb::newton::{Condition, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use crate::hb::structure::resonance::linear_resonances;
use std::ops::ControlFlow;

/// Largest relative change of the displacements, and of the frequency over the band, per step of a sweep.
const SWEEP_STEP: f64 = 0.3;
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
/// [`Status::NoPeakInBand`] if the branch has none, else the status of the way that failed: one that stopped inside the band
/// says nothing about the part that it has not seen.
pub(super) fn swept_maximum<'p>(
    rungs: &[Balance<'p>],
    level: f64,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let way = |direction| highest_on_way(rungs, level, direction, peak, newton);
    let highest = way(SweepDirection::Upward).or_else(|_| way(SweepDirection::Downward))?;
    highest.ok_or(Status::NoPeakInBand)
}

fn highest_on_way<'p>(
    rungs: &[Balance<'p>],
    level: f64,
    direction: SweepDirection,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<Option<Located<'p>>, Status> {
    let balance = &rungs[rungs.len() - 1];
    let [omega, _] = direction.ends(peak.band);
    let first = first_solution(rungs, newton, level, (omega, direction))?;
    let route = Route {
        band: peak.band,
        direction,
        largest_step: SWEEP_STEP,
        largest_advance: SWEEP_ADVANCE,
    };
    let mut maxima = Vec::new();
    let end = follow(balance, first, route, newton, |from, to| {
        let stretch = Stretch::new(balance, &from, to);
        maxima.extend(maximum_on(&stretch, balance, peak, newton));
        ControlFlow::Continue(())
    });
    match end.status {
        Status::Converged => {
            Ok((maxima.into_iter()).reduce(|best, other| higher(balance, best, other)))
        }
        status => Err(status),
    }
}
