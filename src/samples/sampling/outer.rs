//! Points over the box of inputs that are known to an interval only.

use super::sobol::{MOST_DIMENSIONS, Sobol};
use super::stream::OUTER;
use crate::setting::BadSetting;

/// How the box of the epistemic inputs is covered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OuterKind {
    /// The corners, the centre and `points` space-filling ones.
    #[default]
    Corners,
    /// A full grid of `points` per input, the ends of every interval included.
    Grid,
}

/// Scale of an interval, as written in a study file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Even in the value.
    Linear,
    /// Even in its logarithm.
    Log,
}

/// Ratio of the ends from which an interval of positive values counts as one over orders of magnitude.
const DECADE: f64 = 10.0;

/// What is known of an epistemic input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EpistemicInterval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// Scale on which points are spaced; log needs a positive lower end.
    pub scale: Scale,
}

impl EpistemicInterval {
    /// Scale of an interval that states none: log if it is positive and its ends are a factor of ten apart or more.
    #[must_use]
    pub fn usual_scale(lower: f64, upper: f64) -> Scale {
        match lower > 0.0 && upper >= DECADE * lower {
            true => Scale::Log,
            false => Scale::Linear,
        }
    }

    /// The value at the share `t` of the way from the lower to the upper end; the ends themselves at 0 and 1.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let (lower, upper) = (self.lower, self.upper);
        let between = match self.scale {
            Scale::Linear => (1.0 - t) * lower + t * upper,
            Scale::Log => libm::exp((1.0 - t) * libm::log(lower) + t * libm::log(upper)),
        };
        match t {
            0.0 => lower,
            1.0 => upper,
            _ => between.clamp(lower, upper),
        }
    }

    /// The share t at which [`Self::at`] gives `value`.
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        let on_scale = |value: f64| match self.scale {
            Scale::Linear => value,
            Scale::Log => libm::log(value),
        };
        let [lower, upper, value] = [self.lower, self.upper, value].map(on_scale);
        (value - lower) / (upper - lower)
    }
}

/// Outer points over the box of the inputs that are known to an interval only; the samples are repeated at each.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EpistemicTable {
    /// How the box of the intervals is covered.
    #[serde(default)]
    #[schemars(extend("default" = "corners"))]
    kind: OuterKind,
    /// Space-filling points beside the corners (8 if absent), or points of a grid per input (3 if absent).
    #[schemars(range(max = MOST_POINTS))]
    points: Option<u64>,
    /// Further points, at most, for each number that a criterion judges, where it could be worst; 9 per epistemic input if
    /// absent, none with 0. Where the resonance lies below an engine order at one point and above it at another, the crossing
    /// between them is sought by halving their distance, whatever this says.
    #[schemars(range(max = MOST_SEARCH))]
    search: Option<u64>,
}

/// Space-filling points if the study does not say.
const SPACE_FILLING: u64 = 8;
/// Grid points per input if the study does not say.
const GRID: u64 = 3;
/// Points of a search for the worst case, per epistemic input, if the study does not say.
const SEARCH: u64 = 9;
/// Points of a search at most.
const MOST_SEARCH: u64 = 10_000;
/// Outer points at most: each is a study of its own.
const MOST_POINTS: u64 = 100_000;

/// Values of the epistemic inputs at every outer point.
#[derive(Debug, Clone, PartialEq)]
pub struct OuterPoints {
    /// Shape: points × epistemic inputs.
    pub values: Vec<Vec<f64>>,
    /// The intervals that they cover. Shape: `[epistemic inputs]`.
    pub intervals: Vec<EpistemicInterval>,
    /// Points that a search for the worst case may look at, for each number that is judged.
    pub search: usize,
}

impl OuterPoints {
    /// Values at a point of the unit cube. Shape: `[epistemic inputs]`.
    #[must_use]
    pub fn at(&self, unit: &[f64]) -> Vec<f64> {
        let pairs = unit.iter().zip(&self.intervals);
        pairs.map(|(t, interval)| interval.at(*t)).collect()
    }

    /// The point of the unit cube with these `values`. Shape of both: `[epistemic inputs]`.
    #[must_use]
    pub fn unit(&self, values: &[f64]) -> Vec<f64> {
        let pairs = values.iter().zip(&self.intervals);
        pairs
            .map(|(value, interval)| interval.share(*value))
            .collect()
    }
}

