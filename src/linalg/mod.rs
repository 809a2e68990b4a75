//! Linear algebra on top of faer: generalised eigenvalue problems, dense and sparse, conjugate residuals, vector loops.
//!
//! Knows nothing of structures; the names stiffness and mass are used because they are the pencil's usual names.

mod dense_eigen;
pub mod gcr;
pub mod single;
mod sparse_eigen;
pub mod vector;

pub use dense_eigen::{symmetric_eigen, symmetric_generalized_eigen};
pub use sparse_eigen::{LowestModes, Wanted, lowest_modes, wanted_modes};

/// Why a factorisation or an eigenvalue problem has no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LinalgError {
    /// A matrix that must be positive definite is not.
    #[error("{matrix} is not positive definite")]
    NotPositiveDefinite {
        /// Which matrix.
        matrix: &'static str,
    },
    /// The eigenvalue iteration ended before the residual was small.
    #[error("eigenvalue iteration ended with relative residual {residual:.1e}")]
    EigenNotConverged {
        /// Largest relative residual of the wanted modes.
        residual: f64,
    },
}
