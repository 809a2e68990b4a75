//! The largest multipliers of a ring of many unknowns, from what becomes of a few random disturbances of all sectors.
//!
//! Most disturbances that last are modes of the stuck structure that contacts hardly touch: their multipliers fill the unit circle, hundreds in
//! a small disk, and one that grows is found only together with its neighbours. Filter diagonalisation
//! ([`crate::linalg::filter_diagonalization`]) sorts them by angle. Classes of disturbances are looked at one by one.

use super::ring_map::{RingMap, WaveCoordinate};
use crate::linalg::filter_diagonalization::Powers;
use faer::prelude::*;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Disturbances that are marched together.
const DISTURBANCES: usize = 4;

/// Channels by which a class is seen, at most: three times as many as the transforms of a window.
const CHANNELS: usize = 192;

/// Periods after which multipliers are sought for the first time, and those after which the march ends.
const PERIODS: [usize; 2] = [30, 150];

/// Share of the periods in which disturbances that do not last die out.
const TRANSIENT: f64 = 0.15;

/// Error of a multiplier, as its residual states it, over its modulus or 1 (the larger), below which it is known.
const ACCURACY: f64 = 1e-3;

/// The search ends when all multipliers are known whose modulus is less than this below the largest.
const NEAR: f64 = 1e-2;

/// A multiplier.
#[derive(Debug, Clone, Copy)]
pub(super) struct Multiplier {
    pub(super) value: c64,
    /// As its residual states it.
    pub(super) error: f64,
}

/// Multipliers found.
#[derive(Debug)]
pub(super) struct Leading {
    /// The largest modulus first.
    pub(super) multipliers: Vec<Multiplier>,
    /// Whether none of the largest is missing.
    pub(super) settled: bool,
}

impl Multiplier {
    pub(super) fn exact(value: c64) -> Self {
        Self { value, error: 0.0 }
    }

    pub(super) fn is_known(&self) -> bool {
        self.error <= ACCURACY * self.value.norm().max(1.0)
    }
}

/// A coordinate, and the channel that sees it with this sign.
struct Seen {
    coordinate: WaveCoordinate,
    channel: usize,
    sign: f64,
}

/// Powers of the map of a lap, as seen in one class.
struct Class {
    number: usize,
    n_channels: usize,
    coordinates: Vec<Seen>,
    powers: Powers,
}

impl Class {
    fn new(map: &RingMap, number: usize, random: &mut ChaCha8Rng) -> Self {
        let all = map.coordinates_of_class(number);
        let n_channels = CHANNELS.min(all.len());
        // each in one channel, each channel with as many
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.shuffle(random);
        let coordinates = (all.into_iter().zip(order))
            .map(|(coordinate, place)| Seen {
                coordinate,
                channel: place % n_channels,
                sign: if random.random::<bool>() { 1.0 } else { -1.0 },
            })
            .collect();
        Self {
            number,
            n_channels,
            coordinates,
            powers: Powers::default(),
        }
    }

    fn see(&mut self, disturbances: &Mat<f64>, ln_factor: f64) {
        let mut seen = Mat::zeros(self.n_channels, disturbances.ncols());
        for j in 0..disturbances.ncols() {
            let (x, seen) = (disturbances.col_as_slice(j), seen.col_as_slice_mut(j));
            for of in &self.coordinates {
                let at = of.coordinate;
                let imaginary = at.imaginary.map_or(0.0, |row| at.sign * x[row]);
                seen[of.channel] += c64::new(x[at.real], imaginary) * of.sign;
            }
        }
        self.powers.push(seen, ln_factor);
    }
}

/// The largest multipliers of `map`; `None` if an eigenvalue iteration fails.
pub(super) fn leading(map: &RingMap) -> Option<Leading> {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    // those of class −c are the conjugates of those of class c
    let mut classes: Vec<Class> = (0..=map.classes() / 2)
        .map(|number| Class::new(map, number, &mut random))
        .collect();
    let mut disturbances = Mat::from_fn(map.size(), DISTURBANCES, |_, _| {
        random.random::<f64>() - 0.5
    });
    let mut ln_factor = 0.0;
    let [mut periods, last] = PERIODS;
    let mut laps = 0;
    loop {
        while laps <= periods * map.laps() {
            (classes.iter_mut()).for_each(|class| class.see(&disturbances, ln_factor));
            disturbances = map.lap(&disturbances);
            let norm = disturbances.norm_l2();
            if norm > 0.0 {
                disturbances *= Scale(1.0 / norm);
                ln_factor += libm::log(norm);
            }
            laps += 1;
        }
        let found = sought(map, &classes, (TRANSIENT * laps as f64) as usize)?;
        if found.settled || periods == last {
            return Some(found);
        }
        periods = (periods + periods / 2).min(last);
    }
}

/// Multipliers by the laps from `first` on.
fn sought(map: &RingMap, classes: &[Class], first: usize) -> Option<Leading> {
    let power = map.laps() as i32;
    let mut multipliers: Vec<Multiplier> = Vec::new();
    for class in classes {
        let turn = map.turn_of_class(class.number);
        let other = (2 * class.number) % map.classes() != 0;
        for found in class.powers.eigenvalues(first)? {
            let value = found.value.powi(power) * turn;
            let error = value.norm() * f64::from(power) * found.residual / found.value.norm();
            multipliers.push(Multiplier { value, error });
            if other {
                let value = value.conj();
                multipliers.push(Multiplier { value, error });
            }
        }
    }
    multipliers.sort_by(|a, b| b.value.norm_sqr().total_cmp(&a.value.norm_sqr()));
    let largest = multipliers.first().map_or(0.0, |m| m.value.norm());
    let mut near = (multipliers.iter()).take_while(|m| m.value.norm() >= largest - NEAR);
    let settled = near.all(Multiplier::is_known);
    Some(Leading {
        multipliers,
        settled,
    })
}
