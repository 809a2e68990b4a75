//! Vector loops that the compiler turns into vector instructions without changing bits: those of the instruction set
//! that their caller is compiled for.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul};

/// Partial sums of an inner product: of its main part, and of what that leaves.
const LANES: usize = 32;
const FEWER_LANES: usize = 8;

/// Partial sums of an inner product in single precision.
const SINGLE_LANES: usize = 64;

/// Inner product in partial sums, in a fixed order.
#[must_use]
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    in_partial_sums::<f64, LANES>(a, b)
}

/// The same in single precision.
#[must_use]
#[inline(always)]
pub fn single_dot(a: &[f32], b: &[f32]) -> f32 {
    in_partial_sums::<f32, SINGLE_LANES>(a, b)
}

#[inline(always)]
fn in_partial_sums<T, const N: usize>(a: &[T], b: &[T]) -> T
where
    T: Copy + Default + Add<Output = T> + Mul<Output = T> + AddAssign + Sum,
{
    let ((a, a_left), (b, b_left)) = (a.as_chunks::<N>(), b.as_chunks::<N>());
    let mut sums = [T::default(); N];
    for (a, b) in a.iter().zip(b) {
        for ((sum, x), y) in sums.iter_mut().zip(a).zip(b) {
            *sum += *x * *y;
        }
    }
    let (a, a_left) = a_left.as_chunks::<FEWER_LANES>();
    let (b, b_left) = b_left.as_chunks::<FEWER_LANES>();
    for (a, b) in a.iter().zip(b) {
        for ((sum, x), y) in sums.iter_mut().zip(a).zip(b) {
            *sum += *x * *y;
        }
    }
    let rest: T = a_left.iter().zip(b_left).map(|(x, y)| *x * *y).sum();
    // pair by pair: one after the other would take longer than a short product
    let mut width = N;
    while width > 1 {
        width /= 2;
        for i in 0..width {
            let other = sums[i + width];
            sums[i] += other;
        }
    }
    sums[0] + rest
}

/// ‖a‖₂.
#[must_use]
#[inline(always)]
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// y += factor x.
#[inline(always)]
pub fn axpy<T: Copy + Mul<Output = T> + AddAssign>(factor: T, x: &[T], y: &mut [T]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * *x;
    }
}

/// y += factor x with the `[real, imaginary]` part of x; factor and y in cosine and sine coefficients, ŷ = y_c − i y_s.
#[inline(always)]
pub fn axpy_complex(factor: (f64, f64), x: [&[f64]; 2], y: (&mut [f64], &mut [f64])) {
    for (((c, s), re), im) in (y.0.iter_mut().zip(y.1)).zip(x[0]).zip(x[1]) {
        *c += re * factor.0 + im * factor.1;
        *s += re * factor.1 - im * factor.0;
    }
}
