//! Frequencies of a study: the band of the resonance search, and where `solve` evaluates the response.

use crate::hb::branch::sweep::SweepDirection;
use crate::setting::{BadSetting, Plain, positive, within, without_round_off};
use crate::units::{hz_to_rad_s, rad_s_to_hz};

/// Unit in which a study states and reports frequencies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub enum FrequencyUnit {
    /// Cycles per second: models in SI units.
    #[serde(rename = "Hz")]
    Hertz,
    /// Angular frequency: non-dimensional models.
    #[serde(rename = "rad/s")]
    RadiansPerSecond,
}

impl FrequencyUnit {
    /// As written in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hertz => "Hz",
            Self::RadiansPerSecond => "rad/s",
        }
    }

    /// Ending of keys and columns in this unit.
    #[must_use]
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Hertz => "hz",
            Self::RadiansPerSecond => "rad_s",
        }
    }

    /// Angular frequency (rad/s) of a value in this unit.
    #[must_use]
    pub fn to_rad_s(self, value: f64) -> f64 {
        match self {
            Self::Hertz => hz_to_rad_s(value),
            Self::RadiansPerSecond => value,
        }
    }

    /// Value in this unit of an angular frequency (rad/s).
    #[must_use]
    pub fn of_rad_s(self, omega: f64) -> f64 {
        match self {
            Self::Hertz => rad_s_to_hz(omega),
            Self::RadiansPerSecond => omega,
        }
    }

    /// An angular frequency (rad/s) in this unit, as a message shows it.
    #[must_use]
    pub fn shown(self, omega: f64) -> String {
        let value = Plain(without_round_off(self.of_rad_s(omega)));
        format!("{value} {}", self.name())
    }
}

/// Where `solve` evaluates the response.
#[derive(Debug, Clone, PartialEq)]
pub enum Points {
    /// A continuous curve over the band.
    Continuation,
    /// At prescribed frequencies.
    Prescribed {
        /// Angular frequencies (rad/s), ascending.
        omega: Vec<f64>,
        /// Which way they are swept.
        sweep: SweepDirection,
    },
}

/// Which maximum of the band is the peak of a sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PeakSetting {
    /// The highest one of the modes that compete.
    #[default]
    Highest,
    /// The highest one; every mode in the band is searched.
    All,
    /// The one of a mode: its number among the stuck frequencies, 1 for the lowest, as `inspect` counts them.
    Mode(usize),
}

/// Frequencies of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencySettings {
    /// Unit of the study file and of its results.
    pub unit: FrequencyUnit,
    /// Band of the resonance search (rad/s), ascending.
    pub band: [f64; 2],
    /// Points of `solve`.
    pub points: Points,
    /// The peak of `run`.
    pub peak: PeakSetting,
}

/// `peak` of the table.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"highest\", \"all\" or the number of a mode, as `inspect` counts the stuck frequencies"
)]
enum PeakTable {
    Mode(#[schemars(range(min = 1))] usize),
    Named(NamedPeak),
}

#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum NamedPeak {
    Highest,
    All,
}

/// The band, one of `band_hz` and `band_rad_s`, and where `solve` evaluates the response: at `points`, at values in the unit
/// of the band, or, with neither, on a continuous curve over the band.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "oneOf" = [
        { "required": ["band_hz"], "properties": { "values_rad_s": false } },
        { "required": ["band_rad_s"], "properties": { "values_hz": false } }
    ],
    "dependentSchemas" = {
        "points": { "properties": { "values_hz": false, "values_rad_s": false } },
        "sweep": { "anyOf": [
            { "required": ["points"] },
            { "required": ["values_hz"] },
            { "required": ["values_rad_s"] }
        ] }
    }
))]
pub struct FrequencyTable {
    /// Band of the resonance search, [low, high] (Hz); the model is in SI units then.
    #[serde(default, deserialize_with = "crate::setting::exactly_if_given")]
    #[schemars(inner(range(min = FREQUENCY[0], max = FREQUENCY[1])))]
    band_hz: Option<[f64; 2]>,
    /// Band of the resonance search as angular frequencies (rad/s), for a model in any consistent set of units.
    #[serde(default, deserialize_with = "crate::setting::exactly_if_given")]
    #[schemars(inner(range(min = FREQUENCY[0], max = FREQUENCY[1])))]
    band_rad_s: Option<[f64; 2]>,
    /// Frequencies at which `solve` evaluates the response (Hz), ascending. Values outside the band extend it.
    #[schemars(length(min = 1), inner(range(min = FREQUENCY[0], max = FREQUENCY[1])))]
    values_hz: Option<Vec<f64>>,
    /// Frequencies at which `solve` evaluates the response (rad/s), ascending; with `band_rad_s`.
    #[schemars(length(min = 1), inner(range(min = FREQUENCY[0], max = FREQUENCY[1])))]
    values_rad_s: Option<Vec<f64>>,
    /// Number of evenly spaced frequencies over the band at which `solve` evaluates the response.
    #[schemars(range(min = 2, max = MOST_POINTS))]
    points: Option<usize>,
    /// Which way `points` and values are swept, and so which solution they give where there are several.
    #[schemars(extend("default" = SweepDirection::default()))]
    sweep: Option<SweepDirection>,
    /// Which maximum in the band is the result of a sample of `run`: the `highest`; also the highest, but with every mode in
    /// the band searched, and with statistics of each in table and report (`all`); or that of one mode by its number among the stuck
    /// frequencies, 1 for the lowest.
    #[schemars(extend("default" = "highest"))]
    peak: Option<PeakTable>,
}

