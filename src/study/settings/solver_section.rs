//! Sections `[contact]` and `[solver]` of a study file and the settings that they state.

use crate::aft::settings::{MOST_LAPS, MOST_TIME_POINTS};
use crate::aft::{AftSettings, Laps};
use crate::contact::{Events, FrictionLaw};
use crate::harmonics::HarmonicSet;
use crate::hb::settings::{
    HIGHEST_HARMONIC, MOST_BUDGET, MOST_ITERATIONS, THRESHOLD, TOLERANCE, highest_harmonic,
};
use crate::hb::{AlertSettings, HbSettings, NewtonSettings, SliderAnchor, StabilityScope};
use crate::model::interface::{InterfaceSettings, STIFFNESS_N_PER_UM, StiffnessShare};
use crate::setting::{BadSetting, FRICTION};
use crate::units::n_per_um_to_n_per_m;

/// The contacts. Stiffness, friction and share belong to the built-in model; a user's own model has them per pair, in
/// `[[model.contact]]`.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactSection {
    /// Normal stiffness of an interface of the built-in model (N/µm).
    #[schemars(
        range(min = STIFFNESS_N_PER_UM[0], max = STIFFNESS_N_PER_UM[1]),
        extend("default" = in_n_per_um(InterfaceSettings::default().normal_stiffness))
    )]
    normal_stiffness_n_per_um: Option<f64>,
    /// Tangential stiffness of an interface of the built-in model, in each direction (N/µm).
    #[schemars(
        range(min = STIFFNESS_N_PER_UM[0], max = STIFFNESS_N_PER_UM[1]),
        extend("default" = in_n_per_um(InterfaceSettings::default().tangential_stiffness))
    )]
    tangential_stiffness_n_per_um: Option<f64>,
    /// Friction coefficient of the interfaces of the built-in model.
    #[schemars(
        range(min = FRICTION[0], max = FRICTION[1]),
        extend("default" = InterfaceSettings::default().friction_coefficient)
    )]
    friction_coefficient: Option<f64>,
    /// How the pairs of an interface of the built-in model share its stiffness.
    #[schemars(extend("default" = InterfaceSettings::default().share))]
    share: Option<StiffnessShare>,
    /// Friction law of every contact. With one tangential direction both are the same.
    #[schemars(extend("default" = DEFAULT_LAW))]
    law: Option<FrictionLaw>,
    /// How slip and separation that start or end between two samples of the period are resolved.
    #[schemars(extend("default" = Events::default()))]
    events: Option<Events>,
    /// Where the sliders start, just before wt = 0 of the first pass. It decides the mean tractions of contacts that never
    /// slip.
    #[schemars(extend("default" = DEFAULT_ANCHOR))]
    anchor: Option<SliderAnchor>,
}

/// Keys of `[contact]` that are constants of the interfaces of the built-in model.
pub(in crate::study) const OF_INTERFACE: [&str; 4] = [
    "normal_stiffness_n_per_um",
    "tangential_stiffness_n_per_um",
    "friction_coefficient",
    "share",
];

impl ContactSection {
    /// Constants of the interfaces of the built-in model.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[contact]`.
    pub fn interface(&self) -> Result<InterfaceSettings, BadSetting> {
        let default = InterfaceSettings::default();
        let settings = InterfaceSettings {
            normal_stiffness: self
                .normal_stiffness_n_per_um
                .map_or(default.normal_stiffness, n_per_um_to_n_per_m),
            tangential_stiffness: self
                .tangential_stiffness_n_per_um
                .map_or(default.tangential_stiffness, n_per_um_to_n_per_m),
            friction_coefficient: self
                .friction_coefficient
                .unwrap_or(default.friction_coefficient),
            share: self.share.unwrap_or(default.share),
        };
        settings.validate()?;
        Ok(settings)
    }

    /// Refuses what a model with constants per pair would ignore.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[contact]`.
    pub fn refuse_interface(&self) -> Result<(), BadSetting> {
        let share = self.share.map(|share| format!("{share:?}"));
        let given = [
            number(self.normal_stiffness_n_per_um),
            number(self.tangential_stiffness_n_per_um),
            number(self.friction_coefficient),
            share,
        ];
        for (key, value) in OF_INTERFACE.into_iter().zip(given) {
            let rule = "must be absent: a model of kind \"matrices\" has its constants in [[model.contact]]";
            BadSetting::unless(value.is_none(), key, value.unwrap_or_default(), rule)?;
        }
        Ok(())
    }
}

/// A stiffness (N/m) in the unit of the study file.
fn in_n_per_um(stiffness: f64) -> f64 {
    stiffness / n_per_um_to_n_per_m(1.0)
}

