//! Designs compared on common random numbers, from the results of their runs.

use std::path::Path;

use super::output::OutputFolder;
use crate::Error;
use crate::report::StoredRun;
use crate::report::compare::{self, DesignComparison};
use crate::report::run::CHANGED;

/// Compares the runs in `folders` sample by sample, and writes `comparison.json` and `comparison.html` into `output`.
///
/// Nothing is solved. The runs must have the same seed, design of the samples, levels and inputs; an input whose
/// distribution differs is taken as a part of the designs, any other must have the same values in every sample.
///
/// # Errors
/// [`Error::Report`] if a folder holds no results; [`Error::Results`] on the first run that cannot be paired with the
/// first of them, or with fewer than two runs; [`Error::File`] or [`Error::Report`] if the results cannot be written.
pub fn compare(folders: &[&Path], output: &OutputFolder) -> Result<DesignComparison, Error> {
    for (i, folder) in folders.iter().enumerate() {
        let same = |other: &&&Path| other.canonicalize().ok() == folder.canonicalize().ok();
        if folder.exists() && folders[..i].iter().any(|other| same(&other)) {
            return Err(Error::results(
                folder,
                "is given twice: a comparison needs the results of different runs",
            ));
        }
    }
    let runs: Vec<StoredRun> = (folders.iter())
        .map(|folder| StoredRun::read(folder).map(StoredRun::without_search))
        .collect::<Result<_, _>>()?;
    let [first, others @ ..] = runs.as_slice() else {
        return Err(too_few(output));
    };
    if others.is_empty() {
        return Err(too_few(output));
    }
    for (folder, run) in folders.iter().zip(&runs) {
        if let Some(name) = run.changed.first() {
            return Err(Error::results(folder, format!("{name} {CHANGED}")));
        }
        check(run, first).map_err(|reason| {
            let (other, extended) = (
                folders[0].display(),
                extended(folders[0], folder, first, run),
            );
            let message = format!("cannot be compared with {other}: {reason}{extended}");
            Error::results(folder, message)
        })?;
    }
    let comparison = DesignComparison::of(folders, &runs);
    compare::write(output.path(), &comparison, &runs)?;
    Ok(comparison)
}

fn too_few(output: &OutputFolder) -> Error {
    Error::results(
        output.path(),
        "a comparison needs the results of two runs at least",
    )
}

/// The command that adds the samples that one of two runs lacks; empty where their number is not what differs, or cannot be reached.
fn extended(that: &Path, this: &Path, first: &StoredRun, run: &StoredRun) -> String {
    let [least, most] = [first, run].map(|run| run.outcomes.len() as u64);
    let (folder, fewer, wanted) = match least < most {
        true => (that, first, most),
        false => (this, run, least),
    };
    let design = |run: &StoredRun| {
        let (record, seed) = (&run.record.design, run.record.provenance.seed);
        (record.kind, record.outer_points, seed)
    };
    let each = wanted / fewer.record.design.outer_points.max(1);
    let reached = fewer.record.design.growth.total(each) == Some(each);
    match least != most && design(first) == design(run) && reached {
        true => format!(
            "; `microslip extend {} --samples {wanted}` adds the missing samples",
            folder.display()
        ),
        false => String::new(),
    }
}

/// Whether the samples of `run` pair with those of `first` by index.
fn check(run: &StoredRun, first: &StoredRun) -> Result<(), String> {
    let (this, that) = (&run.record, &first.record);
    let same = |what: &str, this: String, that: String| match this == that {
        true => Ok(()),
        false => Err(format!("its {what} is {this}, there {that}")),
    };
    let seed = |run: &StoredRun| run.record.provenance.seed.to_string();
    same("seed", seed(run), seed(first))?;
    let design = |run: &StoredRun| run.record.design.description.clone();
    same("design of the samples", design(run), design(first))?;
    same(
        "list of levels",
        format!("{:?}", this.levels),
        format!("{:?}", that.levels),
    )?;
    same(
        "unit of the levels",
        this.level_unit.clone(),
        that.level_unit.clone(),
    )?;
    let names = |run: &StoredRun| {
        let names: Vec<_> = run.record.inputs.iter().map(|i| i.name.as_str()).collect();
        names.join(", ")
    };
    same("list of random inputs", names(run), names(first))?;
    same(
        "number of samples",
        run.outcomes.len().to_string(),
        first.outcomes.len().to_string(),
    )?;
    check_values(run, first)
}

/// Every sample has the index and the outer point of the other, and its values of the inputs with the same distribution.
fn check_values(run: &StoredRun, first: &StoredRun) -> Result<(), String> {
    let common: Vec<usize> = (0..run.record.inputs.len())
        .filter(|&j| run.record.inputs[j].prior == first.record.inputs[j].prior)
        .collect();
    for (this, that) in run.outcomes.iter().zip(&first.outcomes) {
        if this.index != that.index || this.group != that.group {
            return Err(format!(
                "its sample {} stands where sample {} is there",
                this.index, that.index
            ));
        }
        if let Some(&j) = common.iter().find(|&&j| this.inputs[j] != that.inputs[j]) {
            let (name, index) = (&run.record.inputs[j].name, this.index);
            return Err(format!(
                "sample {index} has another {name} although its distribution is the same"
            ));
        }
    }
    Ok(())
}
