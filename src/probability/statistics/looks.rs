//! Looks at a growing number of samples, each with a share of the risk, so that one may stop at any of them.
//!
//! An interval that is judged again and again until it decides is wrong more often than it says. Look j takes the share
//! 1/(j (j + 1)) of the risk; the shares of all looks, however many will follow, sum to 1. So the probability that the
//! interval of any look misses the truth is at most the whole risk (Bonferroni), whatever the rule to stop. Numbers double
//! from look to look: few looks, and none costs more than the samples before it. Source of the idea: Pocock, Biometrika 64
//! (1977) 191–199, and spending functions, Lan & DeMets, Biometrika 70 (1983) 659–663.

/// Share of the risk that look number `look` takes, counted from 1; all of it for 0, no look at all.
fn share_of_risk(look: usize) -> f64 {
    match look {
        0 => 1.0,
        j => 1.0 / (j as f64 * (j as f64 + 1.0)),
    }
}

/// Confidence at look number `look` of what is stated with `confidence` over all looks.
#[must_use]
pub fn confidence_at(look: usize, confidence: f64) -> f64 {
    1.0 - (1.0 - confidence) * share_of_risk(look)
}

/// Numbers of samples at which is looked: `at_most`, its half, its quarter, … (rounded up) down to the last one that is not
/// below `least`; ascending. Twice `at_most` gives the same numbers and one more.
#[must_use]
pub fn looks(least: u64, at_most: u64) -> Vec<u64> {
    let halved = |n: &u64| Some(n.div_ceil(2)).filter(|half| half < n && *half >= least);
    let mut sizes: Vec<u64> = std::iter::successors(Some(at_most), halved).collect();
    sizes.reverse();
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shares never sum to more than the whole risk, and looks stay where they are when the most is doubled, so that an
    /// extension has spent what a run to its number would have spent. Seen to fail with the whole risk at
    /// every look.
    #[test]
    fn an_extension_looks_where_the_whole_run_does() {
        let spent: f64 = (1..100_000).map(share_of_risk).sum();
        assert!(spent < 1.0 && spent > 0.9999, "{spent}");
        assert_eq!(looks(73, 1000), [125, 250, 500, 1000]);
        assert_eq!(looks(73, 70), [70]);
        assert_eq!(looks(1, 1), [1]);
        for at_most in [33, 59, 100, 1001, 4095] {
            let few = looks(20, at_most);
            let many = looks(20, 4 * at_most);
            assert_eq!(many[..few.len()], few[..]);
            assert_eq!(many[few.len()..], [2 * at_most, 4 * at_most]);
            assert!(few[0] >= 20 && few[0] < 40, "{few:?}");
        }
    }
}
