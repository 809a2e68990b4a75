//! Names of the parameters of a contact.

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
