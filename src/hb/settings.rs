//! How a harmonic balance problem is solved.

use crate::aft::AftSettings;
use crate::harmonics::HarmonicSet;
use crate::setting::{BadSetting, positive};

/// Where the sliders start: decides the mean tractions of contacts that never slip.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum SliderAnchor {
    /// Traction-free at zero relative displacement of the unloaded model.
    Unloaded,
    /// Traction-free at the static equilibrium under the static load without friction.
    StaticEquilibrium,
}

/// Stop rules of Newton's method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonSettings {
    /// Largest residual component over the problem's fixed displacement scale.
    pub tolerance: f64,
    /// Iterations before giving up.
    pub max_iterations: usize,
    /// Iterations of all solves of one search or curve before it ends with [`super::Status::BudgetSpent`].
    pub budget: usize,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            max_iterations: 40,
            budget: 20_000,
        }
    }
}

/// When harmonics are added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlertSettings {
    /// Largest truncation error accepted, relative to the amplitude.
    pub threshold: f64,
    /// Harmonics are raised up to this order, not beyond.
    pub highest_harmonic: usize,
}

impl Default for AlertSettings {
    fn default() -> Self {
        Self {
            threshold: 0.01,
            highest_harmonic: 21,
        }
    }
}

/// All settings of the harmonic balance solver.
#[derive(Debug, Clone, PartialEq)]
pub struct HbSettings {
    /// Harmonics of the first solution.
    pub harmonics: HarmonicSet,
    /// Contact evaluation.
    pub aft: AftSettings,
    /// Slider anchor policy.
    pub anchor: SliderAnchor,
    /// Newton's method.
    pub newton: NewtonSettings,
    /// Error alert; `None` switches it off.
    pub alert: Option<AlertSettings>,
}

impl HbSettings {
    /// Checks every rule between the settings.
    ///
    /// # Errors
    /// The first [`BadSetting`].
    pub fn validate(&self) -> Result<(), BadSetting> {
        self.aft.validate(self.harmonics.highest())?;
        positive("newton.tolerance", self.newton.tolerance)?;
        BadSetting::unless(
            self.newton.max_iterations > 0,
            "newton.max_iterations",
            self.newton.max_iterations,
            "must be at least 1",
        )?;
        BadSetting::unless(
            self.newton.budget > 0,
            "newton.budget",
            self.newton.budget,
            "must be at least 1",
        )?;
        if let Some(alert) = self.alert {
            positive("alert.threshold", alert.threshold)?;
            BadSetting::unless(
                alert.highest_harmonic >= self.harmonics.highest(),
                "alert.highest_harmonic",
                alert.highest_harmonic,
                "must not be below the highest harmonic of the solution",
            )?;
        }
        Ok(())
    }
}
