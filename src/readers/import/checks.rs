//! What the matrices of a structure must be, whole or before a reduction.

use super::model::{ImportedModel, Part};
use super::role::Role;
use super::symmetric::Symmetric;
use crate::file::FileError;
use crate::model::matrix_checks::dependent_row;
use crate::model::matrix_market::LARGEST;

/// Whether a model is as its files state it, or reduced already: what helps is different.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Read,
    Reduced,
}

impl Stage {
    fn if_too_large(self) -> &'static str {
        match self {
            Self::Read => {
                "--cut-off HZ reduces a larger model to its contact, excited and response nodes and its modes below HZ"
            }
            Self::Reduced => "keep fewer degrees of freedom",
        }
    }

    fn if_massless(self) -> &'static str {
        match self {
            Self::Read => "--cut-off HZ condenses it, or the finite-element program",
            Self::Reduced => "nothing with mass moves with it, so it cannot be kept",
        }
    }
}

impl ImportedModel {
    /// Requires that every matrix is positive semidefinite, up to the digits of its file. Of a model that must be reduced only
    /// its entries are compared with its diagonal: its reduction shows the rest.
    ///
    /// # Errors
    /// [`FileError`] with the file and its most negative eigenvalue.
    pub(super) fn check_semidefinite(&self) -> Result<(), FileError> {
        let mut parts = self.matrices.values();
        parts.try_for_each(|part| {
            let semidefinite = match self.dofs.len() > LARGEST {
                true => part.values.allowed_by_diagonal(),
                false => part.values.positive_semidefinite(part.digits),
            };
            semidefinite.map_err(|rule| FileError::content(&part.path, None, rule))
        })
    }

    /// Requires that it is small enough to be solved as it is, and that every degree of freedom has a mass.
    ///
    /// # Errors
    /// [`FileError`] with the file and the degree of freedom.
    pub(super) fn check_as_reduced(&self, stage: Stage) -> Result<(), FileError> {
        let mass = &self.matrices[&Role::Mass];
        let fault = |rule: String| Err(FileError::content(&mass.path, None, rule));
        let n = self.dofs.len();
        if n > LARGEST {
            return fault(format!(
                "has {n} rows: at most {LARGEST}; {}",
                stage.if_too_large()
            ));
        }
        let massless = massless(mass);
        if let Some(&dof) = massless.first() {
            return fault(format!(
                "degree of freedom {} has no mass: {}",
                self.dofs[dof],
                stage.if_massless()
            ));
        }
        match dependent_row(&mass.values.to_dense()) {
            None => Ok(()),
            Some(row) => fault(format!(
                "must be positive definite, but degree of freedom {} has no mass of its own beside those before it: {}",
                self.dofs[row],
                stage.if_massless()
            )),
        }
    }
}

/// Rows of a positive semidefinite mass that are zero.
pub(super) fn massless(mass: &Part<Symmetric>) -> Vec<usize> {
    let diagonal = mass.values.diagonal();
    (0..mass.values.n).filter(|&i| diagonal[i] <= 0.0).collect()
}
