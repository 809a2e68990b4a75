//! Axes: where a value lies, and ticks that can be read.

use super::display::{minus_sign, superscript};
use crate::statistics::hull;

/// How values map to positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal distances for equal differences.
    Linear,
    /// Equal distances for equal ratios.
    Log,
}

/// One axis of a figure.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    scale: Scale,
    low: f64,
    high: f64,
    /// Names at 0, −1, −2, …, from top to bottom; none on an axis of numbers.
    names: Vec<String>,
}

impl Axis {
    /// One line per name, the first on top: name i stands at −i.
    pub fn of_names(names: Vec<String>) -> Self {
        Self {
            label: String::new(),
            scale: Scale::Linear,
            low: 0.5 - names.len().max(1) as f64,
            high: 0.5,
            names,
        }
    }

    /// Logarithmic from `low` to `high`, both positive.
    pub fn log(label: impl Into<String>, low: f64, high: f64) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Log,
            low,
            high,
            names: Vec::new(),
        }
    }

    /// Both ends.
    pub fn range(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Linear from `low` to `high`; widened where they coincide.
    pub fn linear(label: impl Into<String>, low: f64, high: f64) -> Self {
        let least = 1e-9 * low.abs().max(high.abs()).max(1e-6);
        let widen = if high - low > least {
            0.0
        } else {
            0.5 * low.abs().max(1.0) * 1e-3
        };
        Self {
            label: label.into(),
            scale: Scale::Linear,
            low: low - widen,
            high: high + widen,
            names: Vec::new(),
        }
    }

    /// An axis that shows all finite values with some space; logarithmic where they are positive and spread
    /// over more than a factor of 20. From 0 to 1 without values.
    pub fn around(label: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        let Some([low, high]) = hull(values.filter(|v| v.is_finite())) else {
            return Self::linear(label, 0.0, 1.0);
        };
        if low > 0.0 && high / low > 20.0 {
            let space = (high / low).powf(0.04);
            return Self::log(label, low / space, high * space);
        }
        let space = 0.05 * (high - low);
        Self::linear(label, low - space, high + space)
    }

    /// The same axis starting at zero.
    pub fn starting_at_zero(mut self) -> Self {
        if self.scale == Scale::Linear && self.high > 0.0 {
            self.low = 0.0;
        }
        self
    }

    /// Position of a value: 0 at the low end, 1 at the high end; `None` for what has no place on the axis.
    pub fn position(&self, value: f64) -> Option<f64> {
        let position = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        position.is_finite().then_some(position)
    }

    /// Ends of `n` parts of equal length, from low to high.
    pub fn parts(&self, n: usize) -> Vec<[f64; 2]> {
        let at = |i: usize| {
            let position = i as f64 / n as f64;
            match self.scale {
                Scale::Linear => self.low + position * (self.high - self.low),
                Scale::Log => self.low * (self.high / self.low).powf(position),
            }
        };
        (0..n).map(|i| [at(i), at(i + 1)]).collect()
    }

    /// Values and labels of the ticks; at most as many as fit when a label of c characters takes `space(c)` of
    /// the axis length.
    pub fn ticks(&self, space: impl Fn(usize) -> f64) -> Vec<(f64, String)> {
        if !self.names.is_empty() {
            let name = |(i, name): (usize, &String)| (-(i as f64), name.clone());
            return self.names.iter().enumerate().map(name).collect();
        }
        let mut best = Vec::new();
        for wanted in 2..=7 {
            let ticks = match self.scale {
                Scale::Linear => self.linear_ticks(wanted),
                Scale::Log => self.log_ticks(wanted),
            };
            let widest = ticks.iter().map(|t| t.1.chars().count()).max().unwrap_or(0);
            let fits = ticks.len() as f64 * space(widest) <= 1.0;
            if ticks.len() > best.len() && (fits || best.len() < 2) {
                best = ticks;
            }
        }
        best
    }

    fn linear_ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        let rough = (self.high - self.low) / wanted as f64;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|m| m * decade)
            .find(|step| *step >= 0.999 * rough)
            .unwrap_or(10.0 * decade);
        let first = (self.low / step - 1e-6).ceil() as i64;
        let last = (self.high / step + 1e-6).floor() as i64;
        (first..=last)
            .map(|i| i as f64 * step)
            .map(|value| {
                (
                    value,
                    tick_label(value, step, self.low.abs().max(self.high.abs())),
                )
            })
            .collect()
    }

    /// Powers of ten, thinned to every second, third, … where there are many; with 2 and 5 where there are few.
    fn log_ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        let (first, last) = (
            self.low.log10().floor() as i32,
            self.high.log10().ceil() as i32,
        );
        let decades = (self.high / self.low).log10();
        let stride = (decades / wanted as f64).ceil().max(1.0) as usize;
        let mantissas: &[f64] = match decades / wanted as f64 {
            many if many > 0.7 => &[1.0],
            some if some > 0.45 => &[1.0, 3.0],
            _ => &[1.0, 2.0, 5.0],
        };
        (first..=last)
            .step_by(stride)
            .flat_map(|exponent| mantissas.iter().map(move |m| m * 10f64.powi(exponent)))
            .filter(|v| (self.low * 0.9999..=self.high * 1.0001).contains(v))
            .map(|value| (value, tick_label(value, value, value)))
            .collect()
    }
}

