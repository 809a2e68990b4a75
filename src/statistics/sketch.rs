//! Histogram of logarithmic bins that shards fill apart and merge in any order to the same bits.
//!
//! Rule of `DDSketch` (Masson, Rim & Lee, Proc. VLDB 12 (2019) 2195–2205): with γ = (1 + a)/(1 − a), value x > 0 falls in
//! bin ⌈log_γ x⌉, and the bin's value 2γᵏ/(γ + 1) is off by at most the share a. Bins are integers, so merging is adding.

use std::collections::BTreeMap;

/// Counts of values in logarithmic bins, of both signs, with failed samples beside them.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Sketch {
    accuracy: f64,
    negative: BTreeMap<i32, u64>,
    zero: u64,
    positive: BTreeMap<i32, u64>,
    failed: u64,
}

/// Two sketches have different bins.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("sketches of relative accuracy {left} and {right} have different bins")]
pub struct SketchMismatch {
    /// Relative accuracy of the sketch that was to take the other in.
    pub left: f64,
    /// Relative accuracy of the other.
    pub right: f64,
}

impl Sketch {
    /// An empty sketch; `None` unless the relative accuracy lies in [1e-6, 0.5].
    #[must_use]
    pub fn new(accuracy: f64) -> Option<Self> {
        (1e-6..=0.5).contains(&accuracy).then(|| Self {
            accuracy,
            negative: BTreeMap::new(),
            zero: 0,
            positive: BTreeMap::new(),
            failed: 0,
        })
    }

    /// Counts one sample; a value that is not finite is a failed sample.
    pub fn add(&mut self, value: f64) {
        if !value.is_finite() {
            self.failed += 1;
        } else if value == 0.0 {
            self.zero += 1;
        } else {
            let bin = (value.abs().ln() / self.log_gamma()).ceil() as i32;
            let side = match value > 0.0 {
                true => &mut self.positive,
                false => &mut self.negative,
            };
            *side.entry(bin).or_insert(0) += 1;
        }
    }

    /// Adds the counts of another sketch.
    ///
    /// # Errors
    ///
    /// The accuracies differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), SketchMismatch> {
        if self.accuracy != other.accuracy {
            return Err(SketchMismatch {
                left: self.accuracy,
                right: other.accuracy,
            });
        }
        for (own, added) in [
            (&mut self.negative, &other.negative),
            (&mut self.positive, &other.positive),
        ] {
            for (&bin, &count) in added {
                *own.entry(bin).or_insert(0) += count;
            }
        }
        self.zero += other.zero;
        self.failed += other.failed;
        Ok(())
    }

    /// Number of samples that did not fail.
    #[must_use]
    pub fn valid(&self) -> u64 {
        self.negative.values().sum::<u64>() + self.zero + self.positive.values().sum::<u64>()
    }

    /// Number of failed samples.
    #[must_use]
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// Value of the order statistic x₍ᵣₐₙₖ₎ of the valid samples to the relative accuracy; `None` outside 1..=valid.
    #[must_use]
    pub fn order_statistic(&self, rank: u64) -> Option<f64> {
        let gamma = self.log_gamma().exp();
        let value = |bin: i32| (f64::from(bin) * self.log_gamma()).exp() * 2.0 / (gamma + 1.0);
        let negative = self.negative.iter().rev().map(|(&k, &c)| (-value(k), c));
        let positive = self.positive.iter().map(|(&k, &c)| (value(k), c));
        let zero = std::iter::once((0.0, self.zero));
        let mut seen = 0;
        negative
            .chain(zero)
            .chain(positive)
            .find(|(_, count)| {
                seen += count;
                rank >= 1 && rank <= seen
            })
            .map(|(value, _)| value)
    }

    /// ln γ.
    fn log_gamma(&self) -> f64 {
        ((1.0 + self.accuracy) / (1.0 - self.accuracy)).ln()
    }
}
