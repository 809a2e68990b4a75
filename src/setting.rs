//! A setting that breaks a rule: which key, its value, the rule. The study file's reader adds file and line.

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
            Err(Self {
                key: key.to_owned(),
                value: value.to_string(),
                rule: rule.to_owned(),
            })
        }
    }

    /// The same broken rule, seen from one level up: `prefix.key`.
    #[must_use]
    pub fn under(mut self, prefix: &str) -> Self {
        self.key = format!("{prefix}.{}", self.key);
        self
    }
}

/// Requires a finite number > 0.
///
/// # Errors
/// [`BadSetting`] otherwise.
pub fn positive(key: &str, value: f64) -> Result<(), BadSetting> {
    BadSetting::unless(
        value.is_finite() && value > 0.0,
        key,
        value,
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
        value,
        "must be a finite number >= 0",
    )
}
