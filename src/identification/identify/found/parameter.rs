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
    /// All, in the order of tables and pages.
    pub const ALL: [Self; 3] = [
        Self::FrictionCoefficient,
        Self::TangentialStiffnessNPerUm,
        Self::NormalStiffnessNPerUm,
    ];

    /// Its name in files and messages, with the unit.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FrictionCoefficient => "friction_coefficient",
            Self::TangentialStiffnessNPerUm => "tangential_stiffness_n_per_um",
            Self::NormalStiffnessNPerUm => "normal_stiffness_n_per_um",
        }
    }

    /// Its name in sentences, without the unit.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::FrictionCoefficient => "friction coefficient",
            Self::TangentialStiffnessNPerUm => "tangential stiffness",
            Self::NormalStiffnessNPerUm => "normal stiffness",
        }
    }

    /// Its unit; none of a bare number.
    #[must_use]
    pub fn unit(self) -> Option<&'static str> {
        match self {
            Self::FrictionCoefficient => None,
            Self::TangentialStiffnessNPerUm | Self::NormalStiffnessNPerUm => Some("N/µm"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ContactParameter;

    /// Place in the order of tables: a parameter without one does not compile.
    fn place(parameter: ContactParameter) -> usize {
        match parameter {
            ContactParameter::FrictionCoefficient => 0,
            ContactParameter::TangentialStiffnessNPerUm => 1,
            ContactParameter::NormalStiffnessNPerUm => 2,
        }
    }

    /// Seen to fail with another name of one, and with one twice in the list.
    #[test]
    fn all_parameters_have_their_names_of_files() {
        assert_eq!(ContactParameter::ALL.map(place), [0, 1, 2]);
        for parameter in ContactParameter::ALL {
            let in_files = serde_json::to_value(parameter).ok();
            assert_eq!(in_files, Some(parameter.name().into()));
        }
    }
}