fn number(value: Option<f64>) -> Option<String> {
    value.map(|value| value.to_string())
}

/// How the equations are solved.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverSection {
    /// Harmonics of the first solution, before the alert adds any.
    #[schemars(extend("default" = DEFAULT_HARMONIC))]
    harmonics: Option<Harmonics>,
    /// Samples per period of the contact evaluation: more than 4 times the highest harmonic; times the highest harmonic, twice
    /// that of the alert included, at most 16777216.
    #[schemars(range(min = 5, max = MOST_TIME_POINTS), extend("default" = DEFAULT_TIME_POINTS))]
    time_points: Option<usize>,
    /// Passes over the period from the start of the sliders; the forces are those of the last. Two are exact for the box law
    /// and for one tangential direction; one is not, by up to a fifth of the amplitude.
    #[schemars(extend("default" = NamedLaps::Periodic))]
    laps: Option<LapsTable>,
    /// Largest residual over the static displacement of the contacts.
    #[schemars(
        range(min = TOLERANCE[0], max = TOLERANCE[1]),
        extend("default" = NewtonSettings::default().tolerance)
    )]
    tolerance: Option<f64>,
    /// Iterations of Newton's method in one solve.
    #[schemars(
        range(min = 1, max = MOST_ITERATIONS),
        extend("default" = NewtonSettings::default().max_iterations)
    )]
    max_iterations: Option<usize>,
    /// Newton iterations of one search for a peak, of one curve of a sample, of one sweep of `solve` through the band, or of one
    /// solution on it; more end it with the status `budget-spent`.
    #[schemars(
        range(min = 1, max = MOST_BUDGET),
        extend("default" = NewtonSettings::default().budget)
    )]
    budget: Option<usize>,
    /// Error alert: each solution is solved for again with twice its harmonics and with `compared_with` at least, and gets more where the
    /// stated truncation error is above the threshold. The points of a curve of `solve`, its peak among them, have the error stated but keep
    /// `harmonics`. `false` checks nothing and adds none; `true` takes the defaults.
    #[schemars(extend("default" = true))]
    alert: Option<Alert>,
    /// Which solutions are assessed for stability by their Floquet multipliers: those with lift-off, all that slip or lift off, those whose
    /// contacts are open for most of the period, or none. Those that are unstable have the status `unstable`. What is not assessed has
    /// the status `bouncing-contact` where a part that only contacts hold is open for most of the period. A model of kind `cyclic` is assessed by marching all its sectors, and
    /// has the default `"bouncing"`.
    #[schemars(extend("default" = StabilityScope::default()))]
    stability: Option<StabilityScope>,
    /// Whether a mirror-symmetric model is solved on one half of its contacts. `false` solves both halves, and so also finds
    /// solutions that break the symmetry.
    #[schemars(extend("default" = true))]
    mirror: Option<bool>,
}

/// Harmonics of the first solution.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected the highest harmonic (5) or a list of harmonics ([0, 1, 3, 5])"
)]
enum Harmonics {
    /// 0, 1, ... up to this one.
    UpTo(#[schemars(range(min = 1, max = HIGHEST_HARMONIC))] usize),
    /// These, ascending, 0 and 1 among them.
    List(
        #[schemars(
            length(min = 2),
            inner(range(max = HIGHEST_HARMONIC)),
            extend("uniqueItems" = true, "prefixItems" = [{ "const": 0 }, { "const": 1 }])
        )]
        Vec<usize>,
    ),
}

/// Passes over the period.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(untagged, expecting = "expected \"periodic\" or a number of passes")]
enum LapsTable {
    /// So many.
    Fixed(#[schemars(range(min = 1, max = MOST_LAPS))] usize),
    /// Until the sliders are periodic.
    Named(NamedLaps),
}

#[derive(Debug, Clone, PartialEq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum NamedLaps {
    Periodic,
}

/// Error alert.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected false, or a table with threshold, highest_harmonic and compared_with (numbers)"
)]
enum Alert {
    Switch(bool),
    On(AlertTable),
}

#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct AlertTable {
    /// Truncation error over the amplitude above which harmonics are added.
    #[schemars(
        range(min = THRESHOLD[0], max = THRESHOLD[1]),
        extend("default" = AlertSettings::default().threshold)
    )]
    threshold: Option<f64>,
    /// Highest harmonic to which they are added; not below that of the first solution.
    #[schemars(
        range(min = 1, max = HIGHEST_HARMONIC),
        extend("default" = AlertSettings::default().highest_harmonic)
    )]
    highest_harmonic: Option<usize>,
    /// Fewest harmonics on which a solution is compared before it is accepted: 40 miss fewer resonances of contacts on their springs than
    /// 20, and take more time.
    #[schemars(
        range(min = 1, max = HIGHEST_HARMONIC),
        extend("default" = AlertSettings::default().compared_with)
    )]
    compared_with: Option<usize>,
}

