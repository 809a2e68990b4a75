//! Eigenvalues of a linear map Γ whose moduli are close to the largest one, from what Γ makes of a few vectors.
//!
//! The powers x, Γ x, Γ² x, ... are seen through some channels only, fewer than a vector has entries. A Fourier transform over
//! the powers sorts the eigenvectors by the angle of their eigenvalues: those transforms whose angles lie in a window span the
//! eigenvectors there, and a small eigenvalue problem finds them. So all eigenvalues near the circle are found without one large matrix, also
//! where there are thousands of them.
//!
//! ```text
//! y_k = C Γᵏ x
//! u(θ) = Σ_k w_k (ρ e^{iθ})⁻ᵏ y_k,   v(θ) = Σ_k w_k (ρ e^{iθ})⁻ᵏ y_{k+1}
//! u ↦ v is C ↦ C Γ:   U = [u(θ₁), u(θ₂), ...],   V z = γ U z
//! ```
//!
//! with a taper w and the growth ρ of the powers. The residual ‖V z − γ U z‖/‖U z‖ is that of an eigenvector of Γ, as the channels see it.
//!
//! Source: Wall and Neuhauser, J. Chem. Phys. 102, 8011–8022, 1995; with several vectors: Mandelshtam, Prog. Nucl. Magn. Reson.
//! Spectrosc. 38, 159–196, 2001.

use faer::prelude::*;
use rustfft::FftPlanner;
use std::f64::consts::{PI, TAU};

/// Angles of a window.
const ANGLES: usize = 16;

/// Angles by which windows follow each other.
const STRIDE: usize = 8;

/// Combinations of the transforms of a window below this share of the largest are noise.
const NOISE: f64 = 1e-9;

/// Vectors weaker than this in the transforms of their window are what noise and far eigenvalues leave.
const FAINT: f64 = 1e-5;

/// Angles that windows are moved by, so that no eigenvalue with a simple angle, such as 1 and −1, lies on their border.
const OFFSET: f64 = 0.25;

/// Powers of a map, applied to some vectors and seen through channels.
#[derive(Debug, Default)]
pub struct Powers {
    /// Shape: one matrix per power, channels × vectors.
    seen: Vec<Mat<c64>>,
    /// Natural logarithm of the factor that each of them lacks.
    ln_factor: Vec<f64>,
}

/// An approximate eigenvalue.
#[derive(Debug, Clone, Copy)]
pub struct Eigenvalue {
    /// The eigenvalue γ.
    pub value: c64,
    /// Norm of the residual of its unit vector.
    pub residual: f64,
}

impl Powers {
    /// Adds what the channels see of the next power: exp(`ln_factor`) `seen`. Shape: channels × vectors.
    pub fn push(&mut self, seen: Mat<c64>, ln_factor: f64) {
        self.seen.push(seen);
        self.ln_factor.push(ln_factor);
    }

    /// Eigenvalues by the powers from `first` on, in no order; `None` where there are fewer than three of these, and if an iteration fails. Those
    /// whose modulus is far below the largest are missing or have a large residual.
    #[must_use]
    pub fn eigenvalues(&self, first: usize) -> Option<Vec<Eigenvalue>> {
        let n = self.seen.len().checked_sub(first + 1).filter(|n| *n > 1)?;
        let ln_norm = |k: usize| self.ln_factor[k] + libm::log(self.seen[k].norm_l2());
        let (start, end) = (ln_norm(first), ln_norm(first + n));
        if end == f64::NEG_INFINITY {
            // nothing is left of the vectors
            return Some(Vec::new());
        }
        let ln_growth = (end - start) / n as f64;
        let level = |k: usize| start + k as f64 * ln_growth;
        let levels: Vec<f64> = (0..n).map(level).collect();
        let [u, v] = [first, first + 1].map(|first| self.transform(first, &levels));
        let (channels, vectors) = self.seen[first].shape();
        let windows = n.div_ceil(STRIDE);
        let mut found = Vec::new();
        for window in 0..windows {
            let [low, high] =
                [window, window + 1].map(|border| (border * n) as f64 / windows as f64 - OFFSET);
            let middle = 0.5 * (low + high);
            let count = ANGLES.min(n);
            let from = middle.round() as usize + n - count / 2;
            let columns = |of: &Mat<c64>| {
                Mat::from_fn(channels, count * vectors, |i, j| {
                    of[((from + j / vectors) % n, j % vectors * channels + i)]
                })
            };
            let turn = -TAU * middle / n as f64;
            let turn = c64::new(libm::cos(turn), libm::sin(turn));
            let half = PI * (high - low) / n as f64;
            let inside = |of: &Eigenvalue| {
                let turned = of.value * turn;
                let angle = libm::atan2(turned.im, turned.re);
                // one window has them all
                windows == 1 || (angle >= -half && angle < half)
            };
            let here = in_window(columns(&u), columns(&v))?;
            found.extend(here.into_iter().filter(inside));
        }
        Some(found)
    }

