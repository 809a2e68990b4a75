//! Numbers of one loop, taken at the places of its test.

use super::branch::slope;
use super::loop_shape::LoopShape;
use super::normal::normal_line;
use super::plateau::SURE;
use super::slope::Line;
use crate::identify::cycles::mean_loop::{MeanLoop, neighbour_correlation, robust_scale};

/// Numbers of a loop, in SI units, with the rig's stiffness in series.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) struct LoopNumbers {
    /// Mean normal force.
    pub(in crate::identify) normal: f64,
    /// Half the difference of the plateaus over the mean normal force there.
    pub(in crate::identify) friction: Option<PlateauNumbers>,
    /// Lines of both stick branches, of either sign.
    pub(in crate::identify) lines: [Option<Line>; 2],
    /// Normal force over approach.
    pub(in crate::identify) normal_line: Option<Line>,
    /// Energy of the cycle.
    pub(in crate::identify) energy: f64,
}

/// What the plateaus of a loop say.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) struct PlateauNumbers {
    /// Friction coefficient.
    pub(in crate::identify) coefficient: f64,
    /// Its standard error, from the samples of the plateaus.
    pub(in crate::identify) standard_error: Option<f64>,
    /// Offset of T.
    pub(in crate::identify) offset: f64,
    /// Slip distance per cycle; absent without a stick slope.
    pub(in crate::identify) slip_distance: Option<f64>,
    /// Elastic part of the travel per cycle; absent without a stick slope.
    elastic_travel: Option<f64>,
    /// ∮ N |ds| over the slip s (N m): the energy of the cycle over the friction coefficient; absent without a stick slope.
    load_over_slip: Option<f64>,
    /// Mean normal force on the plateaus.
    pub(in crate::identify) normal: f64,
}

impl LoopNumbers {
    /// Of one loop.
    pub(in crate::identify) fn of(cycle: &MeanLoop, shape: &LoopShape<'_>) -> Self {
        let lines = [0, 1].map(|side| {
            let window = shape.windows[side]?;
            slope(&shape.halves[side], cycle, &window)
        });
        let mut numbers = Self {
            normal: cycle.normal.iter().sum::<f64>() / cycle.samples() as f64,
            friction: None,
            lines,
            normal_line: normal_line(cycle),
            energy: cycle.energy(),
        };
        numbers.friction =
            (shape.plateaus).map(|places| plateaus(cycle, shape, places, numbers.stick()));
        numbers
    }

    /// Mean compliance of the stick branches (m/N): of either sign, where noise hides the travel.
    pub(in crate::identify) fn compliance(&self) -> Option<f64> {
        let lines = self.lines.iter().flatten();
        let each: Vec<f64> = lines.map(|line| 1.0 / line.slope).collect();
        (!each.is_empty()).then(|| each.iter().sum::<f64>() / each.len() as f64)
    }

    /// Slope of the stick branches (N/m), of their mean compliance.
    pub(in crate::identify) fn stick(&self) -> Option<f64> {
        self.compliance().filter(|mean| *mean > 0.0).map(f64::recip)
    }

    /// Whether the plateaus leave a way to slip beside the elastic travel, by more than its error. A contact that sticks has none, though a
    /// normal force that grows may make its T/N flat. What noise hides is no slip.
    pub(in crate::identify) fn has_way_to_slip(&self) -> bool {
        let ways = self
            .friction
            .and_then(|p| p.slip_distance.zip(p.elastic_travel));
        ways.is_none_or(|(slip, elastic)| slip > SURE * elastic * self.error_of_stick())
    }

    /// Relative standard error of the slope of the stick branches, by the points of both; 0 of branches without one.
    fn error_of_stick(&self) -> f64 {
        let lines = self.lines.iter().flatten();
        let errors = lines.map(|line| line.standard_error.unwrap_or(0.0) / line.slope.powi(2));
        let count = self.lines.iter().flatten().count().max(1) as f64;
        let both = errors.map(|error| error * error).sum::<f64>().sqrt() / count;
        both * self.stick().unwrap_or(0.0)
    }

    /// Energy over the normal force along the slip: ∮ T du = μ ∮ N |ds|, since the elastic part of the motion gives back its work.
    pub(in crate::identify) fn friction_from_energy(&self) -> Option<f64> {
        let plateaus = self.friction?;
        plateaus.slip_distance.filter(|slip| *slip > 0.0)?;
        let load = plateaus.load_over_slip.filter(|load| *load > 0.0)?;
        Some(self.energy / load)
    }
}

