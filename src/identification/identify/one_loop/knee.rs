//! The knee of a branch: how the slip limits of the parts of a contact are spread.

use super::slip_limits::{PressureSpread, SlipLimits, TENTH};
use super::weak_part::{WEAK, WeakPart, weak_parts};
use crate::identify::golden::smallest;
use libm::{asin, exp, log, pow};
use std::f64::consts::FRAC_2_PI;

/// How the slip limits of the parts of a contact are spread, over their mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) enum Knee<'m> {
    /// None is below `least` = m, and a share (1 − (x − m)/((1 − m)(1 + q)))^q of the parts still sticks where x is the elastic swing
    /// of the force over that of full slip.
    ///
    /// q = 0 is one limit for all (elastic-Coulomb), q = 1 limits spread evenly, q = 1/2 with m = 0 a pressure like a parabola.
    Spread {
        /// m, from 0 to below 1.
        least: f64,
        /// q ≥ 0.
        exponent: f64,
    },
    /// Those under a rigid flat punch, p = (2/π)/√(1 − t²) with t even from 0 to 1 (Johnson 1985, Contact Mechanics, sec. 2.8): none
    /// is below 2/π, few are very large.
    Punch,
    /// A part of the contact slips early, as a loose edge does: the limits of this share of the area are spread evenly from the least to
    /// the greatest, all others are alike.
    Weak(WeakPart),
    /// Those of a pressure map.
    Map(&'m SlipLimits),
}

/// A branch: displacement since the contact was at its limit, and the share of the swing of T.
#[derive(Debug, Clone)]
pub(super) struct Branch {
    /// Displacement over that at which an elastic branch of a first guess would reach full slip.
    pub(super) displacement: Vec<f64>,
    /// Share of the swing.
    pub(super) share: Vec<f64>,
}

/// The most probable knee, and what the others make of the stiffness of each branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FittedKnee<'m> {
    pub(super) knee: Knee<'m>,
    /// Mean stiffness over all knees, by their probability, over that with this one.
    pub(super) mean: [f64; 2],
    /// Relative standard deviation of the stiffness over all knees, by their probability.
    pub(super) model_error: [f64; 2],
}

/// Least slip limits that are tried...
const LEAST: [f64; 10] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// ...and exponents, besides 0.
const EXPONENTS: [f64; 5] = [0.25, 0.5, 0.75, 1.0, 2.0];
/// Exponents besides these where the share of the area about the mean pressure is stated: most of the contact near the mean, the rest far below it, as where air
/// presses and escapes at the edges.
const FINE_EXPONENTS: [f64; 3] = [0.05, 0.1, 0.15];
/// Standard uncertainty of the share of the contact about the mean: of the map, and because no contact is exactly a knee of the family.
const OF_MAP: f64 = 0.05;
/// Probability of one slip limit for all before the loop is seen, where nothing is known of the pressure.
const ONE_LIMIT: f64 = 0.5;
/// Range of the stiffness that is tried, over the first guess, and steps of the search.
const RANGE: [f64; 2] = [0.7, 1.6];
const STEPS: usize = 16;
/// Elastic swing, over that of full slip, up to which the inverse of the punch's branch is sought, and halvings of a search.
const LONGEST_TAIL: f64 = 20.0;
const HALVINGS: usize = 48;
/// Distance of a branch from the nearest knee of this family, as a share of the swing: no contact is exactly one of them.
const FAMILY: f64 = 2e-3;
/// Independent parts of a branch in which it lies so far off.
const PARTS: f64 = 6.0;
/// Change of a branch by its knee that is told.
const SEEN: f64 = 0.01;
/// Displacement, over that of full slip without a knee, up to which a branch tells its knee.
pub(super) const REACH: f64 = 2.5;

impl Knee<'_> {
    /// Share of the swing at an elastic swing of `x` times that of full slip.
    fn share(&self, x: f64) -> f64 {
        match *self {
            Self::Spread { least: m, .. } if x <= m => x,
            Self::Spread {
                least: m,
                exponent: q,
            } => {
                let z = ((x - m) / ((1.0 - m) * (1.0 + q))).min(1.0);
                m + (1.0 - m) * (1.0 - pow(1.0 - z, 1.0 + q))
            }
            Self::Punch if x <= FRAC_2_PI => x,
            Self::Punch => {
                // parts up to t slip
                let t = (1.0 - (FRAC_2_PI / x).powi(2)).sqrt();
                FRAC_2_PI * asin(t) + x * (1.0 - t)
            }
            Self::Weak(part) => part.share(x),
            Self::Map(limits) => limits.share(x),
        }
    }

    /// Share of the parts whose slip limit is above `x` times the mean.
    fn above(&self, x: f64) -> f64 {
        match *self {
            Self::Spread { least: m, .. } if x <= m => 1.0,
            Self::Spread { exponent: 0.0, .. } => f64::from(u8::from(x < 1.0)),
            Self::Spread {
                least: m,
                exponent: q,
            } => pow((1.0 - (x - m) / ((1.0 - m) * (1.0 + q))).max(0.0), q),
            Self::Punch if x <= FRAC_2_PI => 1.0,
            Self::Punch => 1.0 - (1.0 - (FRAC_2_PI / x).powi(2)).sqrt(),
            Self::Weak(part) => part.above(x),
            Self::Map(limits) => limits.above(x),
        }
    }

    /// Share of the parts whose slip limit is within a tenth of the mean.
    fn even_area(&self) -> f64 {
        self.above(1.0 - TENTH) - self.above(1.0 + TENTH)
    }

    /// Whether it changes a branch up to this share of the swing.
    pub(in crate::identify) fn bends_before(&self, share: f64) -> bool {
        self.elastic(share) > (1.0 + SEEN) * share
    }

    /// The elastic swing at a share of the swing: the inverse.
    pub(super) fn elastic(&self, share: f64) -> f64 {
        match *self {
            Self::Spread {
                least: m,
                exponent: q,
            } => {
                if share <= m || q == 0.0 {
                    return share;
                }
                let w = ((share - m) / (1.0 - m)).min(1.0);
                m + (1.0 - m) * (1.0 + q) * (1.0 - pow(1.0 - w, 1.0 / (1.0 + q)))
            }
            Self::Punch if share <= FRAC_2_PI => share,
            Self::Punch => self.halved([FRAC_2_PI, LONGEST_TAIL], share),
            Self::Weak(part) if share <= part.least => share,
            Self::Weak(part) => self.halved([part.least, part.rest()], share),
            Self::Map(limits) => limits.elastic(share),
        }
    }

    /// The elastic swing at a share of the swing, between two of them, by halving.
    fn halved(&self, [mut low, mut high]: [f64; 2], share: f64) -> f64 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match self.share(middle) < share {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }
}

