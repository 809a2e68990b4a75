//! Half a cycle: from one reversal of the motion to the next.

use crate::identify::cycles::mean_loop::{MeanLoop, half_swing, median, smooth};

/// From a reversal to the next one.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) struct Half {
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

/// Share of the cycle, on both sides of the turn of the smooth motion, in which a reversal is sought.
const SEARCH: f64 = 0.125;
/// Samples on both sides of the turn that tell T/N there.
const NEAR: usize = 2;
/// Share of the limit of T/N at the turn of the motion from which on it is the reversal itself: a corner among noise is none.
const STILL_SLIPS: f64 = 0.95;
/// Share of the samples whose T/N counts as at its limit when reversals are sought: a contact that is nearly open has larger ones.
const LIMITED: f64 = 0.1;

/// The half down from the greatest displacement, then the half up.
///
/// Where the rig gives way, the contact rests at a reversal while the force falls: the displacement has a flat top, and its
/// smooth motion turns in the middle of it. The reversal is the corner of the loop before it, where displacement and T/N, each
/// over its swing, are greatest together. Where T/N is at its limit when the motion turns, the turn is the reversal.
pub(super) fn halves(cycle: &MeanLoop, least_normal: f64) -> [Half; 2] {
    let motion = smooth(&cycle.displacement);
    let n = motion.len();
    let by_motion = |sign: f64| {
        let along = |i: &usize| sign * motion[*i];
        (0..n)
            .max_by(|a, b| along(a).total_cmp(&along(b)))
            .unwrap_or(0)
    };
    let reach = half_swing(&motion).max(f64::MIN_POSITIVE);
    let ratio: Vec<f64> = (0..n)
        .map(|i| cycle.ratio(i, least_normal).unwrap_or(0.0))
        .collect();
    let mut sizes: Vec<f64> = ratio.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let limit = sizes[((1.0 - LIMITED) * (n - 1) as f64) as usize].max(f64::MIN_POSITIVE);
    let corner = |sign: f64| {
        let turn = by_motion(sign);
        let mut near: Vec<f64> = (n - NEAR..=n + NEAR)
            .map(|step| sign * ratio[(turn + step) % n])
            .collect();
        if median(&mut near).is_some_and(|ratio| ratio >= STILL_SLIPS * limit) {
            return turn;
        }
        let around = (SEARCH * n as f64) as usize;
        let height = |i: &usize| sign * (motion[*i] / reach + (ratio[*i] / limit).clamp(-1.0, 1.0));
        (n - around..=n + around)
            .map(|step| (turn + step) % n)
            .max_by(|a, b| height(a).total_cmp(&height(b)))
            .unwrap_or(turn)
    };
    let [top, bottom] = [1.0, -1.0].map(corner);
    let half = |first: usize, last: usize, sign| Half {
        first,
        samples: (last + n - first) % n + 1,
        sign,
    };
    [half(top, bottom, -1.0), half(bottom, top, 1.0)]
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
    pub(in crate::identify) fn force(&self, cycle: &MeanLoop) -> Vec<f64> {
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

    /// First and last place that tell the forces shortly before the next reversal.
    fn end(&self, cycle: &MeanLoop) -> [usize; 2] {
        let last = self.last(cycle);
        let count = ((END * cycle.samples() as f64).ceil() as usize).max(3);
        [(last + 1).saturating_sub(count), last]
    }

    /// T/N in the direction of the motion shortly before the next reversal.
    pub(super) fn end_ratio(&self, cycle: &MeanLoop, least_normal: f64) -> Option<f64> {
        let (ratio, [first, last]) = (self.ratio(cycle, least_normal), self.end(cycle));
        let end = &ratio[first..=last];
        median(&mut end.iter().copied().flatten().collect::<Vec<f64>>())
    }

    /// T and N shortly before the next reversal; none where the normal force is too small.
    fn end_forces(&self, cycle: &MeanLoop, least_normal: f64) -> Option<[f64; 2]> {
        let [first, last] = self.end(cycle);
        let closed: Vec<usize> = (first..=last)
            .map(|place| self.sample(place, cycle))
            .filter(|i| cycle.normal[*i] > least_normal)
            .collect();
        let middle =
            |signal: &[f64]| median(&mut closed.iter().map(|i| signal[*i]).collect::<Vec<f64>>());
        Some([middle(&cycle.tangential)?, middle(&cycle.normal)?])
    }

    /// Force at the reversal before, against the motion, and at each place the swing of the force from there to slip of the whole, where
    /// T/N has these sizes before the reversal and at the end: the limit of slip goes with the normal force of the instant.
    pub(super) fn swings(&self, cycle: &MeanLoop, [before, after]: [f64; 2]) -> (f64, Vec<f64>) {
        let n = cycle.samples();
        let around = (n - 1..=n + 1).map(|step| cycle.normal[(self.first + step) % n]);
        let start = before * (around.sum::<f64>() / 3.0).max(0.0);
        let at = |place| start + after * cycle.normal[self.sample(place, cycle)];
        (start, (0..self.samples).map(at).collect())
    }
}

/// What the forces at both ends of a loop say together, whatever the offset of T.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) struct Ends {
    /// (T₊ − T₋)/(N₊ + N₋): the friction coefficient where both ends slip, and never more than it.
    pub(in crate::identify) ratio: f64,
    /// Offset of T without which T/N has this size at both ends.
    pub(super) offset: f64,
}

impl Ends {
    /// Of the half down and the half up; none where the normal force is too small.
    pub(in crate::identify) fn of(
        [down, up]: &[Half; 2],
        cycle: &MeanLoop,
        least_normal: f64,
    ) -> Option<Self> {
        let down = down.end_forces(cycle, least_normal)?;
        let up = up.end_forces(cycle, least_normal)?;
        let ratio = (up[0] - down[0]) / (up[1] + down[1]);
        let offset = up[0] - ratio * up[1];
        Some(Self { ratio, offset })
    }
}
