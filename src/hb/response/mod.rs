//! Forced response curves: through a band, at prescribed frequencies, around a peak.

pub mod curve;
pub mod forced_response;
mod stations;
pub mod values;
