//! Distributions of one input, sampled by the inverse of the distribution function.

use crate::setting::{BadSetting, positive, within};
use crate::special::{
    beta_cdf, beta_density, beta_quantile, normal_cdf, normal_density, normal_quantile,
};
use libm::{exp, log};
use std::fmt;

/// Family and parameters.
#[derive(
    Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
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
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(try_from = "Stated", into = "Stated")]
pub struct Distribution {
    shape: Shape,
    support: [f64; 2],
    /// F of the uncut shape at both ends of the support.
    kept: [f64; 2],
}

/// A distribution as it is stored.
#[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Stated {
    /// Family and parameters.
    shape: Shape,
    /// Lower and upper end where it is cut (and normalised again); null where it is not.
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

/// Exponents of a beta distribution for which its functions are accurate; a narrower one is a normal distribution.
pub(super) const BETA_EXPONENT: [f64; 2] = [0.01, 1e6];
/// Standard deviations of ln x that can be meant: at 10 one standard deviation is a factor of 22000.
pub(super) const LOG_STANDARD_DEVIATION: [f64; 2] = [1e-9, 10.0];

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
                let (key, value) = ("log_standard_deviation", log_standard_deviation);
                within(key, value, LOG_STANDARD_DEVIATION)
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
                within("alpha", alpha, BETA_EXPONENT)?;
                within("beta", beta, BETA_EXPONENT)?;
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

    /// F(x).
    fn cdf(&self, x: f64) -> f64 {
        match *self {
            Self::Fixed { value } => f64::from(u8::from(x >= value)),
            Self::Uniform { low, high } => ((x - low) / (high - low)).clamp(0.0, 1.0),
            Self::LogUniform { low, high } => {
                let from_low = log(x.clamp(low, high)) - log(low);
                from_low / (log(high) - log(low))
            }
            Self::Normal {
                mean,
                standard_deviation,
            } => normal_cdf((x - mean) / standard_deviation),
            Self::Lognormal { .. } if x <= 0.0 => 0.0,
            Self::Lognormal {
                median,
                log_standard_deviation,
            } => normal_cdf((log(x) - log(median)) / log_standard_deviation),
            Self::Triangular { low, mode, high } => {
                let [below, above] = triangle(low, mode, high);
                let [t, u] = [x - low, high - x].map(|d| (d / (high - low)).clamp(0.0, 1.0));
                match x < mode {
                    true => t * t / below,
                    false if u == 0.0 => 1.0,
                    false => 1.0 - u * u / above,
                }
            }
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => beta_cdf(alpha, beta, (x - low) / (high - low)),
        }
    }

    /// dF/dx inside the support; 0 for a single value, which has none.
    fn density(&self, x: f64) -> f64 {
        match *self {
            Self::Fixed { .. } => 0.0,
            Self::Uniform { low, high } => 1.0 / (high - low),
            Self::LogUniform { low, high } => 1.0 / (x * (log(high) - log(low))),
            Self::Normal {
                mean,
                standard_deviation,
            } => normal_density((x - mean) / standard_deviation) / standard_deviation,
            Self::Lognormal { .. } if x <= 0.0 => 0.0,
            Self::Lognormal {
                median,
                log_standard_deviation,
            } => {
                let score = (log(x) - log(median)) / log_standard_deviation;
                normal_density(score) / (x * log_standard_deviation)
            }
            Self::Triangular { low, mode, high } => {
                let [below, above] = triangle(low, mode, high);
                let [t, u] = [x - low, high - x].map(|d| d / (high - low));
                let height = match x < mode {
                    true => t / below,
                    false if above == 0.0 => 1.0,
                    false => u / above,
                };
                2.0 / (high - low) * height
            }
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => beta_density(alpha, beta, (x - low) / (high - low)) / (high - low),
        }
    }

    /// F⁻¹(p), 0 < p < 1.
    fn quantile(&self, p: f64) -> f64 {
        match *self {
            Self::Fixed { value } => value,
            Self::Uniform { low, high } => low + p * (high - low),
            Self::LogUniform { low, high } => exp(log(low) + p * (log(high) - log(low))),
            Self::Normal {
                mean,
                standard_deviation,
            } => mean + standard_deviation * normal_quantile(p),
            Self::Lognormal {
                median,
                log_standard_deviation,
            } => median * exp(log_standard_deviation * normal_quantile(p)),
            Self::Triangular { low, mode, high } => {
                let [below, above] = triangle(low, mode, high);
                match p < below {
                    true => low + (high - low) * (p * below).sqrt(),
                    false => high - (high - low) * ((1.0 - p) * above).sqrt(),
                }
            }
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => low + (high - low) * beta_quantile(alpha, beta, p),
        }
    }
}

