//! Designs compared on the same samples of the random inputs: `comparison.json` and `comparison.html`.
//!
//! Knows stored runs alone: nothing is solved. Start reading in [`mod@comparison`].

pub mod comparison;
mod page;
mod performance;
mod write;

pub use comparison::{Compared, DesignComparison, Pair, PointRanking};
pub use write::write;
