//! Distributions of one input, sampled by the inverse of the distribution function.

use statrs::distribution::{
    Beta, Continuous, ContinuousCDF, LogNormal, Normal, Triangular, Uniform,
};

use crate::setting::{BadSetting, positive};
use std::fmt;

/// Family and parameters.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Always `value`.
    Fixed {
        /// The value.
        value: f64,
    },
    /// Constant density on (low, high).
    Uniform {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// ln x is uniform on (ln low, ln high).
    LogUniform {
        /// Lower end, > 0.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Gaussian.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation, > 0.
        standard_deviation: f64,
    },
    /// ln x is Gaussian with mean ln `median`.
    Lognormal {
        /// Median of x, > 0.
        median: f64,
        /// Standard deviation of ln x, > 0.
        log_standard_deviation: f64,
    },
    /// Density rises linearly from low to mode and falls linearly to high.
    Triangular {
        /// Lower end.
        low: f64,
        /// Place of the maximum, low ≤ mode ≤ high.
        mode: f64,
        /// Upper end.
        high: f64,
    },
    /// low + (high − low) · Beta(alpha, beta).
    Beta {
        /// First exponent, > 0.
        alpha: f64,
        /// Second exponent, > 0.
        beta: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
}

/// A shape with checked parameters, possibly cut to an interval (and normalised again).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Stated", into = "Stated")]
pub struct Distribution {
    shape: Shape,
    law: Law,
    support: [f64; 2],
    /// F of the uncut law at both ends of the support.
    kept: [f64; 2],
}

/// A distribution as it is stored: what [`Distribution::new`] takes.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Stated {
    shape: Shape,
    truncation: Option<[f64; 2]>,
}

impl From<Distribution> for Stated {
    fn from(distribution: Distribution) -> Self {
        Self {
            shape: distribution.shape,
            truncation: distribution.truncation(),
        }
    }
}

impl TryFrom<Stated> for Distribution {
    type Error = BadSetting;

    fn try_from(stated: Stated) -> Result<Self, BadSetting> {
        Self::new(stated.shape, stated.truncation)
    }
}

/// Least probability that a truncation must keep: below it the inverse loses digits to cancellation.
const LEAST_KEPT: f64 = 1e-6;

