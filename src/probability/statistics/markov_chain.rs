//! Whether Markov chains have forgotten their starts, and how many independent draws they count for.
//!
//! Split R̂ of rank-normalised draws, and effective sample sizes of the bulk and the tails: Vehtari, Gelman, Simpson, Carpenter &
//! Bürkner, Bayesian Anal. 16 (2021) 667–718. Shape of `chains` everywhere: chains × draws, all of one length.

use crate::special::normal_quantile;

/// Diagnostics of one number of the chains.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Mixing {
    /// Split R̂: the larger one of the rank-normalised draws and of their distances from the median. 1 where chains agree.
    pub r_hat: f64,
    /// Independent draws that the chains count for in the middle of the distribution.
    pub bulk_effective: f64,
    /// The same at the 5 % and the 95 % quantile, the smaller one.
    pub tail_effective: f64,
}

/// Fewest draws of a chain that diagnostics take.
const FEWEST_DRAWS: usize = 8;
/// Probability of each tail.
const TAIL: f64 = 0.05;

/// Diagnostics of `chains`; `None` for fewer than 8 draws, or draws that do not differ or are not finite.
#[must_use]
pub fn mixing(chains: &[Vec<f64>]) -> Option<Mixing> {
    let halves = split(chains)?;
    let all: Vec<f64> = halves.concat();
    let finite = all.iter().all(|v| v.is_finite());
    let differ = all.iter().any(|v| *v != all[0]);
    if !finite || !differ {
        return None;
    }
    let mut sorted = all;
    sorted.sort_by(f64::total_cmp);
    let at = |p: f64| sorted[((p * sorted.len() as f64) as usize).min(sorted.len() - 1)];
    let median = at(0.5);
    let scores = normal_scores(&halves);
    let folded = normal_scores(&each(&halves, |v| (v - median).abs()));
    let tails = [TAIL, 1.0 - TAIL].map(|p| {
        let limit = at(p);
        effective(&each(&halves, |v| f64::from(u8::from(v <= limit))))
    });
    Some(Mixing {
        r_hat: r_hat(&scores).max(r_hat(&folded)),
        bulk_effective: effective(&scores),
        tail_effective: tails[0].min(tails[1]),
    })
}

/// Each chain as its two halves: a chain that drifts disagrees with itself.
fn split(chains: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = chains.first()?.len();
    if n < FEWEST_DRAWS || chains.iter().any(|chain| chain.len() != n) {
        return None;
    }
    let half = n / 2;
    let halves = chains.iter().flat_map(|c| [&c[..half], &c[n - half..]]);
    Some(halves.map(<[f64]>::to_vec).collect())
}

fn each(chains: &[Vec<f64>], of: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
    let chain = |chain: &Vec<f64>| chain.iter().map(|v| of(*v)).collect();
    chains.iter().map(chain).collect()
}

/// Φ⁻¹((rank − 3/8) / (n + 1/4)) of the draws of all chains together; ties have their mean rank.
fn normal_scores(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let draws = chains[0].len();
    let all: Vec<f64> = chains.concat();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|a, b| all[*a].total_cmp(&all[*b]));
    let mut scores = vec![0.0; all.len()];
    let mut first = 0;
    while first < order.len() {
        let tied = order[first..]
            .iter()
            .take_while(|&&i| all[i] == all[order[first]]);
        let count = tied.count();
        let rank = first as f64 + 0.5 * (count as f64 + 1.0);
        let score = normal_quantile((rank - 0.375) / (all.len() as f64 + 0.25));
        for &i in &order[first..first + count] {
            scores[i] = score;
        }
        first += count;
    }
    scores.chunks(draws).map(<[f64]>::to_vec).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean variance within chains, and the estimate of the variance of all that counts their means in. Shape: W, var⁺.
