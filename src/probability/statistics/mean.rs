//! Intervals of a mean from few values whose law may be skewed.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Student's factor of an interval on both sides for a number of degrees of freedom; infinite where there is none.
#[must_use]
pub fn student(freedom: f64, confidence: f64) -> f64 {
    let student = StudentsT::new(0.0, 1.0, freedom);
    student.map_or(f64::INFINITY, |t| t.inverse_cdf((1.0 + confidence) / 2.0))
}

/// Mean of some values, its standard error and their skewness.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampleMean {
    pub(super) mean: f64,
    pub(super) error: f64,
    /// Without bias for normal values (Fisher's G₁); 0 of fewer than three.
    skewness: f64,
    n: f64,
}

impl SampleMean {
    /// Of at least two values.
    pub(super) fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        let deviation = (squares / n).sqrt();
        let skewness = match n > 2.0 && deviation > 0.0 {
            true => {
                let cubes = values.iter().map(|v| ((v - mean) / deviation).powi(3));
                cubes.sum::<f64>() / n * (n * (n - 1.0)).sqrt() / (n - 2.0)
            }
            false => 0.0,
        };
        Self {
            mean,
            error: (squares / (n - 1.0) / n).sqrt(),
            skewness,
            n,
        }
    }

    /// Interval of the mean: the hull of Student's interval and of that of skewed laws, each of this confidence.
    ///
    /// The first is too short where the values are skewed (exponential: 92.0 % of the stated 95 % with 20 values, 89.3 % with 8),
    /// the second where they are not and few. For normal values the hull is 1.16, 1.04 and 1.02 times as wide as
    /// Student's interval with 8, 20 and 40 of them.
    pub(super) fn interval(&self, confidence: f64) -> (f64, f64) {
        let half = student(self.n - 1.0, confidence) * self.error;
        let (lower, upper) = self.skewed_interval(1.0, confidence);
        (lower.min(self.mean - half), upper.max(self.mean + half))
    }

    /// Hall's interval: Student's factors on t + γ t²/(3 √n) + γ² t³/(27 n) + γ/(6 √n), which has no skewness, solved for t
    /// = (mean − μ)/error; `factor` times the skewness γ of the values.
    ///
    /// Source: Hall, J. R. Statist. Soc. B 54 (1992) 221–228.
    pub(super) fn skewed_interval(&self, factor: f64, confidence: f64) -> (f64, f64) {
        if self.error <= 0.0 {
            return (self.mean, self.mean);
        }
        let a = factor * self.skewness / self.n.sqrt();
        let solved = |transformed: f64| {
            // (∛(1 + a r) − 1) 3/a
            let r = transformed - a / 6.0;
            let root = (1.0 + a * r).cbrt();
            3.0 * r / (root * root + root + 1.0)
        };
        let t = student(self.n - 1.0, confidence);
        let at = |transformed: f64| self.mean - self.error * solved(transformed);
        (at(t), at(-t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transformation of the limits is ± Student's factor. Values 1, 2, 6: mean 3, error √(7/3), population variance 14/3,
    /// third moment 6, G₁ = 6/(14/3)^{3/2} √6. Seen to fail with the last term of the transformation left out, and with the
    /// skewness that divides by n alone.
    #[test]
    fn halls_limits_by_hand() {
        let found = SampleMean::of(&[1.0, 2.0, 6.0]);
        let error = (7.0_f64 / 3.0).sqrt();
        assert!((found.mean - 3.0).abs() < 1e-15 && (found.error - error).abs() < 1e-15);
        let g = 6.0 / (14.0_f64 / 3.0).powf(1.5) * 6_f64.sqrt();
        let (lower, upper) = found.skewed_interval(1.0, 0.95);
        for (limit, factor) in [(lower, 4.302_652_729_7), (upper, -4.302_652_729_7)] {
            let (t, a) = ((3.0 - limit) / error, g / 3_f64.sqrt());
            let transformed = t + a * t * t / 3.0 + a * a * t.powi(3) / 27.0 + a / 6.0;
            assert!((transformed - factor).abs() < 1e-8, "{transformed}");
        }
        let (lower, upper) = found.interval(0.95);
        assert!((lower - (3.0 - 4.302_652_729_7 * error)).abs() < 1e-8);
        assert!(upper > 3.0 + 4.302_652_729_7 * error);
    }

    /// Without skewness, with two values and without spread: Student's interval. Seen to fail with n degrees of freedom.
    #[test]
    fn values_without_skewness_have_students_interval() {
        for values in [&[1.0, 2.0, 3.0][..], &[5.0, 9.0], &[4.0, 4.0, 4.0]] {
            let found = SampleMean::of(values);
            let half = student(values.len() as f64 - 1.0, 0.9) * found.error;
            let (lower, upper) = found.interval(0.9);
            assert!((lower - (found.mean - half)).abs() < 1e-12);
            assert!((upper - (found.mean + half)).abs() < 1e-12);
        }
    }
}
