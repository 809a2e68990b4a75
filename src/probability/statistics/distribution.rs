//! Empirical distribution function, histogram and rank correlation.

use super::observed::Sorted;
use super::order_statistic::quantile;
use super::sensitivity::varies;

/// Corners (x, F(x)) of the empirical distribution function: one per distinct value, F just after the step.
#[must_use]
pub fn empirical_cdf(sorted: &Sorted) -> Vec<(f64, f64)> {
    let values = sorted.values();
    let mut corners: Vec<(f64, f64)> = Vec::with_capacity(values.len());
    for (i, &x) in values.iter().enumerate() {
        let share = (i + 1) as f64 / values.len() as f64;
        match corners.last_mut() {
            Some(last) if last.0 == x => last.1 = share,
            _ => corners.push((x, share)),
        }
    }
    corners
}

/// One bin [lower, upper) of a histogram; the last bin includes its upper edge.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Bin {
    /// Lower edge.
    pub lower: f64,
    /// Upper edge.
    pub upper: f64,
    /// Number of values inside.
    pub count: usize,
}

/// Equal bins over the range of the values, at most `max_bins`; empty without values.
///
/// Width 2 · IQR / n^(1/3) (Freedman & Diaconis, Z. Wahrscheinlichkeitstheorie 57 (1981) 453–476).
/// Values that are all equal share one bin of width 0.
#[must_use]
pub fn histogram(sorted: &Sorted, max_bins: usize) -> Vec<Bin> {
    let values = sorted.values();
    let (Some(&first), Some(&last)) = (values.first(), values.last()) else {
        return Vec::new();
    };
    let range = last - first;
    let quartile = |p| quantile(sorted, p).unwrap_or(first);
    let width = 2.0 * (quartile(0.75) - quartile(0.25)) / (values.len() as f64).cbrt();
    let wanted = if range <= 0.0 {
        1.0
    } else if width > 0.0 {
        (range / width).ceil()
    } else {
        max_bins as f64
    };
    let n_bins = (wanted as usize).clamp(1, max_bins.max(1));
    let edge = |i: usize| first + range * i as f64 / n_bins as f64;
    let mut bins: Vec<Bin> = (0..n_bins)
        .map(|i| Bin {
            lower: edge(i),
            upper: edge(i + 1),
            count: 0,
        })
        .collect();
    for &value in values {
        let i = bins.partition_point(|bin| bin.upper <= value);
        bins[i.min(n_bins - 1)].count += 1;
    }
    bins
}

/// Spearman's rank correlation of pairs, ties at their mean rank; `None` unless both sides vary by more than rounding.
///
/// Pairs with a non-finite member are left out.
#[must_use]
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let kept = || pairs.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    if !varies(kept().map(|p| p.0)) || !varies(kept().map(|p| p.1)) {
        return None;
    }
    let x = centred_ranks(&kept().map(|p| p.0).collect::<Vec<_>>());
    let y = centred_ranks(&kept().map(|p| p.1).collect::<Vec<_>>());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale = (dot(&x, &x) * dot(&y, &y)).sqrt();
    (scale > 0.0).then(|| (dot(&x, &y) / scale).clamp(-1.0, 1.0))
}

/// Ranks minus their mean (n + 1)/2; equal values share their mean rank.
pub(super) fn centred_ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    // equal values share a rank, whatever their order
    order.sort_unstable_by(|&i, &j| values[i].total_cmp(&values[j]));
    let mut ranks = vec![0.0; values.len()];
    let mut start = 0;
    for tie in order.chunk_by(|&i, &j| values[i] == values[j]) {
        let middle = start as f64 + (tie.len() - 1) as f64 / 2.0;
        for &i in tie {
            ranks[i] = middle - (values.len() - 1) as f64 / 2.0;
        }
        start += tie.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail when ties made two corners.
    #[test]
    fn distribution_function_steps_at_distinct_values() {
        let cdf = empirical_cdf(&Sorted::finite([2.0, 1.0, 2.0, 4.0]));
        assert_eq!(cdf, [(1.0, 0.25), (2.0, 0.75), (4.0, 1.0)]);
    }

    /// Seen to fail without the `min` that keeps the maximum in the last bin.
    #[test]
    fn every_value_lands_in_exactly_one_bin() {
        for values in [
            vec![5.0; 4],
            vec![1.0, 1.0, 1.0, 9.0],
            (0..1000).map(f64::from).collect(),
        ] {
            let sorted = Sorted::finite(values);
            let bins = histogram(&sorted, 30);
            assert!(!bins.is_empty() && bins.len() <= 30);
            let total: usize = bins.iter().map(|b| b.count).sum();
            assert_eq!(total, sorted.values().len());
        }
        let uniform = histogram(&Sorted::finite((0..1000).map(f64::from)), 30);
        assert_eq!(uniform.len(), 10);
        assert!(uniform.iter().all(|b| b.count == 100));
        assert!(histogram(&Sorted::default(), 30).is_empty());
    }

    /// Monotone maps have ±1; swapping one of n neighbours costs 6·2/(n(n² − 1)). Seen to fail without tie ranks.
    #[test]
    fn rank_correlation_of_monotone_and_tied_pairs() {
        let monotone: Vec<(f64, f64)> =
            (1..9).map(|i| (f64::from(i), f64::from(i).exp())).collect();
        assert_eq!(rank_correlation(&monotone), Some(1.0));
        let mut swapped = monotone;
        let (a, b) = (swapped[3].1, swapped[4].1);
        (swapped[3].1, swapped[4].1) = (b, a);
        let expected = 1.0 - 12.0 / (8.0 * 63.0);
        assert!((rank_correlation(&swapped).unwrap() - expected).abs() < 1e-12);
        let tied = [(1.0, 1.0), (1.0, 2.0), (2.0, 3.0), (2.0, 4.0)];
        assert!((rank_correlation(&tied).unwrap() - 0.8_f64.sqrt()).abs() < 1e-12);
        assert_eq!(rank_correlation(&[(1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(rank_correlation(&[]), None);
        let noise = |i: i32| 2618.0 * (1.0 + 1e-15 * f64::from(i));
        let rounded: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i), noise(i))).collect();
        assert_eq!(rank_correlation(&rounded), None, "a spread of rounding");
    }
}