/// The most probable knee of both branches, each with its own stiffness; the others give mean and model error by their probability.
pub(super) fn fit<'m>(branches: &[Branch; 2], spread: PressureSpread<'m>) -> FittedKnee<'m> {
    let (knees, before): (Vec<Knee<'m>>, Vec<f64>) = possible(spread).into_iter().unzip();
    let fits: Vec<([f64; 2], f64)> = knees.iter().map(|knee| stiffness(branches, knee)).collect();
    let points = branches
        .iter()
        .map(|branch| branch.share.len())
        .sum::<usize>() as f64;
    let smallest = fits
        .iter()
        .map(|(_, square)| *square)
        .fold(f64::INFINITY, f64::min);
    let noise = smallest / (points - 4.0).max(1.0);
    let variance = noise.max(FAMILY * FAMILY * points / PARTS);
    let score = |place: usize| log(before[place]) - 0.5 * (fits[place].1 - smallest) / variance;
    let scores: Vec<f64> = (0..knees.len()).map(score).collect();
    let best = (0..knees.len())
        .max_by(|a, b| scores[*a].total_cmp(&scores[*b]))
        .unwrap_or(0);
    let weights: Vec<f64> = scores.iter().map(|s| exp(s - scores[best])).collect();
    let whole: f64 = weights.iter().sum();
    let expected = |number: &dyn Fn(usize) -> f64| -> f64 {
        let each = weights.iter().enumerate();
        each.map(|(place, w)| w * number(place)).sum::<f64>() / whole
    };
    let mean = [0, 1].map(|side| expected(&|place| fits[place].0[side] / fits[best].0[side]));
    let error = |side: usize| {
        let over = mean[side] * fits[best].0[side];
        expected(&|place| (fits[place].0[side] / over - 1.0).powi(2)).sqrt()
    };
    FittedKnee {
        knee: knees[best],
        mean,
        model_error: [error(0), error(1)],
    }
}

/// Knees with their probability before the loop is seen, up to a factor.
///
/// Where nothing is known of the pressure one limit for all is as probable as all others. Where the share of the contact about the mean
/// is known, those are probable that have it. Where a map is known, it is the knee, to its own uncertainty.
fn possible(spread: PressureSpread<'_>) -> Vec<(Knee<'_>, f64)> {
    match spread {
        PressureSpread::Unknown => {
            let knees = family(&EXPONENTS);
            let others = (1.0 - ONE_LIMIT) / (knees.len() - 1) as f64;
            let before = [ONE_LIMIT].into_iter().chain(std::iter::repeat(others));
            knees.into_iter().zip(before).chain(weak(WEAK)).collect()
        }
        PressureSpread::EvenArea(stated) => {
            let before =
                |knee: &Knee<'_>| exp(-0.5 * ((knee.even_area() - stated) / OF_MAP).powi(2));
            let knees = family(&[&FINE_EXPONENTS[..], &EXPONENTS].concat()).into_iter();
            let each = 1.0 / knees.len() as f64;
            let alike = knees.map(|knee| (knee, each)).chain(weak(WEAK));
            alike.map(|(knee, p)| (knee, p * before(&knee))).collect()
        }
        PressureSpread::Map(known) => {
            let maps = known.maps().iter();
            maps.map(|map| (Knee::Map(&map.limits), map.before))
                .collect()
        }
    }
}

/// Contacts with a weak part, of this probability together.
fn weak<'m>(together: f64) -> impl Iterator<Item = (Knee<'m>, f64)> {
    let parts = weak_parts();
    let each = together / parts.len() as f64;
    parts.into_iter().map(move |part| (Knee::Weak(part), each))
}

/// Knees with these exponents that are tried where no map is known; the first is one limit for all.
fn family<'m>(exponents: &[f64]) -> Vec<Knee<'m>> {
    let spread = |least, exponent| Knee::Spread { least, exponent };
    let mut knees = vec![spread(0.0, 0.0), Knee::Punch];
    for least in LEAST {
        knees.extend(exponents.iter().map(|q| spread(least, *q)));
    }
    knees
}

/// Stiffness of both branches over its first guess, by least squares, and the sum of the squares.
fn stiffness(branches: &[Branch; 2], knee: &Knee<'_>) -> ([f64; 2], f64) {
    let [a, b] = branches.each_ref().map(|branch| {
        let square = |k: f64| -> f64 {
            let both = branch.displacement.iter().zip(&branch.share);
            both.map(|(x, y)| (knee.share(k * x) - y).powi(2)).sum()
        };
        let best = smallest(RANGE, STEPS, square);
        (best, square(best))
    });
    ([a.0, b.0], a.1 + b.1)
}

/// Fewest points of a branch that tell its knee.
pub(super) const LEAST_POINTS: usize = 5;
