//! The run that a report is made from: its record `run.json`, its tables read back, and whether both are still its own.
//!
//! Computes no statistic. Start reading in [`mod@record`].

pub mod input;
pub mod record;
pub mod stored_run;

pub use input::ReportInput;
pub use record::{
    CONTROL_VARIATE, ComponentRecord, ContactGridRecord, DesignRecord, FURTHER_POINTS, FileRecord,
    FinerGridRecord, InputRecord, LinearRecord, RECORD, RunRecord, StaticLoadRecord, TABLES,
};
pub use stored_run::{
    CHANGED, StoredRun, engine_order, order_folder, order_of_folder, require_unchanged,
};
