//! Linear modes of a reduced model: free contacts and stuck contacts.

use faer::Mat;

use super::ReducedModel;
use super::lower_triangle::lower;
use super::rigid::{RigidModes, Triangles, axes, digits, total_mass};
use crate::contact::ContactParameters;
use crate::linalg::{LinalgError, symmetric_generalized_eigen};

impl ReducedModel {
    /// Natural angular frequencies (rad/s) without contact forces, ascending; rigid-body modes are 0 up to round-off.
    ///
    /// # Errors
    /// [`LinalgError`] if the matrices are not what the model promises.
    pub fn free_frequencies(&self) -> Result<Vec<f64>, LinalgError> {
        frequencies(&self.stiffness, &self.mass)
    }

    /// Natural angular frequencies (rad/s) without contact forces, and the rigid-body modes among them.
    ///
    /// # Errors
    /// [`LinalgError`] if the matrices are not what the model promises.
    pub fn free_modes(&self) -> Result<(Vec<f64>, RigidModes), LinalgError> {
        let (k, m) = (&self.stiffness, &self.mass);
        let (lambda, shapes) = symmetric_generalized_eigen(k.as_ref(), m.as_ref())?;
        let triangles = Triangles {
            stiffness: || lower(k),
            digits: digits(lower(k)),
            mass: || lower(m),
        };
        let rigid = triangles.rigid_modes(&lambda, &shapes, &self.axes());
        Ok((roots(&lambda), rigid))
    }

    /// r'Mr of the unit displacement along x, y and z; nothing where no name of a degree of freedom is `node.1`, `node.2` or
    /// `node.3`.
    #[must_use]
    pub fn total_mass(&self) -> Option<[f64; 3]> {
        total_mass(lower(&self.mass), &self.axes())
    }

    fn axes(&self) -> Vec<Option<usize>> {
        axes(self.dof_names.iter().cloned())
    }

    /// Natural angular frequencies (rad/s) with every contact closed and stuck, ascending.
    ///
    /// K + Σ k_n B_nᵀB_n + k_t1 B_t1ᵀB_t1 + k_t2 B_t2ᵀB_t2. Shape: `parameters` `[n_contacts]`.
    ///
    /// # Errors
    /// [`LinalgError`] if the matrices are not what the model promises.
    pub fn stuck_frequencies(
        &self,
        parameters: &[ContactParameters<f64>],
    ) -> Result<Vec<f64>, LinalgError> {
        assert_eq!(
            parameters.len(),
            self.contacts.len(),
            "one set of parameters per contact pair"
        );
        let mut stiffness = self.stiffness.clone();
        for (pair, p) in self.contacts.iter().zip(parameters) {
            for (row, k) in [(&pair.t1, p.k_t[0]), (&pair.t2, p.k_t[1]), (&pair.n, p.k_n)] {
                for &(i, a) in row {
                    for &(j, b) in row {
                        stiffness[(i, j)] += k * a * b;
                    }
                }
            }
        }
        frequencies(&stiffness, &self.mass)
    }
}

/// √λ of K φ = λ M φ.
fn frequencies(stiffness: &Mat<f64>, mass: &Mat<f64>) -> Result<Vec<f64>, LinalgError> {
    let (lambda, _) = symmetric_generalized_eigen(stiffness.as_ref(), mass.as_ref())?;
    Ok(roots(&lambda))
}

fn roots(lambda: &[f64]) -> Vec<f64> {
    lambda.iter().map(|l| l.max(0.0).sqrt()).collect()
}