    /// Tapered transforms of the powers from `first` on, each over exp(its level). Shape: powers × vectors · channels.
    fn transform(&self, first: usize, levels: &[f64]) -> Mat<c64> {
        let (channels, vectors) = self.seen[first].shape();
        let n = levels.len();
        let weight = |k: usize| {
            let taper = libm::sin(PI * (k as f64 + 0.5) / n as f64).powi(4);
            taper * libm::exp(self.ln_factor[first + k] - levels[k])
        };
        let weights: Vec<f64> = (0..n).map(weight).collect();
        let mut of = Mat::from_fn(n, vectors * channels, |k, column| {
            self.seen[first + k][(column % channels, column / channels)] * weights[k]
        });
        let fourier = FftPlanner::new().plan_fft_forward(n);
        (0..of.ncols()).for_each(|column| fourier.process(of.col_as_slice_mut(column)));
        of
    }
}

/// Eigenvalues of the map that takes the columns of `u` to those of `v`.
fn in_window(mut u: Mat<c64>, mut v: Mat<c64>) -> Option<Vec<Eigenvalue>> {
    for j in 0..u.ncols() {
        let norm = u.col(j).norm_l2();
        if norm > 0.0 {
            let scale = Scale(c64::new(1.0 / norm, 0.0));
            for of in [&mut u, &mut v] {
                let mut column = of.col_mut(j);
                column *= scale;
            }
        }
    }
    let parts = u.thin_svd().ok()?;
    let sizes: Vec<f64> = parts.S().column_vector().iter().map(|s| s.re).collect();
    let rank = sizes.iter().filter(|s| **s > NOISE * sizes[0]).count();
    let basis = parts.U().subcols(0, rank);
    let combine = Mat::from_fn(u.ncols(), rank, |i, j| parts.V()[(i, j)] / sizes[j]);
    let image = v * &combine;
    let projected = basis.adjoint() * &image;
    let pairs = projected.eigen().ok()?;
    let vectors = pairs.U();
    let [before, after, share] = [basis * vectors, &image * vectors, combine * vectors];
    let found = (0..rank).filter_map(|k| {
        let value = pairs.S()[k];
        let norm = before.col(k).norm_l2();
        let missing = (before.col(k).iter().zip(after.col(k).iter()))
            .map(|(x, y)| (y - value * x).norm_sqr())
            .sum::<f64>();
        (norm > FAINT * share.col(k).norm_l2()).then_some(Eigenvalue {
            value,
            residual: missing.sqrt() / norm,
        })
    });
    Some(found.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of eigenvalues: one of the modulus `largest`, 79 more that last, two of them close to each other, and 40 that do not; a shear makes the
    /// eigenvectors oblique.
    fn map(largest: f64) -> Mat<f64> {
        let n = 240;
        let pair = |k: usize| match k {
            0 => (largest, 0.7),
            2 => (0.9995, 2.4 + 1e-3),
            1..80 => (0.9995 - 1e-6 * k as f64, 2.4 * k as f64),
            _ => (0.9 - 0.01 * (k - 80) as f64, 0.3 * k as f64),
        };
        let turned = Mat::from_fn(n, n, |i, j| {
            let (size, angle) = pair(i / 2);
            match (i / 2 == j / 2, i % 2, j % 2) {
                (false, ..) => 0.0,
                (true, 0, 1) => -size * libm::sin(angle),
                (true, 1, 0) => size * libm::sin(angle),
                _ => size * libm::cos(angle),
            }
        });
        let shear = Mat::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) + 0.3 * f64::from(u8::from(j == i + 1))
        });
        let sheared = &shear * turned;
        let right = shear
            .transpose()
            .partial_piv_lu()
            .solve(sheared.transpose());
        right.transpose().to_owned()
    }

    /// Powers of a map, applied to four vectors, seen through 192 channels.
    fn powers(map: &Mat<f64>, count: usize) -> Powers {
        let mixed = |i: usize, j: usize| libm::sin(1.0 + (i * i) as f64 + 7.3 * (i * j + j) as f64);
        let n = map.nrows();
        let channels = Mat::from_fn(192, n, mixed);
        let mut vectors = Mat::from_fn(n, 4, |i, j| mixed(i, j + 1000));
        let mut powers = Powers::default();
        let mut ln_factor = 0.0;
        for _ in 0..count {
            let seen = &channels * &vectors;
            let complex = Mat::from_fn(192, 4, |i, j| c64::new(seen[(i, j)], 0.0));
            powers.push(complex, ln_factor);
            vectors = map * &vectors;
            let norm = vectors.norm_l2();
            if norm > 0.0 {
                vectors *= Scale(1.0 / norm);
                ln_factor += libm::log(norm);
            }
        }
        powers
    }

    fn nearest(to: c64, of: impl Iterator<Item = c64>) -> f64 {
        of.map(|other| (other - to).norm())
            .fold(f64::INFINITY, f64::min)
    }

    /// Compared with all eigenvalues by the dense routine, in two cases: one eigenvalue grows slowly, or one grows so much that it hides the
    /// others. None near the largest modulus is missed, and none with a small residual is false. Seen to fail with windows of 6 angles,
    /// narrower than their distance.
    #[test]
    fn finds_all_eigenvalues_near_the_largest() {
        for (largest, count, last) in [(1.003, 79, 0.999), (1.8, 0, 1.7)] {
            let map = map(largest);
            let all = map.eigenvalues().expect("eigenvalues");
            let found = powers(&map, 160).eigenvalues(40).expect("eigenvalues");
            let lasting: Vec<c64> = all.iter().copied().filter(|m| m.norm() > last).collect();
            assert_eq!(lasting.len(), 2 * (count + 1));
            let sure = found.iter().filter(|of| of.residual < 1e-6);
            let missed = lasting
                .iter()
                .map(|m| nearest(*m, sure.clone().map(|of| of.value)));
            let missed = missed.fold(0.0, f64::max);
            let wrong = sure.map(|of| nearest(of.value, all.iter().copied()));
            let wrong = wrong.fold(0.0, f64::max);
            println!("{} found, {missed:e} {wrong:e}", found.len());
            assert!(missed < 1e-8 && wrong < 1e-5, "{missed:e} {wrong:e}");
        }
    }

    /// Too few powers for all that last: those which are not known say so by their residuals. What has died out has no eigenvalue, and two
    /// powers are no series.
    #[test]
    fn says_what_it_does_not_know() {
        let found = powers(&map(1.003), 50).eigenvalues(10).expect("some");
        let worst = found.iter().filter(|of| of.value.norm() > 0.99);
        let worst = worst.map(|of| of.residual).fold(0.0, f64::max);
        assert!(worst > 1e-4, "{worst:e}");
        let shift = Mat::from_fn(9, 9, |i, j| f64::from(u8::from(j == i + 1)));
        let none = powers(&shift, 40).eigenvalues(10).expect("none");
        assert!(none.is_empty());
        assert!(powers(&shift, 2).eigenvalues(0).is_none());
    }
}