/// Probabilities below and above the mode.
fn triangle(low: f64, mode: f64, high: f64) -> [f64; 2] {
    [mode - low, high - mode].map(|d| d / (high - low))
}

/// `uniform: low 0.1, high 0.8`
impl fmt::Display for Distribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_words(|value| format!("{value:?}")))
    }
}

impl Distribution {
    /// Name and parameters, each number as `show` writes it.
    pub fn in_words(&self, show: impl Fn(f64) -> String) -> String {
        let parameter =
            |(key, value): (&str, f64)| format!("{} {}", key.replace('_', " "), show(value));
        let parameters = self.shape.parameters().into_iter().map(parameter);
        let ends = |[low, high]: [f64; 2]| format!("truncation [{}, {}]", show(low), show(high));
        let stated: Vec<String> = parameters.chain(self.truncation().map(ends)).collect();
        format!("{}: {}", self.shape.name(), stated.join(", "))
    }

    /// A distribution of checked parameters; `truncation` = [low, high] cuts it and normalises what is left.
    ///
    /// # Errors
    /// [`BadSetting`] on the parameter, or on `truncation` unless it is an interval inside the support that keeps
    /// at least a millionth of the probability.
    pub fn new(shape: Shape, truncation: Option<[f64; 2]>) -> Result<Self, BadSetting> {
        shape.validate()?;
        let support = shape.support();
        let Some([low, high]) = truncation else {
            return Ok(Self {
                shape,
                support,
                kept: [0.0, 1.0],
            });
        };
        let kept = [shape.cdf(low), shape.cdf(high)];
        let written = format!("[{low}, {high}]");
        let rule = |holds, rule| BadSetting::unless(holds, "truncation", &written, rule);
        rule(
            support[0] < support[1],
            "is for distributions with a range: this is one value",
        )?;
        rule(low < high, "must be [low, high] with low < high")?;
        rule(
            support[0] <= low && high <= support[1],
            "must lie inside the range of the distribution",
        )?;
        rule(
            kept[1] - kept[0] >= LEAST_KEPT,
            "must keep at least 1e-6 of the probability",
        )?;
        Ok(Self {
            shape,
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

    /// Whether the value, or its logarithm, is Gaussian but for a cut of less than a hundredth.
    #[must_use]
    pub fn is_gaussian(&self) -> bool {
        let shape = matches!(self.shape, Shape::Normal { .. } | Shape::Lognormal { .. });
        shape && self.kept[1] - self.kept[0] > 0.99
    }

    /// F⁻¹(u): the value at the uniform number u in (0, 1); never outside [`Distribution::support`].
    #[must_use]
    pub fn quantile(&self, u: f64) -> f64 {
        let p = self.kept[0] + u * (self.kept[1] - self.kept[0]);
        self.shape
            .quantile(p)
            .clamp(self.support[0], self.support[1])
    }

    /// dF/dx: density at x, 0 outside of the support; for the weights of samples under another distribution. A fixed value has none.
    #[must_use]
    pub fn density(&self, x: f64) -> Option<f64> {
        let [low, high] = self.support;
        match self.shape {
            Shape::Fixed { .. } => None,
            _ if x < low || x > high => Some(0.0),
            _ => Some(self.shape.density(x) / (self.kept[1] - self.kept[0])),
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
        (self.shape.cdf(x) - self.kept[0]) / (self.kept[1] - self.kept[0])
    }
}

fn finite(key: &str, value: f64) -> Result<(), BadSetting> {
    BadSetting::unless(value.is_finite(), key, value, "must be a finite number")
}

fn ascending(low: f64, high: f64) -> Result<(), BadSetting> {
    finite("low", low)?;
    finite("high", high)?;
    BadSetting::unless(low < high, "high", high, "must be greater than low")?;
    let rule = "must leave a range that a number can hold";
    BadSetting::unless((high - low).is_finite(), "high", high, rule)
}
