//! Least and greatest value.

/// Lowest and highest value; `None` without any.
#[must_use]
pub fn hull(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let ends = values.into_iter().map(|v| [v, v]);
    ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}
