//! Errors of the engine as exceptions.

use microslip::Error;
use microslip::file::FileError;
use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    _native,
    StudyError,
    PyValueError,
    "What a study, a file or a value breaks: the message has file, line or key, and the rule."
);

/// The exception for `error`: what the operating system refuses is an `OSError`, a stop a `KeyboardInterrupt`.
pub(crate) fn raised(error: &Error) -> PyErr {
    let message = error.to_string();
    match error {
        Error::Stopped { .. } => PyKeyboardInterrupt::new_err(message),
        Error::File(FileError::System { .. }) => PyOSError::new_err(message),
        _ => StudyError::new_err(message),
    }
}
