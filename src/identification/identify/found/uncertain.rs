//! A value with what is not known of it.

use crate::statistics::student;
use libm::exp;

/// A value, its uncertainty and an interval, in the unit that its key names.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Uncertain {
    /// Best value.
    pub value: f64,
    /// Standard error by noise and by the scatter of the loops.
    pub standard_error: f64,
    /// Degrees of freedom of the standard error.
    pub degrees_of_freedom: f64,
    /// Standard uncertainty by the stated errors of the measuring chain; it is the same for all tests of a rig.
    pub systematic: f64,
    /// Lower end of the interval of the stated confidence.
    pub lower: f64,
    /// Upper end of it.
    pub upper: f64,
}

impl Uncertain {
    /// Interval t √(standard error² + systematic²) on both sides of the value; never below 0, where no parameter of a contact is.
    ///
    /// The degrees of freedom of the sum are those of Welch and Satterthwaite, with infinitely many for the stated errors.
    /// Source: JCGM 100:2008 (GUM), G.4.
    #[must_use]
    pub fn new(value: f64, errors: [f64; 2], degrees_of_freedom: f64, confidence: f64) -> Self {
        let half = half_width(errors, degrees_of_freedom, confidence);
        let [standard_error, systematic] = errors;
        Self {
            value,
            standard_error,
            degrees_of_freedom,
            systematic,
            lower: (value - half).max(0.0),
            upper: value + half,
        }
    }

    /// Of a value whose logarithm has these errors: the interval is that of the logarithm.
    #[must_use]
    pub fn of_logarithm(
        mean: f64,
        errors: [f64; 2],
        degrees_of_freedom: f64,
        confidence: f64,
    ) -> Self {
        let half = half_width(errors, degrees_of_freedom, confidence);
        let [standard_error, systematic] = errors;
        let value = exp(mean);
        Self {
            value,
            standard_error: value * standard_error,
            degrees_of_freedom,
            systematic: value * systematic,
            lower: exp(mean - half),
            upper: exp(mean + half),
        }
    }

    /// The same in a unit of which `factor` are one of the present.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            standard_error: self.standard_error * factor,
            degrees_of_freedom: self.degrees_of_freedom,
            systematic: self.systematic * factor,
            lower: self.lower * factor,
            upper: self.upper * factor,
        }
    }
}

/// Half the interval of a value with a standard error of so many degrees of freedom and a systematic error.
fn half_width([standard_error, systematic]: [f64; 2], freedom: f64, confidence: f64) -> f64 {
    let variance = standard_error.powi(2) + systematic.powi(2);
    let share = match variance > 0.0 {
        true => standard_error.powi(2) / variance,
        false => 1.0,
    };
    factor(freedom / (share * share), confidence) * variance.sqrt()
}

/// Degrees of freedom above which Student's law is the normal one to five digits.
const MANY: f64 = 1e6;

/// Student's factor of an interval on both sides, for any number of degrees of freedom from 1 on.
#[must_use]
pub fn factor(degrees_of_freedom: f64, confidence: f64) -> f64 {
    let freedom = match degrees_of_freedom.is_finite() {
        true => degrees_of_freedom.clamp(1.0, MANY),
        false => MANY,
    };
    student(freedom, confidence)
}
