//! Linear algebra on top of faer: generalised eigenvalue problems, dense and sparse, conjugate residuals, vector loops.
//!
//! Knows nothing of structures; the names stiffness and mass are used because they are the pencil's usual names.
//!
//! ```
//! # use microslip_solver as microslip;
//! use faer::mat;
//! use microslip::linalg::symmetric_generalized_eigen;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let stiffness = mat![[2.0, -1.0], [-1.0, 2.0]];
//! let mass = mat![[1.0, 0.0], [0.0, 1.0]];
//! let (squared_frequencies, modes) = symmetric_generalized_eigen(stiffness.as_ref(), mass.as_ref())?;
//! assert!((squared_frequencies[0] - 1.0).abs() < 1e-12 && (squared_frequencies[1] - 3.0).abs() < 1e-12);
//! assert!((modes[(0, 0)] - modes[(1, 0)]).abs() < 1e-12); // the lower mode: both masses together
//! # Ok(())
//! # }
//! ```

mod dense_eigen;
pub mod filter_diagonalization;
pub mod gcr;
pub mod recycled;
pub mod single;
mod sparse_eigen;
pub mod split;
pub mod vector;

pub use dense_eigen::{Scalar, symmetric_eigen, symmetric_generalized_eigen};
pub use sparse_eigen::{FactoredPencil, LowestModes, Wanted, lowest_modes};

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
    #[error(
        "modes of the stiffness and mass matrices were not found, the iteration ended with a relative residual of {residual:.1e}: their entries \
         must not differ so much in size (check units and directions of the degrees of freedom)"
    )]
    EigenNotConverged {
        /// Largest relative residual of the wanted modes.
        residual: f64,
    },
}
