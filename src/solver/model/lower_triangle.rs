//! What the entries (row, column, value) of the lower triangle of a symmetric matrix say.

use faer::Mat;

/// Entries of the lower triangle of (A + Aᵀ)/2 that are not zero, column by column.
pub fn lower(a: &Mat<f64>) -> impl Iterator<Item = (usize, usize, f64)> {
    let places = (0..a.ncols()).flat_map(|j| (j..a.nrows()).map(move |i| (i, j)));
    let entries = places.map(|(i, j)| (i, j, 0.5 * (a[(i, j)] + a[(j, i)])));
    entries.filter(|(.., value)| *value != 0.0)
}

/// Σ |x_i| |A_ij| |x_j|: rounding the entries of A moves xᵀAx by at most so much times their relative error.
pub fn unsigned_energy(
    lower: impl Iterator<Item = (usize, usize, f64)>,
    x: impl Fn(usize) -> f64,
) -> f64 {
    let term = |(row, column, value): (usize, usize, f64)| {
        let both = if row == column { 1.0 } else { 2.0 };
        both * (value * x(row) * x(column)).abs()
    };
    lower.map(term).sum()
}

/// For each of `n` rows the least row that it is connected with, by entries that are not zero.
pub fn parts(n: usize, lower: impl Iterator<Item = (usize, usize, f64)>) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..n).collect();
    for (row, column, _) in lower.filter(|(.., value)| *value != 0.0) {
        let (a, b) = (root(&mut parent, row), root(&mut parent, column));
        parent[a.max(b)] = a.min(b);
    }
    (0..n).map(|row| root(&mut parent, row)).collect()
}

/// The least row of the part that a row is known to be in. The chain of parents to it becomes shorter.
fn root(parent: &mut [usize], mut row: usize) -> usize {
    while parent[row] != row {
        parent[row] = parent[parent[row]];
        row = parent[row];
    }
    row
}
