//! The compliance of a structure after springs are attached to it, one by one.
//!
//! A spring k at point i changes the compliance H to H − k/(1 + k Hᵢᵢ) hᵢ hᵢᵀ, where hᵢ is the i-th column of H (Sherman and
//! Morrison). With all springs it is (I + H K)⁻¹ H: one symmetric update of rank one per spring, a third of the operations of
//! a solve with I + H K, and without cancellation for soft springs. The pivot 1 + k Hᵢᵢ is small where the structure with
//! this spring resonates, so the spring with the largest pivot is attached first.

use faer::prelude::*;
use pulp::{Arch, Simd, WithSimd};

/// Number of updates that are applied together, in one pass over the matrix.
const WIDTH: usize = 4;

/// Real and imaginary part of a symmetric matrix; only the lower triangle counts.
#[derive(Debug, Clone)]
pub(in crate::hb) struct Symmetric {
    pub(in crate::hb) real: Mat<f64>,
    pub(in crate::hb) imaginary: Mat<f64>,
}

impl Symmetric {
    /// The compliance (m/N) with springs `k` (N/m) at the points, both triangles. The imaginary part of a spring is its damping
    /// constant times the frequency.
    pub(in crate::hb) fn with_springs(mut self, k: &[c64]) -> Self {
        Arch::new().dispatch(Attachment {
            compliance: &mut self,
            springs: k,
        });
        for matrix in [&mut self.real, &mut self.imaginary] {
            for j in 0..k.len() {
                for i in 0..j {
                    matrix[(i, j)] = matrix[(j, i)];
                }
            }
        }
        self
    }

    /// See [`Self::with_springs`].
    #[inline(always)]
    fn attach(&mut self, k: &[c64]) {
        let m = k.len();
        let mut diagonal: [Vec<f64>; 2] =
            [&self.real, &self.imaginary].map(|matrix| (0..m).map(|i| matrix[(i, i)]).collect());
        let none = c64::new(0.0, 0.0);
        let mut left: Vec<usize> = (0..m).filter(|&i| k[i] != none).collect();
        let mut group: [Update; WIDTH] = std::array::from_fn(|_| Update::new(m));
        while !left.is_empty() {
            for next in 0..WIDTH {
                let (earlier, rest) = group.split_at_mut(next);
                let pivot = |i: usize| k[i] * c64::new(diagonal[0][i], diagonal[1][i]) + 1.0;
                let sizes = (left.iter().enumerate()).map(|(at, &i)| (at, pivot(i).norm_sqr()));
                let largest = sizes.reduce(|a, b| if b.1 > a.1 { b } else { a });
                let Some((at, _)) = largest else {
                    rest[0] = Update::new(m);
                    continue;
                };
                let i = left.swap_remove(at);
                rest[0].read(self, i, earlier);
                rest[0].scale(pivot(i).inv() * k[i]);
                rest[0].apply_to_diagonal(&mut diagonal);
            }
            self.apply(&group);
        }
    }

    /// Adds a group of updates to the lower triangle.
    #[inline(always)]
    fn apply(&mut self, group: &[Update; WIDTH]) {
        let m = self.real.nrows();
        for j in 0..m {
            let n = m - j;
            let real = &mut self.real.col_as_slice_mut(j)[j..][..n];
            let imaginary = &mut self.imaginary.col_as_slice_mut(j)[j..][..n];
            let factor: [[f64; 2]; WIDTH] =
                std::array::from_fn(|u| [group[u].scaled[0][j], group[u].scaled[1][j]]);
            let column: [[&[f64]; 2]; WIDTH] = std::array::from_fn(|u| {
                [&group[u].column[0][j..][..n], &group[u].column[1][j..][..n]]
            });
            for i in 0..n {
                let (mut re, mut im) = (real[i], imaginary[i]);
                for (f, c) in factor.iter().zip(&column) {
                    re -= f[0] * c[0][i] - f[1] * c[1][i];
                    im -= f[0] * c[1][i] + f[1] * c[0][i];
                }
                (real[i], imaginary[i]) = (re, im);
            }
        }
    }
}

/// An update −f h hᵀ with a column h of the compliance; real and imaginary parts.
struct Update {
    /// h.
    column: [Vec<f64>; 2],
    /// f h.
    scaled: [Vec<f64>; 2],
}

impl Update {
    /// No update.
    fn new(m: usize) -> Self {
        let zeros = || [vec![0.0; m], vec![0.0; m]];
        Self {
            column: zeros(),
            scaled: zeros(),
        }
    }

    /// Column i of the compliance, with the updates that the matrix does not have yet.
    #[inline(always)]
    fn read(&mut self, compliance: &Symmetric, i: usize, earlier: &[Self]) {
        let parts = [&compliance.real, &compliance.imaginary];
        for (column, matrix) in self.column.iter_mut().zip(parts) {
            (0..i).for_each(|j| column[j] = matrix[(i, j)]);
            column[i..].copy_from_slice(&matrix.col_as_slice(i)[i..]);
        }
        let [real, imaginary] = &mut self.column;
        for update in earlier {
            let [f_real, f_imaginary] = [update.scaled[0][i], update.scaled[1][i]];
            let other = update.column[0].iter().zip(&update.column[1]);
            for ((re, im), (a, b)) in real.iter_mut().zip(imaginary.iter_mut()).zip(other) {
                *re -= f_real * a - f_imaginary * b;
                *im -= f_real * b + f_imaginary * a;
            }
        }
    }

    /// Sets f.
    #[inline(always)]
    fn scale(&mut self, f: c64) {
        let [real, imaginary] = &mut self.scaled;
        let column = self.column[0].iter().zip(&self.column[1]);
        for ((re, im), (a, b)) in real.iter_mut().zip(imaginary).zip(column) {
            *re = f.re * a - f.im * b;
            *im = f.re * b + f.im * a;
        }
    }

    /// Adds this update to a diagonal.
    #[inline(always)]
    fn apply_to_diagonal(&self, diagonal: &mut [Vec<f64>; 2]) {
        let [real, imaginary] = diagonal;
        let scaled = self.scaled[0].iter().zip(&self.scaled[1]);
        let column = self.column[0].iter().zip(&self.column[1]);
        for (((re, im), (x, y)), (a, b)) in real.iter_mut().zip(imaginary).zip(scaled).zip(column) {
            *re -= x * a - y * b;
            *im -= x * b + y * a;
        }
    }
}

struct Attachment<'a> {
    compliance: &'a mut Symmetric,
    springs: &'a [c64],
}

impl WithSimd for Attachment<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.compliance.attach(self.springs);
    }
}
