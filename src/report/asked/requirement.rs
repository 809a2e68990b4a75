//! What the designer asks of the blade: `[operation]`, `[stress]` and `[[criteria]]` of a study file.
//!
//! No number here is a standard's: every limit is the user's, who names the document that it comes from.

use crate::setting::{
    BadSetting, LARGEST, NOT_BLANK, Plain, non_negative, positive, unusual, within,
};
use crate::statistics::{Demonstration, confidence_at};
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

/// Share of the assumed prior that must keep a limit if the study does not say.
const DEFAULT_SHARE: f64 = 0.95;
/// Confidence of a judgement if the study does not say.
const DEFAULT_CONFIDENCE: f64 = 0.95;

/// Largest engine order that can be meant.
const LARGEST_ORDER: u32 = 100_000;
/// Engine orders, or speeds that are held, at most: each has a row and a line in the figures.
const MOST: usize = 1000;
/// Largest stress or strength that can be meant (MPa): a larger number is one in Pa.
const LARGEST_MPA: f64 = 1e6;
/// Strengths of metals (MPa): a smaller number may be one in GPa.
const USUAL_STRENGTH_MPA: [f64; 2] = [10.0, 1e4];
/// Speeds of turbines (1/min): a smaller number may be one in Hz.
const USUAL_SPEED_RPM: [f64; 2] = [100.0, 2e5];

/// Pattern of a line of printable characters, for JSON Schema.
pub(crate) const LINE: &str = r"^[^\u0000-\u001f\u007f-\u009f\ufffe\uffff]*$";

/// Requirements of a study; all may be absent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Requirements {
    /// Where the blade runs.
    pub operation: Option<Operation>,
    /// What it bears.
    pub stress: Option<Stress>,
    /// What is judged.
    pub criteria: Vec<Criterion>,
}

/// Speeds and orders of the excitation, for the frequency margin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Operation {
    /// Lowest and highest speed of continuous operation (1/min).
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(max = 1e7)), transform = crate::setting::positive_items)]
    pub speed_rpm: [f64; 2],
    /// Orders of the excitation: multiples of the speed.
    #[schemars(length(min = 1, max = MOST), inner(range(min = 1, max = LARGEST_ORDER)), extend("uniqueItems" = true))]
    #[serde(deserialize_with = "orders")]
    pub engine_orders: Vec<u32>,
    /// Speeds that are held for long (1/min), inside the range.
    #[serde(default)]
    #[schemars(length(max = MOST), inner(range(max = 1e7)), transform = crate::setting::positive_items)]
    pub dwell_rpm: Vec<f64>,
    /// What a frequency margin is a share of.
    #[serde(default)]
    pub margin_relative_to: MarginBase,
}

/// Denominator of a frequency margin; both are in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MarginBase {
    /// Frequency of the excitation.
    #[default]
    EngineOrder,
    /// Resonance frequency.
    Resonance,
}

/// From the amplitude of the first response coordinate to the life of the material, by Goodman's line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stress {
    /// Alternating stress at the critical place per amplitude of the first response coordinate (MPa/µm).
    #[schemars(range(max = LARGEST_MPA), extend("exclusiveMinimum" = 0))]
    pub modal_stress_mpa_per_um: f64,
    /// Mean stress at the critical place (MPa).
    #[schemars(range(min = 0, max = LARGEST_MPA))]
    pub mean_stress_mpa: f64,
    /// Alternating stress that the material bears for ever without mean stress, below its ultimate strength (MPa).
    #[schemars(range(max = LARGEST_MPA), extend("exclusiveMinimum" = 0))]
    pub endurance_limit_mpa: f64,
    /// Ultimate strength (MPa).
    #[schemars(range(max = LARGEST_MPA), extend("exclusiveMinimum" = 0))]
    pub ultimate_strength_mpa: f64,
}

/// What a criterion judges, with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RequiredQuantity {
    /// Smallest distance of the resonance to any engine order over `speed_rpm`, at least `limit` (%); needs `[operation]`.
    FrequencyMarginPercent,
    /// Amplitude of the first response coordinate, at most `limit` (µm).
    AmplitudeUm,
    /// Goodman's allowable over actual alternating stress, at least `limit`; needs `[stress]`.
    ReserveFactor,
    /// Probability that the reserve factor is below 1, at most `limit`, without a `share`; needs `[stress]`.
    ProbabilityOfExceedance,
}

