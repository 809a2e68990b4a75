use microslip::aft::*;
use microslip::contact::*;
use microslip::harmonics::HarmonicSet;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n = 512;
    let set = HarmonicSet::up_to(5);
    let m = 11;
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut d = vec![0.0; 3 * m * n];
    let mut p = vec![];
    for s in 0..n {
        let sz = [
            10f64.powf(rng.random_range(-0.8..1.2)),
            rng.random_range(0.0..1.3),
        ];
        for (row, v) in d.chunks_exact_mut(n).enumerate() {
            let o = (row % m).div_ceil(2) as f64;
            v[s] = sz[row / (2 * m)] / (1.0 + o * o) * rng.random_range(-1.0..1.0);
        }
        p.push(ContactParameters {
            k_n: 1.0,
            k_t: [1.0; 2],
            mu: rng.random_range(0.2..0.6),
            n_0: 1.0,
            anchor: [0.0; 2],
        });
    }
    let law = if a[1] == "box" {
        FrictionLaw::Box
    } else {
        FrictionLaw::Circle
    };
    let want = if a[2] == "f" {
        Want::Forces
    } else {
        Want::ForcesAndTangents
    };
    let plan = AftPlan::<f64>::new(
        &set,
        AftSettings {
            n_time: 128,
            law,
            recontact: Recontact::Interpolated,
            laps: Laps::Periodic,
        },
    );
    let b = AftBatch {
        n_states: n,
        displacement: d,
        parameters: p,
    };
    let mut o = AftForces::default();
    let t = std::time::Instant::now();
    let reps = a[3].parse().unwrap();
    for _ in 0..reps {
        evaluate(&plan, &b, want, &mut o);
    }
    println!(
        "{:.0} k/s",
        (n * reps) as f64 / t.elapsed().as_secs_f64() / 1e3
    );
}