impl Shape {
    /// Name in study files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fixed { .. } => "fixed",
            Self::Uniform { .. } => "uniform",
            Self::LogUniform { .. } => "log-uniform",
            Self::Normal { .. } => "normal",
            Self::Lognormal { .. } => "lognormal",
            Self::Triangular { .. } => "triangular",
            Self::Beta { .. } => "beta",
        }
    }

    /// Parameters with their keys in study files.
    #[must_use]
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Fixed { value } => vec![("value", value)],
            Self::Uniform { low, high } | Self::LogUniform { low, high } => {
                vec![("low", low), ("high", high)]
            }
            Self::Normal {
                mean,
                standard_deviation,
            } => vec![("mean", mean), ("standard_deviation", standard_deviation)],
            Self::Lognormal {
                median,
                log_standard_deviation,
            } => vec![
                ("median", median),
                ("log_standard_deviation", log_standard_deviation),
            ],
            Self::Triangular { low, mode, high } => {
                vec![("low", low), ("mode", mode), ("high", high)]
            }
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => vec![
                ("alpha", alpha),
                ("beta", beta),
                ("low", low),
                ("high", high),
            ],
        }
    }

    /// Checks the parameters.
    fn validate(&self) -> Result<(), BadSetting> {
        match *self {
            Self::Fixed { value } => finite("value", value),
            Self::Uniform { low, high } => ascending(low, high),
            Self::LogUniform { low, high } => {
                positive("low", low)?;
                ascending(low, high)
            }
            Self::Normal {
                mean,
                standard_deviation,
            } => {
                finite("mean", mean)?;
                positive("standard_deviation", standard_deviation)
            }
            Self::Lognormal {
                median,
                log_standard_deviation,
            } => {
                positive("median", median)?;
                positive("log_standard_deviation", log_standard_deviation)
            }
            Self::Triangular { low, mode, high } => {
                ascending(low, high)?;
                let inside = (low..=high).contains(&mode);
                BadSetting::unless(inside, "mode", mode, "must be between low and high")
            }
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => {
                positive("alpha", alpha)?;
                positive("beta", beta)?;
                ascending(low, high)
            }
        }
    }

    /// Ends of the interval outside of which the density is 0.
    fn support(&self) -> [f64; 2] {
        match *self {
            Self::Fixed { value } => [value, value],
            Self::Uniform { low, high }
            | Self::LogUniform { low, high }
            | Self::Triangular { low, high, .. }
            | Self::Beta { low, high, .. } => [low, high],
            Self::Normal { .. } => [f64::NEG_INFINITY, f64::INFINITY],
            Self::Lognormal { .. } => [0.0, f64::INFINITY],
        }
    }

    /// The library's law; it refuses only parameters that [`Shape::validate`] refuses, or an overflow of them.
    fn law(&self) -> Result<Law, BadSetting> {
        let law = match *self {
            Self::Fixed { value } => Some(Law::Point(value)),
            Self::Uniform { low, high } => Uniform::new(low, high).ok().map(Law::Uniform),
            Self::LogUniform { low, high } => {
                Uniform::new(low.ln(), high.ln()).ok().map(Law::LogUniform)
            }
            Self::Normal {
                mean,
                standard_deviation,
            } => Normal::new(mean, standard_deviation).ok().map(Law::Normal),
            Self::Lognormal {
                median,
                log_standard_deviation,
            } => LogNormal::new(median.ln(), log_standard_deviation)
                .ok()
                .map(Law::Lognormal),
            Self::Triangular { low, mode, high } => {
                Triangular::new(low, high, mode).ok().map(Law::Triangular)
            }
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => Beta::new(alpha, beta)
                .ok()
                .map(|law| Law::Beta(law, low, high - low)),
        };
        law.ok_or_else(|| BadSetting {
            key: "distribution".to_owned(),
            value: self.name().to_owned(),
            rule: "must have parameters that the distribution allows".to_owned(),
        })
    }
}

/// The shape with its parameters checked, ready to be evaluated.
#[derive(Debug, Clone, PartialEq)]
enum Law {
    Point(f64),
    Uniform(Uniform),
    /// On ln x.
    LogUniform(Uniform),
    Normal(Normal),
    Lognormal(LogNormal),
    Triangular(Triangular),
    /// With the lower end and the width of its interval.
    Beta(Beta, f64, f64),
}

impl Law {
    /// F(x).
    fn cdf(&self, x: f64) -> f64 {
        match self {
            Self::Point(value) => f64::from(u8::from(x >= *value)),
            Self::Uniform(law) => law.cdf(x),
            Self::LogUniform(law) => law.cdf(x.ln()),
            Self::Normal(law) => law.cdf(x),
            Self::Lognormal(law) => law.cdf(x),
            Self::Triangular(law) => law.cdf(x),
            Self::Beta(law, low, width) => law.cdf((x - low) / width),
        }
    }

    /// dF/dx inside the support; 0 for a single value, which has none.
    fn density(&self, x: f64) -> f64 {
        match self {
            Self::Point(_) => 0.0,
            Self::Uniform(law) => law.pdf(x),
            Self::LogUniform(law) => law.pdf(x.ln()) / x,
            Self::Normal(law) => law.pdf(x),
            Self::Lognormal(law) => law.pdf(x),
            Self::Triangular(law) => law.pdf(x),
            Self::Beta(law, low, width) => law.pdf((x - low) / width) / width,
        }
    }

    /// F⁻¹(p), 0 < p < 1.
    fn quantile(&self, p: f64) -> f64 {
        match self {
            Self::Point(value) => *value,
            Self::Uniform(law) => law.inverse_cdf(p),
            Self::LogUniform(law) => law.inverse_cdf(p).exp(),
            Self::Normal(law) => law.inverse_cdf(p),
            Self::Lognormal(law) => law.inverse_cdf(p),
            Self::Triangular(law) => law.inverse_cdf(p),
            Self::Beta(law, low, width) => low + width * law.inverse_cdf(p),
        }
    }
}

