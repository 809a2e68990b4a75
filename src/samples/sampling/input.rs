//! The quantities of a study that may be random.

use super::distribution::{Distribution, Shape};
use crate::setting::{BadSetting, FRICTION, USUAL_FRICTION, unusual};
use schemars::{JsonSchema, SchemaGenerator};
use std::sync::LazyLock;

/// A quantity that may be random. The order is the order of the sampled values everywhere.
///
/// The JSON Schema takes the description of each input from here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum Input {
    /// Factor on the normal and the tangential contact stiffness together.
    StiffnessScale,
    /// Factor on the normal contact stiffness, on top of `stiffness_scale`.
    NormalStiffnessScale,
    /// Factor on the tangential contact stiffness, on top of `stiffness_scale`.
    TangentialStiffnessScale,
    /// Friction coefficient of every contact pair (absolute, not a factor).
    FrictionCoefficient,
    /// Factor on the static load: the centrifugal load on the strip, or `static_force`.
    StaticLoadScale,
    /// Factor on both stiffnesses of interface 0, the left one, on top of the others. Ends the mirror symmetry.
    LeftStiffnessScale,
    /// Factor on both stiffnesses of interface 1, the right one, on top of the others. Ends the mirror symmetry.
    RightStiffnessScale,
    /// Friction coefficient of interface 0 (absolute), in place of the common one. Ends the mirror symmetry.
    LeftFrictionCoefficient,
    /// Friction coefficient of interface 1 (absolute), in place of the common one. Ends the mirror symmetry.
    RightFrictionCoefficient,
    /// Factor on the damping matrix: on the damping ratio of every mode.
    DampingScale,
    /// Factor on every excitation level; the results stand at the nominal level.
    ExcitationScale,
    /// How far the load of each platform goes from the model's (0) to that of a rigid flat punch (1), which presses at the edges
    /// of the contact width; the load is kept. Built-in model only.
    EdgePressure,
    /// Thickness of the strip (mm; absolute), in place of `strip_mm[2]`. The centrifugal load is that of the nominal strip and
    /// grows with the mass, `static_load_scale` comes on top; every sample meshes and reduces the strip anew, and keeps as many modes of it
    /// as the nominal strip has below `strip_cut_off_hz`, wherever its own frequencies lie. Built-in model only.
    #[schemars(rename = "strip_thickness_mm")]
    StripThickness,
    /// Number by which the tractions that all contacts begin with are drawn, each evenly within its friction limit at rest. They stay
    /// in part where a contact never slips through. `uniform` from 0 to 1; in place of `contact.anchor`; ends the mirror symmetry.
    /// Not for a tuned disk.
    InitialTraction,
    /// Standard normal coefficient of a mode of the contact pressure's random field, below [`PRESSURE_MODES`].
    #[schemars(skip)]
    PressureMode(u8),
    /// Relative deviation of the frequency of one blade of a disk, below [`MOST_BLADES`], from the nominal one.
    #[schemars(skip)]
    BladeFrequency(u8),
}

/// Most blades of a disk whose frequencies may deviate one by one.
pub const MOST_BLADES: usize = 128;
/// Names of their deviations.
static BLADE_NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let name = |blade| format!("blade_{blade}_frequency_deviation");
    (0..MOST_BLADES).map(name).collect()
});
/// Largest relative deviation of a blade's frequency.
pub const LARGEST_DEVIATION: f64 = 0.9;

/// Coefficients of the pressure field at most.
pub const PRESSURE_MODES: usize = PRESSURE_NAMES.len();
const PRESSURE_NAMES: [&str; 16] = [
    "pressure_mode_1",
    "pressure_mode_2",
    "pressure_mode_3",
    "pressure_mode_4",
    "pressure_mode_5",
    "pressure_mode_6",
    "pressure_mode_7",
    "pressure_mode_8",
    "pressure_mode_9",
    "pressure_mode_10",
    "pressure_mode_11",
    "pressure_mode_12",
    "pressure_mode_13",
    "pressure_mode_14",
    "pressure_mode_15",
    "pressure_mode_16",
];

/// Probability of values beyond those that a study is expected to meet.
const SELDOM: f64 = 1e-6;

impl Input {
    /// Every input that `[inputs]` can name, in order; the modes of the pressure field come after them.
    pub const ALL: [Self; 14] = [
        Self::StiffnessScale,
        Self::NormalStiffnessScale,
        Self::TangentialStiffnessScale,
        Self::FrictionCoefficient,
        Self::StaticLoadScale,
        Self::LeftStiffnessScale,
        Self::RightStiffnessScale,
        Self::LeftFrictionCoefficient,
        Self::RightFrictionCoefficient,
        Self::DampingScale,
        Self::ExcitationScale,
        Self::EdgePressure,
        Self::StripThickness,
        Self::InitialTraction,
    ];

