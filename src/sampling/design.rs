//! The inputs of sample i, under every kind of design.

use super::correlation::{Copula, CorrelationTable};
use super::distribution::{Distribution, Shape};
use super::file::SampleTable;
use super::input::Input;
use super::outer::{EpistemicInterval, EpistemicTable, OuterPoints, Scale};
use super::pick_freeze::is_independent;
use super::plan::{DesignKind, DesignTable, Growth, Plan};
use super::table::Uncertainty;
use crate::setting::BadSetting;

/// Everything that a study says about its samples.
#[derive(Debug, Clone, Default)]
pub struct DesignSettings {
    /// The seed.
    pub seed: u64,
    /// Number of samples; absent where the design decides it.
    pub samples: Option<u64>,
    /// `[design]`.
    pub design: DesignTable,
    /// `[inputs.*]`.
    pub inputs: Vec<(Input, Uncertainty)>,
    /// `[correlation]`.
    pub correlation: Option<CorrelationTable>,
    /// `[epistemic]`.
    pub epistemic: Option<EpistemicTable>,
    /// Content of the file that `[design]` names.
    pub file: Option<SampleTable>,
}

/// Random inputs, how they are drawn, and the seed that all samples come from.
///
/// A nested design has outer points over the epistemic inputs. Sample i belongs to outer point i mod (outer points), and
/// its random numbers are those of inner sample ⌊i / outer points⌋: the same at every outer point.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    seed: u64,
    samples: u64,
    kind: DesignKind,
    inputs: Vec<(Input, Distribution)>,
    /// Inputs that are drawn: not fixed, epistemic or from a file; and their places among all.
    drawn: Vec<Input>,
    drawn_places: Vec<usize>,
    plan: Plan,
    /// Whether inputs are correlated, in the plan or by the copula.
    correlated: bool,
    copula: Option<Copula>,
    file: Option<(Vec<usize>, Vec<Vec<f64>>)>,
    outer: Option<(Vec<usize>, OuterPoints)>,
}

/// What a sample belongs to, beside its design.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SampleGroup {
    /// Outer point of a nested design.
    pub outer: Option<u64>,
    /// Replicate of a quasi-random design with several.
    pub replicate: Option<u64>,
    /// Place in a row of a pick-freeze design: 0 = A, 1 = B, 2 + j = A with the j-th random input of B.
    pub place: Option<u64>,
}

impl SampleGroup {
    /// Whether the sample is a draw of the population. Mixed samples of a pick-freeze design share their inputs with
    /// others, so no statistic of the population may count them.
    #[must_use]
    pub fn of_population(&self) -> bool {
        self.place.is_none_or(is_independent)
    }
}

impl Design {
    /// A Monte Carlo design of the given inputs, put in the order of [`Input`].
    ///
    /// # Errors
    /// [`BadSetting`] on `<input>` or `<input>.<parameter>`: an input twice, or a distribution that gives it values
    /// without meaning.
    pub fn new(seed: u64, inputs: Vec<(Input, Distribution)>) -> Result<Self, BadSetting> {
        let uncertain = |(input, distribution)| (input, Uncertainty::Aleatory(distribution));
        let settings = DesignSettings {
            seed,
            inputs: inputs.into_iter().map(uncertain).collect(),
            ..DesignSettings::default()
        };
        settings.build().map_err(|mut bad| {
            if let Some(key) = bad.key.strip_prefix("inputs.") {
                bad.key = key.to_owned();
            }
            bad
        })
    }

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
        let column = |(columns, rows): &(Vec<usize>, Vec<Vec<f64>>)| {
            let column = columns.iter().position(|c| *c == place)?;
            let values = rows.iter().map(|row| row[column]);
            Some(
                values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                    [v.min(low), v.max(high)]
                }),
            )
        };
        let in_file = self.file.as_ref().and_then(column);
        in_file.unwrap_or_else(|| self.inputs[place].1.support())
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

    /// Outer point, replicate and place in its row of sample `i`.
    #[must_use]
    pub fn group(&self, i: u64) -> SampleGroup {
        let n_outer = self.outer_points();
        SampleGroup {
            outer: self.outer.as_ref().map(|_| i % n_outer),
            replicate: self.plan.replicates().map(|n| i / n_outer % n),
            place: self.plan.place(i),
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

    /// Why the variance of a result is no sum of parts by the inputs, if that is so.
    #[must_use]
    pub fn indivisible(&self) -> Option<&'static str> {
        if self.correlated {
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
        self.plan.growth()
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
                "sobol, {replicates} {} of {} points",
                if *replicates == 1 {
                    "replicate"
                } else {
                    "replicates"
                },
                inner / replicates
            ),
            Plan::PickFreeze(design) => {
                let (rows, row) = (inner / design.row(), design.row());
                let word = if rows == 1 { "row" } else { "rows" };
                format!("pick-freeze, {rows} {word} of {row} samples")
            }
            Plan::Grid(points) => {
                let sides: Vec<_> = points.iter().map(u64::to_string).collect();
                format!("grid of {} points", sides.join(" x "))
            }
            _ => format!("{}, {inner} samples", self.kind.name()),
        };
        if self.copula.is_some() {
            text.push_str(", correlated");
        }
        if self.outer.is_some() {
            let n = self.outer_points();
            text.push_str(&format!(" at each of {n} outer points"));
        }
        text
    }
}

