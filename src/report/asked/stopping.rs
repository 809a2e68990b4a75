//! When a study has enough samples: `samples = { until = ..., at_most = ... }`.

use super::requirement::Criterion;
use crate::page::display::stated_percent;
use crate::report::convention::CONFIDENCE;
use crate::setting::{BadSetting, positive, within};
use crate::statistics::{confidence_at, looks, wilks_sample_size};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a study goes on for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    /// Until every criterion is PASS or FAIL.
    Decided,
    /// Until the 95 % interval of a quantile is narrow enough at every level.
    Width,
}

/// A result of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ResultOfSample {
    /// Resonance frequency.
    Frequency,
    /// Amplitude at resonance.
    Amplitude,
}

/// Rule by which there are enough samples.
#[derive(Debug, Clone, PartialEq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    {
        "properties": {
            "until": { "const": "decided" }, "of": false, "quantile": false, "relative": false
        }
    },
    { "properties": { "until": { "const": "width" } }, "required": ["of", "relative"] }
]))]
pub struct StoppingTable {
    /// What the study goes on for.
    pub until: Until,
    /// Samples at most. The rule is judged at this number, its half, its quarter, ...; `inspect` names the numbers.
    #[schemars(range(min = 1, max = crate::sampling::design_settings::MOST_SAMPLES))]
    pub at_most: u64,
    /// Result whose quantile is meant; with `width` only, and then required.
    pub of: Option<ResultOfSample>,
    /// Probability of the quantile; with `width` only.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "default" = 0.5))]
    pub quantile: Option<f64>,
    /// Width of the quantile's 95 % interval over the quantile itself, at most; with `width` only, and then required.
    #[schemars(range(max = WIDEST), extend("exclusiveMinimum" = 0))]
    pub relative: Option<f64>,
}

/// Widest interval that a rule can ask for, over its quantile.
const WIDEST: f64 = 1.0;
/// Samples of the first look at least, whatever few could decide.
const FIRST_LOOK: u64 = 32;

/// The rule of a study.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "until")]
pub enum StoppingRule {
    /// Every criterion is PASS or FAIL.
    Decided,
    /// The 95 % interval of a quantile is at most so wide, at every level.
    Width {
        /// Result.
        of: ResultOfSample,
        /// Probability of the quantile.
        quantile: f64,
        /// Width over the quantile.
        relative: f64,
    },
}

/// How the number of samples of a run came out of its results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stopping {
    /// The rule.
    pub rule: StoppingRule,
    /// Samples at most.
    pub at_most: u64,
    /// Numbers of samples at which the rule was judged, ascending: the last one is that of the run.
    pub looks: Vec<u64>,
    /// Whether the rule was met at the last of them.
    pub met: bool,
}

impl StoppingTable {
    /// What is planned for a study with these criteria: all its looks.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `samples`.
    pub fn plan(&self, criteria: &[Criterion]) -> Result<Stopping, BadSetting> {
        let rule = self.rule(criteria)?;
        Ok(Stopping {
            rule,
            at_most: self.at_most,
            looks: rule.looks(criteria, self.at_most),
            met: false,
        })
    }

    fn rule(&self, criteria: &[Criterion]) -> Result<StoppingRule, BadSetting> {
        let of_width = [
            ("of", self.of.is_some()),
            ("quantile", self.quantile.is_some()),
            ("relative", self.relative.is_some()),
        ];
        if self.until == Until::Decided {
            for (key, given) in of_width {
                let rule = "must be absent with until = \"decided\"";
                BadSetting::unless(!given, key, "(given)", rule)?;
            }
            let some = !criteria.is_empty();
            let rule = "needs a criterion to decide: [[criteria]]";
            BadSetting::unless(some, "until", "\"decided\"", rule)?;
            return Ok(StoppingRule::Decided);
        }
        let absent =
            |key: &str| BadSetting::new(key, "(absent)", "must be given with until = \"width\"");
        let quantile = self.quantile.unwrap_or(0.5);
        let inside = quantile > 0.0 && quantile < 1.0;
        BadSetting::unless(inside, "quantile", quantile, "must lie between 0 and 1")?;
        let relative = self.relative.ok_or_else(|| absent("relative"))?;
        positive("relative", relative)?;
        within("relative", relative, [0.0, WIDEST])?;
        Ok(StoppingRule::Width {
            of: self.of.ok_or_else(|| absent("of"))?,
            quantile,
            relative,
        })
    }
}

impl StoppingRule {
    /// Numbers of samples at which the rule is judged: from the first one on that could meet it.
    fn looks(&self, criteria: &[Criterion], at_most: u64) -> Vec<u64> {
        let bounded = |content: f64, confidence: f64| {
            wilks_sample_size(content, confidence, 1).map_or(u64::MAX, |n| n as u64)
        };
        let least = match *self {
            Self::Decided => {
                let passes = |criterion: &Criterion| {
                    let content = criterion.demonstration(1, 1).content;
                    bounded(content, confidence_at(1, criterion.confidence()))
                };
                criteria.iter().map(passes).max().unwrap_or(0)
            }
            Self::Width { quantile, .. } => {
                // both limits are there once each takes its half of the risk
                let one_sided = 0.5 * (1.0 + confidence_at(1, CONFIDENCE));
                bounded(quantile.max(1.0 - quantile), one_sided)
            }
        };
        looks(least.max(FIRST_LOOK), at_most)
    }
}

impl Stopping {
    /// Samples to which an extension can go that must reach `least`: its looks are those of the run to so many, too.
    #[must_use]
    pub fn growth(&self, least: u64) -> Option<u64> {
        let doubled = |n: &u64| n.checked_mul(2);
        std::iter::successors(Some(self.at_most), doubled).find(|n| *n >= least)
    }

    /// What is gone on for, in words.
    #[must_use]
    pub fn goal(&self) -> String {
        match &self.rule {
            StoppingRule::Decided => "every criterion is decided".to_owned(),
            StoppingRule::Width {
                of,
                quantile,
                relative,
            } => {
                let of = match of {
                    ResultOfSample::Frequency => "frequency",
                    ResultOfSample::Amplitude => "amplitude",
                };
                let [quantile, relative] = [*quantile, *relative].map(stated_percent);
                format!(
                    "the interval of the {quantile} quantile of the {of} is at most {relative} of it wide"
                )
            }
        }
    }

    /// What the number of samples does to the confidence, in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let goal = self.goal();
        let numbers: Vec<String> = self.looks.iter().map(u64::to_string).collect();
        let end = match self.met {
            true => "It was met there",
            false => "It was not met",
        };
        let j = self.looks.len();
        format!(
            "The number of samples came out of the results: it grew until {goal}, to at most {}, judged at {}. {end}. What is \
             stated with 95 % confidence holds so over all looks together: it is computed at {:.2} %, with 1/{} of the risk.",
            self.at_most,
            numbers.join(", "),
            100.0 * confidence_at(j, CONFIDENCE),
            j * (j + 1),
        )
    }
}
