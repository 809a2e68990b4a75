//! The samples of a run under other distributions of their inputs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::draws::{DrawsDensity, LEAST_DRAWS, MOST_DRAWS, distance, largest_distance};
use super::output::OutputFolder;
use super::settings::document::Document;
use crate::Error;
use crate::file::FileError;
use crate::report::StoredRun;
use crate::report::reweighting::{LEAST_EFFECTIVE_SAMPLES, ReweightedInput, Reweighting};
use crate::report::run::require_unchanged;
use crate::sampling::{Distribution, DistributionTable, Input, SampleTable, Uncertainty};
use crate::statistics::{Weights, hull};

/// Name of the file that [`reweight`] writes.
pub const REWEIGHTED: &str = "reweighted.json";
/// Largest probability of a new distribution beyond the values of the samples: their ends leave 2/(n + 1) of their own
/// distribution outside on average, which is this at n = 39.
const MOST_BEYOND: f64 = 0.05;

/// An input whose distribution changes.
struct Change {
    /// Its place among the values of a sample.
    column: usize,
    name: String,
    new: Distribution,
    old: Distribution,
}

/// What the samples stand for.
#[derive(Debug, Clone)]
pub enum NewInputs {
    /// Distributions `[inputs.*]` of a TOML file.
    Distributions(PathBuf),
    /// Draws, one row each, such as `posterior.csv` of a calibration.
    Draws(PathBuf),
}

/// Statistics of the samples in `folder` under other distributions of their inputs, written to `reweighted.json` in `output`. Inputs
/// that the file does not name keep theirs. Nothing is solved.
///
/// # Errors
/// [`Error::Study`] with line, key and rule if the file breaks one: an input that the run did not draw, a distribution
/// beyond the range that was sampled. [`Error::Results`] if the folder holds no results, its inputs are correlated, or the
/// weights leave too few effective samples; [`Error::File`] or [`Error::Report`] on files.
pub fn reweight(
    folder: &Path,
    new: &NewInputs,
    output: &OutputFolder,
) -> Result<Reweighting, Error> {
    let refused = |message: String| Error::results(folder, message);
    require_unchanged(folder)?;
    let run = StoredRun::read(folder)?;
    let (path, [new, old], inputs) = match new {
        NewInputs::Distributions(path) => {
            let text = crate::file::read_text(path)?;
            let (densities, inputs) = of_distributions(&run, &changes(&run, path, &text)?);
            (path, densities, inputs)
        }
        NewInputs::Draws(path) => {
            let (ratios, inputs) = of_draws(&run, path)?;
            let old = vec![1.0; ratios.len()];
            (path, [ratios, old], inputs)
        }
    };
    let found = Reweighting::of(&run, inputs, [&new, &old]).map_err(|left| {
        let place = left.outer.map_or_else(String::new, |o| format!(" at outer point {o}"));
        let (effective, samples) = (left.effective_samples, left.samples);
        refused(format!(
            "{samples} samples count for {effective:.1}{place} under the distributions of {}: must be at least \
             {LEAST_EFFECTIVE_SAMPLES}; a distribution closer to the sampled one, or more samples (`extend`)",
            path.display()
        ))
    })?;
    output.write(REWEIGHTED, |file| {
        serde_json::to_writer_pretty(&mut *file, &found)?;
        writeln!(file)
    })?;
    Ok(found)
}

/// New and old densities of the samples, and the inputs in words.
fn of_distributions(run: &StoredRun, changes: &[Change]) -> ([Vec<f64>; 2], Vec<ReweightedInput>) {
    let density = |of: fn(&Change) -> &Distribution| -> Vec<f64> {
        let product = |inputs: &[f64]| -> f64 {
            let factor = |c: &Change| of(c).density(inputs[c.column]).unwrap_or(0.0);
            changes.iter().map(factor).product()
        };
        run.outcomes.iter().map(|o| product(&o.inputs)).collect()
    };
    let inputs = (changes.iter())
        .map(|change| ReweightedInput {
            name: change.name.clone(),
            sampled: change.old.to_string(),
            reweighted: change.new.to_string(),
            distance: None,
        })
        .collect();
    ([density(|c| &c.new), density(|c| &c.old)], inputs)
}

/// New over old densities of the samples where the file `path` has draws, and the inputs in words.
fn of_draws(run: &StoredRun, path: &Path) -> Result<(Vec<f64>, Vec<ReweightedInput>), Error> {
    let refused = |rule: String| Error::from(FileError::content(path, None, rule));
    let table = SampleTable::read(path)?;
    let count = table.rows.len();
    if count < LEAST_DRAWS {
        let rule = format!("has {count} draws: must have at least {LEAST_DRAWS}");
        return Err(refused(rule));
    }
    // chains alternate in the file of a calibration: its first rows are of all of them
    let draws = &table.rows[..count.min(MOST_DRAWS)];
    let columns = drawn_inputs(run, &table).map_err(refused)?;
    let laws: Vec<&Distribution> = columns.iter().map(|(_, law)| *law).collect();
    let outcomes = run.outcomes.iter();
    let samples: Vec<Vec<f64>> = outcomes
        .map(|o| columns.iter().map(|(j, _)| o.inputs[*j]).collect())
        .collect();
    let density = DrawsDensity::of(draws, &laws).map_err(|(column, rule)| {
        let at = column.map_or_else(String::new, |j| {
            format!("column {}: ", table.inputs[j].name())
        });
        refused(format!("{at}{rule}"))
    })?;
    let ratios = density.ratios(&samples, &laws);
    let weights = Weights::of_densities(&ratios, &vec![1.0; ratios.len()])
        .ok_or_else(|| refused("has draws that no sample is near to".to_owned()))?;
    let mut inputs = Vec::new();
    for (j, law) in laws.iter().enumerate() {
        let name = table.inputs[j].name().to_owned();
        let distance = distance_of(j, &samples, &weights, draws)
            .map_err(|rule| refused(format!("column {name}: {rule}")))?;
        inputs.push(ReweightedInput {
            name,
            sampled: law.to_string(),
            reweighted: format!("{} draws", draws.len()),
            distance: Some(distance),
        });
    }
    Ok((ratios, inputs))
}

