//! A batch of harmonic states of contacts.
//!
//! Arrays run over states fastest, so that neighbouring states are neighbours in memory (vector lanes, GPU threads).

use crate::contact::ContactParameters;

/// Displacement coefficients and parameters of many independent contact states.
#[derive(Debug, Clone, Default)]
pub struct AftBatch<T> {
    /// Number of states.
    pub n_states: usize,
    /// Relative displacements (m). Shape: `[component t1, t2, n][coefficient][state]`.
    pub displacement: Vec<T>,
    /// Contact parameters. Shape: `[state]`.
    pub parameters: Vec<ContactParameters<T>>,
}

/// What an evaluation computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// Forces and summaries; tangents of an earlier evaluation are discarded.
    Forces,
    /// Forces, summaries and exact derivatives.
    ForcesAndTangents,
}