/// T = ± μ N + offset on both plateaus: two equations of the means over the samples.
fn plateaus(
    cycle: &MeanLoop,
    shape: &LoopShape<'_>,
    places: [[usize; 2]; 2],
    stick: Option<f64>,
) -> PlateauNumbers {
    let means = [0, 1].map(|side| {
        let samples = samples(cycle, shape, side, places[side]);
        let mean =
            |values: &[f64]| samples.iter().map(|i| values[*i]).sum::<f64>() / samples.len() as f64;
        [mean(&cycle.tangential), mean(&cycle.normal)]
    });
    let [down, up] = means;
    let coefficient = (up[0] - down[0]) / (up[1] + down[1]);
    let offset = up[0] - coefficient * up[1];
    let errors = [0, 1].map(|side| {
        let sign = shape.halves[side].sign;
        let rest =
            |i: &usize| cycle.tangential[*i] - offset - sign * coefficient * cycle.normal[*i];
        mean_error(
            &samples(cycle, shape, side, places[side])
                .iter()
                .map(rest)
                .collect::<Vec<f64>>(),
        )
    });
    let reversals = shape
        .halves
        .map(|half| half.sample(half.samples - 1, cycle));
    let travel = cycle.displacement[reversals[1]] - cycle.displacement[reversals[0]];
    let swing = coefficient * (cycle.normal[reversals[0]] + cycle.normal[reversals[1]]);
    PlateauNumbers {
        coefficient,
        standard_error: errors[0]
            .zip(errors[1])
            .map(|(a, b)| a.hypot(b) / (up[1] + down[1])),
        offset,
        slip_distance: stick.map(|stick| 2.0 * (travel - swing / stick)),
        elastic_travel: stick.map(|stick| 2.0 * swing / stick),
        load_over_slip: stick.map(|stick| load_over_slip(cycle, offset, stick)),
        normal: 0.5 * (up[1] + down[1]),
    }
}

/// ∮ N |ds| over the slip s = u − T/k: slip goes with T, and ds is 0 where the contact sticks, so it is ∮ sign T N du + ∮ |T| dN / k.
fn load_over_slip(cycle: &MeanLoop, offset: f64, stick: f64) -> f64 {
    let n = cycle.samples();
    let step = |i: usize| {
        let ends = [i, (i + 1) % n];
        let tangential = ends.map(|i| cycle.tangential[i] - offset);
        let normal = ends.map(|i| cycle.normal[i]);
        let change = |[first, last]: [f64; 2]| last - first;
        let mean = |[first, last]: [f64; 2]| 0.5 * (first + last);
        let size = tangential.map(f64::abs);
        // of a straight line that may pass 0
        let sign = match change(tangential) {
            0.0 => tangential[0].signum(),
            change_of_t => change(size) / change_of_t,
        };
        let motion = change(ends.map(|i| cycle.displacement[i]));
        sign * mean(normal) * motion + mean(size) * change(normal) / stick
    };
    (0..n).map(step).sum()
}

/// Samples of a plateau where the normal force is large enough and the contact slips: where it sticks for a moment, as a rig that
/// vibrates makes it do, T/N lies far from its usual value.
pub(super) fn samples(
    cycle: &MeanLoop,
    shape: &LoopShape<'_>,
    side: usize,
    [first, last]: [usize; 2],
) -> Vec<usize> {
    let all = (first..=last).map(|place| shape.halves[side].sample(place, cycle));
    let closed: Vec<usize> = all
        .clone()
        .filter(|i| cycle.normal[*i] > shape.least_normal)
        .collect();
    if closed.is_empty() {
        return all.collect();
    }
    let ratio = |i: &usize| (cycle.tangential[*i] - shape.offset) / cycle.normal[*i];
    let ratios: Vec<f64> = closed.iter().map(ratio).collect();
    let Some([usual, deviation]) = robust_scale(&ratios) else {
        return closed;
    };
    let far = (FAR * deviation).max(FAR_OF_RATIO * usual.abs());
    let slips = |i: &usize| (ratio(i) - usual).abs() <= far;
    closed.into_iter().filter(slips).collect()
}

/// Distance of a T/N from its median, in standard deviations (of the median absolute deviation), from which on the contact sticks...
const FAR: f64 = 6.0;
/// ...and over the median.
const FAR_OF_RATIO: f64 = 0.01;

/// Standard error of the mean of values whose neighbours may be alike; none of fewer than four.
fn mean_error(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    if values.len() < 4 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let alike = neighbour_correlation(values).clamp(0.0, MOST_ALIKE);
    Some((square / (n - 1.0) / n * (1.0 + alike) / (1.0 - alike)).sqrt())
}

/// Largest correlation of neighbours that is believed.
const MOST_ALIKE: f64 = 0.95;
