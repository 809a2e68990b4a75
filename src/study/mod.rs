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
pub use runs::profile::{Profile, Stage};
pub use runs::progress::Progress;
pub use runs::run::{check_folder, run};
pub use runs::run_result::RunResult;
pub use runs::run_settings::RunSettings;
pub use runs::share::{Share, ShareResult, solve_share};
pub use runs::status::{FolderStatus, RunStatus, order_folders};
pub use settings::frequency::{FrequencySettings, FrequencyUnit, Points};
pub use settings::identified_inputs::IdentifiedInputs;
pub use settings::key_reference::key_reference;
pub use settings::model::ModelSettings;
pub use settings::read::Study;
pub use settings::schema::schema;
pub use solve::{LevelCurve, solve, write_curves};
