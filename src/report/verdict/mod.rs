//! Whether the blade keeps what is asked: PASS, FAIL or UNDECIDED for each criterion, with the sentence that says so.
//!
//! Knows no page: the sentence is plain text. Start reading in [`mod@criterion_result`], then `judgement` (levels and outer
//! points) and `judged` (one population).

mod badness;
pub mod criterion_result;
mod ignorance;
mod judged;
pub(super) mod judgement;
mod numerical_error;
pub mod over_box;
pub(super) mod sentence;

pub use badness::{badness, side_of_order};
pub use criterion_result::{CriterionResult, LevelResult};
pub(super) use numerical_error::NumericalErrors;
