//! Nodes between two samples, where one step of slip does not resolve how the traction turns ([`super::cells`]).

use super::node::Node;

/// The nodes between samples of one state.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Between<T> {
    /// Ascending from phase 0.
    pub nodes: Vec<Node<T>>,
    /// Basis rows there. Shape: `[node][m]`.
    pub rows: Vec<T>,
    /// Weights in the sum over the samples, whose own weights are 1.
    pub weights: Vec<T>,
    /// What is added to the weights of the samples. Shape: `[time]`.
    pub sample_weights: Vec<T>,
    /// Number of nodes before each sample. Shape: `[time + 1]`.
    pub before: Vec<usize>,
}

impl<T> Between<T> {
    /// The basis row at node k.
    pub(in crate::aft) fn row(&self, k: usize) -> &[T] {
        let m = self.rows.len() / self.nodes.len();
        &self.rows[k * m..][..m]
    }
}
