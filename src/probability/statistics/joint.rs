//! Joint tolerance region of two results, such as resonance frequency and amplitude.

use super::limit::{Interval, Limit};
use super::observed::Observed;
use super::tolerance::{tolerance_confidence, tolerance_order};
use std::borrow::Cow;

/// A rectangle that holds a share of the population of pairs.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct JointRegion {
    /// Limits of the first result.
    pub x: Interval,
    /// Limits of the second result.
    pub y: Interval,
    /// Share of the population inside.
    pub content: f64,
    /// Confidence asked for.
    pub confidence: f64,
    /// Confidence reached, not less than what was asked for; 1 if nothing is cut off.
    pub achieved_confidence: f64,
    /// Number of cuts, each through one sample.
    pub cuts: usize,
    /// Samples with both results.
    pub valid: usize,
    /// Failed samples.
    pub failed: usize,
}

/// Sides in the order of the cuts: an upper limit of the second result (the amplitude) comes first.
const SIDES: usize = 4;

/// Region that holds the share `content` with the given confidence; a pair with a value that is not finite is failed.
///
/// The sides y above, x below, x above, y below take turns to cut off the outermost sample that is left. Whatever the
/// law, the share outside after k cuts in n samples exceeds 1 − content with the probability of fewer than k beyond:
/// Wald's statistically equivalent blocks. With f failed samples each side moves out to the order statistic f steps
/// further of all valid ones, which encloses the region for every place where they could have been.
/// Sources: Wald, Ann. Math. Statist. 14 (1943) 45–55; Tukey, Ann. Math. Statist. 18 (1947) 529–539; Guba, Makai & Pál,
/// Reliab. Eng. Syst. Saf. 80 (2003) 217–232 (two-sided 95/95 for two results: n = 153).
#[must_use]
pub fn joint_region(pairs: &[(f64, f64)], content: f64, confidence: f64) -> JointRegion {
    let n = pairs.len();
    let known = |(x, y): &&(f64, f64)| x.is_finite() && y.is_finite();
    let failed = n - pairs.iter().filter(known).count();
    // a copy of a million pairs is left out where it would be the same
    let valid: Cow<'_, [(f64, f64)]> = match failed {
        0 => Cow::Borrowed(pairs),
        _ => pairs.iter().filter(known).copied().collect(),
    };
    let cuts = tolerance_order(n, content, confidence);
    let per_side = |side: usize| (cuts + SIDES - 1 - side) / SIDES;
    let [above_y, below_x, above_x, below_y] = if failed == 0 {
        cut_in_turns(&valid, cuts)
    } else {
        outermost(
            &valid,
            [0, 1, 2, 3].map(|side| per_side(side).saturating_sub(failed)),
        )
    };
    JointRegion {
        x: Interval {
            lower: below_x,
            upper: above_x,
        },
        y: Interval {
            lower: below_y,
            upper: above_y,
        },
        content,
        confidence,
        achieved_confidence: tolerance_confidence(n, content, cuts),
        cuts,
        valid: valid.len(),
        failed,
    }
}

/// How far out a pair (x, y) lies on a side: the larger the further.
fn outwards(side: usize, pair: (f64, f64)) -> f64 {
    let (x, y) = pair;
    match side {
        0 => y,
        1 => -x,
        2 => x,
        _ => -y,
    }
}

/// Limit of a side from how far out it lies, the inverse of [`outwards`].
fn limit(side: usize, outward: Option<f64>) -> Limit {
    let value = |v: f64| match side {
        0 | 2 => v,
        _ => -v,
    };
    outward.map(value).into()
}

/// Limits after the sides took turns in cutting off the outermost pair left.
fn cut_in_turns(valid: &[(f64, f64)], cuts: usize) -> [Limit; SIDES] {
    let order = |side: usize| {
        let further_out = |&i: &usize, &j: &usize| {
            let [of_i, of_j] = [i, j].map(|k| outwards(side, valid[k]));
            of_j.total_cmp(&of_i).then(i.cmp(&j))
        };
        let mut order: Vec<usize> = (0..valid.len()).collect();
        // a side meets no more samples than are cut off in all: the others need no order
        if cuts < order.len() {
            order.select_nth_unstable_by(cuts, further_out);
            order.truncate(cuts);
            order.shrink_to_fit();
        }
        order.sort_unstable_by(further_out);
        order.into_iter()
    };
    let mut orders = [0, 1, 2, 3].map(order);
    let mut gone = vec![false; valid.len()];
    let mut limits = [Limit::Unbounded; SIDES];
    for cut in 0..cuts {
        let side = cut % SIDES;
        if let Some(i) = orders[side].find(|&i| !gone[i]) {
            gone[i] = true;
            limits[side] = limit(side, Some(outwards(side, valid[i])));
        }
    }
    limits
}

/// Limits at the given orders from outside, of all valid pairs; order 0 = unbounded.
fn outermost(valid: &[(f64, f64)], orders: [usize; SIDES]) -> [Limit; SIDES] {
    let mut side = 0;
    orders.map(|order| {
        let all = Observed::of(valid.iter().map(|&pair| outwards(side, pair)));
        let rank = (valid.len() + 1).saturating_sub(order);
        let found = limit(side, all.valid().order_statistic(rank));
        side += 1;
        found
    })
}
