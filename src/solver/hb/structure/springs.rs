//! The compliance of a structure after springs are attached to it, one by one.
//!
//! A spring k at point i changes the compliance H to H − k/(1 + k Hᵢᵢ) hᵢ gᵢᵀ, where hᵢ is the i-th column of H and gᵢᵀ its
//! i-th row (Sherman and Morrison). With all springs it is (I + H K)⁻¹ H: one update of rank one per spring, without
//! cancellation for soft springs. The pivot 1 + k Hᵢᵢ is small where the structure with this spring resonates, so the spring
//! with the largest pivot is attached first. A structure that is no travelling wave has a symmetric H, gᵢ = hᵢ: updates of
//! its lower triangle take a third of the operations of a solve with I + H K.

use faer::prelude::*;
use pulp::{Arch, Simd, WithSimd};

/// Number of updates that are applied together, in one pass over the matrix.
const WIDTH: usize = 4;

/// A compliance H by its real and its imaginary part.
#[derive(Debug, Clone)]
pub(in crate::hb) struct ContactCompliance {
    pub(in crate::hb) real: Mat<f64>,
    pub(in crate::hb) imaginary: Mat<f64>,
    /// Whether it is symmetric; then only the lower triangle counts where springs are attached.
    pub(in crate::hb) symmetric: bool,
}

impl ContactCompliance {
    /// That of a travelling wave.
    pub(in crate::hb) fn of_wave(g: &Mat<c64>) -> Self {
        let part = |of: fn(c64) -> f64| Mat::from_fn(g.nrows(), g.ncols(), |i, j| of(g[(i, j)]));
        Self {
            real: part(|z| z.re),
            imaginary: part(|z| z.im),
            symmetric: false,
        }
    }

    /// Its complex entries.
    pub(in crate::hb) fn complex(&self) -> Mat<c64> {
        let entry = |i, j| c64::new(self.real[(i, j)], self.imaginary[(i, j)]);
        Mat::from_fn(self.real.nrows(), self.real.ncols(), entry)
    }

    /// The compliance (m/N) with springs `k` (N/m) at the points, both triangles. The imaginary part of a spring is its damping
    /// constant times the frequency.
    pub(in crate::hb) fn with_springs(mut self, k: &[c64]) -> Self {
        Arch::new().dispatch(Attachment {
            compliance: &mut self,
            springs: k,
        });
        if !self.symmetric {
            return self;
        }
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
        let real = self.imaginary.norm_max() == 0.0 && k.iter().all(|k| k.im == 0.0);
        let mut diagonal: [Vec<f64>; 2] =
            [&self.real, &self.imaginary].map(|matrix| (0..m).map(|i| matrix[(i, i)]).collect());
        let none = c64::new(0.0, 0.0);
        let mut left: Vec<usize> = (0..m).filter(|&i| k[i] != none).collect();
        let mut numbers = vec![0.0; WIDTH * 4 * m];
        let mut group: [Update; WIDTH] = Update::group(&mut numbers, m);
        while !left.is_empty() {
            for next in 0..WIDTH {
                let (earlier, rest) = group.split_at_mut(next);
                let pivot = |i: usize| k[i] * c64::new(diagonal[0][i], diagonal[1][i]) + 1.0;
                let sizes = (left.iter().enumerate()).map(|(at, &i)| (at, pivot(i).norm_sqr()));
                let largest = sizes.reduce(|a, b| if b.1 > a.1 { b } else { a });
                let Some((at, _)) = largest else {
                    rest[0].clear();
                    continue;
                };
                let i = left.swap_remove(at);
                rest[0].read(self, i, earlier);
                rest[0].scale(pivot(i).inv() * k[i]);
                rest[0].apply_to_diagonal(&mut diagonal);
            }
            match real {
                true => self.apply_real(&group),
                false => self.apply(&group),
            }
        }
    }

