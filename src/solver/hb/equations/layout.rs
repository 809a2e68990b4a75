//! Sizes and order of the unknowns, and of the derivatives with respect to them.

/// Sizes and order of the unknowns: coefficient, then component (t1, t2, n), then pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Number of contact pairs.
    pub n_pairs: usize,
    /// Coefficients per displacement.
    pub n_coefficients: usize,
}

impl Layout {
    /// Relative displacements per coefficient.
    #[must_use]
    pub fn n_relative(&self) -> usize {
        3 * self.n_pairs
    }

    /// Length of the vector of unknowns.
    #[must_use]
    pub fn n_unknowns(&self) -> usize {
        self.n_relative() * self.n_coefficients
    }
}

/// Derivative of the force deviation g of one pair: blocks (force component, displacement component, m × m).
#[derive(Debug, Clone)]
pub struct PairTangent {
    /// Index of the pair.
    pub pair: usize,
    /// Nonzero blocks, row-major, row = force coefficient, column = displacement coefficient.
    pub blocks: Vec<(usize, usize, Vec<f64>)>,
}
