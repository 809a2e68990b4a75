//! How a statistic settles as samples are added.

use super::observed::Observed;

/// A statistic of the first n samples.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Prefix<T> {
    /// Number of samples used, failed ones included.
    pub n: usize,
    /// The statistic.
    pub value: T,
}

/// Prefixes of a set of n samples: the powers of two from `first` on, and n itself. Samples of a Sobol' sequence are
/// balanced at powers of two only.
#[must_use]
pub fn nested_prefixes(n: usize, first: usize) -> Vec<usize> {
    let mut sizes: Vec<usize> = (0..usize::BITS)
        .map(|k| 1_usize << k)
        .filter(|&size| size >= first && size < n)
        .collect();
    if n > 0 {
        sizes.push(n);
    }
    sizes
}

/// `statistic` over nested prefixes of the samples, in the order of their index; a value that is not finite is a failed
/// sample.
#[must_use]
pub fn convergence<T>(
    values: &[f64],
    first: usize,
    statistic: impl Fn(&Observed) -> T,
) -> Vec<Prefix<T>> {
    nested_prefixes(values.len(), first)
        .into_iter()
        .map(|n| Prefix {
            n,
            value: statistic(&Observed::of(values[..n].iter().copied())),
        })
        .collect()
}
