//! Functions with known answers that stand for the harmonic balance, so that tests see a whole study end to end.
//!
//! Only there with the feature `test-functions`; no release build has it.

use super::outcome::{MaybeReal, PeakRecord};
use std::f64::consts::TAU;

/// A function of the random inputs, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TestFunction {
    /// Ishigami & Homma 1990 with a = 7 and b = 0.1, of three numbers uniform in (0, 1).
    Ishigami,
    /// Sobol's G-function with the coefficients 0, 1, 4.5, 9, 99, 99, 99, 99, of eight numbers uniform in (0, 1).
    GFunction,
    /// Water flow through a borehole (Harper & Gupta 1983) of its eight quantities: radius of the well and of influence,
    /// transmissivity and head above, those below, length, conductivity.
    Borehole,
    /// 100 + load − resistance, of resistance and load: above 100 the structure fails.
    LimitState,
    /// u + 6 exp(−((x − 0.37)/0.03)²) of an epistemic x in (0, 1) and u uniform there: worse by up to 6 in a twentieth of the
    /// interval.
    NarrowWorstCase,
    /// u of a number uniform in (0, 1); a defect of the program above 0.8.
    Panicking,
}

impl TestFunction {
    /// Number of inputs.
    #[must_use]
    pub fn inputs(self) -> usize {
        match self {
            Self::Panicking => 1,
            Self::Ishigami => 3,
            Self::GFunction | Self::Borehole => 8,
            Self::LimitState | Self::NarrowWorstCase => 2,
        }
    }

    /// Value at `x`. Shape: `[inputs]`.
    #[must_use]
    pub fn value(self, x: &[f64]) -> f64 {
        match (self, x) {
            (Self::Ishigami, [x1, x2, x3]) => {
                let [x1, x2, x3] = [x1, x2, x3].map(|u| TAU * (u - 0.5));
                x1.sin() + 7.0 * x2.sin().powi(2) + 0.1 * x3.powi(4) * x1.sin()
            }
            (Self::GFunction, x) => {
                let a = [0.0, 1.0, 4.5, 9.0, 99.0, 99.0, 99.0, 99.0];
                let factor = |(u, a): (&f64, f64)| ((4.0 * u - 2.0).abs() + a) / (1.0 + a);
                x.iter().zip(a).map(factor).product()
            }
            (Self::Borehole, [radius, influence, t_u, h_u, t_l, h_l, length, k_w]) => {
                let log = (influence / radius).ln();
                let resistance =
                    1.0 + 2.0 * length * t_u / (log * radius * radius * k_w) + t_u / t_l;
                TAU * t_u * (h_u - h_l) / (log * resistance)
            }
            (Self::LimitState, [resistance, load]) => 100.0 + load - resistance,
            (Self::NarrowWorstCase, [x, u]) => u + 6.0 * (-((x - 0.37) / 0.03).powi(2)).exp(),
            (Self::Panicking, [u]) => {
                assert!(*u <= 0.8, "a defect on purpose");
                *u
            }
            _ => f64::NAN,
        }
    }

    /// The value as a resonance frequency in Hz and as an amplitude in µm.
    pub(super) fn peak(self, x: &[f64]) -> PeakRecord {
        let value = self.value(x);
        PeakRecord {
            frequency_hz: value,
            amplitude_m: 1e-6 * value,
            route: None,
            truncation_error: MaybeReal::NONE,
            multiplier_real: MaybeReal::NONE,
            multiplier_imaginary: MaybeReal::NONE,
            highest_harmonic: 1,
            stick_fraction: 1.0,
            slip_fraction: 0.0,
            separated_fraction: 0.0,
            work_input_j: 0.0,
            work_viscous_j: 0.0,
            work_friction_j: 0.0,
            damping_ratio: MaybeReal::NONE,
            residual: 0.0,
        }
    }
}