/// One requirement each, judged PASS, FAIL or UNDECIDED. No limit is built in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "if" = { "properties": { "quantity": { "const": "probability-of-exceedance" } } },
    "then" = { "properties": { "limit": { "exclusiveMaximum": 1 }, "share": { "type": "null" } } }
))]
pub struct Criterion {
    /// Name in the report.
    #[schemars(regex(pattern = NOT_BLANK), extend("allOf" = [{ "pattern": LINE }]))]
    pub name: String,
    /// Document that the limit comes from: yours, since none is built in.
    #[schemars(regex(pattern = LINE))]
    pub standard: Option<String>,
    /// Clause of the document that the limit comes from.
    #[schemars(regex(pattern = LINE))]
    pub clause: Option<String>,
    /// What is judged, with its unit.
    pub quantity: RequiredQuantity,
    /// The limit.
    #[schemars(range(max = LARGEST), extend("exclusiveMinimum" = 0))]
    pub limit: f64,
    /// Excitation level at which it is judged; at every level of the study if absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub level: Option<f64>,
    /// Share of the assumed prior that must keep the limit. A probability has none.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "default" = DEFAULT_SHARE))]
    pub share: Option<f64>,
    /// Confidence of the judgement in view of the number of samples.
    #[schemars(extend("exclusiveMinimum" = 0.5, "exclusiveMaximum" = 1, "default" = DEFAULT_CONFIDENCE))]
    pub confidence: Option<f64>,
}

impl RequiredQuantity {
    /// Whether more is better.
    #[must_use]
    pub fn at_least(self) -> bool {
        matches!(self, Self::FrequencyMarginPercent | Self::ReserveFactor)
    }
}

impl Criterion {
    /// Numbers of those of the study's levels that it holds for.
    #[must_use]
    pub fn levels(&self, levels: &[f64]) -> Vec<usize> {
        let chosen = |&i: &usize| self.level.is_none_or(|level| level == levels[i]);
        (0..levels.len()).filter(chosen).collect()
    }

    /// Share of the population that must keep the limit.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.share.unwrap_or(DEFAULT_SHARE)
    }

    /// Confidence of the judgement.
    #[must_use]
    pub fn confidence(&self) -> f64 {
        self.confidence.unwrap_or(DEFAULT_CONFIDENCE)
    }

    /// What the samples of each of so many populations must demonstrate: all must PASS, one that FAILs is enough. A false FAIL
    /// of one of them is as improbable as stated for the criterion (Bonferroni), whatever they have in common; and each is so
    /// over all looks at a growing number of samples, of which this is number `look`, or 0 where the number was given.
    ///
    /// A probability of breaking a limit is a share that keeps it.
    #[must_use]
    pub fn demonstration(&self, populations: usize, look: usize) -> Demonstration {
        let confidence = confidence_at(look, self.confidence());
        let risk = (1.0 - confidence) / populations.max(1) as f64;
        Demonstration {
            content: match self.quantity {
                RequiredQuantity::ProbabilityOfExceedance => 1.0 - self.limit,
                _ => self.share(),
            },
            confidence,
            confidence_of_fail: 1.0 - risk,
        }
    }

    fn validate(&self) -> Result<(), BadSetting> {
        title("name", &self.name)?;
        for (key, text) in [("standard", &self.standard), ("clause", &self.clause)] {
            printable(key, text.as_deref().unwrap_or(""))?;
        }
        positive("limit", self.limit)?;
        within("limit", self.limit, [0.0, LARGEST])?;
        let share = self.share();
        let holds = share > 0.0 && share < 1.0;
        BadSetting::unless(holds, "share", share, "must lie between 0 and 1")?;
        let confidence = self.confidence();
        let holds = confidence > 0.5 && confidence < 1.0;
        let rule = "must lie between 0.5 and 1";
        BadSetting::unless(holds, "confidence", confidence, rule)?;
        if self.quantity == RequiredQuantity::ProbabilityOfExceedance {
            let rule = "must be below 1: it is a probability";
            BadSetting::unless(self.limit < 1.0, "limit", self.limit, rule)?;
            let value = self.share.unwrap_or_default();
            let rule = "must be absent: the limit is the share";
            BadSetting::unless(self.share.is_none(), "share", value, rule)?;
        }
        Ok(())
    }
}

/// Requires a line that is not blank.
///
/// # Errors
/// [`BadSetting`] otherwise.
pub(crate) fn title(key: &str, text: &str) -> Result<(), BadSetting> {
    BadSetting::unless(!text.trim().is_empty(), key, "\"\"", "must not be empty")?;
    printable(key, text)
}

/// Requires a line of characters that a terminal shows as such, and that XML, and with it a figure, can hold.
fn printable(key: &str, text: &str) -> Result<(), BadSetting> {
    let other = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
    let rule = "must be one line of printable characters";
    BadSetting::unless(!text.contains(other), key, format!("{text:?}"), rule)
}

/// Requires a list that a figure can show.
fn at_most(key: &str, values: usize) -> Result<(), BadSetting> {
    let value = format!("[{values} values]");
    let rule = format!("must be at most {MOST} values");
    BadSetting::unless(values <= MOST, key, value, &rule)
}

/// Reads engine orders; those that are no numbers of the type are refused with the rule.
fn orders<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u32>, D::Error> {
    let written = Vec::<i64>::deserialize(deserializer)?;
    let order = |order: i64| {
        let words = || D::Error::custom(format!("{order}: must be from 1 to {LARGEST_ORDER}"));
        u32::try_from(order).map_err(|_| words())
    };
    written.into_iter().map(order).collect()
}

