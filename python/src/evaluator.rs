//! The model of a study as a function of its inputs.

use crate::errors::{StudyError, raised};
use crate::interrupt::Work;
use microslip::study::{EvaluationError, Study};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::ThreadPool;
use std::path::PathBuf;

/// The model of a study as a function of its inputs.
#[pyclass(frozen)]
pub(crate) struct Evaluator {
    model: microslip::study::Evaluator<'static>,
    pool: Option<ThreadPool>,
}

/// Frequencies and amplitudes as the bytes of doubles, and status names. Shape of each: points x levels.
type Found<'py> = (Bound<'py, PyBytes>, Bound<'py, PyBytes>, Vec<&'static str>);

impl Evaluator {
    /// Prepares the model, which starts from so many samples: those in the folder of results, else solved now.
    pub(crate) fn of<'py>(
        py: Python<'py>,
        study: Study,
        (anchors, results): (u64, Option<PathBuf>),
        pool: Option<ThreadPool>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        use microslip::study::Evaluator;
        let work = Work::new(pool.as_ref(), progress);
        let model = work.done(py, |stop, meter| {
            let prepared = study.into_prepared().map_err(|error| raised(&error))?;
            match &results {
                Some(folder) => {
                    Evaluator::stored(prepared, folder, anchors).map_err(|error| raised(&error))
                }
                None => {
                    Evaluator::solved(prepared, anchors, stop, |p| meter.note(p)).map_err(refused)
                }
            }
        })??;
        drop(work);
        Ok(Self { model, pool })
    }
}

fn refused(error: EvaluationError) -> PyErr {
    match error {
        EvaluationError::Stopped => PyKeyboardInterrupt::new_err(error.to_string()),
        error => StudyError::new_err(error.to_string()),
    }
}

#[pymethods]
impl Evaluator {
    #[getter]
    fn anchors(&self) -> usize {
        self.model.anchors()
    }

    /// Resonances at `rows` points given as the bytes of doubles, one point after the other; of a study without random inputs no byte.
    fn evaluate<'py>(&self, py: Python<'py>, points: &[u8], rows: usize) -> PyResult<Found<'py>> {
        let (numbers, _) = points.as_chunks::<8>();
        let numbers: Vec<f64> = numbers
            .iter()
            .map(|bytes| f64::from_ne_bytes(*bytes))
            .collect();
        let columns = numbers.len() / rows.max(1);
        let row = |k: usize| &numbers[k * columns..(k + 1) * columns];
        let rows: Vec<&[f64]> = (0..rows).map(row).collect();
        let work = Work::new(self.pool.as_ref(), None);
        let found = work.done(py, |stop, _| self.model.evaluate(&rows, stop))?;
        let found = found.map_err(refused)?;
        let levels = || found.iter().flatten();
        let peaks = || levels().map(|level| level.peak);
        let bytes = |numbers: &mut dyn Iterator<Item = Option<f64>>| -> Vec<u8> {
            numbers
                .flat_map(|number| number.unwrap_or(f64::NAN).to_ne_bytes())
                .collect()
        };
        let frequencies = bytes(&mut peaks().map(|peak| peak.map(|peak| peak.frequency_hz)));
        let amplitudes = bytes(&mut peaks().map(|peak| peak.map(|peak| peak.amplitude_m)));
        Ok((
            PyBytes::new(py, &frequencies),
            PyBytes::new(py, &amplitudes),
            levels().map(|level| level.status.name()).collect(),
        ))
    }
}