    /// The same as [`Self::apply`] where nothing has an imaginary part, as at rest.
    #[inline(always)]
    fn apply_real(&mut self, group: &[Update<'_>; WIDTH]) {
        let m = self.real.nrows();
        for j in 0..m {
            let first = if self.symmetric { j } else { 0 };
            let n = m - first;
            let real = &mut self.real.col_as_slice_mut(j)[first..][..n];
            let factor: [f64; WIDTH] = std::array::from_fn(|u| group[u].scaled[0][j]);
            let column: [&[f64]; WIDTH] =
                std::array::from_fn(|u| &group[u].column[0][first..][..n]);
            for i in 0..n {
                let mut re = real[i];
                for (f, c) in factor.iter().zip(&column) {
                    re -= f * c[i];
                }
                real[i] = re;
            }
        }
    }

    /// Adds a group of updates, to the lower triangle of a symmetric compliance.
    #[inline(always)]
    fn apply(&mut self, group: &[Update<'_>; WIDTH]) {
        let m = self.real.nrows();
        for j in 0..m {
            let first = if self.symmetric { j } else { 0 };
            let n = m - first;
            let real = &mut self.real.col_as_slice_mut(j)[first..][..n];
            let imaginary = &mut self.imaginary.col_as_slice_mut(j)[first..][..n];
            let factor: [[f64; 2]; WIDTH] =
                std::array::from_fn(|u| [group[u].scaled[0][j], group[u].scaled[1][j]]);
            let column: [[&[f64]; 2]; WIDTH] =
                std::array::from_fn(|u| [0, 1].map(|part| &group[u].column[part][first..][..n]));
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

/// An update −f h gᵀ with a column h and a row gᵀ of the compliance; real and imaginary parts.
struct Update<'a> {
    /// h.
    column: [&'a mut [f64]; 2],
    /// f g.
    scaled: [&'a mut [f64]; 2],
}

impl<'a> Update<'a> {
    /// A group of updates of m points that keeps its numbers in `zeros`, one allocation for all: no updates yet.
    fn group(mut zeros: &'a mut [f64], m: usize) -> [Self; WIDTH] {
        std::array::from_fn(|_| {
            let mut part = || zeros.split_off_mut(..m).unwrap_or_default();
            Self {
                column: [part(), part()],
                scaled: [part(), part()],
            }
        })
    }

    /// Makes it no update.
    fn clear(&mut self) {
        for part in self.column.iter_mut().chain(&mut self.scaled) {
            part.fill(0.0);
        }
    }

    /// Column and row i of the compliance, with the updates that the matrix does not have yet.
    #[inline(always)]
    fn read(&mut self, compliance: &ContactCompliance, i: usize, earlier: &[Self]) {
        let parts = [&compliance.real, &compliance.imaginary];
        for (column, matrix) in self.column.iter_mut().zip(parts) {
            column.copy_from_slice(matrix.col_as_slice(i));
            if compliance.symmetric {
                (0..i).for_each(|j| column[j] = matrix[(i, j)]);
            }
        }
        for update in earlier {
            let f = [update.scaled[0][i], update.scaled[1][i]];
            take_product(&mut self.column, f, &update.column);
        }
        if compliance.symmetric {
            for (row, column) in self.scaled.iter_mut().zip(&self.column) {
                row.copy_from_slice(column);
            }
            return;
        }
        for (row, matrix) in self.scaled.iter_mut().zip(parts) {
            (0..row.len()).for_each(|j| row[j] = matrix[(i, j)]);
        }
        for update in earlier {
            let h = [update.column[0][i], update.column[1][i]];
            take_product(&mut self.scaled, h, &update.scaled);
        }
    }

    /// Multiplies the row by f.
    #[inline(always)]
    fn scale(&mut self, f: c64) {
        let [real, imaginary] = &mut self.scaled;
        for (re, im) in real.iter_mut().zip(&mut **imaginary) {
            (*re, *im) = (f.re * *re - f.im * *im, f.re * *im + f.im * *re);
        }
    }

    /// Adds this update to a diagonal.
    #[inline(always)]
    fn apply_to_diagonal(&self, diagonal: &mut [Vec<f64>; 2]) {
        let [real, imaginary] = diagonal;
        let scaled = self.scaled[0].iter().zip(&*self.scaled[1]);
        let column = self.column[0].iter().zip(&*self.column[1]);
        for (((re, im), (x, y)), (a, b)) in real.iter_mut().zip(imaginary).zip(scaled).zip(column) {
            *re -= x * a - y * b;
            *im -= x * b + y * a;
        }
    }
}

/// y −= f x, real and imaginary parts.
#[inline(always)]
fn take_product([real, imaginary]: &mut [&mut [f64]; 2], f: [f64; 2], x: &[&mut [f64]; 2]) {
    let other = x[0].iter().zip(&*x[1]);
    for ((re, im), (a, b)) in real.iter_mut().zip(&mut **imaginary).zip(other) {
        *re -= f[0] * a - f[1] * b;
        *im -= f[0] * b + f[1] * a;
    }
}

struct Attachment<'a> {
    compliance: &'a mut ContactCompliance,
    springs: &'a [c64],
}

impl WithSimd for Attachment<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.compliance.attach(self.springs);
    }
}
