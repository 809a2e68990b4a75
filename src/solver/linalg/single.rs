//! Products and solves in single precision, for preconditioners: what they lose is found elsewhere, and half of the
//! memory is half of the time.
//!
//! Columns are filled up with zeros to whole vectors of the widest registers.

use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use pulp::Simd;
use std::ops::Range;

/// Single-precision numbers of the widest vector register.
pub const LANES: usize = 16;

/// LU factors of a matrix, with the tiles on their diagonals inverted: solving for one vector is then a row of products of
/// whole vectors.
#[derive(Debug)]
pub struct SingleLu {
    /// Rows of the matrix in the order of the factors.
    order: Vec<usize>,
    lower: Vec<Tile>,
    upper: Vec<Tile>,
}

/// `LANES` columns of a triangular factor.
#[derive(Debug)]
struct Tile {
    /// Of the square on the diagonal, by columns.
    inverse: [[f32; LANES]; LANES],
    /// What lies below it (lower factor) or above it (upper one), by columns.
    rest: Vec<f32>,
}

impl SingleLu {
    /// Factorises a matrix that is rounded to single precision first.
    #[must_use]
    pub fn new(matrix: &Mat<f64>) -> Self {
        let n = matrix.nrows();
        let mut single = Mat::zeros(n, n);
        for j in 0..n {
            round(matrix.col_as_slice(j), single.col_as_slice_mut(j));
        }
        let factors = PartialPivLu::new(single.as_ref());
        let tiles = n.div_ceil(LANES);
        let (l, u) = (factors.L(), factors.U());
        Self {
            order: factors.P().arrays().0.to_vec(),
            lower: (0..tiles)
                .map(|t| Tile::new(l, t, (t + 1) * LANES..tiles * LANES, 0..LANES))
                .collect(),
            upper: (0..tiles)
                .map(|t| Tile::new(u, t, 0..t * LANES, (0..LANES).rev()))
                .collect(),
        }
    }

    /// x ← A⁻¹ x for each of the K vectors.
    #[inline(always)]
    pub fn solve_in_place<S: Simd, const K: usize>(&self, simd: S, x: [&mut [f32]; K]) {
        let size = self.lower.len() * LANES;
        let mut work: [Vec<f32>; K] = std::array::from_fn(|_| vec![0.0; size]);
        for (work, x) in work.iter_mut().zip(&x) {
            for (work, &row) in work.iter_mut().zip(&self.order) {
                *work = x[row];
            }
        }
        for (t, tile) in self.lower.iter().enumerate() {
            let later = (t + 1) * LANES..size;
            tile.solve(simd, &mut work, t * LANES, later);
        }
        for (t, tile) in self.upper.iter().enumerate().rev() {
            tile.solve(simd, &mut work, t * LANES, 0..t * LANES);
        }
        for (x, work) in x.into_iter().zip(&work) {
            x.copy_from_slice(&work[..x.len()]);
        }
    }
}

impl Tile {
    /// Columns `t` of a triangular factor, those beyond its size being those of the identity, with the `rest` of its rows;
    /// `order` is that of the substitution.
    fn new(
        factor: MatRef<'_, f32>,
        t: usize,
        rest: Range<usize>,
        order: impl Iterator<Item = usize>,
    ) -> Self {
        let n = factor.nrows();
        let start = t * LANES;
        let mut square = [[0.0; LANES]; LANES];
        let mut others = Vec::with_capacity(LANES * rest.len());
        for (j, column) in square.iter_mut().enumerate() {
            column[j] = 1.0;
            if start + j < n {
                let all = factor.col(start + j);
                let there = start..n.min(start + LANES);
                (column
                    .iter_mut()
                    .zip(all.subrows(start, there.len()).iter()))
                .for_each(|(to, from)| *to = *from);
                let there = rest.start.min(n)..rest.end.min(n);
                others.extend(all.subrows(there.start, there.len()).iter());
            }
            others.resize((j + 1) * rest.len(), 0.0);
        }
        Self {
            inverse: inverse(&square, order),
            rest: others,
        }
    }

    /// Solves for the unknowns of these columns, which are those from `start`, and takes their part from the others.
    #[inline(always)]
    fn solve<S: Simd, const K: usize>(
        &self,
        simd: S,
        x: &mut [Vec<f32>; K],
        start: usize,
        others: Range<usize>,
    ) {
        let mut solved = [[0.0; LANES]; K];
        let now = x.each_ref().map(|x| &x[start..start + LANES]);
        let to = solved.each_mut().map(<[f32; LANES]>::as_mut_slice);
        add_products(simd, 1.0, self.inverse.as_flattened(), now, 1, to);
        for (x, solved) in x.iter_mut().zip(&solved) {
            x[start..start + LANES].copy_from_slice(solved);
        }
        let others = x.each_mut().map(|x| &mut x[others.clone()]);
        let solved = solved.each_ref().map(<[f32; LANES]>::as_slice);
        add_products(simd, -1.0, &self.rest, solved, 1, others);
    }
}

/// Inverse of a triangle, both by columns, by substitution in an `order`.
fn inverse(
    triangle: &[[f32; LANES]; LANES],
    order: impl Iterator<Item = usize>,
) -> [[f32; LANES]; LANES] {
    let mut rows = [[0.0; LANES]; LANES];
    (0..LANES).for_each(|i| rows[i][i] = 1.0);
    for k in order {
        let scale = 1.0 / triangle[k][k];
        let solved = rows[k].map(|x| x * scale);
        for (row, factor) in rows.iter_mut().zip(triangle[k]) {
            for (x, solved) in row.iter_mut().zip(solved) {
                *x -= factor * solved;
            }
        }
        rows[k] = solved;
    }
    std::array::from_fn(|j| rows.map(|row| row[j]))
}

