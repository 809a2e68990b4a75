//! A run read back from its folder, and whether its files are still those that it wrote.

use super::input::{RESULTS, ReportInput};
use super::record::{CONTROL_VARIATE, FURTHER_POINTS, RECORD, RunRecord, TABLES};
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::store::{read_curves, read_samples};
use crate::file::FileError;
use std::path::Path;

/// A run read back from its folder.
#[derive(Debug, Clone)]
pub struct StoredRun {
    /// `run.json`.
    pub record: RunRecord,
    /// Outcomes of the population with their curves.
    pub outcomes: Vec<SampleOutcome>,
    /// Outcomes of the mixed samples of a pick-freeze design, which belong to no population.
    pub mixed: Vec<SampleOutcome>,
    /// Outcomes of the control variate on few harmonics; empty without.
    pub control: Vec<SampleOutcome>,
    /// Files whose content is not that of the run.
    pub changed: Vec<String>,
    /// Folder of the results in commands that a reader may give.
    pub folder: String,
}

/// Refuses a folder with files that are not those that the run wrote: what is computed from them would pass for its results.
///
/// # Errors
/// [`FileError`] on the first such file.
pub fn require_unchanged(folder: &Path) -> Result<(), FileError> {
    let (record, intact) = RunRecord::read(folder)?;
    let own = (!intact).then(|| RECORD.to_owned());
    match own.into_iter().chain(record.changed(folder)).next() {
        None => Ok(()),
        Some(name) => Err(FileError::content(&folder.join(name), None, CHANGED)),
    }
}

/// What is wrong with a changed file.
pub const CHANGED: &str = "is not the file that the run wrote";

impl StoredRun {
    /// What a report is made from.
    #[must_use]
    pub fn input(&self) -> ReportInput<'_> {
        ReportInput {
            record: &self.record,
            outcomes: &self.outcomes,
            mixed: &self.mixed,
            control: &self.control,
            changed: &self.changed,
            folder: &self.folder,
        }
    }

    /// The same without the points that a search has met: they are others in each study, so that nothing pairs with them.
    #[must_use]
    pub fn without_search(mut self) -> Self {
        let points = self.record.design.outer_points;
        let of_design =
            |o: &SampleOutcome| o.group.outer.is_none_or(|point| u64::from(point) < points);
        self.outcomes.retain(of_design);
        self
    }

    /// Reads what a run left in `folder`.
    ///
    /// # Errors
    /// [`FileError`] with the file that is absent or not what a run writes.
    pub fn read(folder: &Path) -> Result<Self, FileError> {
        let (record, intact) = RunRecord::read(folder)?;
        let [samples, curves] = TABLES.map(|name| folder.join(name));
        let mut stored = read_samples(&samples)?;
        read_curves(&curves, &mut stored.outcomes)?;
        if record.design.further_points > 0 {
            let further = read_samples(&folder.join(FURTHER_POINTS))?;
            stored.outcomes.extend(further.outcomes);
        }
        let control = match record.control_variate {
            Some(_) => read_samples(&folder.join(CONTROL_VARIATE))?.outcomes,
            None => Vec::new(),
        };
        let own = (!intact).then(|| RECORD.to_owned());
        let changed = own.into_iter().chain(record.changed(folder)).collect();
        let shape = |o: &SampleOutcome| {
            o.levels.len() == record.levels.len() && o.inputs.len() == record.inputs.len()
        };
        if !stored.outcomes.iter().chain(&control).all(shape) {
            let rule = format!("must have the levels and inputs of {RECORD} in every sample");
            return Err(FileError::content(&samples, None, rule));
        }
        // a copy of a million samples would take as much memory as they do
        let mut outcomes = stored.outcomes;
        let mixed = outcomes.extract_if(.., |outcome| !outcome.group.of_population());
        let mixed = mixed.collect();
        Ok(Self {
            outcomes,
            mixed,
            control,
            changed,
            folder: in_commands(folder, &record),
            record,
        })
    }
}

/// Name of the folder of an engine order among those of a run that takes several.
#[must_use]
pub fn order_folder(order: u32) -> String {
    format!("order-{order}")
}

/// The engine order whose folder has this name, if one has.
#[must_use]
pub fn order_of_folder(name: &str) -> Option<u32> {
    let order = name.strip_prefix("order-")?.parse().ok()?;
    (order_folder(order) == name).then_some(order)
}

/// The engine order of the run in `folder`; absent for a run of no disk.
///
/// # Errors
/// [`FileError`] if its record is absent or not what a run writes.
pub fn engine_order(folder: &Path) -> Result<Option<u32>, FileError> {
    let (record, _) = RunRecord::read(folder)?;
    Ok(record.disk.map(|disk| disk.engine_order))
}

/// The folder as commands name it: [`RESULTS`] wherever it lies, so that a report stays the same where results are moved; inside it the
/// folder of one of several engine orders, since the folder above has no samples of its own.
fn in_commands(folder: &Path, record: &RunRecord) -> String {
    let named = |order| {
        let own = order_folder(order);
        let absolute = folder.canonicalize().ok()?;
        // files that are not in their places yet lie in a folder inside it
        let mut near = absolute.ancestors().take(2);
        near.find(|path| path.ends_with(&own))?;
        Some(format!("{RESULTS}/{own}"))
    };
    let order = record.disk.as_ref().map(|disk| disk.engine_order);
    order.and_then(named).unwrap_or_else(|| RESULTS.to_owned())
}
