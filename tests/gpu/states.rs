//! Contact states for the tests, from stuck ones to bouncing ones.

use microslip::aft::{AftBatch, AftPlan, AftSettings, Laps};
use microslip::contact::{ContactParameters, Events, FrictionLaw, Real};
use microslip::harmonics::HarmonicSet;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The box law with located events.
pub(crate) fn located<T: Real>(set: &HarmonicSet, n_time: usize) -> AftPlan<T> {
    plan(set, n_time, FrictionLaw::Box, Events::Located)
}

/// Either law, until the slider is periodic.
pub(crate) fn plan<T: Real>(
    set: &HarmonicSet,
    n_time: usize,
    law: FrictionLaw,
    events: Events,
) -> AftPlan<T> {
    let settings = AftSettings {
        n_time,
        law,
        events,
        laps: Laps::Periodic,
    };
    AftPlan::new(set, settings)
}

/// Random states in SI units; about a third sticks, and some lift off or never close.
pub(crate) fn random(set: &HarmonicSet, n: usize, seed: u64) -> AftBatch<f64> {
    let m = set.n_coefficients();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut displacement = vec![0.0; 3 * m * n];
    let mut parameters = Vec::with_capacity(n);
    for i in 0..n {
        let k_t = 10f64.powf(rng.random_range(6.0..8.0));
        let k_n = k_t * rng.random_range(0.5..4.0);
        let mu = rng.random_range(0.1..0.8);
        let n_0 = rng.random_range(1.0..10.0);
        let tangential = mu * n_0 / k_t * 10f64.powf(rng.random_range(-1.0..1.3));
        let normal = n_0 / k_n * rng.random_range(0.0..1.6);
        for c in 0..3 {
            let size = [tangential, 0.7 * tangential, normal][c];
            for j in 0..m {
                let order = set.orders()[j.div_ceil(2)].max(1) as f64;
                let x: f64 = StandardNormal.sample(&mut rng);
                displacement[(c * m + j) * n + i] = size * x / order.powf(1.5);
            }
        }
        parameters.push(ContactParameters {
            k_n,
            k_t: [k_t, 0.8 * k_t],
            mu,
            n_0,
            anchor: [0.3 * tangential, 0.0],
        });
    }
    AftBatch {
        n_states: n,
        displacement,
        parameters,
    }
}
