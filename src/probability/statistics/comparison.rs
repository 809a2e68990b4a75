//! Designs compared on the same samples of the uncertain inputs (common random numbers).

use super::bootstrap::Bootstrap;
use super::observed::{Enclosed, Observed, Sorted};
use super::order_statistic::{QuantileEstimate, quantile_estimate, quantile_rank};
use super::proportion::{Share, share};

/// Which of two results is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Better {
    /// The smaller one, as of amplitudes.
    Smaller,
    /// The larger one, as of margins.
    Larger,
}

/// Design A against design B on the same samples.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Median of the differences A − B with its interval; absent if no pair is solved.
    pub median_difference: Option<QuantileEstimate>,
    /// P(A better than B): yes = better, no = worse or equal, unknown = one of the pair failed.
    pub a_better: Share,
    /// P(B better than A).
    pub b_better: Share,
}

/// Difference a − b of a pair: 0 where its enclosures meet, which is a tie and no win by numerical error; NaN where one of both is not known.
#[must_use]
pub fn difference(a: &Enclosed, b: &Enclosed) -> f64 {
    let known = a.value.is_finite() && b.value.is_finite();
    let apart = a.upper < b.lower || b.upper < a.lower;
    match (known, apart) {
        (false, _) => f64::NAN,
        (true, true) => a.value - b.value,
        (true, false) => 0.0,
    }
}

/// Paired comparison. Shape: entry i of both belongs to sample i; a value that is not finite is a failed sample.
///
/// The difference of a pair in which one failed is not known, and counts as such in every interval. `None` without
/// samples or with confidence outside (0, 1).
#[must_use]
pub fn compare(
    a: &[Enclosed],
    b: &[Enclosed],
    better: Better,
    confidence: f64,
) -> Option<Comparison> {
    assert_eq!(a.len(), b.len(), "both designs on the same samples");
    let pairs = a.iter().zip(b);
    let differences: Vec<f64> = pairs.map(|(a, b)| difference(a, b)).collect();
    let unknown = differences.iter().filter(|d| d.is_nan()).count();
    let smaller = differences.iter().filter(|d| **d < 0.0).count();
    let larger = differences.iter().filter(|d| **d > 0.0).count();
    let (wins, losses) = match better {
        Better::Smaller => (smaller, larger),
        Better::Larger => (larger, smaller),
    };
    let n = differences.len() - unknown;
    Some(Comparison {
        // a difference of finite numbers may overflow and is then unknown too
        median_difference: quantile_estimate(&Observed::of(differences), 0.5, confidence),
        a_better: share(wins, n - wins, unknown, confidence)?,
        b_better: share(losses, n - losses, unknown, confidence)?,
    })
}

/// Ranking of designs by a quantile of their results.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Ranking {
    /// Indices of the designs, best first, by the quantile of the samples that every design solved.
    pub order: Vec<usize>,
    /// Share of the resamples in which this order holds for every value that failed samples could have had and wherever the others lie in
    /// their enclosures.
    pub surely: f64,
    /// Share of the resamples in which it holds for some such values.
    pub possibly: f64,
    /// Per design, the share of the resamples in which it is surely the best, and possibly the best.
    pub best: Vec<(f64, f64)>,
    /// Samples that every design solved.
    pub valid: usize,
    /// Samples that some design failed.
    pub failed: usize,
}

/// Ranks designs by their p-quantile; resamples draw the same samples for all, which keeps the pairing.
///
/// Shape: `designs[k][i]` is the result of design k at sample i; one whose value is not finite is a failed sample. `None`
/// without designs, without a sample that all solved, without replicates, or with a probability outside (0, 1).
#[must_use]
pub fn rank_designs(
    designs: &[Vec<Enclosed>],
    probability: f64,
    better: Better,
    bootstrap: &Bootstrap,
) -> Option<Ranking> {
    let n = designs.first()?.len();
    for design in designs {
        assert_eq!(design.len(), n, "all designs on the same samples");
    }
    if !(probability > 0.0 && probability < 1.0) || bootstrap.replicates == 0 {
        return None;
    }
    let solved: Vec<usize> = (0..n)
        .filter(|&i| designs.iter().all(|design| design[i].value.is_finite()))
        .collect();
    let costs = |chosen: &[usize]| -> Vec<(f64, f64)> {
        let range = |design: &Vec<Enclosed>| cost_range(design, chosen, probability, better);
        designs.iter().map(range).collect()
    };
    let nominal: Vec<f64> = (designs.iter())
        .map(|design| nominal_cost(design, &solved, probability, better))
        .collect();
    let mut order: Vec<usize> = (0..designs.len()).collect();
    order.sort_by(|&i, &j| nominal[i].total_cmp(&nominal[j]).then(i.cmp(&j)));
    let (mut surely, mut possibly) = (0, 0);
    let mut best = vec![(0, 0); designs.len()];
    for replicate in 0..bootstrap.replicates {
        let costs = costs(&bootstrap.resample(replicate, n));
        surely += usize::from(order.windows(2).all(|w| costs[w[0]].1 < costs[w[1]].0));
        possibly += usize::from(may_ascend(order.iter().map(|&k| costs[k])));
        for (k, (sure, possible)) in best.iter_mut().enumerate() {
            let others = || (0..costs.len()).filter(|&other| other != k);
            *sure += usize::from(others().all(|other| costs[k].1 < costs[other].0));
            *possible += usize::from(others().all(|other| costs[k].0 <= costs[other].1));
        }
    }
    let fraction = |count: usize| count as f64 / f64::from(bootstrap.replicates);
    (!solved.is_empty()).then(|| Ranking {
        order,
        surely: fraction(surely),
        possibly: fraction(possibly),
        best: best
            .into_iter()
            .map(|(s, p)| (fraction(s), fraction(p)))
            .collect(),
        valid: solved.len(),
        failed: n - solved.len(),
    })
}

/// Quantile of samples that are solved, as computed, as a cost (small = good).
fn nominal_cost(design: &[Enclosed], solved: &[usize], probability: f64, better: Better) -> f64 {
    let values = Sorted::finite(solved.iter().map(|&i| design[i].value));
    let quantile = values.order_statistic(quantile_rank(solved.len(), probability));
    let quantile = quantile.unwrap_or(f64::NAN);
    match better {
        Better::Smaller => quantile,
        Better::Larger => -quantile,
    }
}

/// Least and largest quantile of the chosen samples over all values that they can have, as a cost (small = good).
fn cost_range(
    design: &[Enclosed],
    chosen: &[usize],
    probability: f64,
    better: Better,
) -> (f64, f64) {
    let results: Vec<Enclosed> = chosen.iter().map(|&i| design[i]).collect();
    let observed = Observed::enclosed(&results);
    let rank = quantile_rank(chosen.len(), probability);
    let low = observed.lowest(rank).value().unwrap_or(f64::NEG_INFINITY);
    let high = observed.highest(rank).value().unwrap_or(f64::INFINITY);
    match better {
        Better::Smaller => (low, high),
        Better::Larger => (-high, -low),
    }
}

/// Whether one value can be taken from each range so that they do not descend.
fn may_ascend(ranges: impl Iterator<Item = (f64, f64)>) -> bool {
    let mut least = f64::NEG_INFINITY;
    for (low, high) in ranges {
        least = least.max(low);
        if least > high {
            return false;
        }
    }
    true
}
