//! The control variate of a study: its samples, and further ones, on few harmonics.
//!
//! They are solved without alert and without curves, in some thousandths of the time of the study's own. They are not kept in
//! parts: a run that goes on after a stop solves them again.

use super::progress::Progress;
use super::session::Session;
use crate::Error;
use crate::ensemble::Ensemble;
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::runner::Stopped;
use crate::harmonics::HarmonicSet;
use crate::hb::{HbSettings, StabilityScope};
use crate::report::asked::ControlVariateSettings;

/// The samples of the control variate on few harmonics.
///
/// # Errors
/// [`Error::Stopped`] if the run was stopped.
pub(super) fn control_samples<F: Fn(Progress) + Sync>(
    session: &Session<'_, F>,
    wanted: ControlVariateSettings,
) -> Result<Vec<SampleOutcome>, Error> {
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(wanted.highest_harmonic()),
        alert: None,
        stability: StabilityScope::Off,
        ..session.prepared.study.solver.clone()
    };
    let ensemble = Ensemble {
        settings: &settings,
        curve_samples: 0,
        // so few harmonics do not pay there
        gpu: None,
        ..*session.ensemble
    };
    let (samples, meter) = (wanted.samples(), &session.meter);
    meter.expect(samples);
    let solved = ensemble.solved_until(samples, &session.settings.stop, |times| {
        meter.one_more(times.newton_iterations);
    });
    solved
        .map(|solved| solved.outcomes)
        .map_err(|Stopped| session.stopped())
}
