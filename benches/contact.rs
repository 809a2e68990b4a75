//! Node-states per second of the contact evaluation, with and without tangents.
//!
//! States: random harmonics that decay with the order; half of the samples slip, 3 % are separated, an eighth of the
//! states are stuck, and the circle law takes 3 laps on average.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use microslip::aft::{AftBatch, AftForces, AftPlan, AftSettings, Laps, Want, evaluate};
use microslip::contact::{ContactParameters, FrictionLaw, Real, Recontact};
use microslip::harmonics::HarmonicSet;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const N_STATES: usize = 512;
/// (highest harmonic, points per period)
const SIZES: [(usize, usize); 2] = [(5, 128), (21, 512)];

fn main() {
    divan::main();
}

fn batch<T: Real>(set: &HarmonicSet) -> AftBatch<T> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let m = set.n_coefficients();
    let mut displacement = vec![T::ZERO; 3 * m * N_STATES];
    let mut parameters = Vec::new();
    for s in 0..N_STATES {
        let sizes = [
            10f64.powf(rng.random_range(-0.8..1.2)),
            rng.random_range(0.0..1.3),
        ];
        for (row, values) in displacement.chunks_exact_mut(N_STATES).enumerate() {
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
        n_states: N_STATES,
        displacement,
        parameters,
    }
}

fn measure<T: Real>(bencher: Bencher, (h, n_time): (usize, usize), law: FrictionLaw, want: Want) {
    let set = HarmonicSet::up_to(h);
    let settings = AftSettings {
        n_time,
        law,
        recontact: Recontact::Interpolated,
        laps: Laps::Periodic,
    };
    let plan = AftPlan::<T>::new(&set, settings);
    let batch = batch(&set);
    let mut out = AftForces::default();
    bencher
        .counter(ItemsCount::new(N_STATES))
        .bench_local(|| evaluate(black_box(&plan), black_box(&batch), want, &mut out));
}

#[divan::bench(args = SIZES)]
fn box_forces(bencher: Bencher, size: (usize, usize)) {
    measure::<f64>(bencher, size, FrictionLaw::Box, Want::Forces);
}

#[divan::bench(args = SIZES)]
fn box_tangents(bencher: Bencher, size: (usize, usize)) {
    measure::<f64>(bencher, size, FrictionLaw::Box, Want::ForcesAndTangents);
}

#[divan::bench(args = SIZES)]
fn circle_forces(bencher: Bencher, size: (usize, usize)) {
    measure::<f64>(bencher, size, FrictionLaw::Circle, Want::Forces);
}

#[divan::bench(args = SIZES)]
fn circle_tangents(bencher: Bencher, size: (usize, usize)) {
    measure::<f64>(bencher, size, FrictionLaw::Circle, Want::ForcesAndTangents);
}

#[divan::bench(args = SIZES)]
fn box_forces_f32(bencher: Bencher, size: (usize, usize)) {
    measure::<f32>(bencher, size, FrictionLaw::Box, Want::Forces);
}