/// Index into memory; a design never asks for more samples than it holds.
fn in_memory(i: u64) -> usize {
    usize::try_from(i).unwrap_or(usize::MAX)
}

impl DesignSettings {
    /// Checks the settings against each other and makes the design.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to the study file.
    pub fn build(mut self) -> Result<Design, BadSetting> {
        self.inputs.sort_by_key(|(input, _)| *input);
        self.check_inputs().map_err(|bad| bad.under("inputs"))?;
        let outer = self.outer()?;
        self.check_pick_freeze()?;
        let n_outer = outer
            .as_ref()
            .map_or(1, |points| points.values.len() as u64);
        let inputs = self.all_inputs()?;
        let places = |wanted: &dyn Fn(Input) -> bool| -> Vec<usize> {
            (0..inputs.len()).filter(|&k| wanted(inputs[k].0)).collect()
        };
        let epistemic = |input: Input| self.interval(input).is_some();
        let drawn_places: Vec<usize> = places(&|input| !epistemic(input) && !self.in_file(input))
            .into_iter()
            .filter(|&k| inputs[k].1.fixed_value().is_none())
            .collect();
        let drawn: Vec<Input> = drawn_places.iter().map(|&k| inputs[k].0).collect();
        let correlation = (self.correlation.as_ref())
            .map(|table| table.matrix(&drawn).map_err(|bad| bad.under("correlation")))
            .transpose()?;
        let (plan, inner) = self.plan(n_outer, &drawn, correlation.as_deref())?;
        let samples = number_of_samples(inner.saturating_mul(n_outer))?;
        // a hypercube has the correlation in the order of its strata
        let copula = match plan {
            Plan::LatinHypercube(_) => None,
            _ => correlation.as_deref().and_then(Copula::new),
        };
        let outer_places = places(&epistemic);
        let file = self.file.as_ref().map(|file| {
            let place = |input| inputs.iter().position(|(other, _)| other == input);
            let columns = file.inputs.iter().filter_map(place).collect();
            (columns, file.rows.clone())
        });
        Ok(Design {
            seed: self.seed,
            samples,
            kind: self.design.kind,
            drawn,
            drawn_places,
            plan,
            correlated: correlation.is_some(),
            copula,
            file,
            outer: outer.map(|points| (outer_places, points)),
            inputs,
        })
    }

    /// The plan and the number of samples at each outer point.
    fn plan(
        &self,
        n_outer: u64,
        drawn: &[Input],
        correlation: Option<&[Vec<f64>]>,
    ) -> Result<(Plan, u64), BadSetting> {
        let inner = self.inner_samples(n_outer)?;
        let planned = self.design.plan(self.seed, inner, drawn, correlation);
        let (plan, count) = planned.map_err(|mut bad| {
            if bad.key == "samples" && n_outer > 1 {
                bad.rule = format!("at each of the {n_outer} outer points: {}", bad.rule);
            }
            bad
        })?;
        let rows = self.file.as_ref().map(|file| file.rows.len() as u64);
        let inner = inner.or(count).or(rows).unwrap_or(1);
        let enough = rows.is_none_or(|rows| inner <= rows);
        let rule = match rows {
            Some(rows) => format!(
                "must be at most {}: the file has {rows} rows",
                rows * n_outer
            ),
            None => String::new(),
        };
        BadSetting::unless(enough, "samples", inner * n_outer, &rule)?;
        Ok((plan, inner))
    }

