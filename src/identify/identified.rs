//! `identified.json`: the joint distribution of the contact parameters, which a study reads by `[inputs] from`.

use crate::sampling::Shape;

/// Version of the format of `identified.json`.
pub const FORMAT: u32 = 1;

/// What was found, for a study.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Identified {
    /// Version of the format.
    pub format: u32,
    /// Parameters with their distributions.
    pub inputs: Vec<IdentifiedInput>,
    /// Correlation of the normal scores of the parameters. Shape: square, in the order of `inputs`.
    pub correlation: Vec<Vec<f64>>,
}

/// A contact parameter, in the units of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactParameter {
    /// Friction coefficient.
    FrictionCoefficient,
    /// Tangential stiffness of the interface (N/µm), as `[contact]` has it.
    TangentialStiffnessNPerUm,
    /// Normal stiffness of the interface (N/µm), as `[contact]` has it; absent where normal motion was not measured.
    NormalStiffnessNPerUm,
}

impl ContactParameter {
    /// Its name in files and messages, with the unit.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FrictionCoefficient => "friction_coefficient",
            Self::TangentialStiffnessNPerUm => "tangential_stiffness_n_per_um",
            Self::NormalStiffnessNPerUm => "normal_stiffness_n_per_um",
        }
    }
}

/// A parameter of the contact and its distribution.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct IdentifiedInput {
    /// Which one.
    pub parameter: ContactParameter,
    /// Distribution of its value at a further contact of the same kind: scatter, and what the tests leave unknown.
    pub shape: Shape,
}