/// `x` in single precision.
#[inline(always)]
pub fn round(x: &[f64], single: &mut [f32]) {
    for (single, x) in single.iter_mut().zip(x) {
        *single = *x as f32;
    }
}

/// `x` in single precision.
#[must_use]
pub fn rounded(x: &[f64]) -> Vec<f32> {
    let mut single = vec![0.0; x.len()];
    round(x, &mut single);
    single
}

/// Columns of `rows` numbers in single precision, each filled up with zeros to whole vectors.
#[must_use]
pub fn filled<'a>(rows: usize, columns: impl ExactSizeIterator<Item = &'a [f64]>) -> Vec<f32> {
    let stride = rows.next_multiple_of(LANES);
    let mut all = vec![0.0; stride * columns.len()];
    for (single, column) in all.chunks_exact_mut(stride).zip(columns) {
        round(column, single);
    }
    all
}

/// `x` as vectors of the instruction set.
#[inline(always)]
pub fn vectors<S: Simd>(x: &[f32]) -> &[S::f32s] {
    S::as_simd_f32s(x).0
}

/// `x` as vectors of the instruction set.
#[inline(always)]
pub(crate) fn vectors_mut<S: Simd>(x: &mut [f32]) -> &mut [S::f32s] {
    S::as_mut_simd_f32s(x).0
}

/// y += factor A x for K vectors x and y at once, A by columns as long as y, whole vectors. The entries of x are `stride`
/// apart. A is read from memory once, which takes most of the time.
#[inline(always)]
pub fn add_products<S: Simd, const K: usize>(
    simd: S,
    factor: f32,
    columns: &[f32],
    x: [&[f32]; K],
    stride: usize,
    y: [&mut [f32]; K],
) {
    let columns = vectors::<S>(columns);
    let mut y = y.map(vectors_mut::<S>);
    let rows = y[0].len();
    for first in (0..rows).step_by(4) {
        match rows - first {
            1 => add_rows::<S, 1, K>(simd, factor, columns, first, x, stride, &mut y),
            2 => add_rows::<S, 2, K>(simd, factor, columns, first, x, stride, &mut y),
            3 => add_rows::<S, 3, K>(simd, factor, columns, first, x, stride, &mut y),
            _ => add_rows::<S, 4, K>(simd, factor, columns, first, x, stride, &mut y),
        }
    }
}

/// V registers of [`add_products`] from the register `first` of the columns.
#[inline(always)]
fn add_rows<S: Simd, const V: usize, const K: usize>(
    simd: S,
    factor: f32,
    columns: &[S::f32s],
    first: usize,
    x: [&[f32]; K],
    stride: usize,
    y: &mut [&mut [S::f32s]; K],
) {
    let rows = y[0].len();
    let mut sums = [[simd.splat_f32s(0.0); V]; K];
    for (j, column) in columns.chunks_exact(rows).enumerate() {
        let column = &column[first..][..V];
        for (sums, x) in sums.iter_mut().zip(&x) {
            let x = simd.splat_f32s(x[j * stride]);
            for (sum, a) in sums.iter_mut().zip(column) {
                *sum = simd.mul_add_f32s(*a, x, *sum);
            }
        }
    }
    let factor = simd.splat_f32s(factor);
    for (y, sums) in y.iter_mut().zip(sums) {
        for (y, sum) in y[first..][..V].iter_mut().zip(sums) {
            *y = simd.mul_add_f32s(sum, factor, *y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Solve<'a, const K: usize>(&'a SingleLu, [&'a mut [f32]; K]);

    impl<const K: usize> WithSimd for Solve<'_, K> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.0.solve_in_place(simd, self.1);
        }
    }

    /// Sizes below, at and above whole tiles, with pivots off the diagonal; two vectors at once give the bits of one. Seen to
    /// fail with upper triangles inverted from the top, and with the first vector's entries taken for the second.
    #[test]
    fn solutions_leave_the_round_off_of_single_precision() {
        for n in [1, 5, 16, 17, 32, 43, 129] {
            let entry = |i: usize, j: usize| {
                let off = ((3 * i + 7 * j + i * j) as f64).sin();
                if (i + 1) % n == j {
                    off + 4.0
                } else {
                    off / n as f64
                }
            };
            let matrix = Mat::from_fn(n, n, entry);
            let b: Vec<f64> = (0..n).map(|i| (i as f64).cos() + 2.0).collect();
            let mut x = vec![0.0; n];
            round(&b, &mut x);
            let mut both = [vec![1.0; n], x.clone()];
            let factors = SingleLu::new(&matrix);
            Arch::new().dispatch(Solve(&factors, [&mut x]));
            let [other, same] = &mut both;
            Arch::new().dispatch(Solve(&factors, [other, same]));
            assert_eq!(x, *same, "{n}");
            for (i, b) in b.iter().enumerate() {
                let product: f64 = (0..n).map(|j| entry(i, j) * f64::from(x[j])).sum();
                assert!((product - b).abs() < 1e-5, "{n}, row {i}: {product} {b}");
            }
        }
    }
}
