//! The box law: a slider per direction of slip.

pub(super) mod located;
pub(super) mod march;
pub(super) mod play;
pub(super) mod tangent;
