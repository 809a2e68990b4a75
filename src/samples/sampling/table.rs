//! The table that states what is known of an input in a study file.

use super::distribution::{BETA_EXPONENT, Distribution, LOG_STANDARD_DEVIATION, Shape};
use super::outer::{EpistemicInterval, Scale};
use crate::setting::BadSetting;
use serde_json::json;

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
#[schemars(transform = by_family)]
pub struct DistributionTable {
    /// Whether the input varies or has one unknown value.
    #[serde(default)]
    #[schemars(extend("default" = "aleatory"))]
    kind: UncertaintyKind,
    /// Lower end of an interval without a distribution.
    lower: Option<f64>,
    /// Upper end of an interval without a distribution.
    upper: Option<f64>,
    /// How outer points are spaced over the interval. If absent `log` where the interval is positive and spans a factor of
    /// ten, else `linear`.
    scale: Option<Scale>,
    /// Family of the distribution, with its parameters.
    distribution: Option<Family>,
    /// The value of `fixed`.
    value: Option<f64>,
    /// Lower end of `uniform`, `log-uniform`, `triangular` and `beta`.
    low: Option<f64>,
    /// Upper end of `uniform`, `log-uniform`, `triangular` and `beta`.
    high: Option<f64>,
    /// Mean of `normal`.
    mean: Option<f64>,
    /// Standard deviation of `normal`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    standard_deviation: Option<f64>,
    /// Median of `lognormal`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    median: Option<f64>,
    /// Standard deviation of the logarithm of `lognormal`.
    #[schemars(range(min = LOG_STANDARD_DEVIATION[0], max = LOG_STANDARD_DEVIATION[1]))]
    log_standard_deviation: Option<f64>,
    /// Most likely value of `triangular`.
    mode: Option<f64>,
    /// First exponent of `beta`.
    #[schemars(range(min = BETA_EXPONENT[0], max = BETA_EXPONENT[1]))]
    alpha: Option<f64>,
    /// Second exponent of `beta`.
    #[schemars(range(min = BETA_EXPONENT[0], max = BETA_EXPONENT[1]))]
    beta: Option<f64>,
    /// [low, high] that cuts the distribution, of any family but `fixed`.
    #[serde(default, deserialize_with = "crate::setting::exactly_if_given")]
    truncation: Option<[f64; 2]>,
}

/// Every family with its parameters.
const FAMILIES: [(&str, &[&str]); 7] = [
    ("fixed", &["value"]),
    ("uniform", &["low", "high"]),
    ("log-uniform", &["low", "high"]),
    ("normal", &["mean", "standard_deviation"]),
    ("lognormal", &["median", "log_standard_deviation"]),
    ("triangular", &["low", "mode", "high"]),
    ("beta", &["alpha", "beta", "low", "high"]),
];

/// JSON Schema: each family takes its parameters and no others, an interval its ends.
fn by_family(schema: &mut schemars::Schema) {
    let every = FAMILIES.iter().flat_map(|(_, keys)| *keys);
    let absent = |but: &[&str]| {
        let others = every.clone().filter(|key| !but.contains(key));
        let absent = others.map(|key| ((*key).to_owned(), false.into()));
        absent.collect::<serde_json::Map<_, _>>()
    };
    let mut alternatives = Vec::new();
    for (family, keys) in FAMILIES {
        let mut properties = absent(keys);
        properties.insert("kind".to_owned(), json!({ "const": "aleatory" }));
        properties.insert("distribution".to_owned(), json!({ "const": family }));
        properties.extend(["lower", "upper"].map(|key| (key.to_owned(), false.into())));
        match family {
            "fixed" => properties.insert("truncation".to_owned(), false.into()),
            "log-uniform" => properties.insert("low".to_owned(), json!({ "exclusiveMinimum": 0 })),
            _ => None,
        };
        let required: Vec<&str> = ["distribution"].iter().chain(keys).copied().collect();
        alternatives.push(json!({ "properties": properties, "required": required }));
    }
    let mut properties = absent(&[]);
    properties.insert("kind".to_owned(), json!({ "const": "epistemic" }));
    properties.extend(["distribution", "truncation"].map(|key| (key.to_owned(), false.into())));
    let required = ["kind", "lower", "upper"];
    alternatives.push(json!({ "properties": properties, "required": required }));
    schema.insert("oneOf".to_owned(), alternatives.into());
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
            let rule = format!("must be given for {name}");
            let value = value.ok_or_else(|| BadSetting::new(key, "(absent)", rule))?;
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
        let rule = "must be given, or kind = \"epistemic\" with lower and upper";
        let family =
            (self.distribution).ok_or_else(|| BadSetting::new("distribution", "(absent)", rule))?;
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
    let rule = "must be given for this distribution";
    value.ok_or_else(|| BadSetting::new(key, "(absent)", rule))
}
