//! Slip limits of the parts of a contact from a map of its pressure.
//!
//! With one friction coefficient and one stiffness over the area a part slips where the elastic swing, over that of full slip, is its
//! pressure over the mean pressure. So the branch is a line between the pressures of the cells, exactly, for any map.

use crate::record::PressureMap;

/// "About the mean": within this share of it.
pub(super) const TENTH: f64 = 0.1;
/// Pressures of a map with the same order and another contrast: its pressures to these powers...
const POWERS: [f64; 5] = [0.9, 0.95, 1.0, 1.05, 1.1];
/// ...and the standard uncertainty of the power: half and twice the mean pressure are known to 3.5 %. An error of all pressures alike
/// changes nothing, and independent errors of many cells have nearly no effect on their distribution.
const OF_POWER: f64 = 0.05;

/// What is known of the pressure of a contact beside its loop.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) enum PressureSpread<'m> {
    /// Nothing.
    Unknown,
    /// Share of the area whose pressure is within a tenth of its mean.
    EvenArea(f64),
    /// A map.
    Map(&'m KnownPressure),
}

/// Slip limits that a pressure map gives, and how surely.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownPressure {
    maps: Vec<PossibleMap>,
    cells: usize,
    even_area: f64,
}

/// One of the maps that the measured one may stand for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PossibleMap {
    pub(super) limits: SlipLimits,
    /// Its probability before the loop is seen, up to a factor.
    pub(super) before: f64,
}

/// Slip limits of the parts of a contact, over their mean.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct SlipLimits {
    /// Steps of the distribution, by rising limit.
    steps: Vec<LimitStep>,
}

/// Parts with one limit.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LimitStep {
    limit: f64,
    /// Share of the swing where these parts begin to slip.
    share: f64,
    /// Share of the parts with this limit or a greater one.
    sticks: f64,
}

impl KnownPressure {
    /// From a map.
    #[must_use]
    pub fn new(map: &PressureMap) -> Self {
        let of = |power: f64| {
            let parts = map.cells.iter();
            SlipLimits::new(parts.map(|cell| ContactPart {
                limit: libm::pow(cell.pressure_pa, power),
                area: cell.area_m2,
            }))
        };
        let maps = POWERS.map(|power| PossibleMap {
            limits: of(power),
            before: libm::exp(-0.5 * ((power - 1.0) / OF_POWER).powi(2)),
        });
        Self {
            cells: map.cells.len(),
            even_area: of(1.0).even_area(),
            maps: maps.into(),
        }
    }

    /// Cells of the map.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Share of the area whose pressure is within a tenth of its mean.
    #[must_use]
    pub fn even_area(&self) -> f64 {
        self.even_area
    }

    pub(super) fn maps(&self) -> &[PossibleMap] {
        &self.maps
    }
}

/// A part of the contact.
#[derive(Debug, Clone, Copy)]
struct ContactPart {
    /// Up to a factor.
    limit: f64,
    /// Up to a factor.
    area: f64,
}

impl SlipLimits {
    fn new(parts: impl Iterator<Item = ContactPart>) -> Self {
        let mut parts: Vec<ContactPart> = parts.collect();
        parts.sort_by(|a, b| a.limit.total_cmp(&b.limit));
        let area: f64 = parts.iter().map(|part| part.area).sum();
        let mean = parts.iter().map(|part| part.area * part.limit).sum::<f64>() / area;
        let mut steps: Vec<LimitStep> = Vec::new();
        let [mut slipping, mut sticking] = [0.0, 1.0];
        for alike in parts.chunk_by(|a, b| a.limit == b.limit) {
            let limit = alike[0].limit / mean;
            steps.push(LimitStep {
                limit,
                share: slipping + sticking * limit,
                sticks: sticking,
            });
            let own = alike.iter().map(|part| part.area).sum::<f64>() / area;
            slipping += own * limit;
            sticking = (sticking - own).max(0.0);
        }
        Self { steps }
    }

