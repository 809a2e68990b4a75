//! Zeros of smooth functions between two samples.

use crate::contact::Real;

/// Most steps of a search; bisection alone needs 52.
const MAX_STEPS: usize = 60;

/// Phase between `low` and `high` where a function is 0, of which `at` gives value, slope and curvature; it is positive at
/// `high` if `rising`, else at `low`. Halley's method from `guess`, with bisection where it would leave the bracket. Ends
/// where the error after the step, a multiple of its cube, is within `tolerance`.
#[inline(always)]
pub(in crate::aft) fn zero<T: Real>(
    [mut low, mut high]: [T; 2],
    rising: bool,
    guess: T,
    tolerance: T,
    mut at: impl FnMut(T) -> [T; 3],
) -> T {
    let half = T::from_f64(0.5);
    let middle = |low: T, high: T| half * (low + high);
    let mut theta = if guess > low && guess < high {
        guess
    } else {
        middle(low, high)
    };
    let width = high - low;
    for _ in 0..MAX_STEPS {
        let [value, slope, curvature] = at(theta);
        if value == T::ZERO {
            break;
        }
        if (value > T::ZERO) == rising {
            high = theta;
        } else {
            low = theta;
        }
        let newton = value / slope;
        let bend = newton * curvature / slope;
        let halley = theta - newton / (T::ONE - half * bend);
        let inside = halley > low && halley < high;
        let next = if inside { halley } else { middle(low, high) };
        let step = (next - theta).abs();
        let share = step / width;
        theta = next;
        let error = step * (bend * bend + share * share);
        if (inside && error <= tolerance) || step <= T::EPSILON * high {
            break;
        }
    }
    theta
}

/// Where a monotone function with these values and rates (times the step) at both ends passes zero, as a share of the
/// interval: by the cubic of the phase over the value, or by the straight line where that leaves the interval.
#[inline(always)]
pub(in crate::aft) fn crossing_share<T: Real>(value: [T; 2], rate: [T; 2]) -> T {
    let line = linear_share(value[0], value[1]);
    let (rest, rise) = (T::ONE - line, value[1] - value[0]);
    let share = line * line * (T::ONE + rest + rest)
        + rise * line * rest * (rest / rate[0] - line / rate[1]);
    if share > T::ZERO && share < T::ONE {
        share
    } else {
        line
    }
}

/// Where a straight line between two values of different sign passes zero, as a share of the interval.
#[inline(always)]
pub(in crate::aft) fn linear_share<T: Real>(before: T, after: T) -> T {
    before / (before - after)
}

/// Where the rate of a cubic with these rates (times the step) at both ends passes zero between them, as a share of the
/// interval; see [`turns_twice`].
#[inline(always)]
pub(in crate::aft) fn turn_share<T: Real>(rise: T, rate: [T; 2]) -> T {
    let two = T::ONE + T::ONE;
    let sign = if rate[0] > T::ZERO { T::ONE } else { -T::ONE };
    let curvature = T::from_f64(3.0) * (rate[0] + rate[1]) - T::from_f64(6.0) * rise;
    let slope = sign * (rate[0] + curvature - rate[1]);
    let root = (slope * slope - two * two * curvature * rate[0]).sqrt();
    two * sign * rate[0] / (slope + root)
}

/// Whether a function of this value and rate (times the step) at both ends dips towards zero and comes back.
#[inline(always)]
pub(in crate::aft) fn dips<T: Real>(value: [T; 2], rate: [T; 2]) -> bool {
    (value[0] * value[1] > T::ZERO)
        & (value[0] * rate[0] < T::ZERO)
        & (value[1] * rate[1] > T::ZERO)
}

/// Whether the cubic of these values and rates (times the step) at both ends turns twice between them. Its rate is
/// r₀ (1 − s) + r₁ s − c s (1 − s) with c = 3 (r₀ + r₁) − 6 Δ, which has roots if c exceeds (√r₀ + √r₁)².
#[inline(always)]
pub(in crate::aft) fn turns_twice<T: Real>(rise: T, rate: [T; 2]) -> bool {
    let sum = rate[0] + rate[1];
    let excess = sum + sum - T::from_f64(6.0) * rise;
    let product = rate[0] * rate[1];
    (product > T::ZERO)
        & (excess * rate[0] > T::ZERO)
        & (excess * excess > T::from_f64(4.0) * product)
}