    /// Refuses a value that cannot be meant (negative, not finite, beyond any use; a factor of 0). A coefficient of the pressure may
    /// be negative.
    ///
    /// # Errors
    /// [`BadSetting`] on `key`.
    pub fn accepts_value(self, key: &str, value: f64) -> Result<(), BadSetting> {
        let most = self.largest();
        if self.may_be_negative() {
            let rule = format!("must be from -{most} to {most}: {}", self.meaning());
            return BadSetting::unless(value.abs() <= most, key, value, &rule);
        }
        let zero_allowed = self.zero_allowed();
        let above = value > 0.0 || (zero_allowed && value == 0.0);
        let rule = match zero_allowed {
            true => "must be >= 0",
            false => "must be > 0",
        };
        BadSetting::unless(above, key, value, rule)?;
        let rule = format!("must be at most {most}: {}", self.meaning());
        BadSetting::unless(value <= most, key, value, &rule)
    }

    /// Whether its values lie on both sides of 0.
    fn may_be_negative(self) -> bool {
        matches!(self, Self::PressureMode(_) | Self::BladeFrequency(_))
    }

    /// Whether 0 has a meaning.
    #[must_use]
    pub fn zero_allowed(self) -> bool {
        matches!(
            self,
            Self::FrictionCoefficient
                | Self::LeftFrictionCoefficient
                | Self::RightFrictionCoefficient
                | Self::StaticLoadScale
                | Self::EdgePressure
                | Self::InitialTraction
        )
    }

    /// Largest value that can be meant.
    #[must_use]
    pub fn largest(self) -> f64 {
        match self {
            Self::EdgePressure | Self::InitialTraction => 1.0,
            Self::FrictionCoefficient
            | Self::LeftFrictionCoefficient
            | Self::RightFrictionCoefficient => FRICTION[1],
            Self::StripThickness => 1e3,
            // no probability that a number can hold lies beyond
            Self::PressureMode(_) => 40.0,
            Self::BladeFrequency(_) => LARGEST_DEVIATION,
            _ => 1e6,
        }
    }