/// Frequencies that can be meant, in either unit.
pub(super) const FREQUENCY: [f64; 2] = [1e-6, 1e9];
/// Most points that `points` may ask for.
pub(super) const MOST_POINTS: usize = 1_000_000;

impl FrequencyTable {
    /// The settings that the table states.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[frequency]`.
    pub fn settings(&self) -> Result<FrequencySettings, BadSetting> {
        let (unit, band) = self.band()?;
        let suffix = unit.suffix();
        let key = format!("band_{suffix}");
        let written = format!("[{}, {}]", band[0], band[1]);
        positive(&key, band[0])?;
        positive(&key, band[1])?;
        for end in band {
            within(&key, end, FREQUENCY)?;
        }
        let rule = "must be [low, high] with low < high";
        BadSetting::unless(band[0] < band[1], &key, written, rule)?;
        Ok(FrequencySettings {
            unit,
            band: band.map(|f| unit.to_rad_s(f)),
            points: self.points(unit, band)?,
            peak: self.peak()?,
        })
    }

    fn peak(&self) -> Result<PeakSetting, BadSetting> {
        match self.peak {
            None | Some(PeakTable::Named(NamedPeak::Highest)) => Ok(PeakSetting::Highest),
            Some(PeakTable::Named(NamedPeak::All)) => Ok(PeakSetting::All),
            Some(PeakTable::Mode(0)) => Err(BadSetting::new(
                "peak",
                0,
                "must be at least 1, the lowest mode",
            )),
            Some(PeakTable::Mode(number)) => Ok(PeakSetting::Mode(number)),
        }
    }

    fn band(&self) -> Result<(FrequencyUnit, [f64; 2]), BadSetting> {
        match (self.band_hz, self.band_rad_s) {
            (Some(band), None) => Ok((FrequencyUnit::Hertz, band)),
            (None, Some(band)) => Ok((FrequencyUnit::RadiansPerSecond, band)),
            (None, None) => {
                let rule = "must be given, or band_rad_s for a non-dimensional model";
                Err(BadSetting::new("band_hz", "(absent)", rule))
            }
            (Some(_), Some(_)) => {
                let rule = "must be absent if band_hz is given";
                Err(BadSetting::new("band_rad_s", "[...]", rule))
            }
        }
    }

    fn points(&self, unit: FrequencyUnit, band: [f64; 2]) -> Result<Points, BadSetting> {
        let (values, other, other_key) = match unit {
            FrequencyUnit::Hertz => (&self.values_hz, &self.values_rad_s, "values_rad_s"),
            FrequencyUnit::RadiansPerSecond => (&self.values_rad_s, &self.values_hz, "values_hz"),
        };
        let rule = format!("must be in the unit of the band: values_{}", unit.suffix());
        BadSetting::unless(other.is_none(), other_key, "[...]", &rule)?;
        let points = self.points;
        let count = points.unwrap_or(2);
        let rule = format!("must be from 2 to {MOST_POINTS}");
        BadSetting::unless((2..=MOST_POINTS).contains(&count), "points", count, &rule)?;
        let values = match (values, points) {
            (Some(_), Some(_)) => {
                return Err(BadSetting::new(
                    "points",
                    count,
                    "must be absent if values are given",
                ));
            }
            (None, None) => {
                let rule = "must be absent for a continuous curve, which has all solutions";
                return match self.sweep {
                    Some(sweep) => Err(BadSetting::new("sweep", sweep.name(), rule)),
                    None => Ok(Points::Continuation),
                };
            }
            (None, Some(n)) => {
                let step = (band[1] - band[0]) / (n - 1) as f64;
                (0..n).map(|i| band[0] + step * i as f64).collect()
            }
            (Some(values), None) => {
                let key = format!("values_{}", unit.suffix());
                ascending_positive(&key, values)?;
                for (i, value) in values.iter().enumerate() {
                    within(&format!("{key}[{i}]"), *value, FREQUENCY)?;
                }
                values.clone()
            }
        };
        Ok(Points::Prescribed {
            omega: values.iter().map(|f| unit.to_rad_s(*f)).collect(),
            sweep: self.sweep.unwrap_or_default(),
        })
    }
}

/// Requires a list of at least one finite positive number, each greater than the one before.
///
/// # Errors
/// [`BadSetting`] on `key` or `key[i]`.
pub(super) fn ascending_positive(key: &str, values: &[f64]) -> Result<(), BadSetting> {
    BadSetting::unless(!values.is_empty(), key, "[]", "must not be empty")?;
    for (i, value) in values.iter().enumerate() {
        positive(&format!("{key}[{i}]"), *value)?;
        let rule = "must be greater than the one before";
        let holds = i == 0 || values[i - 1] < *value;
        BadSetting::unless(holds, &format!("{key}[{i}]"), value, rule)?;
    }
    Ok(())
}
