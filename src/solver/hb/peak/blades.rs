//! The largest amplitude of a mistuned disk: over all blades and all frequencies of the band.
//!
//! A mistuned disk has as many resonances in a narrow band as it has blades, some of them close together, and each blade answers to
//! several. No track from the modes of the stuck disk tells which of them becomes the highest. So the branch is followed through the whole
//! band with one harmonic, and the first response of every blade is watched. The highest maxima that the points of the branch show are
//! then located with all harmonics of the study, each as the peak of its blade.

use super::level_peak::LevelPeak;
use super::predicted::raised;
use super::refine::refined_maximum;
use super::search::{PeakSettings, find_peak};
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::sweep::{SweepDirection, SweepSettings};
use crate::hb::branch::sweep_start::Sweep;
use crate::hb::equations::effort::Meter;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::Ladder;
use crate::hb::newton::{Iterate, Point};
use crate::hb::route::PeakRoute;
use crate::hb::settings::{HbSettings, NewtonSettings};
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use std::ops::ControlFlow;

/// Largest relative change of the displacements per step of the sweep: the amplitude of a single resonance between two points is
/// then at most some 2 % above both.
const SWEEP_STEP: f64 = 0.4;
/// Residual of the solutions of the sweep.
const SWEEP_TOLERANCE: f64 = 1e-6;
/// Largest change of the frequency per step, as a share of the band.
const SWEEP_ADVANCE: f64 = 0.05;
/// A maximum of the points is located if it is at least this share of the largest amplitude that the points show.
const COMPETES: f64 = 0.93;
/// Blades whose amplitudes at a point differ by less than this share are equal: one of them is enough.
const EQUAL: f64 = 1e-6;
/// Most maxima that are located.
const MOST_MAXIMA: usize = 6;

/// The largest amplitude and the blade that has it.
#[derive(Debug)]
pub struct LargestBlade {
    /// How the search ended. The amplitude is that of the response `blade`.
    pub peak: LevelPeak,
    /// Number of the blade, from 0; 0 where there is no solution.
    pub blade: usize,
}

/// A point of the branch, with the amplitudes of all blades.
struct SweepPoint {
    point: Point,
    amplitudes: Vec<f64>,
}

/// The largest first harmonic of all responses of `problem` at `level` in the band of `peak`, each being that of a blade.
#[must_use]
pub fn largest_of_blades(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    level: f64,
) -> LargestBlade {
    let meter = Meter::new(&problem.effort);
    let blades = problem.model.part(1).response.nrows();
    let failed = |status, count| LargestBlade {
        peak: LevelPeak::failed(level, status, count),
        blade: 0,
    };
    // a sweep passes as many resonances as there are blades
    (problem.effort).grant(settings.newton.budget.saturating_mul(blades.max(1)));
    let upward = swept(problem, settings, peak, level, SweepDirection::Upward);
    let seen = upward.or_else(|_| swept(problem, settings, peak, level, SweepDirection::Downward));
    let seen = match seen {
        Ok(seen) => seen,
        Err(_) if problem.effort.is_spent() => return failed(Status::BudgetSpent, meter.read()),
        Err(status) => return failed(status, meter.read()),
    };
    let mut best: Option<(f64, usize, Solution)> = None;
    let mut end = Status::NoPeakInBand;
    let mut lost = 0.0_f64;
    let mut count = meter.read();
    for (at, blade) in maxima(&seen) {
        let of_blade = problem.with_resonance_response(blade);
        of_blade.effort.grant(settings.newton.budget);
        let located = located(&of_blade, settings, peak, &seen[at].point);
        count += of_blade.effort.count();
        let alert_time = of_blade.effort.alert_time();
        problem.effort.add_alert_time(alert_time);
        match located {
            Ok(solution) => {
                let amplitude = solution.amplitude(blade);
                if best.as_ref().is_none_or(|(known, ..)| amplitude > *known) {
                    best = Some((amplitude, blade, solution));
                }
            }
            // of a flank at an end of the band the maximum lies outside
            Err(status) => {
                end = status;
                lost = lost.max(seen[at].amplitudes[blade]);
            }
        }
    }
    match best {
        // a maximum that was seen but not located may be the largest
        Some((known, blade, solution)) if known >= lost => LargestBlade {
            peak: LevelPeak::found(solution, count),
            blade,
        },
        _ => failed(end, count),
    }
}