impl EpistemicTable {
    /// Covers the box of `intervals`, each on its scale; the seed moves the space-filling points.
    ///
    /// # Errors
    /// [`BadSetting`] on `points`, relative to `[epistemic]`.
    pub fn cover(
        &self,
        seed: u64,
        intervals: &[EpistemicInterval],
    ) -> Result<OuterPoints, BadSetting> {
        let inputs = u32::try_from(intervals.len()).unwrap_or(u32::MAX);
        let (count, least) = match self.kind {
            OuterKind::Corners => {
                let points = self.points.unwrap_or(SPACE_FILLING);
                let corners = 2_u64.checked_pow(inputs).and_then(|n| n.checked_add(1));
                (corners.and_then(|n| n.checked_add(points)), 0)
            }
            OuterKind::Grid => (self.points.unwrap_or(GRID).checked_pow(inputs), 2),
        };
        let points = self.points.map_or("(absent)".to_owned(), |n| n.to_string());
        let enough = self.points.is_none_or(|n| n >= least);
        BadSetting::unless(enough, "points", &points, "must be at least 2 per input")?;
        let rule = format!("must make at most {MOST_POINTS} points over all epistemic inputs");
        let few = count.is_some_and(|n| n <= MOST_POINTS) && intervals.len() <= MOST_DIMENSIONS;
        BadSetting::unless(few, "points", &points, &rule)?;
        let unit = match self.kind {
            OuterKind::Corners => {
                corners_and_more(seed, intervals.len(), self.points.unwrap_or(SPACE_FILLING))
            }
            OuterKind::Grid => grid(intervals.len(), self.points.unwrap_or(GRID)),
        };
        let search = self.search.unwrap_or(SEARCH * u64::from(inputs));
        let rule = format!("must be at most {MOST_SEARCH}");
        BadSetting::unless(search <= MOST_SEARCH, "search", search, &rule)?;
        let mut outer = OuterPoints {
            values: Vec::new(),
            intervals: intervals.to_vec(),
            search: search as usize,
        };
        outer.values = unit.iter().map(|point| outer.at(point)).collect();
        Ok(outer)
    }
}

/// Points of the unit cube: corners (the first input changes fastest), centre, Sobol' points.
fn corners_and_more(seed: u64, inputs: usize, points: u64) -> Vec<Vec<f64>> {
    let sobol = Sobol::new(inputs);
    grid(inputs, 2)
        .into_iter()
        .chain([vec![0.5; inputs]])
        .chain((0..points).map(|i| sobol.scrambled(seed, 0, OUTER, i)))
        .collect()
}

/// `points` per input from 0 to 1; the first input changes fastest.
fn grid(inputs: usize, points: u64) -> Vec<Vec<f64>> {
    let mut cube = vec![Vec::new()];
    for _ in 0..inputs {
        cube = (0..points)
            .flat_map(|k| {
                let t = k as f64 / (points - 1) as f64;
                cube.iter()
                    .map(move |point| [&[t], point.as_slice()].concat())
            })
            .collect();
        // the new coordinate went to the front and changes slowest: it belongs to the back
        cube.iter_mut().for_each(|point| point.rotate_left(1));
    }
    cube
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over two orders of magnitude the points are even in the logarithm: seven of nine between the ends lie below 3.2,
    /// and the centre is their geometric mean. Seen to fail with all intervals linear.
    #[test]
    fn wide_intervals_are_covered_on_their_scale() {
        let interval = |lower: f64, upper: f64| EpistemicInterval {
            lower,
            upper,
            scale: EpistemicInterval::usual_scale(lower, upper),
        };
        let table = EpistemicTable {
            kind: OuterKind::Grid,
            points: Some(9),
            search: None,
        };
        let values = |of: EpistemicInterval| -> Vec<f64> {
            let points = table.cover(1, &[of]).unwrap();
            points.values.into_iter().map(|v| v[0]).collect()
        };
        let wide = values(interval(0.1, 10.0));
        assert_eq!((wide[0], wide[8]), (0.1, 10.0));
        assert!((wide[4] - 1.0).abs() < 1e-12, "{wide:?}");
        let ratio = wide[1] / wide[0];
        assert!(
            wide.windows(2)
                .all(|w| (w[1] / w[0] / ratio - 1.0).abs() < 1e-12)
        );
        assert_eq!(values(interval(0.1, 0.9))[4], 0.5);
        assert_eq!(values(interval(-1.0, 10.0))[4], 4.5);
    }
}
