//! The study file and the commands on it.
//!
//! Reads `study.toml` into the modules' own settings ([`Study`]) and orchestrates them; holds no numerics.
//! Start reading at [`Study::read`]; the commands are [`inspect()`], [`solve()`], [`run()`], [`extend()`],
//! [`compare()`] and [`reweight()`]. [`Evaluator`] is the model of a study as a function of its inputs.
//!
//! What `microslip inspect` shows of a study, and what a mistake in one looks like:
//!
//! ```
//! use microslip::study::{Study, inspect};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! let inspection = inspect(&study)?;
//! println!("{inspection:#?}");
//! let wrong = study.text.replace("samples = 100", "samples = -1");
//! let error = Study::parse(&study.path, &wrong).expect_err("a negative number");
//! assert!(error.to_string().contains("samples"));
//! # Ok(())
//! # }
//! ```
//!
//! The peaks of two lumped blades and their damper at a small and a large excitation level:
//!
//! ```
//! use microslip::contact::FrictionLaw;
//! use microslip::hb::peak::{search::PeakSettings, track::track_peaks};
//! use microslip::hb::structure::resonance::Band;
//! use microslip::hb::{LinearModel, Problem, Status};
//! use microslip::study::Study;
//! use microslip::units::{hz_to_rad_s, rad_s_to_hz};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! study.solver.alert = None; // keep to the harmonics of the study
//! let model = study.build_model()?;
//! let linear = LinearModel::new(&model.reduced)?;
//! let problem = Problem::new(&linear, model.contacts, 1.0, study.solver.anchor)?;
//! let band = Band { low: hz_to_rad_s(300.0), high: hz_to_rad_s(400.0) };
//! let search = PeakSettings { band, frequency_tolerance: 1e-9 };
//! for peak in track_peaks(&problem, &study.solver, search, &study.levels)? {
//!     assert_eq!(peak.status, Status::Converged);
//!     let solution = peak.solution.expect("converged");
//!     println!("{:.2} Hz, {:.2e} m", rad_s_to_hz(solution.omega), solution.amplitude(0));
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The first samples of a study, solved without writing a file:
//!
//! ```
//! use microslip::study::Study;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! study.solver.alert = None; // keep to the harmonics of the study
//! let prepared = study.prepared()?;
//! let mut ensemble = prepared.ensemble(None);
//! ensemble.curve_samples = 0;
//! let outcomes = ensemble.run(2, || {});
//! for outcome in &outcomes {
//!     let peak = outcome.levels[0].peak.expect("a peak");
//!     println!("{:?}: {:.2} Hz by {:?}", outcome.inputs, peak.frequency_hz, peak.route);
//! }
//! assert!(outcomes.iter().all(|outcome| outcome.levels[0].around.curve().is_empty()));
//! // the nominal model has its curve whatever the samples have
//! assert!(!ensemble.nominal().levels[0].around.curve().is_empty());
//! # Ok(())
//! # }
//! ```

pub mod built;
pub mod compare;
pub mod disk;
mod draws;
pub mod estimate;
pub mod evaluator;
pub mod export;
pub mod output;
pub mod output_schema;
pub mod prepared;
pub mod reweight;
pub mod runs;
pub mod settings;
pub mod solve;

pub use built::{StudyDisk, StudyModel};
pub use compare::compare;
pub use disk::disk;
pub use estimate::inspect::{Inspection, NodalFrequencies, inspect};
pub use estimate::pilot::Pilot;
pub use evaluator::{EvaluationError, Evaluator};
pub use export::{Exported, export};
pub use output::{OutputFolder, OutputSettings, write_arrow_tables};
pub(crate) use output_schema::schema_of;
pub use output_schema::{OutputFile, output_schema};
pub use prepared::PreparedStudy;
pub use reweight::{NewInputs, reweight};
pub use runs::extend::extend;
pub use runs::join::join;
pub use runs::merge::merge;
pub use runs::profile::{Profile, RunStage};
pub use runs::progress::Progress;
pub use runs::run::{check_band, check_folder, run};
pub use runs::run_result::RunResult;
pub use runs::run_settings::RunSettings;
pub use runs::share::{SampleShare, ShareResult, solve_share};
pub use runs::status::{FolderStatus, RunStatus, order_folders};
pub use settings::frequency::{FrequencySettings, FrequencyUnit, Points};
pub use settings::identified_inputs::IdentifiedInputs;
pub use settings::key_reference::key_reference;
pub use settings::model::ModelSettings;
pub use settings::read::Study;
pub use settings::schema::schema;
pub use solve::{LevelCurve, solve, write_curves};
