//! What the result of a state does not depend on: the states beside it, and what else is wanted.

use super::{forces, plans, random_states, run};
use microslip::aft::{Laps, Tangent, TangentBlock, Want};
use microslip::harmonics::HarmonicSet;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Seen to fail with: the Newton search of a lane ended by the others (`all` for `any` in the loop over laps).
#[test]
fn a_state_does_not_see_its_neighbours() {
    let set = HarmonicSet::up_to(4);
    let states = random_states(&mut ChaCha8Rng::seed_from_u64(9), &set, 37);
    let size = TangentBlock::COUNT * set.n_coefficients().pow(2);
    for plan in plans(&set, &[Laps::Periodic, Laps::Fixed(2)]) {
        let together = run(&plan, &states, Want::ForcesAndTangents);
        for (i, state) in states.iter().enumerate() {
            let alone = run(&plan, std::slice::from_ref(state), Want::ForcesAndTangents);
            assert_eq!(
                forces(&together, i),
                forces(&alone, 0),
                "forces of state {i}"
            );
            assert_eq!(
                together.summaries[i], alone.summaries[0],
                "summary of state {i}"
            );
            match (together.tangents[i], alone.tangents[0]) {
                (Tangent::Blocks(a), Tangent::Blocks(b)) => {
                    assert_eq!(
                        together.blocks[a..][..size],
                        alone.blocks[b..][..size],
                        "{i}"
                    );
                }
                (a, b) => assert_eq!(a, b, "tangent of state {i}"),
            }
        }
    }
}

/// Seen to fail with: states that stick not marched again where the first lap is not recorded.
#[test]
fn forces_alone_are_those_that_come_with_tangents() {
    let set = HarmonicSet::up_to(4);
    let states = random_states(&mut ChaCha8Rng::seed_from_u64(11), &set, 100);
    for plan in plans(&set, &[Laps::Periodic, Laps::Fixed(1), Laps::Fixed(3)]) {
        let mut stuck = 0;
        for state in &states {
            let [alone, with] = [Want::Forces, Want::ForcesAndTangents]
                .map(|want| run(&plan, std::slice::from_ref(state), want));
            stuck += usize::from(with.tangents[0] == Tangent::Stuck);
            assert_eq!(alone.forces, with.forces, "{:?}", plan.settings());
            assert_eq!(alone.summaries, with.summaries, "{:?}", plan.settings());
        }
        assert!(stuck > 2, "{stuck} stuck, {:?}", plan.settings());
    }
}
