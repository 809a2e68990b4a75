//! A distribution in another unit.

use super::Shape;

impl Shape {
    /// Distribution of `factor` times the number, of the same family; `factor` > 0.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Fixed { value } => Self::Fixed {
                value: factor * value,
            },
            Self::Uniform { low, high } => Self::Uniform {
                low: factor * low,
                high: factor * high,
            },
            Self::LogUniform { low, high } => Self::LogUniform {
                low: factor * low,
                high: factor * high,
            },
            Self::Normal {
                mean,
                standard_deviation,
            } => Self::Normal {
                mean: factor * mean,
                standard_deviation: factor * standard_deviation,
            },
            // ln(factor x) = ln factor + ln x scatters as ln x does
            Self::Lognormal {
                median,
                log_standard_deviation,
            } => Self::Lognormal {
                median: factor * median,
                log_standard_deviation,
            },
            Self::Triangular { low, mode, high } => Self::Triangular {
                low: factor * low,
                mode: factor * mode,
                high: factor * high,
            },
            Self::Beta {
                alpha,
                beta,
                low,
                high,
            } => Self::Beta {
                alpha,
                beta,
                low: factor * low,
                high: factor * high,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Distribution;
    use super::*;

    /// Quantiles of the scaled distribution are the scaled quantiles, of every family.
    #[test]
    fn quantiles_scale_with_the_number() {
        let shapes = [
            Shape::Fixed { value: 2.0 },
            Shape::Uniform {
                low: 1.0,
                high: 3.0,
            },
            Shape::LogUniform {
                low: 0.1,
                high: 10.0,
            },
            Shape::Normal {
                mean: 2.0,
                standard_deviation: 0.5,
            },
            Shape::Lognormal {
                median: 2.0,
                log_standard_deviation: 0.7,
            },
            Shape::Triangular {
                low: 1.0,
                mode: 1.5,
                high: 3.0,
            },
            Shape::Beta {
                alpha: 2.0,
                beta: 5.0,
                low: 1.0,
                high: 3.0,
            },
        ];
        for shape in shapes {
            let before = Distribution::new(shape, None).unwrap();
            let after = Distribution::new(shape.scaled(4.3), None).unwrap();
            for u in [0.01, 0.3, 0.5, 0.9] {
                let ratio = after.quantile(u) / (4.3 * before.quantile(u));
                assert!((ratio - 1.0).abs() < 1e-12, "{shape:?} at {u}: {ratio}");
            }
        }
    }
}
