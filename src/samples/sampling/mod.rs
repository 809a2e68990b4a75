//! Random inputs: which ones there are, how each is distributed, and sample i of a design.
//!
//! x(i, j) = F_j⁻¹(u(i, j)), where u is a function of the seed, the design, sample i and input j alone: sample i is the
//! same whatever else runs, in whatever order. In a Monte Carlo design it is also the same whatever other inputs and how
//! many samples there are. Sobol' points, pick-freeze rows of them too, depend on the list of inputs (the first dimensions
//! are the most even). A Latin hypercube and a grid depend on the number of samples too. Knows no blade and no contact. Start reading at [`design`].
//!
//! ```
//! # use microslip_samples as microslip;
//! use microslip::sampling::{Design, Distribution, Input, Shape};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let friction = Distribution::new(Shape::Uniform { low: 0.1, high: 0.8 }, None)?;
//! let design = Design::new(2026, vec![(Input::FrictionCoefficient, friction)])?;
//! // sample 1000 needs none of the samples before it
//! let values = design.sample(1000);
//! assert_eq!(values, design.sample(1000));
//! assert!((0.1..0.8).contains(&values[0]));
//! # Ok(())
//! # }
//! ```

pub mod correlation;
pub mod design;
pub mod design_settings;
pub mod distribution;
pub mod file;
pub mod input;
mod joe_kuo;
pub mod latin;
pub mod outer;
pub mod pick_freeze;
pub mod plan;
pub mod rectangles;
pub mod scaled;
pub mod sobol;
pub mod stream;
pub mod table;

pub use correlation::{CorrelationTable, KnownCorrelation};
pub use design::{Design, SampleGroup};
pub use design_settings::DesignSettings;
pub use distribution::{Distribution, Shape};
pub use file::SampleTable;
pub use input::Input;
pub use outer::{EpistemicInterval, EpistemicTable};
pub use plan::{DesignKind, DesignTable, Growth};
pub use table::{DistributionTable, Uncertainty};
