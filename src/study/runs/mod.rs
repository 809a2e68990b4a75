//! Runs: samples solved by one process or many, interrupted, resumed, put together, and written.
//!
//! Start reading at [`run::run`]; `session` is what all of them share.

mod contact_grid;
mod control_variate;
pub mod extend;
pub mod join;
pub mod merge;
pub mod profile;
pub mod progress;
mod replacement;
pub(super) mod resume;
pub mod run;
mod run_record;
pub mod run_result;
pub mod run_settings;
mod session;
pub mod share;
pub mod status;
mod worst_cases;
