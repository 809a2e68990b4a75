//! The study file and the commands on it.
//!
//! Reads `study.toml` into the rooms' own settings ([`Study`]) and orchestrates them; holds no numerics.
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

pub mod built;
pub mod compare;
mod control_variate;
pub mod disk;
pub mod document;
mod engine_orders;
pub mod evaluator;
pub mod export;
pub mod extend;
pub mod frequency;
pub mod identified_inputs;
mod inputs;
pub mod inspect;
pub mod join;
pub mod key_reference;
pub mod merge;
pub mod model;
mod nominal_stiffness;
pub mod output;
pub mod output_schema;
mod pilot;
pub mod prepared;
mod processor_time;
pub mod profile;
pub mod progress;
pub mod read;
mod requirements;
mod resume;
pub mod reweight;
pub mod run;
mod run_record;
pub mod run_result;
pub mod run_settings;
mod samples;
pub mod schema;
mod session;
pub mod share;
mod size;
pub mod solve;
pub mod solver_section;
pub mod status;
mod worst_cases;

pub use built::{StudyDisk, StudyModel};
pub use compare::compare;
pub use disk::disk;
pub use evaluator::{EvaluationError, Evaluator};
pub use export::{Exported, export};
pub use extend::extend;
pub use frequency::{FrequencySettings, FrequencyUnit, Points};
pub use identified_inputs::IdentifiedInputs;
pub use inspect::{Inspection, NodalFrequencies, inspect};
pub use join::join;
pub use key_reference::key_reference;
pub use merge::merge;
pub use model::ModelSettings;
pub use output::{OutputFolder, OutputSettings, write_arrow_tables};
pub(crate) use output_schema::schema_of;
pub use output_schema::{OutputFile, output_schema};
pub use pilot::Pilot;
pub use prepared::PreparedStudy;
pub use profile::{Profile, Stage};
pub use progress::Progress;
pub use read::Study;
pub use reweight::reweight;
pub use run::run;
pub use run_result::RunResult;
pub use run_settings::RunSettings;
pub use schema::schema;
pub use share::{Share, ShareResult, solve_share};
pub use solve::{LevelCurve, solve, write_curves};
pub use status::{FolderStatus, RunStatus};
