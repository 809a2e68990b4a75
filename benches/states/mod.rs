//! Random contact states: harmonics that decay with the order, about half of the time slips, an eighth of the states is
//! stuck.

use microslip::aft::AftBatch;
use microslip::contact::{ContactParameters, Real};
use microslip::harmonics::HarmonicSet;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// `n` states, the same ones in every run.
pub(super) fn batch<T: Real>(set: &HarmonicSet, n: usize) -> AftBatch<T> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let m = set.n_coefficients();
    let mut displacement = vec![T::ZERO; 3 * m * n];
    let mut parameters = Vec::new();
    for s in 0..n {
        let sizes = [
            10f64.powf(rng.random_range(-0.8..1.2)),
            rng.random_range(0.0..1.3),
        ];
        for (row, values) in displacement.chunks_exact_mut(n).enumerate() {
            let order = (row % m).div_ceil(2) as f64;
            let size = sizes[row / (2 * m)] / (1.0 + order * order);
            values[s] = T::from_f64(size * rng.random_range(-1.0..1.0));
        }
        parameters.push(ContactParameters {
            k_n: T::ONE,
            k_t: [T::ONE; 2],
            mu: T::from_f64(rng.random_range(0.2..0.6)),
            n_0: T::ONE,
            anchor: [T::ZERO; 2],
        });
    }
    AftBatch {
        n_states: n,
        displacement,
        parameters,
    }
}
