//! Samples grouped into bins of equal count along one input.

/// Samples between two values of an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Smallest value of the input in the group.
    pub lower: f64,
    /// Largest value of the input in the group.
    pub upper: f64,
    /// Indices of the samples, in ascending order of the input.
    pub members: Vec<usize>,
}

/// Samples in at most `bins` groups of (nearly) equal count, in ascending order of `inputs`; equal values stay together.
#[must_use]
pub fn equal_count(inputs: &[f64], bins: usize) -> Vec<Group> {
    let mut order: Vec<usize> = (0..inputs.len()).collect();
    order.sort_by(|&i, &j| inputs[i].total_cmp(&inputs[j]));
    let (n, bins) = (order.len(), bins.max(1));
    let mut groups: Vec<Group> = Vec::with_capacity(bins);
    let mut start = 0;
    for bin in 1..=bins {
        let mut end = (n * bin / bins).max(start);
        while end > start && end < n && inputs[order[end]] == inputs[order[end - 1]] {
            end += 1;
        }
        if let [first, .., last] | [first @ last] = order[start..end] {
            groups.push(Group {
                lower: inputs[first],
                upper: inputs[last],
                members: order[start..end].to_vec(),
            });
        }
        start = end;
    }
    groups
}