/// The points of a sweep through the band with one harmonic.
fn swept(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    level: f64,
    direction: SweepDirection,
) -> Result<Vec<SweepPoint>, Status> {
    // its solutions are only starts for others
    let newton = NewtonSettings {
        tolerance: settings.newton.tolerance.max(SWEEP_TOLERANCE),
        ..settings.newton
    };
    let ladder = Ladder::new(problem, settings);
    let rungs = &ladder.rungs()[..1];
    let balance = &rungs[0];
    let sweep = Sweep {
        rungs,
        newton,
        level,
        settings: SweepSettings {
            band: peak.band,
            direction,
            largest_step: SWEEP_STEP,
            largest_advance: SWEEP_ADVANCE,
        },
    };
    let first = sweep.first_at_end()?;
    let mut seen = Vec::new();
    let see = |iterate: &Iterate<'_>| SweepPoint {
        point: iterate.point.clone(),
        amplitudes: (iterate.responses(balance).iter())
            .map(|y| y.norm())
            .collect(),
    };
    let [_, far_end] = direction.ends(peak.band);
    let end = sweep.followed(first, |from, to| {
        if seen.is_empty() {
            seen.push(see(&from.iterate));
        }
        // amplitudes beyond the band are not those of the disk in the band
        let beyond = direction.sign() * (to.iterate.point.omega - far_end) > 0.0;
        let clipped = match beyond {
            true => BranchSegment::new(&from, to).clipped(balance, far_end, newton),
            false => None,
        };
        seen.push(see(&clipped.as_ref().unwrap_or(to).iterate));
        ControlFlow::Continue(())
    });
    match end.status {
        Status::Converged => Ok(seen),
        status => Err(status),
    }
}

/// The highest maxima of each blade's amplitude over the points: number of the point and blade, highest first.
fn maxima(seen: &[SweepPoint]) -> Vec<(usize, usize)> {
    let largest = seen
        .iter()
        .flat_map(|at| &at.amplitudes)
        .fold(0.0, |a: f64, b| a.max(*b));
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for (i, at) in seen.iter().enumerate() {
        for (blade, &amplitude) in at.amplitudes.iter().enumerate() {
            let beside = |j: Option<usize>| {
                j.and_then(|j| seen.get(j))
                    .map_or(0.0, |other| other.amplitudes[blade])
            };
            let is_maximum =
                amplitude >= beside(i.checked_sub(1)) && amplitude > beside(i.checked_add(1));
            if is_maximum && amplitude >= COMPETES * largest {
                found.push((i, blade, amplitude));
            }
        }
    }
    found.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut distinct: Vec<(usize, usize, f64)> = Vec::new();
    for candidate in found {
        let equal = |known: &&(usize, usize, f64)| {
            known.0 == candidate.0 && (candidate.2 / known.2 - 1.0).abs() < EQUAL
        };
        if !distinct.iter().any(|known| equal(&known)) {
            distinct.push(candidate);
        }
    }
    distinct.truncate(MOST_MAXIMA);
    distinct
        .into_iter()
        .map(|(at, blade, _)| (at, blade))
        .collect()
}

/// The peak of the blade that leads `problem`, next to a point with one harmonic, on the harmonics of the study and as many more as the
/// alert asks for.
fn located(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    point: &Point,
) -> Result<Solution, Status> {
    let newton = settings.newton;
    let ladder = Ladder::new(problem, settings);
    let start = Iterate::new(ladder.first(), point.clone());
    let found = find_peak(ladder.first(), start, peak, newton)?;
    let found = raised(ladder.rungs(), found, peak, newton)?;
    Ok(Solution {
        route: Some(PeakRoute::SweptOnOne),
        ..refined_maximum(ladder.full(), found, settings, peak)
    })
}
