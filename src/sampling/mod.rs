//! Random inputs: which ones there are, how each is distributed, and sample i of a Monte Carlo design.
//!
//! x(i, j) = F_j⁻¹(u(i, j)), where u is a function of (seed, sample i, input j) alone: sample i is the same
//! whatever else runs, in whatever order. Knows no blade and no contact. Start reading at [`design`].

pub mod design;
pub mod distribution;
pub mod input;
pub mod stream;
pub mod table;

pub use design::Design;
pub use distribution::{Distribution, Shape};
pub use input::Input;
pub use table::DistributionTable;
