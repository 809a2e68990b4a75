//! Limits that may be open: what a sample cannot bound is said to be unbounded, never NaN.

/// One limit of an interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Limit {
    /// The samples do not bound this side.
    Unbounded,
    /// A finite limit.
    #[serde(untagged)]
    Value(f64),
}

impl Limit {
    /// The finite limit; `None` = unbounded.
    #[must_use]
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::Unbounded => None,
        }
    }

    /// The value as `show` writes it, or the word for an unbounded side.
    #[must_use]
    pub fn in_words(self, show: impl FnOnce(f64) -> String) -> String {
        self.value().map_or_else(|| "open".to_owned(), show)
    }
}

impl From<Option<f64>> for Limit {
    /// Absent or not finite = unbounded.
    fn from(value: Option<f64>) -> Self {
        match value.filter(|v| v.is_finite()) {
            Some(value) => Self::Value(value),
            None => Self::Unbounded,
        }
    }
}

/// A range whose sides may be open.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Interval {
    /// Lower limit.
    pub lower: Limit,
    /// Upper limit.
    pub upper: Limit,
}

impl Interval {
    /// Open on both sides.
    pub const UNBOUNDED: Self = Self {
        lower: Limit::Unbounded,
        upper: Limit::Unbounded,
    };

    /// Closed range between two limits; one that is not finite is an open side.
    #[must_use]
    pub fn between(lower: f64, upper: f64) -> Self {
        Self {
            lower: Some(lower).into(),
            upper: Some(upper).into(),
        }
    }

    /// Both limits as `show` writes them.
    #[must_use]
    pub fn in_words(&self, separator: &str, show: impl Fn(f64) -> String) -> String {
        let [lower, upper] = [self.lower, self.upper].map(|limit| limit.in_words(&show));
        format!("{lower}{separator}{upper}")
    }

    /// Whether `value` lies between the limits, limits included.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.lower.value().is_none_or(|lower| lower <= value)
            && self.upper.value().is_none_or(|upper| value <= upper)
    }
}
