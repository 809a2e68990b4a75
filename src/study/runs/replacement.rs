//! What a run may put in the place of the results in its folder.

use super::resume::{accepted, as_asked, identity, stated_identity};
use super::run_settings::RunSettings;
use crate::Error;
use crate::ensemble::parts::{RunIdentity, more_samples, more_samples_of_any_order};
use crate::ensemble::store::{ATLAS_FILE, read_study};
use crate::file::{finish_placing, refuse_inputs};
use crate::report::run::{RECORD, TABLES};
use crate::report::{REPORT_FILES, RunRecord};
use crate::study::output::{OPTIONAL_TABLES, OutputFolder};
use crate::study::settings::read::Study;

/// The run that `study` makes in `folder` with this program, before anything is solved for it.
///
/// # Errors
/// [`Error::File`] if a file of the study cannot be read; [`Error::Results`] if `folder` holds results of this run with more samples.
pub(super) fn admitted(study: &Study, folder: &OutputFolder) -> Result<RunIdentity, Error> {
    let identity = identity(study, folder)?;
    refuse_fewer(study, folder, &identity)?;
    Ok(identity)
}

/// Refuses results that would replace a file of their own study.
///
/// # Errors
/// [`Error::File`] on the first one.
pub(super) fn refuse_own_inputs(study: &Study, folder: &OutputFolder) -> Result<(), Error> {
    let optional = OPTIONAL_TABLES.into_iter().chain([ATLAS_FILE, RECORD]);
    let names = TABLES.into_iter().chain(REPORT_FILES).chain(optional);
    let written = names.map(|name| folder.path().join(name));
    Ok(refuse_inputs(written, &study.inputs_on_disk())?)
}

/// Refuses to put the results of fewer samples in the place of more of the same study, or of the same disk under another engine order.
/// Where a file that it names has another content by now they are not of the same study any more.
///
/// # Errors
/// [`Error::Results`] if the results in `folder` are of this study with more samples; [`Error::File`] if files that wait there cannot
/// be placed.
fn refuse_fewer(study: &Study, folder: &OutputFolder, identity: &RunIdentity) -> Result<(), Error> {
    finish_placing(folder.path())?;
    let record = RunRecord::of_folder(folder.path());
    if record.is_ok_and(|record| record.files != identity.files) {
        return Ok(());
    }
    // what cannot be read is replaced
    let Ok(stored) = read_study(folder.path()) else {
        return Ok(());
    };
    let Some(more) = more_samples_of_any_order(&study.text, &stored.text) else {
        return Ok(());
    };
    let own = study.samples;
    let message = match more_samples(&study.text, &stored.text) {
        Some(_) => format!(
            "holds {more} samples of this study, of which its file asks for {own}: ask for {more}, or for fewer samples take another --output, or delete these"
        ),
        None => format!(
            "holds {more} samples of this disk under another engine order, in place of which its file asks for {own}: take another --output, or delete these"
        ),
    };
    Err(Error::results(folder.path(), message))
}

/// That a run will replace the results in `folder`, where these are not of it.
pub(super) fn replaced(
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Option<String> {
    let stored = stated_identity(folder.path()).ok()?;
    let (stored, _) = as_asked(identity, stored);
    let difference = accepted(identity, &stored, settings).err()?;
    let path = folder.path().display();
    Some(format!("replaces the results in {path}, of {difference}"))
}