    /// Share of the swing at an elastic swing of `x` times that of full slip.
    pub(super) fn share(&self, x: f64) -> f64 {
        let next = self.steps.partition_point(|step| step.limit < x);
        let step = self.steps.get(next).or(self.steps.last());
        step.map_or(x, |step| {
            step.share + step.sticks * (x.min(step.limit) - step.limit)
        })
    }

    /// The elastic swing at a share of the swing: the inverse.
    pub(super) fn elastic(&self, share: f64) -> f64 {
        let next = self.steps.partition_point(|step| step.share < share);
        let step = self.steps.get(next).or(self.steps.last());
        step.map_or(share, |step| {
            step.limit + (share.min(step.share) - step.share) / step.sticks
        })
    }

    /// Share of the parts whose slip limit is above `x` times the mean.
    pub(super) fn above(&self, x: f64) -> f64 {
        let next = self.steps.partition_point(|step| step.limit <= x);
        self.steps.get(next).map_or(0.0, |step| step.sticks)
    }

    /// Share of the parts whose slip limit is within a tenth of the mean.
    fn even_area(&self) -> f64 {
        self.above(1.0 - TENTH) - self.above(1.0 + TENTH)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(parts: &[(f64, f64)]) -> SlipLimits {
        SlipLimits::new(
            parts
                .iter()
                .map(|&(limit, area)| ContactPart { limit, area }),
        )
    }

    /// Limits that are spread evenly from 0 to twice the mean, in unequal cells: the share of the swing is 1 − (1 − x/2)².
    ///
    /// Seen to fail with equal areas.
    #[test]
    fn the_branch_of_an_even_spread_is_that_of_its_equation() {
        let narrow = (0..1000_u32).map(|i| (f64::from(i) + 0.5, 1.0));
        let wide = (500..1000_u32).map(|i| (2.0 * f64::from(i) + 1.0, 2.0));
        let mut parts: Vec<(f64, f64)> = narrow.chain(wide).collect();
        parts.reverse();
        let found = limits(&parts);
        for x in [0.0, 0.1, 0.5, 0.9, 1.0, 1.3, 1.9, 2.5] {
            let exact = 1.0 - (1.0 - 0.5 * f64::min(x, 2.0)).powi(2);
            let share = found.share(x);
            assert!((share - exact).abs() < 1e-6, "{x}: {share} {exact}");
            assert!(
                (found.above(x) - (1.0 - 0.5 * x).max(0.0)).abs() < 1e-3,
                "{x}"
            );
            if (0.05..1.0).contains(&x) {
                let back = found.elastic(share);
                assert!((back - x).abs() < 1e-9, "{x}: {back}");
            }
        }
        assert!(
            (found.even_area() - 0.1).abs() < 1e-3,
            "{}",
            found.even_area()
        );
    }

    /// A fifth of the area at 2, the rest at 3/4: a corner at each, whatever the unit. One limit is elastic-Coulomb.
    ///
    /// Seen to fail with equal areas.
    #[test]
    fn few_cells_are_exact() {
        let found = limits(&[(6e5, 2e-6), (6e5, 6e-6), (1.6e6, 2e-6)]);
        for (x, share) in [(0.5, 0.5), (0.75, 0.75), (1.0, 0.8), (2.0, 1.0), (3.0, 1.0)] {
            assert!((found.share(x) - share).abs() < 1e-12, "{x}");
        }
        assert!((found.elastic(0.9) - 1.5).abs() < 1e-12);
        assert_eq!(found.steps.len(), 2);
        let one = limits(&[(7.0, 1.0); 4]);
        for (x, share) in [(0.4, 0.4), (1.0, 1.0), (1.7, 1.0)] {
            assert!((one.share(x) - share).abs() < 1e-12, "{x}");
        }
        assert!((one.even_area() - 1.0).abs() < 1e-12, "{one:?}");
    }
}
