//! Half a cycle: from one reversal of the motion to the next.

use super::mean_loop::{MeanLoop, median, smooth};

/// From a reversal to the next one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Half {
    /// First sample, at the reversal.
    first: usize,
    /// Samples up to the next reversal, which counts too.
    pub(super) samples: usize,
    /// Direction of the motion: -1 from the greatest displacement down, 1 up.
    pub(super) sign: f64,
}

/// Share of the cycle before a reversal that is left out: there the phases of different cycles differ.
const MARGIN: f64 = 0.01;
/// Share of the cycle, before that, which gives T/N at the end of a half.
const END: f64 = 0.03;

/// The way down from the greatest displacement, then the way up.
pub(super) fn halves(cycle: &MeanLoop) -> [Half; 2] {
    let motion = smooth(&cycle.displacement);
    let n = motion.len();
    let turn = (1..n)
        .min_by(|a, b| motion[*a].total_cmp(&motion[*b]))
        .unwrap_or(n / 2);
    let half = |first, samples, sign| Half {
        first,
        samples,
        sign,
    };
    [half(0, turn + 1, -1.0), half(turn, n - turn + 1, 1.0)]
}

impl Half {
    /// Sample of the loop at a place of the half.
    pub(super) fn sample(&self, place: usize, cycle: &MeanLoop) -> usize {
        (self.first + place) % cycle.samples()
    }

    /// Displacement since the reversal, at each place; rises.
    pub(super) fn displacement(&self, cycle: &MeanLoop) -> Vec<f64> {
        let start = cycle.displacement[self.first % cycle.samples()];
        let at = |place| self.sign * (cycle.displacement[self.sample(place, cycle)] - start);
        (0..self.samples).map(at).collect()
    }

    /// Tangential force in the direction of the motion, at each place.
    pub(super) fn force(&self, cycle: &MeanLoop) -> Vec<f64> {
        let at = |place| self.sign * cycle.tangential[self.sample(place, cycle)];
        (0..self.samples).map(at).collect()
    }

    /// T/N in the direction of the motion, at each place; none where the normal force is too small.
    pub(super) fn ratio(&self, cycle: &MeanLoop, least_normal: f64) -> Vec<Option<f64>> {
        let at = |place| cycle.ratio(self.sample(place, cycle), least_normal);
        (0..self.samples)
            .map(|place| at(place).map(|r| self.sign * r))
            .collect()
    }

    /// Last place that counts before the next reversal.
    pub(super) fn last(&self, cycle: &MeanLoop) -> usize {
        let margin = (MARGIN * cycle.samples() as f64).ceil() as usize;
        self.samples.saturating_sub(1 + margin)
    }

    /// T/N in the direction of the motion shortly before the next reversal.
    pub(super) fn end_ratio(&self, cycle: &MeanLoop, least_normal: f64) -> Option<f64> {
        let (ratio, last) = (self.ratio(cycle, least_normal), self.last(cycle));
        let count = ((END * cycle.samples() as f64).ceil() as usize).max(3);
        let end = &ratio[(last + 1).saturating_sub(count)..=last];
        median(&mut end.iter().copied().flatten().collect::<Vec<f64>>())
    }
}