/// Columns of the run's inputs that a table of draws has, and the distributions they were drawn from.
fn drawn_inputs<'a>(
    run: &'a StoredRun,
    table: &SampleTable,
) -> Result<Vec<(usize, &'a Distribution)>, String> {
    if run.record.design.correlated {
        let rule =
            "must belong to a study without correlated inputs: their densities are no product";
        return Err(rule.to_owned());
    }
    let inputs = &run.record.inputs;
    let drawn = |name: &str| {
        let j = inputs.iter().position(|input| input.name == name)?;
        Some((j, inputs[j].distribution.as_ref()?))
    };
    if let Some(input) = table.inputs.iter().find(|input| input.numbers_draws()) {
        let rule = "must be absent: its values only number the draws of a field";
        return Err(format!("column {}: {rule}", input.name()));
    }
    let names = table.inputs.iter().map(|input| input.name());
    let rule = "must be an input that the study draws from a distribution";
    names
        .map(|name| drawn(name).ok_or_else(|| format!("column {name}: {rule}")))
        .collect()
}

/// Distance of weighted samples and draws in column j, or why they do not stand for the draws.
fn distance_of(
    j: usize,
    samples: &[Vec<f64>],
    weights: &Weights,
    draws: &[Vec<f64>],
) -> Result<f64, String> {
    let [of_samples, of_draws] =
        [samples, draws].map(|rows| rows.iter().map(|r| r[j]).collect::<Vec<f64>>());
    let distance = distance(&of_samples, weights.values(), &of_draws);
    let effective = weights.effective_sample_size();
    // fewer effective samples than a statement needs have a message of their own
    if effective >= LEAST_EFFECTIVE_SAMPLES && distance > largest_distance(effective) {
        return Err(format!(
            "the weighted samples do not have its distribution (the functions are {distance:.2} apart): a run that covers the \
             draws better, or a study with [design] kind = \"file\""
        ));
    }
    Ok(distance)
}

/// Reads the new distributions and finds the old ones.
fn changes(run: &StoredRun, path: &Path, text: &str) -> Result<Vec<Change>, Error> {
    let mut document = Document::parse(path, text)?;
    let tables: BTreeMap<String, DistributionTable> = document.take("inputs")?.unwrap_or_default();
    document.finish(&["inputs"])?;
    if tables.is_empty() {
        let rule = "must hold the new distribution of an input: [inputs.NAME]";
        return Err(document.at_key("inputs", rule.to_owned()));
    }
    if run.record.design.correlated {
        let rule =
            "must belong to a study without correlated inputs: their densities are no product";
        return Err(document.at_key("inputs", rule.to_owned()));
    }
    let mut changes = Vec::new();
    for (name, table) in &tables {
        let key = format!("inputs.{name}");
        let column = run
            .record
            .inputs
            .iter()
            .position(|input| input.name == *name);
        let old = column.and_then(|j| run.record.inputs[j].distribution.clone());
        let (Some(column), Some(old), Some(input)) = (column, old, Input::from_name(name)) else {
            let rule = match column.is_some_and(|j| run.record.inputs[j].distribution.is_some()) {
                true => {
                    "must be an input that [inputs] of a study can name: this one comes from the model"
                }
                false => "must be an input that the study draws from a distribution",
            };
            return Err(document.at_key(&key, rule.to_owned()));
        };
        let uncertainty = document.checked(table.uncertainty().map_err(|bad| bad.under(&key)))?;
        let Uncertainty::Aleatory(new) = uncertainty else {
            let rule = "must be a distribution: an interval gives no weights";
            return Err(document.at_key(&key, rule.to_owned()));
        };
        document.checked(input.accepts(&new).map_err(|bad| bad.under(&key)))?;
        let values = run.outcomes.iter().map(|outcome| outcome.inputs[column]);
        check_range(&new, &old, values).map_err(|rule| document.at_key(&key, rule))?;
        changes.push(Change {
            column,
            name: name.clone(),
            new,
            old,
        });
    }
    Ok(changes)
}

/// A part of the new distribution that the samples do not reach stays unseen whatever the weights.
fn check_range(
    new: &Distribution,
    old: &Distribution,
    values: impl Iterator<Item = f64>,
) -> Result<(), String> {
    if new.fixed_value().is_some() {
        return Err("must have a density: one value alone gives no weights".to_owned());
    }
    let ([low, high], [from, to]) = (new.support(), old.support());
    if low < from || high > to {
        return Err(format!(
            "must lie in the sampled range {from} .. {to}, not {low} .. {high}; cut it with truncation = [low, high]"
        ));
    }
    let Some([least, largest]) = hull(values) else {
        return Err("must lie where the samples are: there are none".to_owned());
    };
    let beyond = new.cdf(least) + 1.0 - new.cdf(largest);
    if beyond > MOST_BEYOND {
        return Err(format!(
            "must lie where the samples are: {:.0} % of it are outside of their values {least:.4} .. {largest:.4}",
            100.0 * beyond
        ));
    }
    Ok(())
}
