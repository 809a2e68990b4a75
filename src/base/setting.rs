//! A setting that breaks a rule, or is unusual: which key, its value, the rule. The study file's reader adds file and line.
//!
//! ```
//! # use microslip_base as microslip;
//! use microslip::setting::positive;
//!
//! let bad = positive("tolerance", -1.0).map_err(|bad| bad.under("solver"));
//! let message = bad.err().map(|bad| bad.to_string());
//! assert_eq!(message.as_deref(), Some("solver.tolerance = -1: must be a finite number > 0"));
//! ```

use serde::de::{Deserialize, Deserializer, Error as _};

/// A value outside its range. `key` is the dotted path below the settings struct that checks it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value}: {rule}")]
pub struct BadSetting {
    /// Dotted path of the key.
    pub key: String,
    /// The value as the user would write it.
    pub value: String,
    /// The rule that it breaks.
    pub rule: String,
}

impl BadSetting {
    /// The value of `key` that breaks `rule`.
    #[must_use]
    pub fn new(
        key: impl Into<String>,
        value: impl std::fmt::Display,
        rule: impl Into<String>,
    ) -> Self {
        Self {
            key: key.into(),
            value: value.to_string(),
            rule: rule.into(),
        }
    }

    /// `Err` with key, value and rule unless `holds`.
    ///
    /// # Errors
    /// Returns the broken rule.
    pub fn unless(
        holds: bool,
        key: &str,
        value: impl std::fmt::Display,
        rule: &str,
    ) -> Result<(), Self> {
        if holds {
            Ok(())
        } else {
            Err(Self::new(key, value, rule))
        }
    }

    /// The same broken rule, seen from one level up: `prefix.key`.
    #[must_use]
    pub fn under(mut self, prefix: &str) -> Self {
        self.key = format!("{prefix}.{}", self.key);
        self
    }
}

/// Largest number in units of the user's own: its square and its products with others can still be held.
pub const LARGEST: f64 = 1e30;

/// Friction coefficients that can be meant; a larger number is a percentage.
pub const FRICTION: [f64; 2] = [0.0, 10.0];
/// Friction coefficients of metals, dry or oily, cold or hot.
pub const USUAL_FRICTION: [f64; 2] = [0.05, 1.5];

/// Pattern of a text that is more than white space, for JSON Schema.
pub const NOT_BLANK: &str = "\\S";

/// Requires a friction coefficient that can be meant.
///
/// # Errors
/// [`BadSetting`] otherwise.
pub fn friction_coefficient(key: &str, value: f64) -> Result<(), BadSetting> {
    let rule = "must be from 0 to 10: a friction coefficient, no percentage";
    let [least, most] = FRICTION;
    BadSetting::unless((least..=most).contains(&value), key, Plain(value), rule)
}

/// Requires a finite number > 0.
///
/// # Errors
/// [`BadSetting`] otherwise.
pub fn positive(key: &str, value: f64) -> Result<(), BadSetting> {
    BadSetting::unless(
        value.is_finite() && value > 0.0,
        key,
        Plain(value),
        "must be a finite number > 0",
    )
}

/// Requires a finite number ≥ 0.
///
/// # Errors
/// [`BadSetting`] otherwise.
pub fn non_negative(key: &str, value: f64) -> Result<(), BadSetting> {
    BadSetting::unless(
        value.is_finite() && value >= 0.0,
        key,
        Plain(value),
        "must be a finite number >= 0",
    )
}

/// Requires a number from `least` to `most`.
///
/// # Errors
/// [`BadSetting`] otherwise.
pub fn within(key: &str, value: f64, [least, most]: [f64; 2]) -> Result<(), BadSetting> {
    let rule = format!("must be from {} to {}", Plain(least), Plain(most));
    BadSetting::unless((least..=most).contains(&value), key, Plain(value), &rule)
}

/// What is unusual about a value that may be meant all the same.
#[must_use]
pub fn unusual(key: &str, value: f64, usual: [f64; 2]) -> Option<BadSetting> {
    let [low, high] = usual;
    let rule = format!("is unusual: usual is {} to {}", Plain(low), Plain(high));
    let inside = (low..=high).contains(&value);
    BadSetting::unless(inside, key, Plain(value), &rule).err()
}

/// Significant digits of a computed number that a message shows: more than anyone states, fewer than rounding spoils.
const SHOWN_DIGITS: usize = 12;

/// A number for a message that was not read but computed, such as one that was converted to another unit and back: 500, not
/// 499.99999999999994.
#[must_use]
pub fn without_round_off(value: f64) -> f64 {
    let shown = format!("{value:.*e}", SHOWN_DIGITS - 1);
    shown.parse().unwrap_or(value)
}

/// A number as people write it: 0.05, 1e9.
#[derive(Debug, Clone, Copy)]
pub struct Plain(pub f64);

impl std::fmt::Display for Plain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0.abs() {
            0.0 => write!(f, "0"),
            size if (1e-3..1e5).contains(&size) => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

/// Reads a list of exactly `N` values: serde's own reading of an array drops what comes after them.
///
/// # Errors
/// The deserializer's, if it is no list or one of another length.
pub fn exactly<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let values = Vec::<T>::deserialize(deserializer)?;
    let found = values.len();
    let wrong = |_| D::Error::custom(format!("expected a list of {N} values, not of {found}"));
    values.try_into().map_err(wrong)
}

/// The same for a key that may be absent.
///
/// # Errors
/// As [`exactly`].
pub fn exactly_if_given<'de, D, T, const N: usize>(
    deserializer: D,
) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    exactly(deserializer).map(Some)
}

/// JSON Schema of a list whose numbers are > 0.
pub fn positive_items(schema: &mut schemars::Schema) {
    let items = schema
        .get_mut("items")
        .and_then(|items| items.as_object_mut());
    if let Some(items) = items {
        items.insert("exclusiveMinimum".to_owned(), 0.into());
    }
}

#[cfg(test)]
mod unit_tests {
    use super::without_round_off;

    #[test]
    fn round_off_is_not_shown() {
        for value in [500.0, 540.0, 0.1, 369.5, 1e-6, 123_456.789_012, 1e9, 0.0] {
            for error in [-3e-16, 0.0, 3e-16] {
                assert_eq!(without_round_off(value * (1.0 + error)), value);
            }
        }
        assert!(without_round_off(f64::NAN).is_nan());
        assert_eq!(without_round_off(f64::INFINITY), f64::INFINITY);
    }
}
