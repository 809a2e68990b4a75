//! What a study says about its samples, and the design that is made of it.

use super::correlation::{Copula, CorrelationTable, KnownCorrelation, correlation_matrix};
use super::design::Design;
use super::distribution::{Distribution, Shape};
use super::file::SampleTable;
use super::input::Input;
use super::outer::{EpistemicInterval, EpistemicTable, OuterPoints, Scale};
use super::plan::{DesignKind, DesignTable, Plan};
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
    /// Correlations of inputs that another file states.
    pub known_correlation: Option<KnownCorrelation>,
    /// `[epistemic]`.
    pub epistemic: Option<EpistemicTable>,
    /// Content of the file that `[design]` names.
    pub file: Option<SampleTable>,
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
        let (table, known) = (&self.correlation, &self.known_correlation);
        let correlation = correlation_matrix(table.as_ref(), known.as_ref(), &drawn);
        let correlation = correlation.map_err(|bad| bad.under("correlation"))?;
        refuse_correlated_draws(&drawn, correlation.as_deref())?;
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
            correlation,
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
            if let (None, Some(known)) = (&self.correlation, &self.known_correlation)
                && bad.key == "correlation"
            {
                bad.key = "inputs.from".to_owned();
                bad.value = format!("{:?}, with correlated inputs", known.origin);
            }
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
                Uncertainty::Epistemic(_) if input.numbers_draws() => {
                    let rule = "must be \"aleatory\": its values only number the draws of a field, so that none is worse than others";
                    Err(BadSetting::new("kind", "\"epistemic\"", rule))
                }
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

/// Refuses a correlation with an input whose values only number draws.
fn refuse_correlated_draws(
    drawn: &[Input],
    correlation: Option<&[Vec<f64>]>,
) -> Result<(), BadSetting> {
    let correlated = |&(k, input): &(usize, &Input)| {
        let row = correlation.map_or(&[][..], |matrix| &matrix[k]);
        input.numbers_draws() && row.iter().enumerate().any(|(j, rho)| j != k && *rho != 0.0)
    };
    let found = drawn.iter().enumerate().find(correlated);
    let name = found.map_or("", |(_, input)| input.name());
    let rule =
        "must be independent of all other inputs: its values only number the draws of a field";
    BadSetting::unless(found.is_none(), "correlation.pairs", name, rule)
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
