//! The inputs of sample i, under every kind of design.

use super::correlation::Copula;
use super::distribution::{Distribution, Shape};
use super::input::Input;
use super::outer::OuterPoints;
use super::pick_freeze::is_independent;
use super::plan::{DesignKind, Growth, Plan};
use crate::setting::BadSetting;
use crate::units::count;

/// Random inputs, how they are drawn, and the seed that all samples come from.
///
/// A nested design has outer points over the epistemic inputs. Sample i belongs to outer point i mod (outer points), and
/// its random numbers are those of inner sample ⌊i / outer points⌋: the same at every outer point.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    pub(super) seed: u64,
    pub(super) samples: u64,
    pub(super) kind: DesignKind,
    pub(super) inputs: Vec<(Input, Distribution)>,
    /// Inputs that are drawn: not fixed, epistemic or from a file; and their places among all.
    pub(super) drawn: Vec<Input>,
    pub(super) drawn_places: Vec<usize>,
    pub(super) plan: Plan,
    /// Correlation of the normal scores of the drawn inputs, in the plan or by the copula; absent where they are independent.
    pub(super) correlation: Option<Vec<Vec<f64>>>,
    pub(super) copula: Option<Copula>,
    pub(super) file: Option<(Vec<usize>, Vec<Vec<f64>>)>,
    pub(super) outer: Option<(Vec<usize>, OuterPoints)>,
}

/// What a sample belongs to, beside its design.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SampleGroup {
    /// Outer point of a nested design.
    pub outer: Option<u32>,
    /// Replicate of a quasi-random design with several.
    pub replicate: Option<u32>,
    /// Place in a row of a pick-freeze design: 0 = A, 1 = B, 2 + j = A with the j-th random input of B.
    pub place: Option<u32>,
}

impl SampleGroup {
    /// Whether the sample is a draw of the population. Mixed samples of a pick-freeze design share their inputs with
    /// others, so no statistic of the population may count them.
    #[must_use]
    pub fn of_population(&self) -> bool {
        self.place.is_none_or(|place| is_independent(place.into()))
    }
}

impl Design {
    /// The seed.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The inputs with their distributions, in the order of the values of a sample.
    ///
    /// An epistemic input has a uniform or log-uniform distribution here and one from a file a wide lognormal: scales that tell how far
    /// apart two samples are, and no statement about probability.
    #[must_use]
    pub fn inputs(&self) -> &[(Input, Distribution)] {
        &self.inputs
    }