impl Operation {
    fn validate(&self) -> Result<(), BadSetting> {
        let [low, high] = self.speed_rpm;
        positive("speed_rpm[0]", low)?;
        positive("speed_rpm[1]", high)?;
        within("speed_rpm[1]", high, [0.0, 1e7])?;
        let rule = "must be [low, high] with low <= high";
        let value = format!("[{}, {}]", Plain(low), Plain(high));
        BadSetting::unless(low <= high, "speed_rpm", value, rule)?;
        let some = !self.engine_orders.is_empty();
        BadSetting::unless(some, "engine_orders", "[]", "must not be empty")?;
        at_most("engine_orders", self.engine_orders.len())?;
        at_most("dwell_rpm", self.dwell_rpm.len())?;
        for (i, order) in self.engine_orders.iter().enumerate() {
            let key = format!("engine_orders[{i}]");
            let new = *order > 0 && !self.engine_orders[..i].contains(order);
            BadSetting::unless(new, &key, order, "must be a whole number >= 1, given once")?;
            let rule = format!("must be at most {LARGEST_ORDER}");
            BadSetting::unless(*order <= LARGEST_ORDER, &key, order, &rule)?;
        }
        for (i, speed) in self.dwell_rpm.iter().enumerate() {
            let key = format!("dwell_rpm[{i}]");
            let rule = "must lie in the range speed_rpm";
            BadSetting::unless((low..=high).contains(speed), &key, Plain(*speed), rule)?;
        }
        Ok(())
    }
}

impl Stress {
    fn validate(&self) -> Result<(), BadSetting> {
        for (key, value) in [
            ("modal_stress_mpa_per_um", self.modal_stress_mpa_per_um),
            ("endurance_limit_mpa", self.endurance_limit_mpa),
            ("ultimate_strength_mpa", self.ultimate_strength_mpa),
        ] {
            positive(key, value)?;
            within(key, value, [0.0, LARGEST_MPA])?;
        }
        non_negative("mean_stress_mpa", self.mean_stress_mpa)?;
        within("mean_stress_mpa", self.mean_stress_mpa, [0.0, LARGEST_MPA])?;
        BadSetting::unless(
            self.mean_stress_mpa < self.ultimate_strength_mpa,
            "mean_stress_mpa",
            Plain(self.mean_stress_mpa),
            "must be below ultimate_strength_mpa",
        )?;
        // an alternating stress as large as the ultimate strength breaks the material in its first cycle
        BadSetting::unless(
            self.endurance_limit_mpa < self.ultimate_strength_mpa,
            "endurance_limit_mpa",
            Plain(self.endurance_limit_mpa),
            "must be below ultimate_strength_mpa",
        )
    }
}

impl Requirements {
    /// Checks every table on its own and against the others and the study's levels.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to the study file.
    pub fn validate(&self, levels: &[f64]) -> Result<(), BadSetting> {
        if let Some(operation) = &self.operation {
            operation.validate().map_err(|b| b.under("operation"))?;
        }
        if let Some(stress) = &self.stress {
            stress.validate().map_err(|b| b.under("stress"))?;
        }
        for (i, criterion) in self.criteria.iter().enumerate() {
            let under = |bad: BadSetting| bad.under(&format!("criteria[{i}]"));
            criterion.validate().map_err(under)?;
            self.supports(criterion).map_err(under)?;
            let mut names = self.criteria[..i].iter().map(|other| other.name.trim());
            let new = !names.any(|name| name == criterion.name.trim());
            let rule = "must not be given twice";
            BadSetting::unless(new, "name", &criterion.name, rule).map_err(under)?;
            let known = criterion.level.is_none_or(|level| levels.contains(&level));
            let value = criterion.level.unwrap_or_default();
            BadSetting::unless(known, "level", value, "must be one of levels").map_err(under)?;
        }
        Ok(())
    }

    /// What may be meant but is unusual.
    #[must_use]
    pub fn unusual(&self) -> Vec<BadSetting> {
        let strengths = self.stress.iter().flat_map(|stress| {
            [
                ("stress.endurance_limit_mpa", stress.endurance_limit_mpa),
                ("stress.ultimate_strength_mpa", stress.ultimate_strength_mpa),
            ]
        });
        let strengths =
            strengths.filter_map(|(key, value)| unusual(key, value, USUAL_STRENGTH_MPA));
        let speeds = self
            .operation
            .iter()
            .flat_map(|operation| operation.speed_rpm);
        let speed =
            speeds.filter_map(|speed| unusual("operation.speed_rpm", speed, USUAL_SPEED_RPM));
        strengths.chain(speed.take(1)).collect()
    }

    fn supports(&self, criterion: &Criterion) -> Result<(), BadSetting> {
        let (given, table) = match criterion.quantity {
            RequiredQuantity::FrequencyMarginPercent => (self.operation.is_some(), "[operation]"),
            RequiredQuantity::ReserveFactor | RequiredQuantity::ProbabilityOfExceedance => {
                (self.stress.is_some(), "[stress]")
            }
            RequiredQuantity::AmplitudeUm => (true, ""),
        };
        let value = serde_json::to_string(&criterion.quantity).unwrap_or_default();
        let rule = format!("needs the table {table}");
        BadSetting::unless(given, "quantity", value, &rule)
    }
}
