//! The model of a study as a function: values of the inputs to frequency, amplitude and status at every level, without samples.
//!
//! What serves other programs (`serve`, the package for Python) and calibration. The model once, then as many points as wanted:
//!
//! ```
//! use microslip::ensemble::stop::Stop;
//! use microslip::study::{Evaluator, Study};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! let never = Stop::default();
//! let model = Evaluator::solved(study.into_prepared()?, 3, &never, |_progress| {})?;
//! assert_eq!(model.input_names(), ["stiffness_scale", "friction_coefficient"]);
//! let points = [[1.0, 0.4], [1.2, 0.4]];
//! for levels in model.evaluate(&points, &never)? {
//!     let peak = levels[0].peak.ok_or(levels[0].status.name())?;
//!     println!("{:.2} Hz, {:.1} um", peak.frequency_hz, 1e6 * peak.amplitude_m);
//! }
//! let wrong = model.evaluate(&[[1.0, -0.4]], &never).expect_err("negative friction");
//! assert_eq!(wrong.to_string(), "row 0: friction_coefficient = -0.4: must be >= 0");
//! # Ok(())
//! # }
//! ```

use std::path::Path;

use super::prepared::PreparedStudy;
use super::runs::progress::{Meter, Progress};
use super::runs::resume::{Resumed, as_asked, identity_of_results, results_refusal};
use super::runs::run_settings::RunSettings;
use super::settings::read::Study;
use crate::Error;
use crate::ensemble::atlas::{Anchor, Atlas};
use crate::ensemble::outcome::{LevelOutcome, SampleOutcome};
use crate::ensemble::parts::{Difference, RunIdentity};
use crate::ensemble::program::Program;
use crate::ensemble::runner::{MOST_ANCHORS, Stopped};
use crate::ensemble::stop::Stop;
use crate::ensemble::store::StoredStudy;
use crate::setting::BadSetting;
use rayon::prelude::*;

/// The model of a study as a function of its inputs.
///
/// Its searches start from solved samples of the study, its anchors: with more of them a point costs less. Where a search starts
/// decides the last digits of a result, and seldom which of several maxima it finds; so results are the same bits for the same
/// anchors, whatever the number of threads, the other points and their order.
#[derive(Debug)]
pub struct Evaluator<'s> {
    prepared: PreparedStudy<'s>,
    anchors: usize,
    atlas: Atlas,
    sampled: Vec<SampleOutcome>,
}

/// Why points are not evaluated. A point without a resonance is no error: its levels say so by their status.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluationError {
    /// Values of a point that cannot be meant.
    #[error("row {row}: {bad}")]
    Inputs {
        /// The point, 0-based.
        row: usize,
        /// The input, its value and the rule.
        bad: BadSetting,
    },
    /// The evaluation was told to stop.
    #[error("stopped before the last row")]
    Stopped,
}

impl<'s> Evaluator<'s> {
    /// Solves the first `anchors` samples of the study to start from: at most as many as it has, and at most [`MOST_ANCHORS`]. None
    /// is allowed; each point then takes some ten times as long.
    ///
    /// # Errors
    /// [`EvaluationError::Stopped`] if `stop` said so.
    pub fn solved(
        prepared: PreparedStudy<'s>,
        anchors: u64,
        stop: &Stop,
        progress: impl Fn(Progress) + Sync,
    ) -> Result<Self, EvaluationError> {
        let samples = anchors.min(prepared.study.samples).min(MOST_ANCHORS);
        let mut ensemble = prepared.ensemble(None);
        ensemble.curve_samples = 0;
        let meter = Meter::start(0, samples, progress);
        let solved = ensemble.solved_until(samples, stop, |times| {
            meter.one_more(times.newton_iterations);
        });
        let solved = solved.map_err(|Stopped| EvaluationError::Stopped)?;
        Ok(Self {
            sampled: solved.outcomes,
            ..Self::starting_from(prepared, solved.anchors)
        })
    }

