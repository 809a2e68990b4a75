//! Parameters of one test with their uncertainty, from its mean loop, and what a reader of the result must know.

mod known;
mod range_end;
mod series;
pub mod test_estimate;
mod test_notes;
mod unlike;