    /// Ends of the values of the input at a place among [`Design::inputs`]: of its distribution or interval, or of its column in
    /// the file.
    #[must_use]
    pub fn range(&self, place: usize) -> [f64; 2] {
        let column = self.column(place).map(|values| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [v.min(low), v.max(high)]
            })
        });
        column.unwrap_or_else(|| self.inputs[place].1.support())
    }

    /// What may be meant but is unusual among the inputs with a distribution or an interval; keys are their names.
    #[must_use]
    pub fn unusual(&self) -> Vec<BadSetting> {
        let inputs = self.inputs.iter().enumerate();
        let stated = inputs.filter(|(place, _)| self.column(*place).is_none());
        stated
            .filter_map(|(_, (input, distribution))| {
                input.unusual([0.01, 0.99].map(|p| distribution.quantile(p)))
            })
            .collect()
    }

    /// The same among the columns of the file, with values that stand in it.
    #[must_use]
    pub fn unusual_in_file(&self) -> Vec<BadSetting> {
        let ends = |place: usize| {
            let mut values: Vec<f64> = self.column(place)?.collect();
            values.sort_by(f64::total_cmp);
            let beyond = values.len() / 100;
            let [least, greatest] = [beyond, values.len().checked_sub(1 + beyond)?];
            Some([values[least], values[greatest]])
        };
        let inputs = self.inputs.iter().enumerate();
        inputs
            .filter_map(|(place, (input, _))| input.unusual(ends(place)?))
            .collect()
    }

    /// Values of the input at a place among [`Design::inputs`] in the file, if it is a column of it.
    fn column(&self, place: usize) -> Option<impl Iterator<Item = f64>> {
        let (columns, rows) = self.file.as_ref()?;
        let column = columns.iter().position(|c| *c == place)?;
        Some(rows.iter().map(move |row| row[column]))
    }

    /// Values of sample `i`, in the order of [`Design::inputs`]: F_j⁻¹(u(i, j)), or the file's or outer point's value.
    #[must_use]
    pub fn sample(&self, i: u64) -> Vec<f64> {
        let n_outer = self.outer_points();
        let place = in_memory(i % n_outer);
        let point = self.outer().map(|points| points.values[place].as_slice());
        self.at_point(i / n_outer, point.unwrap_or_default())
    }

    /// Values of inner sample `inner` where the epistemic inputs have the values `point`: the same random numbers at any.
    ///
    /// Shape: `point` has one value per epistemic input.
    #[must_use]
    pub fn at_point(&self, inner: u64, point: &[f64]) -> Vec<f64> {
        let mut values: Vec<f64> = (self.inputs.iter())
            .map(|(_, distribution)| distribution.fixed_value().unwrap_or(0.0))
            .collect();
        let mut u = self.plan.point(self.seed, inner, &self.drawn);
        if let Some(copula) = &self.copula {
            copula.correlate(&mut u);
        }
        for (&column, u) in self.drawn_places.iter().zip(u) {
            values[column] = self.inputs[column].1.quantile(u);
        }
        let set = |values: &mut Vec<f64>, columns: &[usize], row: &[f64]| {
            (columns.iter().zip(row)).for_each(|(&column, value)| values[column] = *value);
        };
        if let Some((columns, rows)) = &self.file {
            set(&mut values, columns, &rows[in_memory(inner)]);
        }
        if let Some((columns, _)) = &self.outer {
            set(&mut values, columns, point);
        }
        values
    }

    /// The outer points with the intervals that they cover; absent without epistemic inputs.
    #[must_use]
    pub fn outer(&self) -> Option<&OuterPoints> {
        self.outer.as_ref().map(|(_, points)| points)
    }

    /// The same design with its first samples alone; for one whose samples do not depend on their number.
    #[must_use]
    pub fn first(&self, samples: u64) -> Self {
        Self {
            samples,
            ..self.clone()
        }
    }

    /// What is assumed of input `j`, in words.
    #[must_use]
    pub fn assumption(&self, j: usize) -> String {
        let distribution = &self.inputs[j].1;
        if self
            .outer
            .as_ref()
            .is_some_and(|(places, _)| places.contains(&j))
        {
            let [lower, upper] = distribution.support();
            let scale = match distribution.shape() {
                Shape::LogUniform { .. } => ", points even in the logarithm",
                _ => "",
            };
            return format!("known to an interval only: lower {lower:?}, upper {upper:?}{scale}");
        }
        match &self.file {
            Some((columns, _)) if columns.contains(&j) => "values of a file".to_owned(),
            _ if self.inputs[j].0.numbers_draws() => {
                "a number by which every contact is drawn, evenly within its friction limit"
                    .to_owned()
            }
            _ => distribution.to_string(),
        }
    }

    /// Where inputs are in the unit cube: their distribution functions. Shape: `[inputs]`, as `values`.
    #[must_use]
    pub fn place(&self, values: &[f64]) -> Vec<f64> {
        (self.inputs.iter().zip(values))
            .map(|((_, distribution), value)| distribution.cdf(*value))
            .collect()
    }

    /// Medians of the inputs.
    #[must_use]
    pub fn medians(&self) -> Vec<f64> {
        let laws = self.inputs.iter();
        laws.map(|(_, distribution)| distribution.quantile(0.5))
            .collect()
    }

    /// Values of the inputs at a place in the unit cube: their quantiles. The inverse of [`Design::place`].
    #[must_use]
    pub fn values_at(&self, place: &[f64]) -> Vec<f64> {
        (self.inputs.iter().zip(place))
            .map(|((_, distribution), share)| distribution.quantile(*share))
            .collect()
    }

    /// Outer point, replicate and place in its row of sample `i`.
    #[must_use]
    pub fn group(&self, i: u64) -> SampleGroup {
        let n_outer = self.outer_points();
        SampleGroup {
            outer: self.outer.as_ref().map(|_| in_32_bits(i % n_outer)),
            replicate: (self.plan.replicates()).map(|n| in_32_bits(i / n_outer % n)),
            place: self.plan.place(i).map(in_32_bits),
        }
    }

    /// Places among [`Design::inputs`] of those that are drawn from their distribution: not fixed, epistemic or from a file.
    #[must_use]
    pub fn drawn(&self) -> &[usize] {
        &self.drawn_places
    }

    /// The same in a pick-freeze design, whose mixed samples take one of them at a time from B, in the order of
    /// [`SampleGroup::place`]; empty for any other design.
    #[must_use]
    pub fn mixed_inputs(&self) -> &[usize] {
        match self.plan {
            Plan::PickFreeze(_) => &self.drawn_places,
            _ => &[],
        }
    }

    /// Whether inputs are correlated.
    #[must_use]
    pub fn is_correlated(&self) -> bool {
        self.correlation.is_some()
    }

    /// Correlation of the normal scores of the inputs that are drawn, in the order of [`Design::drawn`]; `None` where they are
    /// independent.
    #[must_use]
    pub fn correlation(&self) -> Option<&[Vec<f64>]> {
        self.correlation.as_deref()
    }

    /// Why the variance of a result is no sum of parts by the inputs, if that is so.
    #[must_use]
    pub fn indivisible(&self) -> Option<&'static str> {
        if self.is_correlated() {
            return Some("inputs are correlated");
        }
        if self.outer.is_some() {
            return Some("an epistemic input has no distribution");
        }
        if self.file.is_some() {
            return Some("inputs from a file have no distribution");
        }
        self.drawn.is_empty().then_some("no input is random")
    }

    /// Number of outer points; 1 without epistemic inputs.
    #[must_use]
    pub fn outer_points(&self) -> u64 {
        self.outer().map_or(1, |points| points.values.len() as u64)
    }

    /// To which numbers of samples, at each outer point, more samples leave the first ones as they are.
    #[must_use]
    pub fn growth(&self) -> Growth {
        match &self.file {
            Some((_, rows)) => Growth::UpTo(rows.len() as u64),
            None => self.plan.growth(),
        }
    }

    /// Kind of the design, as in study files.
    #[must_use]
    pub fn kind(&self) -> DesignKind {
        self.kind
    }

    /// The design in words.
    #[must_use]
    pub fn description(&self) -> String {
        let inner = self.samples / self.outer_points();
        let mut text = match &self.plan {
            Plan::Sobol { replicates, .. } => format!(
                "sobol, {} of {}",
                count(*replicates, "replicate"),
                count(inner / replicates, "point")
            ),
            Plan::PickFreeze(design) => {
                let (rows, row) = (inner / design.row(), design.row());
                format!("pick-freeze, {} of {row} samples", count(rows, "row"))
            }
            Plan::Grid(points) => {
                let sides: Vec<_> = points.iter().map(u64::to_string).collect();
                format!("grid of {} points", sides.join(" x "))
            }
            _ => format!("{}, {}", self.kind.name(), count(inner, "sample")),
        };
        if let Some(correlation) = &self.correlation {
            let pairs = correlated_pairs(&self.drawn, correlation);
            text.push_str(&format!(", correlated ({pairs} of the normal scores)"));
        }
        if self.outer.is_some() {
            let each = match self.outer_points() {
                1 => "1 outer point".to_owned(),
                n => format!("each of {n} outer points"),
            };
            text.push_str(&format!(" at {each}"));
        }
        text
    }
}

/// Correlations that are not 0, such as `a and b 0.7`.
fn correlated_pairs(inputs: &[Input], correlation: &[Vec<f64>]) -> String {
    let mut pairs = Vec::new();
    for (i, row) in correlation.iter().enumerate() {
        let others = row[..i].iter().enumerate();
        for (j, value) in others.filter(|(_, value)| **value != 0.0) {
            let [first, second] = [j, i].map(|k| inputs[k].name());
            let rounded = (1e4 * value).round() / 1e4;
            pairs.push(format!("{first} and {second} {rounded}"));
        }
    }
    pairs.join(", ")
}

/// Index into memory; a design never asks for more samples than it holds.
fn in_memory(i: u64) -> usize {
    usize::try_from(i).unwrap_or(usize::MAX)
}

/// A count as outcomes hold it: points, replicates and places of a design are in memory, and budgets bound the work of a sample, so
/// all are far below 2³².
pub(crate) fn in_32_bits<N: TryInto<u32>>(count: N) -> u32 {
    count.try_into().unwrap_or(u32::MAX)
}
