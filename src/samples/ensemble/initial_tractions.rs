//! Initial tractions of the contacts, drawn from one number.
//!
//! The mean traction of a contact that sticks for the whole period depends on what it began with. An assembly leaves any traction within
//! the friction limit there, so a study may draw it for each contact. The draw is an input like others: a number in \[0, 1\], of which
//! the tractions of all contacts are a function.

use crate::contact::FrictionLaw;
use crate::sampling::stream::{INITIAL_TRACTION, uniform};
use std::f64::consts::TAU;

/// Tractions over the friction limit, evenly distributed over what the law admits: a square or a disc, and an interval where the contact
/// has one direction with stiffness. Shape of `stiffness` (N/m, both directions) and of the result: `[contacts]`.
pub(super) fn shares(
    draw: f64,
    stiffness: impl Iterator<Item = [f64; 2]>,
    law: FrictionLaw,
) -> Vec<[f64; 2]> {
    let of_pair = |(pair, k_t): (u64, [f64; 2])| {
        let [a, b] = [0, 1].map(|d| uniform(draw.to_bits(), pair, INITIAL_TRACTION + d));
        match law {
            FrictionLaw::Circle if k_t.iter().all(|k| *k > 0.0) => {
                let (sin, cos) = libm::sincos(TAU * b);
                [a.sqrt() * cos, a.sqrt() * sin]
            }
            FrictionLaw::Box | FrictionLaw::Circle => [2.0 * a - 1.0, 2.0 * b - 1.0],
        }
    };
    (0..).zip(stiffness).map(of_pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every share is admissible, their means and squares are those of a square and of a disc, and another number gives others. Seen to
    /// fail with the radius a itself in place of its root.
    #[test]
    fn shares_fill_what_the_law_admits() {
        let n = 20_000;
        for (law, square) in [(FrictionLaw::Box, 1.0 / 3.0), (FrictionLaw::Circle, 0.25)] {
            let stiff = || std::iter::repeat_n([1.0, 2.0], n);
            let found = shares(0.3, stiff(), law);
            let admissible = |[a, b]: &[f64; 2]| match law {
                FrictionLaw::Box => a.abs() < 1.0 && b.abs() < 1.0,
                FrictionLaw::Circle => a * a + b * b < 1.0,
            };
            assert!(found.iter().all(admissible));
            for d in 0..2 {
                let mean = found.iter().map(|s| s[d]).sum::<f64>() / n as f64;
                let squares = found.iter().map(|s| s[d] * s[d]).sum::<f64>() / n as f64;
                assert!(mean.abs() < 0.02, "{law:?}: {mean}");
                assert!((squares / square - 1.0).abs() < 0.03, "{law:?}: {squares}");
            }
            assert_eq!(found, shares(0.3, stiff(), law));
            assert_ne!(found[..2], shares(0.300_000_1, stiff(), law)[..2]);
        }
    }

    /// With one direction both laws are the same. Seen to fail with the disc for every contact of the circle law.
    #[test]
    fn one_direction_fills_its_interval() {
        let shares = |law| shares(0.3, std::iter::repeat_n([1.0, 0.0], 20_000), law);
        let found = shares(FrictionLaw::Circle);
        // 20 000 of them are not to be printed
        assert!(found == shares(FrictionLaw::Box), "the laws differ");
        let squares = found.iter().map(|[a, _]| a * a).sum::<f64>() / 20_000.0;
        assert!((3.0 * squares - 1.0).abs() < 0.03, "{squares}");
    }
}
