//! SI units only inside; the named conversions at the edges. Also a number with what it counts.
//!
//! ```
//! # use microslip_base as microslip;
//! use microslip::units::{mm_to_m, n_per_um_to_n_per_m, rad_s_to_hz};
//!
//! let stiffness = n_per_um_to_n_per_m(30.0); // N/m
//! let force = stiffness * mm_to_m(2e-3); // N
//! assert!((force - 60.0).abs() < 1e-12);
//! assert!((rad_s_to_hz(std::f64::consts::TAU) - 1.0).abs() < 1e-15);
//! ```

use std::fmt::Display;

/// Standard acceleration of gravity (m/s²), 3rd General Conference on Weights and Measures, 1901.
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// rad/s → Hz.
#[must_use]
pub fn rad_s_to_hz(omega: f64) -> f64 {
    omega / std::f64::consts::TAU
}

/// Hz → rad/s.
#[must_use]
pub fn hz_to_rad_s(frequency: f64) -> f64 {
    frequency * std::f64::consts::TAU
}

/// mm → m.
#[must_use]
pub fn mm_to_m(length: f64) -> f64 {
    length * 1e-3
}

/// N/µm → N/m.
#[must_use]
pub fn n_per_um_to_n_per_m(stiffness: f64) -> f64 {
    stiffness * 1e6
}

/// N/m → N/µm.
#[must_use]
pub fn n_per_m_to_n_per_um(stiffness: f64) -> f64 {
    stiffness / 1e6
}

/// m → µm.
#[must_use]
pub fn m_to_um(length: f64) -> f64 {
    length * 1e6
}

/// µm → m.
#[must_use]
pub fn um_to_m(length: f64) -> f64 {
    length / 1e6
}

/// A number with what it counts: `1 sample`, `2 samples`.
#[must_use]
pub fn count(n: impl Display + PartialEq + From<u8>, noun: &str) -> String {
    let plural = if n == 1.into() { "" } else { "s" };
    format!("{n} {noun}{plural}")
}
