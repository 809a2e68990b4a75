//! Forced response curves: through a band, at prescribed frequencies, around a peak.

mod cubic_segment;
pub mod curve;
mod curve_side;
pub mod forced_response;
mod gap;
mod level_problem;
mod polyline;
pub mod values;
