//! The resonance peak: which maximum it is, how it is located, and how many harmonics it needs.

pub mod alert;
pub mod anchored;
pub mod attribution;
mod band;
pub mod blades;
pub mod branch_maximum;
mod branch_side;
mod corner;
pub(crate) mod growth;
pub mod level_peak;
pub mod maxima;
pub mod more_harmonics;
pub mod predicted;
pub mod refine;
pub mod search;
pub mod track;
