//! The table that states a distribution in a study file.

use super::distribution::{Distribution, Shape};
use crate::setting::BadSetting;

/// Family of a distribution, as written in a study file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
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

/// All parameters that any family has; each family takes its own and refuses the others.
///
/// One flat table and not one variant per family: so a reader of the file can name the line of every mistake.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DistributionTable {
    distribution: Family,
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
    /// The distribution that the table states.
    ///
    /// # Errors
    /// [`BadSetting`] on a missing, superfluous or inadmissible parameter; keys relative to the table.
    pub fn distribution(&self) -> Result<Distribution, BadSetting> {
        let shape = self.shape()?;
        self.refuse_superfluous(&shape)?;
        Distribution::new(shape, self.truncation)
    }

    fn shape(&self) -> Result<Shape, BadSetting> {
        Ok(match self.distribution {
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

    fn refuse_superfluous(&self, shape: &Shape) -> Result<(), BadSetting> {
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
                let taken = shape.parameters().contains(&key);
                let rule = format!("must be absent: {} does not take it", shape.name());
                BadSetting::unless(taken, key, value, &rule)?;
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