    /// What its numbers are.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::EdgePressure => "1 is the pressure of a rigid punch",
            Self::InitialTraction => "a number to draw by",
            Self::FrictionCoefficient
            | Self::LeftFrictionCoefficient
            | Self::RightFrictionCoefficient => "a friction coefficient, no percentage",
            Self::StripThickness => "a thickness in mm",
            Self::PressureMode(_) => "a standard normal number",
            Self::BladeFrequency(_) => "a share of the nominal frequency",
            _ => "a factor on the nominal value",
        }
    }

    /// Values that are usual; `None` where any that is accepted is.
    fn usual(self) -> Option<[f64; 2]> {
        match self {
            Self::FrictionCoefficient
            | Self::LeftFrictionCoefficient
            | Self::RightFrictionCoefficient => Some(USUAL_FRICTION),
            Self::StiffnessScale
            | Self::NormalStiffnessScale
            | Self::TangentialStiffnessScale
            | Self::LeftStiffnessScale
            | Self::RightStiffnessScale => Some([1e-3, 1e3]),
            Self::StaticLoadScale | Self::DampingScale | Self::ExcitationScale => Some([1e-2, 1e2]),
            Self::EdgePressure
            | Self::StripThickness
            | Self::InitialTraction
            | Self::PressureMode(_)
            | Self::BladeFrequency(_) => None,
        }
    }

    /// What may be meant but is unusual among the values that one sample in a hundred lies below, or above.
    #[must_use]
    pub fn unusual(self, ends: [f64; 2]) -> Option<BadSetting> {
        let usual = self.usual()?;
        ends.iter()
            .find_map(|end| unusual(self.name(), *end, usual))
    }

    /// Name in study files, tables and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::StiffnessScale => "stiffness_scale",
            Self::NormalStiffnessScale => "normal_stiffness_scale",
            Self::TangentialStiffnessScale => "tangential_stiffness_scale",
            Self::FrictionCoefficient => "friction_coefficient",
            Self::StaticLoadScale => "static_load_scale",
            Self::LeftStiffnessScale => "left_stiffness_scale",
            Self::RightStiffnessScale => "right_stiffness_scale",
            Self::LeftFrictionCoefficient => "left_friction_coefficient",
            Self::RightFrictionCoefficient => "right_friction_coefficient",
            Self::DampingScale => "damping_scale",
            Self::ExcitationScale => "excitation_scale",
            Self::EdgePressure => "edge_pressure",
            Self::StripThickness => "strip_thickness_mm",
            Self::InitialTraction => "initial_traction",
            Self::PressureMode(k) => PRESSURE_NAMES[usize::from(k)],
            Self::BladeFrequency(blade) => &BLADE_NAMES[usize::from(blade)],
        }
    }

    /// The input of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|input| input.name() == name)
    }

    /// The input with that column in the tables of samples: one that `[inputs]` can name, a mode of the pressure field, or the deviation of
    /// a blade.
    #[must_use]
    pub fn of_column(name: &str) -> Option<Self> {
        let mode = || PRESSURE_NAMES.iter().position(|mode| *mode == name);
        let of_field = || Some(Self::PressureMode(u8::try_from(mode()?).ok()?));
        let blade = || BLADE_NAMES.iter().position(|blade| blade == name);
        let of_blade = || Some(Self::BladeFrequency(u8::try_from(blade()?).ok()?));
        Self::from_name(name).or_else(of_field).or_else(of_blade)
    }

    /// Unit of its values; 1 for a number without.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::StripThickness => "mm",
            _ => "1",
        }
    }

    /// What it is, from its definition.
    #[must_use]
    pub fn description(self) -> String {
        if let Self::PressureMode(k) = self {
            let mode = k + 1;
            return format!(
                "Standard normal coefficient of mode {mode} of the contact pressure's random field."
            );
        }
        if let Self::BladeFrequency(blade) = self {
            return format!(
                "Relative deviation of the frequency of blade {blade}, alone and held at the disk, from the nominal one."
            );
        }
        let schema = Self::json_schema(&mut SchemaGenerator::default()).to_value();
        let options = schema["oneOf"].as_array().into_iter().flatten();
        let mut named = options.filter(|option| option["const"] == self.name());
        let text = named
            .next()
            .and_then(|option| option["description"].as_str());
        text.unwrap_or_default().replace('\n', " ")
    }

    /// Dimension of the uniform stream. Fixed for ever, so that a further input leaves the others' samples alone.
    #[must_use]
    pub fn dimension(self) -> u32 {
        match self {
            Self::StiffnessScale => 0,
            Self::NormalStiffnessScale => 1,
            Self::TangentialStiffnessScale => 2,
            Self::FrictionCoefficient => 3,
            Self::StaticLoadScale => 4,
            Self::LeftStiffnessScale => 5,
            Self::RightStiffnessScale => 6,
            Self::LeftFrictionCoefficient => 7,
            Self::RightFrictionCoefficient => 8,
            Self::DampingScale => 9,
            Self::ExcitationScale => 10,
            Self::EdgePressure => 11,
            Self::StripThickness => 12,
            Self::InitialTraction => 13,
            Self::PressureMode(k) => 64 + u32::from(k),
            Self::BladeFrequency(blade) => 128 + u32::from(blade),
        }
    }

    /// Interface that the input acts on alone: 0 = left, 1 = right; `None` for an input of the whole model.
    #[must_use]
    pub fn interface(self) -> Option<usize> {
        match self {
            Self::LeftStiffnessScale | Self::LeftFrictionCoefficient => Some(0),
            Self::RightStiffnessScale | Self::RightFrictionCoefficient => Some(1),
            _ => None,
        }
    }

    /// Whether the input makes the two sides of a mirror-symmetric model differ.
    #[must_use]
    pub fn one_sided(self) -> bool {
        self.interface().is_some() || matches!(self, Self::PressureMode(_) | Self::InitialTraction)
    }

    /// Whether its values only number the draws of a field: they have no order, and close ones have nothing in common.
    #[must_use]
    pub fn numbers_draws(self) -> bool {
        self == Self::InitialTraction
    }

    /// Whether the input is a factor on a static load that the model has for it.
    #[must_use]
    pub fn is_load(self) -> bool {
        matches!(self, Self::EdgePressure | Self::PressureMode(_))
    }

    /// Refuses a distribution that can give this input a value without physical meaning (negative or too large; a factor of 0).
    ///
    /// # Errors
    /// [`BadSetting`] on `truncation` or `value`, relative to the input.
    pub fn accepts(self, distribution: &Distribution) -> Result<(), BadSetting> {
        if self.may_be_negative() {
            return Ok(());
        }
        if self.numbers_draws() {
            let rule = "must be uniform from 0 to 1, without truncation: its values only number the draws of a field";
            let all = Distribution::new(
                Shape::Uniform {
                    low: 0.0,
                    high: 1.0,
                },
                None,
            )?;
            return BadSetting::unless(*distribution == all, "distribution", distribution, rule);
        }
        let [low, high] = distribution.support();
        if let Some(value) = distribution.fixed_value() {
            return self.accepts_value("value", value);
        }
        BadSetting::unless(
            low >= 0.0,
            "distribution",
            format!("{} on ({low}, ...)", distribution.shape().name()),
            "must not give negative values: raise low or add truncation = [low, high]",
        )?;
        let most = self.largest();
        // a tail that no sample comes near needs no truncation
        let reach = match high.is_finite() || self == Self::EdgePressure {
            true => high,
            false => distribution.quantile(1.0 - SELDOM),
        };
        BadSetting::unless(
            reach <= most,
            "distribution",
            format!("{} on (..., {high})", distribution.shape().name()),
            &format!(
                "must not give values above {most} ({}): lower high or add truncation = [low, high]",
                self.meaning()
            ),
        )
    }
}
