//! Friction contact of one node pair: the law, its parameters and its states.
//!
//! Knows no finite elements, no harmonics and no files.

pub mod law;
mod real;

pub use real::Real;

/// Constants of one contact pair.
///
/// Units: stiffness N/m, force N, displacement m. Sign: normal approach v > 0 is compression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactParameters<T> {
    /// Normal stiffness k_n ≥ 0.
    pub k_n: T,
    /// Tangential stiffness [k_t1, k_t2] ≥ 0.
    pub k_t: [T; 2],
    /// Friction coefficient mu ≥ 0.
    pub mu: T,
    /// Normal force at v = 0 (constant preload); negative is a gap of −n_0/k_n.
    pub n_0: T,
    /// Tangential displacement at which the unslipped slider carries no traction.
    pub anchor: [T; 2],
}

/// How the two tangential directions share the Coulomb limit.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum FrictionLaw {
    /// Each direction has its own limit: |T₁| ≤ mu N and |T₂| ≤ mu N.
    Box,
    /// Coupled radial return: |(T₁, T₂)| ≤ mu N.
    Circle,
}

/// How events between two samples are resolved: the starts and ends of slip and separation.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Events {
    /// Every event is decided at the samples; a slider that closes is anchored at the last separated sample.
    Sampled,
    /// As `Sampled`, but a slider that closes is anchored at the instant of closing, by linear interpolation.
    Interpolated,
    /// Every event is located to rounding between the samples, and the force between the events is integrated in
    /// closed form (box law only).
    Located,
}

impl Events {
    /// What a study gets that does not say: the most accurate that the law has.
    #[must_use]
    pub fn of_law(law: FrictionLaw) -> Self {
        match law {
            FrictionLaw::Box => Self::Located,
            FrictionLaw::Circle => Self::Interpolated,
        }
    }
}