/// A number with just the decimals that its step needs; with the power of ten of `size`, the largest number
/// beside it, where that is long.
fn tick_label(value: f64, step: f64, size: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let long = !(1e-3..1e5).contains(&size);
    let exponent = if long {
        (size.log10() + 1e-9).floor()
    } else {
        0.0
    };
    let unit = 10f64.powf(exponent);
    let decimals = (-(step / unit).log10() - 1e-9).ceil().clamp(0.0, 8.0) as usize;
    let number = minus_sign(&format!("{:.decimals$}", value / unit));
    match (long, number.as_str()) {
        (false, _) => number,
        (true, "1") => format!("10{}", superscript(exponent as i32)),
        (true, _) => format!("{number}·10{}", superscript(exponent as i32)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks(|c| 0.012 * c as f64 + 0.04)
            .into_iter()
            .map(|t| t.1)
            .collect()
    }

    /// No offset, no superfluous digits. Seen to fail with decimals from the value instead of the step.
    #[test]
    fn labels_have_the_decimals_of_their_step() {
        assert_eq!(labels(&Axis::linear("", 2967.92, 2968.51))[0], "2968.0");
        assert_eq!(
            labels(&Axis::linear("", 0.0, 4.0)),
            ["0", "1", "2", "3", "4"]
        );
        assert_eq!(
            labels(&Axis::linear("", 0.0, 3e9)),
            [
                "0",
                "0.5·10⁹",
                "1.0·10⁹",
                "1.5·10⁹",
                "2.0·10⁹",
                "2.5·10⁹",
                "3.0·10⁹"
            ]
        );
        assert_eq!(
            labels(&Axis::around("", [0.1, 10.0].into_iter())),
            ["0.1", "0.2", "0.5", "1", "2", "5", "10"]
        );
    }

    /// Values without a place have no position, and no axis is degenerate.
    #[test]
    fn positions_are_finite_or_absent() {
        let log = Axis::around("", [1e-6, 1.0].into_iter());
        assert_eq!(log.position(0.0), None);
        assert_eq!(log.position(-1.0), None);
        for axis in [
            Axis::linear("", 5.0, 5.0),
            Axis::linear("", 0.0, 0.0),
            Axis::around("", std::iter::empty()),
        ] {
            assert!(axis.position(5.0).is_some() && axis.position(f64::NAN).is_none());
            assert!(!labels(&axis).is_empty(), "{axis:?}");
        }
    }
}
