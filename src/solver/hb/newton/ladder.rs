//! One problem on harmonic sets that grow: hard starts are found with few harmonics, the others are added rung by rung.

use super::iterate::Iterate;
use super::point::Point;
use super::solve::{Condition, solve};
use crate::harmonics::HarmonicSet;
use crate::hb::equations::balance::Balance;
use crate::hb::equations::problem::Problem;
use crate::hb::settings::{HbSettings, NewtonSettings};
use crate::hb::status::Status;

/// Numbers of harmonics (0 included) of the rungs below the full set.
const RUNGS: [usize; 6] = [2, 3, 4, 8, 16, 32];

/// The problem on the first harmonics of the study's set, more on each rung, all on the last.
#[derive(Debug)]
pub struct Ladder<'p> {
    rungs: Vec<Balance<'p>>,
}

impl<'p> Ladder<'p> {
    /// The rungs of `problem` up to the harmonics of `settings`.
    #[must_use]
    pub fn new(problem: &'p Problem<'p>, settings: &HbSettings) -> Self {
        let orders = settings.harmonics.orders();
        let rungs = (RUNGS.iter())
            .filter(|&&n| n < orders.len())
            .filter_map(|&n| HarmonicSet::new(orders[..n].to_vec()).ok())
            .chain([settings.harmonics.clone()])
            .map(|harmonics| Balance::new(problem, harmonics, settings.aft))
            .collect();
        Self { rungs }
    }

    /// The problem on every rung, fewest harmonics first.
    #[must_use]
    pub(crate) fn rungs(&self) -> &[Balance<'p>] {
        &self.rungs
    }

    /// The problem on the fewest harmonics.
    #[must_use]
    pub fn first(&self) -> &Balance<'p> {
        &self.rungs[0]
    }

    /// The problem on the harmonics of the study.
    #[must_use]
    pub fn full(&self) -> &Balance<'p> {
        &self.rungs[self.rungs.len() - 1]
    }
}

/// Takes a solution on the first of `rungs` to the last, solving under `condition` on each.
///
/// # Errors
/// The status of the rung that failed.
pub(crate) fn climb<'p>(
    rungs: &[Balance<'p>],
    start: Point,
    condition: Condition<'_>,
    newton: NewtonSettings,
) -> Result<Iterate<'p>, Status> {
    let mut iterate = Iterate::new(&rungs[0], start);
    for pair in rungs.windows(2) {
        let padded = iterate.point.padded(&pair[0], &pair[1]);
        iterate = solve(&pair[1], padded, condition, newton)?;
    }
    Ok(iterate)
}