/// Harmonics of the first solution if the study does not say.
const DEFAULT_HARMONIC: usize = 5;
/// Points per period if the study does not say.
const DEFAULT_TIME_POINTS: usize = 128;
/// Friction law if the study does not say.
const DEFAULT_LAW: FrictionLaw = FrictionLaw::Box;
/// Start of the sliders if the study does not say.
const DEFAULT_ANCHOR: SliderAnchor = SliderAnchor::Unloaded;

impl SolverSection {
    /// Settings of the harmonic balance solver; `assessed` are the solutions that are assessed for stability where the file does not say.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to the file: `solver.…` or `contact.…`.
    pub fn settings(
        &self,
        contact: &ContactSection,
        assessed: StabilityScope,
    ) -> Result<HbSettings, BadSetting> {
        let harmonics = self.harmonics()?;
        let law = contact.law.unwrap_or(DEFAULT_LAW);
        let settings = HbSettings {
            aft: AftSettings {
                n_time: self.time_points.unwrap_or(DEFAULT_TIME_POINTS),
                law,
                events: contact.events.unwrap_or_default(),
                laps: match self.laps {
                    Some(LapsTable::Fixed(n)) => Laps::Fixed(n),
                    Some(LapsTable::Named(NamedLaps::Periodic)) | None => Laps::Periodic,
                },
            },
            anchor: contact.anchor.unwrap_or(DEFAULT_ANCHOR),
            newton: self.newton(),
            alert: self.alert(&harmonics),
            stability: self.stability.unwrap_or(assessed),
            harmonics,
        };
        settings.validate().map_err(|bad| {
            let section = match bad.key.as_str() {
                "events" => "contact",
                _ => "solver",
            };
            bad.under(section)
        })?;
        Ok(settings)
    }

    /// Whether a mirror-symmetric model is solved on one half of its contacts.
    #[must_use]
    pub fn mirror(&self) -> bool {
        self.mirror.unwrap_or(true)
    }

    fn harmonics(&self) -> Result<HarmonicSet, BadSetting> {
        let highest = match &self.harmonics {
            None => DEFAULT_HARMONIC,
            Some(Harmonics::UpTo(highest)) => *highest,
            Some(Harmonics::List(orders)) => orders.last().copied().unwrap_or(0),
        };
        // before the set takes memory
        highest_harmonic("solver.harmonics", highest)?;
        match &self.harmonics {
            Some(Harmonics::List(orders)) => {
                let rule = "must be ascending without repetition and contain 0 and 1";
                HarmonicSet::new(orders.clone())
                    .map_err(|_| BadSetting::new("solver.harmonics", format!("{orders:?}"), rule))
            }
            _ => Ok(HarmonicSet::up_to(highest)),
        }
    }

    fn newton(&self) -> NewtonSettings {
        let default = NewtonSettings::default();
        NewtonSettings {
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            max_iterations: self.max_iterations.unwrap_or(default.max_iterations),
            budget: self.budget.unwrap_or(default.budget),
        }
    }

    /// The default alert gives way to a solution that starts above its highest harmonic.
    fn alert(&self, harmonics: &HarmonicSet) -> Option<AlertSettings> {
        let default = AlertSettings::default();
        let highest = default.highest_harmonic.max(harmonics.highest());
        match &self.alert {
            Some(Alert::Switch(false)) => None,
            None | Some(Alert::Switch(true)) => Some(AlertSettings {
                highest_harmonic: highest,
                ..default
            }),
            Some(Alert::On(table)) => Some(AlertSettings {
                threshold: table.threshold.unwrap_or(default.threshold),
                highest_harmonic: table.highest_harmonic.unwrap_or(highest),
                compared_with: table.compared_with.unwrap_or(default.compared_with),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with: interpolated events as the default.
    #[test]
    fn events_are_located_unless_the_study_says_otherwise() {
        for (text, expected) in [
            ("", Events::Located),
            ("law = \"box\"", Events::Located),
            ("law = \"circle\"", Events::Located),
            ("events = \"sampled\"", Events::Sampled),
        ] {
            let contact: ContactSection = toml::from_str(text).unwrap();
            let settings = SolverSection::default()
                .settings(&contact, StabilityScope::default())
                .unwrap();
            assert_eq!(settings.aft.events, expected, "{text}");
        }
    }
}
