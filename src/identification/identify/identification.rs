//! From records to the distribution of the contact parameters.

use super::found::identified::{FORMAT, Identified};
use super::found::result::{TestResult, TestStatus};
use super::one_test::test_estimate::identify_test;
use super::pooling::joint::joint;
use super::pooling::pooled::pool;
use super::settings::IdentifySettings;
use crate::file::{FileError, FileRecord};
use crate::record::{HysteresisRecord, TestInFile, read_hysteresis};
use crate::setting::BadSetting;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Why nothing is identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A setting breaks a rule.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// No test can be used; each with its reason.
    #[error("no test can be used: {0}")]
    NoTest(String),
    /// The page template is broken.
    #[error("page of the identification: {0}")]
    Page(#[from] minijinja::Error),
}

/// [`identify`] of the tests in files, which the result names with their hashes.
///
/// # Errors
/// [`IdentifyError`] if a setting breaks a rule, a file cannot be read, or no test can be used.
pub fn identify_files(
    paths: &[PathBuf],
    settings: &IdentifySettings,
) -> Result<Identified, IdentifyError> {
    settings.validate()?;
    let record = |path: &PathBuf| {
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        FileRecord::in_folder(folder, &name)
    };
    let tests = read_hysteresis(paths)?;
    let files = paths.iter().map(record).collect::<Result<_, _>>()?;
    let place = |test: &TestInFile| {
        let line = test
            .line
            .map_or_else(String::new, |line| format!(":{line}"));
        format!("{}{line}: {}", test.path.display(), test.record.name)
    };
    let (records, places): (Vec<_>, Vec<_>) = (tests.into_iter())
        .map(|test| {
            let place = place(&test);
            (test.record, place)
        })
        .unzip();
    let identified = identify_at(&records, &places, settings)?;
    Ok(Identified {
        files,
        ..identified
    })
}

/// Contact parameters from hysteresis tests: each test apart, all together, and the distribution of a further contact. The files are
/// the caller's. The result does not depend on the number of threads.
///
/// # Errors
/// [`IdentifyError`] if a setting breaks a rule or no test can be used.
pub fn identify(
    records: &[HysteresisRecord],
    settings: &IdentifySettings,
) -> Result<Identified, IdentifyError> {
    let names: Vec<String> = records.iter().map(|record| record.name.clone()).collect();
    identify_at(records, &names, settings)
}

/// [`identify`] of tests, which the error names by their `places`.
fn identify_at(
    records: &[HysteresisRecord],
    places: &[String],
    settings: &IdentifySettings,
) -> Result<Identified, IdentifyError> {
    settings.validate()?;
    let tests: Vec<TestResult> = (records.par_iter())
        .map(|record| identify_test(record, settings))
        .collect();
    let reasons = tests
        .iter()
        .zip(places)
        .filter_map(|(test, place)| match &test.status {
            TestStatus::Unusable(reason) => Some((place, &test.name, reason)),
            _ => None,
        });
    let reasons: Vec<(&String, &String, &String)> = reasons.collect();
    if reasons.len() == tests.len() {
        let each = reasons
            .iter()
            .map(|(place, _, reason)| format!("{place} {reason}"));
        return Err(IdentifyError::NoTest(each.collect::<Vec<_>>().join("; ")));
    }
    let pooled = pool(&tests, settings);
    let joint = joint(&pooled, settings)?;
    let unused = (reasons.iter()).map(|(_, name, reason)| format!("not used: {name} {reason}"));
    Ok(Identified {
        format: FORMAT,
        inputs: joint.inputs,
        correlation: joint.correlation,
        notes: unused.chain(joint.notes).collect(),
        settings: Some(*settings),
        pooled: Some(pooled),
        tests,
        files: Vec::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    })
}
