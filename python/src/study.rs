//! A study, and its run.

use crate::errors::raised;
use crate::evaluator::Evaluator;
use crate::interrupt::{Work, pool};
use microslip::study::{OutputFolder, RunSettings, check_folder, run};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A study file that was read and checked.
#[pyclass(frozen)]
pub(crate) struct Study(microslip::study::Study);

#[pymethods]
impl Study {
    /// Reads and checks a study file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let study = py.detach(|| microslip::study::Study::read(&path));
        study.map(Self).map_err(|error| raised(&error))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.0.path.clone()
    }

    #[getter]
    fn samples(&self) -> u64 {
        self.0.samples
    }

    #[getter]
    fn levels(&self) -> Vec<f64> {
        self.0.levels.clone()
    }

    #[getter]
    fn input_names(&self) -> Vec<&'static str> {
        let inputs = self.0.design.inputs().iter();
        inputs.map(|(input, _)| input.name()).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.clone()
    }

    /// What should be known of a folder before a run writes its results there.
    fn check_folder(&self, output: Option<PathBuf>) -> PyResult<Vec<String>> {
        let folder = self.output_folder(output)?;
        check_folder(&self.0, &folder, &RunSettings::default()).map_err(|error| raised(&error))
    }

    /// Solves all samples and writes the results; their folder, and what should be known of the run.
    #[pyo3(signature = (output, threads, progress))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        output: Option<PathBuf>,
        threads: Option<usize>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(PathBuf, Vec<String>)> {
        let study = &self.0;
        let folder = self.output_folder(output)?;
        let pool = pool(threads)?;
        let work = Work::new(pool.as_ref(), progress);
        let done = work.done(py, |stop, meter| {
            let settings = RunSettings {
                stop: stop.clone(),
                ..RunSettings::default()
            };
            run(study, &folder, &settings, |progress| meter.note(progress))
        })?;
        let result = done.map_err(|error| raised(&error))?;
        Ok((folder.path().to_owned(), result.notes))
    }

    /// The model as a function.
    #[pyo3(signature = (anchors, results, threads, progress))]
    fn evaluator<'py>(
        &self,
        py: Python<'py>,
        anchors: u64,
        results: Option<PathBuf>,
        threads: Option<usize>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Evaluator> {
        let pool = pool(threads)?;
        Evaluator::of(py, self.0.clone(), (anchors, results), pool, progress)
    }
}

impl Study {
    /// The folder of the results: the study's own if none is given.
    fn output_folder(&self, output: Option<PathBuf>) -> PyResult<OutputFolder> {
        let study = &self.0;
        let output = output.unwrap_or_else(|| study.folder().join(&study.output.folder));
        OutputFolder::open(&output).map_err(|error| raised(&error))
    }
}
