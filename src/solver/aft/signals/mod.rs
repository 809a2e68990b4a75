//! Trigonometric signals between their samples: where they turn, cross and touch.

pub(super) mod breakpoints;
pub(super) mod polynomial;
pub(super) mod roots;
