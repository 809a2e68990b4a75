//! Linear modes of a reduced model: free contacts and stuck contacts.

use faer::{Mat, MatRef, Side};

use super::ReducedModel;
use crate::contact::ContactParameters;

/// Undamped modes, in ascending order.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Natural angular frequencies (rad/s); rigid-body modes are 0 up to round-off.
    pub omega: Vec<f64>,
    /// Mass-normalised mode shapes, one per column. Shape: n × n.
    pub shapes: Mat<f64>,
}

/// Modes of K φ = ω² M φ.
///
/// `None` if M is not positive definite or the iteration fails.
#[must_use]
pub fn modes(stiffness: MatRef<'_, f64>, mass: MatRef<'_, f64>) -> Option<Modes> {
    let factor = mass.llt(Side::Lower).ok()?;
    let lower = factor.L();
    let mut reduced = stiffness.to_owned();
    lower.solve_lower_triangular_in_place(&mut reduced);
    let mut reduced = reduced.transpose().to_owned();
    lower.solve_lower_triangular_in_place(&mut reduced);
    let eigen = reduced.self_adjoint_eigen(Side::Lower).ok()?;
    let mut shapes = eigen.U().to_owned();
    lower
        .transpose()
        .solve_upper_triangular_in_place(&mut shapes);
    let omega = eigen
        .S()
        .column_vector()
        .iter()
        .map(|lambda| lambda.max(0.0).sqrt())
        .collect();
    Some(Modes { omega, shapes })
}

impl ReducedModel {
    /// Natural angular frequencies (rad/s) without contact forces, ascending.
    #[must_use]
    pub fn free_frequencies(&self) -> Option<Vec<f64>> {
        Some(modes(self.stiffness.as_ref(), self.mass.as_ref())?.omega)
    }

    /// Natural angular frequencies (rad/s) with every contact closed and stuck, ascending.
    ///
    /// K + Σ k_n B_nᵀB_n + k_t1 B_t1ᵀB_t1 + k_t2 B_t2ᵀB_t2. Shape: `parameters` `[n_contacts]`.
    #[must_use]
    pub fn stuck_frequencies(&self, parameters: &[ContactParameters<f64>]) -> Option<Vec<f64>> {
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
        Some(modes(stiffness.as_ref(), self.mass.as_ref())?.omega)
    }
}
