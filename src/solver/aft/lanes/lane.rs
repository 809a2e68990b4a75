//! States of a batch that are evaluated together, as lanes of vectors.

/// States marched together.
pub(in crate::aft) const LANES: usize = 8;

/// One number per state.
pub(in crate::aft) type Lane<T> = [T; LANES];

/// One number per component and state, component by component.
pub(in crate::aft) type Components<T> = [T; 3 * LANES];