    /// Takes the first `anchors` samples from `folder`, the results of a run of the same study, whatever it asks of its samples: nothing is
    /// solved.
    ///
    /// # Errors
    /// [`Error::Results`] if they are results of another study or of other files; [`Error::File`] if they cannot be read or were
    /// changed.
    pub fn stored(prepared: PreparedStudy<'s>, folder: &Path, anchors: u64) -> Result<Self, Error> {
        refuse_other_study(&prepared.study, folder)?;
        let mut resumed = Resumed::default();
        resumed.add_results(folder, &prepared.study, &RunSettings::default(), None)?;
        let anchors = resumed.known.anchors_before(anchors);
        Ok(Self::starting_from(prepared, anchors))
    }

    fn starting_from(prepared: PreparedStudy<'s>, anchors: Vec<Anchor>) -> Self {
        Self {
            prepared,
            anchors: anchors.len(),
            atlas: anchors.into_iter().collect(),
            sampled: Vec::new(),
        }
    }

    /// The study.
    #[must_use]
    pub fn study(&self) -> &Study {
        &self.prepared.study
    }

    /// Names of the inputs, in the order of their values. Units are those of the study file: a name says a unit, a scale has none.
    #[must_use]
    pub fn input_names(&self) -> Vec<&'static str> {
        let inputs = self.study().design.inputs().iter();
        inputs.map(|(input, _)| input.name()).collect()
    }

    /// Excitation levels, ascending.
    #[must_use]
    pub fn levels(&self) -> &[f64] {
        &self.study().levels
    }

    /// Number of solved samples that the searches start from.
    #[must_use]
    pub fn anchors(&self) -> usize {
        self.anchors
    }

    /// Outcomes of the samples that were solved to start from, the first of the study in their order; none from a stored run.
    #[must_use]
    pub fn sampled(&self) -> &[SampleOutcome] {
        &self.sampled
    }

    /// Resonances at each of `points`, on all threads. Shape: points x inputs in, points x levels out. The levels are records as those
    /// of a sample, without curves: frequency in Hz and amplitude in m are in their `peak`, which is there if their `status` has a
    /// solution.
    ///
    /// # Errors
    /// [`EvaluationError::Inputs`] on the first point that breaks a rule of [`Study::check_values`], before anything is solved;
    /// [`EvaluationError::Stopped`] if `stop` said so.
    pub fn evaluate<P: AsRef<[f64]> + Sync>(
        &self,
        points: &[P],
        stop: &Stop,
    ) -> Result<Vec<Vec<LevelOutcome>>, EvaluationError> {
        for (row, point) in points.iter().enumerate() {
            let checked = self.study().check_values(point.as_ref());
            checked.map_err(|bad| EvaluationError::Inputs { row, bad })?;
        }
        let ensemble = self.prepared.ensemble(None);
        let levels = |point: &P| {
            let wanted = !stop.asked();
            wanted.then(|| ensemble.levels(point.as_ref(), &self.atlas))
        };
        // one point may take as long as a hundred others
        let all: Option<_> = points.par_iter().with_max_len(1).map(levels).collect();
        all.ok_or(EvaluationError::Stopped)
    }
}

/// Refuses results of another study or of other files. Another program is no reason: its samples are only starts. Nor is a study that asks
/// other things of the same samples.
fn refuse_other_study(study: &Study, folder: &Path) -> Result<(), Error> {
    let stored = identity_of_results(folder)?;
    let own = RunIdentity {
        study: StoredStudy {
            text: study.text.clone(),
            path: stored.study.path.clone(),
        },
        files: study.file_records()?,
        program: Program::this(),
    };
    match own.difference(&as_asked(&own, stored).0) {
        None | Some(Difference::Program(_)) => Ok(()),
        Some(difference) => Err(Error::results(folder, results_refusal(&difference))),
    }
}
