//! A problem at one level, for sweeps through the band: the start of a sweep, and budgets of the searches within it.

use super::gap::Stop;
use crate::hb::branch::sweep::SweepSettings;
use crate::hb::branch::sweep_start::Sweep;
use crate::hb::equations::balance::Balance;
use crate::hb::equations::effort::{Counted, Meter, WorkCount};
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::Ladder;
use crate::hb::newton::{Iterate, Point, polish};
use crate::hb::peak::alert::AlertSets;
use crate::hb::settings::HbSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;

/// A problem at one level.
pub(super) struct LevelProblem<'a, 'p> {
    ladder: &'a Ladder<'p>,
    pub(super) settings: &'a HbSettings,
    /// Harmonic sets of the error alert, unless it is switched off.
    pub(super) sets: Option<AlertSets<'a, 'p>>,
    level: f64,
    /// Work since the last reading.
    pub(super) meter: Meter<'p>,
}

impl<'a, 'p> LevelProblem<'a, 'p> {
    pub(super) fn new(
        problem: &'p Problem<'p>,
        ladder: &'a Ladder<'p>,
        settings: &'a HbSettings,
        level: f64,
    ) -> Self {
        Self {
            ladder,
            settings,
            sets: AlertSets::new(problem, &settings.harmonics, settings),
            level,
            meter: Meter::new(&problem.effort),
        }
    }

    /// The problem on the harmonics of the settings.
    pub(super) fn balance(&self) -> &'a Balance<'p> {
        self.ladder.full()
    }

    /// A search with a budget of its own. Its work depends neither on the searches before it nor on the frequencies asked for.
    pub(super) fn with_own_budget<T>(&self, search: impl FnOnce() -> T) -> T {
        let effort = &self.balance().problem.effort;
        effort.with_own_budget(self.settings.newton.budget, search)
    }

    /// A frequency without solution.
    pub(super) fn unsolved(&self, omega: f64, status: Status) -> Counted<Solution> {
        let stuck = Point::stuck(self.balance(), omega, self.level);
        let iterate = Iterate::new(self.balance(), stuck);
        Counted {
            solution: Solution::new(self.balance(), &iterate, status),
            work: WorkCount::default(),
        }
    }

    /// The solution where the sweep begins.
    pub(super) fn first(&self, settings: SweepSettings) -> Result<Iterate<'p>, Stop> {
        let [omega, _] = settings.direction.ends(settings.band);
        let newton = self.settings.newton;
        self.balance().problem.effort.grant(newton.budget);
        let sweep = Sweep {
            rungs: self.ladder.rungs(),
            newton,
            level: self.level,
            settings,
        };
        sweep
            .first()
            .map(|first| polish(self.balance(), first))
            .map_err(|status| Stop { omega, status })
    }
}
