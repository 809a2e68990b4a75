//! What the designer reads: `summary.json` and `report.json` for programs, `report.html` for people.
//!
//! The page shows the numbers of [`Summary`] and [`Assessment`] and adds figures. A sample without a solution is counted, shown
//! and bounded, never dropped in silence. The page is one file: no network, no script.
//! Knows how results look, not how they were computed. Start reading in [`mod@summary`].

mod allowable;
pub mod assessment;
mod axis;
pub mod bands;
mod block;
pub mod box_range;
pub mod compare;
mod confidence_band;
pub mod convention;
pub mod correlation;
pub mod criterion_result;
mod display;
pub mod distribution;
mod enough;
pub mod epistemic;
mod error;
pub mod error_budget;
mod figure;
mod ignorance;
mod input;
mod judged;
pub mod judgement;
mod level_mark;
pub mod margins;
mod numerical_error;
pub mod outer_points;
pub mod over_box;
mod page;
mod peak_error;
mod peaks;
pub mod population;
pub mod record;
pub mod replicate_means;
pub mod requirement;
pub mod reweighting;
mod section;
pub mod sensitivity;
pub mod sentence;
mod statistic_cell;
pub mod stopping;
pub mod stored_run;
pub mod summary;
pub mod surrogate;
pub mod surrogate_settings;
mod view;
pub mod worst_case;
mod write;

pub use assessment::Assessment;
pub use enough::at_look;
pub use error::ReportError;
pub use input::ReportInput;
pub use record::RunRecord;
pub use stored_run::StoredRun;
pub use summary::Summary;
pub use write::{render, write};
