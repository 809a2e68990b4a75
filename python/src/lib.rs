//! The native part of the package for Python: what needs the engine. `microslip/__init__.py` is what users see.

mod errors;
mod evaluator;
mod interrupt;
mod study;
mod table;

use pyo3::prelude::*;

/// The native part of microslip: use the classes of the package itself.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::errors::StudyError;
    #[pymodule_export]
    use super::evaluator::Evaluator;
    #[pymodule_export]
    use super::study::Study;
    #[pymodule_export]
    use super::table::stream;
}