/// `uniform: low 0.1, high 0.8`
impl fmt::Display for Distribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parameter = |(key, value): (&str, f64)| format!("{} {value:?}", key.replace('_', " "));
        let parameters = self.shape.parameters().into_iter().map(parameter);
        let cut = self.truncation().map(|ends| format!("truncation {ends:?}"));
        let stated: Vec<String> = parameters.chain(cut).collect();
        write!(f, "{}: {}", self.shape.name(), stated.join(", "))
    }
}

impl Distribution {
    /// A distribution of checked parameters; `truncation` = [low, high] cuts it and normalises what is left.
    ///
    /// # Errors
    /// [`BadSetting`] on the parameter, or on `truncation` unless it is an interval inside the support that keeps
    /// at least a millionth of the probability.
    pub fn new(shape: Shape, truncation: Option<[f64; 2]>) -> Result<Self, BadSetting> {
        shape.validate()?;
        let law = shape.law()?;
        let support = shape.support();
        let Some([low, high]) = truncation else {
            return Ok(Self {
                shape,
                law,
                support,
                kept: [0.0, 1.0],
            });
        };
        let kept = [law.cdf(low), law.cdf(high)];
        let written = format!("[{low}, {high}]");
        let rule = |holds, rule| BadSetting::unless(holds, "truncation", &written, rule);
        rule(low < high, "must be [low, high] with low < high")?;
        rule(
            support[0] <= low && high <= support[1] && support[0] < support[1],
            "must lie inside the range of the distribution",
        )?;
        rule(
            kept[1] - kept[0] >= LEAST_KEPT,
            "must keep at least 1e-6 of the probability",
        )?;
        Ok(Self {
            shape,
            law,
            support: [low, high],
            kept,
        })
    }

    /// Where it is cut, if it is.
    fn truncation(&self) -> Option<[f64; 2]> {
        (self.support != self.shape.support()).then_some(self.support)
    }

    /// Always `value`.
    ///
    /// # Errors
    /// [`BadSetting`] unless it is finite.
    pub fn fixed(value: f64) -> Result<Self, BadSetting> {
        Self::new(Shape::Fixed { value }, None)
    }

    /// Family and parameters.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Closed interval that holds every value; after truncation.
    #[must_use]
    pub fn support(&self) -> [f64; 2] {
        self.support
    }

    /// The value, if it is fixed.
    #[must_use]
    pub fn fixed_value(&self) -> Option<f64> {
        match self.shape {
            Shape::Fixed { value } => Some(value),
            _ => None,
        }
    }

    /// F⁻¹(u): the value at the uniform number u in (0, 1); never outside [`Distribution::support`].
    #[must_use]
    pub fn quantile(&self, u: f64) -> f64 {
        let p = self.kept[0] + u * (self.kept[1] - self.kept[0]);
        self.law.quantile(p).clamp(self.support[0], self.support[1])
    }

    /// dF/dx: density at x, 0 outside of the support; for the weights of samples under another distribution. A fixed value has none.
    #[must_use]
    pub fn density(&self, x: f64) -> Option<f64> {
        let [low, high] = self.support;
        match self.law {
            Law::Point(_) => None,
            _ if x < low || x > high => Some(0.0),
            _ => Some(self.law.density(x) / (self.kept[1] - self.kept[0])),
        }
    }

    /// F(x): the probability of a value ≤ x.
    #[must_use]
    pub fn cdf(&self, x: f64) -> f64 {
        if x >= self.support[1] {
            return 1.0;
        }
        if x < self.support[0] {
            return 0.0;
        }
        (self.law.cdf(x) - self.kept[0]) / (self.kept[1] - self.kept[0])
    }
}

fn finite(key: &str, value: f64) -> Result<(), BadSetting> {
    BadSetting::unless(value.is_finite(), key, value, "must be a finite number")
}

fn ascending(low: f64, high: f64) -> Result<(), BadSetting> {
    finite("low", low)?;
    finite("high", high)?;
    BadSetting::unless(low < high, "high", high, "must be greater than low")
}
