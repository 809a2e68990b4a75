//! The table that states what is known of an input in a study file.

use super::distribution::{Distribution, Shape};
use super::outer::{EpistemicInterval, Scale};
use crate::setting::BadSetting;

/// Family of a distribution, as written in a study file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// `value`.
    Fixed,
    /// `low`, `high`.
    Uniform,
    /// `low`, `high`.
    LogUniform,
    /// `mean`, `standard_deviation`.
    Normal,
    /// `median`, `log_standard_deviation`.
    Lognormal,
    /// `low`, `mode`, `high`.
    Triangular,
    /// `alpha`, `beta`, `low`, `high`.
    Beta,
}

/// What is known of an input.
#[derive(Debug, Clone, PartialEq)]
pub enum Uncertainty {
    /// It varies, with a distribution.
    Aleatory(Distribution),
    /// It has one value within an interval, nothing says where.
    Epistemic(EpistemicInterval),
}

/// Kind of ignorance, as written in a study file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UncertaintyKind {
    /// `distribution` and its parameters.
    #[default]
    Aleatory,
    /// `lower`, `upper`, `scale`.
    Epistemic,
}

/// All parameters that any family has; each family takes its own and refuses the others.
///
/// One flat table and not one variant per family: so a reader of the file can name the line of every mistake.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistributionTable {
    #[serde(default)]
    kind: UncertaintyKind,
    lower: Option<f64>,
    upper: Option<f64>,
    scale: Option<Scale>,
    distribution: Option<Family>,
    value: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
    mean: Option<f64>,
    standard_deviation: Option<f64>,
    median: Option<f64>,
    log_standard_deviation: Option<f64>,
    mode: Option<f64>,
    alpha: Option<f64>,
    beta: Option<f64>,
    truncation: Option<[f64; 2]>,
}

impl DistributionTable {
    /// The distribution or the interval that the table states.
    ///
    /// # Errors
    /// [`BadSetting`] on a missing, superfluous or inadmissible parameter; keys relative to the table.
    pub fn uncertainty(&self) -> Result<Uncertainty, BadSetting> {
        match self.kind {
            UncertaintyKind::Aleatory => {
                for (key, value) in [("lower", self.lower), ("upper", self.upper)] {
                    let rule = "must be absent: only an input of kind \"epistemic\" takes it";
                    BadSetting::unless(value.is_none(), key, value.unwrap_or_default(), rule)?;
                }
                let rule = "must be absent: only an input of kind \"epistemic\" takes it";
                BadSetting::unless(self.scale.is_none(), "scale", "(given)", rule)?;
                self.distribution().map(Uncertainty::Aleatory)
            }
            UncertaintyKind::Epistemic => self.interval(),
        }
    }

    /// The distribution that the table states.
    ///
    /// # Errors
    /// [`BadSetting`] on a missing, superfluous or inadmissible parameter; keys relative to the table.
    pub fn distribution(&self) -> Result<Distribution, BadSetting> {
        let shape = self.shape()?;
        let takes = |key: &str| shape.parameters().iter().any(|(taken, _)| *taken == key);
        self.refuse_superfluous(takes, shape.name())?;
        Distribution::new(shape, self.truncation)
    }

    fn interval(&self) -> Result<Uncertainty, BadSetting> {
        let name = "an input of kind \"epistemic\"";
        let rule = format!("must be absent: {name} has no density, only lower and upper");
        let given = self.distribution.is_some();
        BadSetting::unless(!given, "distribution", "(given)", &rule)?;
        let cut = self.truncation.is_some();
        BadSetting::unless(!cut, "truncation", "(given)", &rule)?;
        self.refuse_superfluous(|_| false, name)?;
        let end = |key: &str, value: Option<f64>| {
            let missing = BadSetting {
                key: key.to_owned(),
                value: "(absent)".to_owned(),
                rule: format!("must be given for {name}"),
            };
            let value = value.ok_or(missing)?;
            let finite = value.is_finite();
            BadSetting::unless(finite, key, value, "must be a finite number")?;
            Ok::<f64, BadSetting>(value)
        };
        let (lower, upper) = (end("lower", self.lower)?, end("upper", self.upper)?);
        let rule = "must be greater than lower";
        BadSetting::unless(lower < upper, "upper", upper, rule)?;
        let usual = EpistemicInterval::usual_scale(lower, upper);
        let scale = self.scale.unwrap_or(usual);
        let rule = "must be \"linear\": a logarithmic scale needs lower > 0";
        let has_one = scale == Scale::Linear || lower > 0.0;
        BadSetting::unless(has_one, "scale", "\"log\"", rule)?;
        Ok(Uncertainty::Epistemic(EpistemicInterval {
            lower,
            upper,
            scale,
        }))
    }

    fn shape(&self) -> Result<Shape, BadSetting> {
        let family = self.distribution.ok_or_else(|| BadSetting {
            key: "distribution".to_owned(),
            value: "(absent)".to_owned(),
            rule: "must be given, or kind = \"epistemic\" with lower and upper".to_owned(),
        })?;
        Ok(match family {
            Family::Fixed => Shape::Fixed {
                value: required("value", self.value)?,
            },
            Family::Uniform => Shape::Uniform {
                low: required("low", self.low)?,
                high: required("high", self.high)?,
            },
            Family::LogUniform => Shape::LogUniform {
                low: required("low", self.low)?,
                high: required("high", self.high)?,
            },
            Family::Normal => Shape::Normal {
                mean: required("mean", self.mean)?,
                standard_deviation: required("standard_deviation", self.standard_deviation)?,
            },
            Family::Lognormal => Shape::Lognormal {
                median: required("median", self.median)?,
                log_standard_deviation: required(
                    "log_standard_deviation",
                    self.log_standard_deviation,
                )?,
            },
            Family::Triangular => Shape::Triangular {
                low: required("low", self.low)?,
                mode: required("mode", self.mode)?,
                high: required("high", self.high)?,
            },
            Family::Beta => Shape::Beta {
                alpha: required("alpha", self.alpha)?,
                beta: required("beta", self.beta)?,
                low: required("low", self.low)?,
                high: required("high", self.high)?,
            },
        })
    }

    fn refuse_superfluous(
        &self,
        takes: impl Fn(&str) -> bool,
        name: &str,
    ) -> Result<(), BadSetting> {
        let given = [
            ("value", self.value),
            ("low", self.low),
            ("high", self.high),
            ("mean", self.mean),
            ("standard_deviation", self.standard_deviation),
            ("median", self.median),
            ("log_standard_deviation", self.log_standard_deviation),
            ("mode", self.mode),
            ("alpha", self.alpha),
            ("beta", self.beta),
        ];
        for (key, value) in given {
            if let Some(value) = value {
                let rule = format!("must be absent: {name} does not take it");
                BadSetting::unless(takes(key), key, value, &rule)?;
            }
        }
        Ok(())
    }
}

fn required(key: &str, value: Option<f64>) -> Result<f64, BadSetting> {
    value.ok_or_else(|| BadSetting {
        key: key.to_owned(),
        value: "(absent)".to_owned(),
        rule: "must be given for this distribution".to_owned(),
    })
}
