//! One input at a time: how far a result moves when an input goes from a low to a high value, the others nominal.

/// Results at the ends of one input's range; `None` = failed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneAtATime {
    /// Result with the input at its low value.
    pub low: Option<f64>,
    /// Result with the input at its high value.
    pub high: Option<f64>,
}

/// One bar of a tornado.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct TornadoBar {
    /// Index of the input.
    pub input: usize,
    /// Change of the result at the input's low value; absent = failed.
    pub low: Option<f64>,
    /// Change of the result at the input's high value; absent = failed.
    pub high: Option<f64>,
    /// Spread of low, high and nominal; absent if an end failed, because it may be any.
    pub swing: Option<f64>,
}

/// Bars by descending swing; those with a failed end come first, because theirs is not known.
///
/// Interactions do not show, and a result that turns between the ends is missed: a first look, no ranking of variances.
#[must_use]
pub fn tornado(nominal: f64, ends: &[OneAtATime]) -> Vec<TornadoBar> {
    let change = |value: Option<f64>| value.filter(|v| v.is_finite()).map(|v| v - nominal);
    let bar = |(input, end): (usize, &OneAtATime)| {
        let (low, high) = (change(end.low), change(end.high));
        let swing = low.zip(high).map(|(low, high)| {
            let above = low.max(high).max(0.0);
            above - low.min(high).min(0.0)
        });
        TornadoBar {
            input,
            low,
            high,
            swing,
        }
    };
    let mut bars: Vec<TornadoBar> = ends.iter().enumerate().map(bar).collect();
    let size = |bar: &TornadoBar| bar.swing.unwrap_or(f64::INFINITY);
    bars.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.input.cmp(&b.input)));
    bars
}
