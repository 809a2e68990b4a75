//! Vector loops that the compiler turns into vector instructions without changing bits: those of the instruction set
//! that their caller is compiled for.

/// Partial sums of an inner product: of its main part, and of what that leaves.
const LANES: usize = 32;
const FEWER_LANES: usize = 8;

/// Inner product in partial sums, in a fixed order.
#[must_use]
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_left), (b, b_left)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for ((sum, x), y) in sums.iter_mut().zip(a).zip(b) {
            *sum += x * y;
        }
    }
    let (a, a_left) = a_left.as_chunks::<FEWER_LANES>();
    let (b, b_left) = b_left.as_chunks::<FEWER_LANES>();
    for (a, b) in a.iter().zip(b) {
        for ((sum, x), y) in sums.iter_mut().zip(a).zip(b) {
            *sum += x * y;
        }
    }
    let rest: f64 = a_left.iter().zip(b_left).map(|(x, y)| x * y).sum();
    // pair by pair: one after the other would take longer than a short product
    let mut width = LANES;
    while width > 1 {
        width /= 2;
        for i in 0..width {
            sums[i] += sums[i + width];
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
pub fn axpy(factor: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