    fn check_inputs(&self) -> Result<(), BadSetting> {
        for pair in self.inputs.windows(2) {
            let twice = pair[0].0 == pair[1].0;
            BadSetting::unless(!twice, pair[0].0.name(), "twice", "must be given once")?;
        }
        for (input, uncertainty) in &self.inputs {
            let accepted = match uncertainty {
                Uncertainty::Aleatory(distribution) => input.accepts(distribution),
                Uncertainty::Epistemic(known) => (input.accepts_value("lower", known.lower))
                    .and_then(|()| input.accepts_value("upper", known.upper)),
            };
            accepted.map_err(|bad| bad.under(input.name()))?;
            let in_file = self.in_file(*input);
            let rule = "must be absent: it is a column of the file of [design]";
            BadSetting::unless(!in_file, input.name(), "(given)", rule)?;
        }
        Ok(())
    }

    /// Sobol' indices are shares of a variance, and an interval has none.
    fn check_pick_freeze(&self) -> Result<(), BadSetting> {
        let inputs = self.inputs.iter().map(|(input, _)| *input);
        let interval = inputs
            .filter(|_| self.design.kind == DesignKind::PickFreeze)
            .find(|input| self.interval(*input).is_some());
        let key =
            interval.map_or_else(String::new, |input| format!("inputs.{}.kind", input.name()));
        let rule = "must be \"aleatory\" in a pick-freeze design: an interval has no variance to share out";
        BadSetting::unless(interval.is_none(), &key, "\"epistemic\"", rule)
    }

    fn in_file(&self, input: Input) -> bool {
        self.file.iter().any(|file| file.inputs.contains(&input))
    }

    /// The interval of an epistemic input.
    fn interval(&self, input: Input) -> Option<EpistemicInterval> {
        let (_, uncertainty) = self.inputs.iter().find(|(other, _)| *other == input)?;
        match uncertainty {
            Uncertainty::Epistemic(interval) => Some(*interval),
            Uncertainty::Aleatory(_) => None,
        }
    }

    fn outer(&self) -> Result<Option<OuterPoints>, BadSetting> {
        let intervals: Vec<EpistemicInterval> = (self.inputs.iter())
            .filter_map(|(input, _)| self.interval(*input))
            .collect();
        if intervals.is_empty() {
            let rule = "must be absent: no input is of kind \"epistemic\"";
            BadSetting::unless(self.epistemic.is_none(), "epistemic", "(given)", rule)?;
            return Ok(None);
        }
        let table = self.epistemic.clone().unwrap_or_default();
        let points = table.cover(self.seed, &intervals);
        points.map(Some).map_err(|bad| bad.under("epistemic"))
    }

    /// Samples at each outer point.
    fn inner_samples(&self, n_outer: u64) -> Result<Option<u64>, BadSetting> {
        let Some(samples) = self.samples else {
            return Ok(None);
        };
        number_of_samples(samples)?;
        let rule =
            format!("must be a multiple of the {n_outer} outer points over the epistemic inputs");
        BadSetting::unless(samples.is_multiple_of(n_outer), "samples", samples, &rule)?;
        Ok(Some(samples / n_outer))
    }

    /// All inputs with their distributions, in order.
    fn all_inputs(&self) -> Result<Vec<(Input, Distribution)>, BadSetting> {
        let mut inputs = Vec::new();
        for (input, uncertainty) in &self.inputs {
            let distribution = match uncertainty {
                Uncertainty::Aleatory(distribution) => distribution.clone(),
                Uncertainty::Epistemic(known) => {
                    let (low, high) = (known.lower, known.upper);
                    let shape = match known.scale {
                        Scale::Linear => Shape::Uniform { low, high },
                        Scale::Log => Shape::LogUniform { low, high },
                    };
                    Distribution::new(shape, None)?
                }
            };
            inputs.push((*input, distribution));
        }
        for input in self.file.iter().flat_map(|file| &file.inputs) {
            inputs.push((*input, scale_of_file()?));
        }
        inputs.sort_by_key(|(input, _)| *input);
        Ok(inputs)
    }
}

/// Most samples of a study: beyond it the tables of the report do not fit into memory.
pub const MOST_SAMPLES: u64 = 100_000_000;

fn number_of_samples(samples: u64) -> Result<u64, BadSetting> {
    let rule = format!("must be from 1 to {MOST_SAMPLES}");
    let holds = (1..=MOST_SAMPLES).contains(&samples);
    BadSetting::unless(holds, "samples", samples, &rule)?;
    Ok(samples)
}

/// Scale of a file's values, the same whatever rows it has: seven decades around 1.
fn scale_of_file() -> Result<Distribution, BadSetting> {
    let shape = Shape::Lognormal {
        median: 1.0,
        log_standard_deviation: 2.0,
    };
    Distribution::new(shape, None)
}
