//! Coordinates of a component in which linear forms of its displacements, its masters, are coordinates themselves.
//!
//! A master y = Σ w_j u_j takes the place of one displacement that no other master weighs, its pivot p:
//! u_p = (y − Σ_{j≠p} w_j u_j)/w_p. With u = T q̃ the matrices become TᵀKT and TᵀMT: as sparse as before, but for the
//! displacements of one master, which now know each other. A force on y acts on the displacements in proportion to w_j.

use super::SparseRow;
use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};

/// The map T between both kinds of coordinates; q̃ has the order of u, with y_k in place of the pivot of master k.
pub(super) struct MasterCoordinates {
    /// Rows of T.
    rows: Vec<SparseRow>,
    /// Places of the masters in q̃, in their order.
    pub(super) pivots: Vec<usize>,
}

impl MasterCoordinates {
    /// Every master needs a displacement of its own, with a weight that is not 0; of several it takes that of the
    /// largest weight.
    pub(super) fn new(n_dofs: usize, masters: &[SparseRow]) -> Self {
        let mut weighed_by = vec![0; n_dofs];
        for &(dof, _) in masters.iter().flatten() {
            weighed_by[dof] += 1;
        }
        let mut rows: Vec<SparseRow> = (0..n_dofs).map(|dof| vec![(dof, 1.0)]).collect();
        let pivots = masters.iter().enumerate().map(|(k, master)| {
            let own = master.iter().filter(|(dof, _)| weighed_by[*dof] == 1);
            let largest = own.reduce(|a, b| if b.1.abs() > a.1.abs() { b } else { a });
            let Some(&(pivot, weight)) = largest.filter(|(_, weight)| *weight != 0.0) else {
                panic!("master {k} has no displacement of its own");
            };
            let others = master.iter().filter(|(dof, _)| *dof != pivot);
            rows[pivot] = vec![(pivot, 1.0 / weight)];
            rows[pivot].extend(others.map(|&(dof, w)| (dof, -w / weight)));
            pivot
        });
        Self {
            pivots: pivots.collect(),
            rows,
        }
    }

    /// TᵀAT.
    pub(super) fn transformed(&self, a: &SparseColMat<usize, f64>) -> SparseColMat<usize, f64> {
        let mut entries = Vec::with_capacity(a.compute_nnz());
        for entry in a.triplet_iter() {
            for &(row, w_row) in &self.rows[entry.row] {
                for &(col, w_col) in &self.rows[entry.col] {
                    entries.push(Triplet {
                        row,
                        col,
                        val: w_row * *entry.val * w_col,
                    });
                }
            }
        }
        SparseColMat::try_new_from_triplets(a.nrows(), a.ncols(), &entries)
            .unwrap_or_else(|_| unreachable!("indices come from the masters"))
    }

    /// u = T q̃, column by column.
    pub(super) fn displacements(&self, coordinates: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(coordinates.nrows(), coordinates.ncols(), |dof, column| {
            let row = self.rows[dof].iter();
            row.map(|&(j, w)| w * coordinates[(j, column)]).sum()
        })
    }
}
