//! A signal as a trigonometric polynomial: its values, derivatives and roots.

use super::roots::zero;
use crate::aft::plan::AftPlan;
use crate::contact::Real;

/// Basis row b(θ). Shape: `[m]`.
#[inline(always)]
pub(in crate::aft) fn basis_row<T: Real>(plan: &AftPlan<T>, theta: T, row: &mut [T]) {
    let (sin, cos) = theta.sine_cosine();
    let (mut c, mut s) = (T::ONE, T::ZERO);
    let mut order = 0;
    row[0] = T::ONE;
    for (&k, pair) in plan.orders[1..].iter().zip(row[1..].chunks_exact_mut(2)) {
        while order < k {
            (c, s) = (c * cos - s * sin, s * cos + c * sin);
            order += 1;
        }
        (pair[0], pair[1]) = (c, s);
    }
}

/// N-th derivative (0 to 2) of the polynomial with coefficients `q` where the basis row is `row`, and the next two.
#[inline(always)]
pub(super) fn derivatives<const N: usize, T: Real>(
    plan: &AftPlan<T>,
    row: &[T],
    q: &[T],
) -> [T; 3] {
    let mut sums = [if N == 0 { q[0] } else { T::ZERO }, T::ZERO, T::ZERO];
    let terms = row[1..].chunks_exact(2).zip(q[1..].chunks_exact(2));
    for (&k, (b, q)) in plan.orders[1..].iter().zip(terms) {
        let k = T::from_f64(k as f64);
        let (even, odd) = (q[0] * b[0] + q[1] * b[1], q[1] * b[0] - q[0] * b[1]);
        let terms = match N {
            0 => [even, k * odd, -(k * k * even)],
            1 => [k * odd, -(k * k * even), -(k * k * k * odd)],
            _ => [-(k * k * even), -(k * k * k * odd), k * k * k * k * even],
        };
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += term;
        }
    }
    sums
}

/// The value of the polynomial with coefficients `q` where the basis row is `row`.
#[inline(always)]
pub(super) fn value<T: Real>(row: &[T], q: &[T]) -> T {
    let terms = row[1..].iter().zip(&q[1..]);
    terms.fold(q[0], |sum, (&b, &q)| sum + b * q)
}

/// The polynomial with coefficients `q` where the basis row is `row`, and its first three derivatives by the phase.
#[inline(always)]
pub(in crate::aft) fn signal_rates<T: Real>(plan: &AftPlan<T>, row: &[T], q: &[T]) -> [T; 4] {
    let [value, rate, bend] = derivatives::<0, T>(plan, row, q);
    let [_, _, jerk] = derivatives::<1, T>(plan, row, q);
    [value, rate, bend, jerk]
}

/// Its derivative by the phase.
#[inline(always)]
pub(in crate::aft) fn rate<T: Real>(plan: &AftPlan<T>, row: &[T], q: &[T]) -> T {
    derivatives::<0, T>(plan, row, q)[1]
}

/// Phase between two ends where the N-th derivative of `q` is `level`; it is above at the second end if `rising`, else at
/// the first. A turning point needs half the digits, since the value there depends on the square of the error.
#[inline(always)]
pub(super) fn root<const N: usize, T: Real>(
    plan: &AftPlan<T>,
    row: &mut [T],
    q: &[T],
    level: T,
    ends: [T; 2],
    rising: bool,
    guess: T,
) -> T {
    let tolerance = if N == 0 {
        T::EPSILON
    } else {
        T::EPSILON.sqrt()
    };
    zero(ends, rising, guess, tolerance, |theta| {
        basis_row(plan, theta, row);
        let [value, slope, curvature] = derivatives::<N, T>(plan, row, q);
        [value - level, slope, curvature]
    })
}
