//! How a harmonic balance problem is solved.

use crate::aft::AftSettings;
use crate::harmonics::HarmonicSet;
use crate::setting::{BadSetting, unusual, within};

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

/// Tolerances that can be met and that leave a solution.
pub const TOLERANCE: [f64; 2] = [1e-14, 1e-3];
/// Iterations that can be asked for.
pub const MOST_ITERATIONS: usize = 10_000;
/// Iterations of all solves of one search or curve that can be asked for.
pub const MOST_BUDGET: usize = 1_000_000_000;
/// Truncation errors that can be told from rounding and that leave an amplitude.
pub const THRESHOLD: [f64; 2] = [1e-9, 1.0];

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

/// Highest harmonic that a solution may have: tables of the contact evaluation grow with its square.
pub const HIGHEST_HARMONIC: usize = 200;

/// Largest product of time points and harmonics: the largest table of a contact evaluation has 32 bytes for each (0.5 GB).
const LARGEST_TABLE: usize = 1 << 24;

/// When harmonics are added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlertSettings {
    /// Largest stated truncation error that certifies a solution, relative to the amplitude.
    pub threshold: f64,
    /// Harmonics are raised up to this order, not beyond.
    pub highest_harmonic: usize,
    /// Fewest harmonics on which a solution is compared before it is accepted.
    pub compared_with: usize,
}

impl Default for AlertSettings {
    fn default() -> Self {
        Self {
            threshold: 0.01,
            highest_harmonic: 56,
            compared_with: 20,
        }
    }
}

impl AlertSettings {
    /// Whether a stated error of the amplitude is not above the threshold.
    #[must_use]
    pub fn accepts(&self, error: f64) -> bool {
        error <= self.threshold
    }

    /// Highest harmonic of the largest set on which a solution up to `highest` is compared before it is accepted.
    #[must_use]
    pub fn most_compared(&self, highest: usize) -> usize {
        (2 * highest).max(self.compared_with)
    }
}

/// Which solutions are assessed for stability.
#[derive(
    Debug,
    Clone,
    Copy,
    Default,
    PartialEq,
    Eq,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum StabilityScope {
    /// None.
    Off,
    /// Those where a part that only contacts hold flies, or where contacts are open for more than 60 % of the period. The default of a disk.
    Bouncing,
    /// Those at which a contact is open for part of the period. The default of other models.
    #[default]
    LiftOff,
    /// Those at which a contact slips or is open. With all contacts stuck a damped structure is stable.
    All,
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
    /// Which solutions are assessed for stability.
    pub stability: StabilityScope,
}

impl HbSettings {
    /// What may be meant but is unusual; keys as in a study file.
    #[must_use]
    pub fn unusual(&self) -> Vec<BadSetting> {
        let tolerance = unusual("tolerance", self.newton.tolerance, [1e-12, 1e-6]);
        let threshold = self.alert.map(|alert| alert.threshold);
        let alert = threshold.and_then(|share| unusual("alert.threshold", share, [1e-4, 0.1]));
        tolerance.into_iter().chain(alert).collect()
    }

    /// Checks every rule between the settings; keys as in a study file.
    ///
    /// # Errors
    /// The first [`BadSetting`].
    pub fn validate(&self) -> Result<(), BadSetting> {
        highest_harmonic("harmonics", self.harmonics.highest())?;
        self.aft.validate(self.harmonics.highest())?;
        within("tolerance", self.newton.tolerance, TOLERANCE)?;
        for (key, count, most) in [
            (
                "max_iterations",
                self.newton.max_iterations,
                MOST_ITERATIONS,
            ),
            ("budget", self.newton.budget, MOST_BUDGET),
        ] {
            let rule = format!("must be from 1 to {most}");
            BadSetting::unless((1..=most).contains(&count), key, count, &rule)?;
        }
        if let Some(alert) = self.alert {
            within("alert.threshold", alert.threshold, THRESHOLD)?;
            highest_harmonic("alert.highest_harmonic", alert.highest_harmonic)?;
            highest_harmonic("alert.compared_with", alert.compared_with)?;
            BadSetting::unless(
                alert.highest_harmonic >= self.harmonics.highest(),
                "alert.highest_harmonic",
                alert.highest_harmonic,
                "must not be below the highest harmonic of the solution",
            )?;
        }
        let highest = self.harmonics.highest();
        let most = self
            .alert
            .map_or(highest, |alert| alert.most_compared(alert.highest_harmonic));
        BadSetting::unless(
            self.aft.n_time * most <= LARGEST_TABLE,
            "time_points",
            self.aft.n_time,
            &format!(
                "times the highest harmonic, twice that of the alert included, must be at most {LARGEST_TABLE}"
            ),
        )
    }
}

/// Requires a highest harmonic from 1 to [`HIGHEST_HARMONIC`].
///
/// # Errors
/// [`BadSetting`] otherwise.
pub fn highest_harmonic(key: &str, value: usize) -> Result<(), BadSetting> {
    let rule = format!("the highest harmonic must be from 1 to {HIGHEST_HARMONIC}");
    BadSetting::unless((1..=HIGHEST_HARMONIC).contains(&value), key, value, &rule)
}
