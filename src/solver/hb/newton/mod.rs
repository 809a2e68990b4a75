//! Newton's method for the balance equations: points, what is evaluated there, steps; the static equilibrium; few
//! harmonics first.

mod damping;
mod iterate;
pub mod ladder;
mod point;
pub mod rest;
mod solve;

pub use iterate::Iterate;
pub use point::{Direction, Metric, Point};
pub(crate) use solve::polish;
pub use solve::{Condition, newton_step, solve};
