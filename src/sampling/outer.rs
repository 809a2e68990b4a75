//! Points over the box of inputs that are known to an interval only.

use super::Input;
use super::sobol::{MOST_DIMENSIONS, Sobol};
use super::stream::OUTER;
use crate::setting::BadSetting;

/// How the box of the epistemic inputs is covered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OuterKind {
    /// The corners, the centre and space-filling points.
    #[default]
    Corners,
    /// A full grid with the ends of every interval.
    Grid,
}

/// `[epistemic]` of a study file.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EpistemicTable {
    #[serde(default)]
    kind: OuterKind,
    points: Option<u64>,
}

/// Space-filling points if the study does not say.
const SPACE_FILLING: u64 = 8;
/// Grid points per input if the study does not say.
const GRID: u64 = 3;
/// Outer points at most: each is a study of its own.
const MOST_POINTS: u64 = 100_000;

/// Values of the epistemic inputs at every outer point.
#[derive(Debug, Clone, PartialEq)]
pub struct OuterPoints {
    /// Shape: points × epistemic inputs.
    pub values: Vec<Vec<f64>>,
}

impl EpistemicTable {
    /// Covers the box of `intervals` [lower, upper]; the seed moves the space-filling points.
    ///
    /// # Errors
    /// [`BadSetting`] on `points`, relative to `[epistemic]`.
    pub fn cover(
        &self,
        seed: u64,
        intervals: &[(Input, [f64; 2])],
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
        let place = |point: Vec<f64>| -> Vec<f64> {
            (point.iter().zip(intervals))
                .map(|(t, (_, [lower, upper]))| (1.0 - t) * lower + t * upper)
                .collect()
        };
        Ok(OuterPoints {
            values: unit.into_iter().map(place).collect(),
        })
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