fn variances(chains: &[Vec<f64>]) -> [f64; 2] {
    let n = chains[0].len() as f64;
    let means: Vec<f64> = chains.iter().map(|chain| mean(chain)).collect();
    let square = |values: &[f64], about: f64| -> f64 {
        values.iter().map(|v| (v - about).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
    };
    let within: Vec<f64> = (chains.iter().zip(&means))
        .map(|(chain, m)| square(chain, *m))
        .collect();
    let within = mean(&within);
    let between = match means.len() {
        1 => 0.0,
        _ => square(&means, mean(&means)),
    };
    [within, within * (n - 1.0) / n + between]
}

fn r_hat(chains: &[Vec<f64>]) -> f64 {
    let [within, all] = variances(chains);
    match within > 0.0 {
        true => (all / within).sqrt(),
        false => f64::INFINITY,
    }
}

/// Effective sample size by Geyer's initial monotone sequence; at most n log10 n of n draws, as chains that alternate give more.
fn effective(chains: &[Vec<f64>]) -> f64 {
    let draws = chains[0].len();
    let total = (chains.len() * draws) as f64;
    let [within, all] = variances(chains);
    if all <= 0.0 {
        return total;
    }
    let means: Vec<f64> = chains.iter().map(|chain| mean(chain)).collect();
    let correlation = |lag: usize| {
        let of_chain = |(chain, m): (&Vec<f64>, &f64)| {
            let pairs = chain.iter().zip(&chain[lag..]);
            pairs.map(|(a, b)| (a - m) * (b - m)).sum::<f64>() / draws as f64
        };
        let covariances: Vec<f64> = chains.iter().zip(&means).map(of_chain).collect();
        1.0 - (within - mean(&covariances)) / all
    };
    let (mut sum, mut least, mut lag) = (0.0, f64::INFINITY, 0);
    while lag + 1 < draws {
        let pair = correlation(lag) + correlation(lag + 1);
        if pair < 0.0 {
            break;
        }
        least = least.min(pair);
        sum += least;
        lag += 2;
    }
    let time = (2.0 * sum - 1.0).max(1.0 / total.log10());
    total / time
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Chains x' = ρ x + √(1 − ρ²) e of normal numbers, each with its own mean.
    fn chains(rho: f64, means: &[f64], draws: usize) -> Vec<Vec<f64>> {
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        let mut normal = move || {
            let u = (generator.next_u64() >> 12) as f64 + 0.5;
            normal_quantile(u / (1_u64 << 52) as f64)
        };
        means
            .iter()
            .map(|m| {
                let mut x = normal();
                let mut next = || {
                    x = rho * x + (1.0 - rho * rho).sqrt() * normal();
                    x + m
                };
                (0..draws).map(|_| next()).collect()
            })
            .collect()
    }

    /// A first-order autoregression of n draws counts for n (1 − ρ)/(1 + ρ). Seen to fail with half of the sum over the lags.
    #[test]
    fn correlated_draws_count_for_fewer() {
        for rho in [0.0, 0.5, 0.9] {
            let found = mixing(&chains(rho, &[0.0; 4], 4000)).unwrap();
            let expected = 16000.0 * (1.0 - rho) / (1.0 + rho);
            let ratio = found.bulk_effective / expected;
            assert!((0.8..1.25).contains(&ratio), "{rho}: {found:?}, {expected}");
            assert!(found.r_hat < 1.01, "{rho}: {found:?}");
            assert!(found.tail_effective > 0.4 * expected, "{rho}: {found:?}");
        }
    }

    /// Chains around other means, a chain that drifts, and chains of other widths disagree. Seen to fail without the variance of the
    /// means.
    #[test]
    fn chains_that_disagree_are_seen() {
        let apart = mixing(&chains(0.0, &[0.0, 0.0, 0.0, 2.0], 500)).unwrap();
        assert!(
            apart.r_hat > 1.1 && apart.bulk_effective < 50.0,
            "{apart:?}"
        );
        let mut drifting = chains(0.0, &[0.0], 1000);
        for (i, v) in drifting[0].iter_mut().enumerate() {
            *v += 3.0 * i as f64 / 1000.0;
        }
        let drifting = mixing(&drifting).unwrap();
        assert!(drifting.r_hat > 1.1, "{drifting:?}");
        let mut wide = chains(0.0, &[0.0; 4], 500);
        wide[0].iter_mut().for_each(|v| *v *= 4.0);
        let wide = mixing(&wide).unwrap();
        assert!(wide.r_hat > 1.05, "{wide:?}");
    }

    /// Constant, short and broken chains have no diagnostics.
    #[test]
    fn what_cannot_be_diagnosed_is_none() {
        assert_eq!(mixing(&[vec![1.0; 100]]), None, "constant");
        assert_eq!(mixing(&[vec![1.0, 2.0, 3.0]]), None, "short");
        let mut broken = chains(0.0, &[0.0], 100);
        broken[0][3] = f64::NAN;
        assert_eq!(mixing(&broken), None, "not finite");
        assert_eq!(mixing(&[]), None, "no chain");
    }
}
