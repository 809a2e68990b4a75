//! One input at a time: each random input at a low and a high value, all others at their medians.
//!
//! A first look that needs two solves per input: interactions do not show, and a result that turns between the ends is
//! missed.

use super::atlas::Anchor;
use super::outcome::LevelOutcome;
use super::runner::FIRST_ANCHORS;
use super::shared::Ensemble;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Probabilities of the low and the high value of an input.
pub const ENDS: [f64; 2] = [0.05, 0.95];

/// Results along each random input alone.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct OneAtATime {
    /// All inputs at their medians. Shape: `[levels]`.
    pub median: Vec<LevelOutcome>,
    /// One entry per random input along which results go: none for one whose values only number draws.
    pub swings: Vec<Swing>,
}

/// Results at the ends of one input.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Swing {
    /// Number of the input among those of a sample.
    pub input: usize,
    /// Its values, of the probabilities [`ENDS`].
    pub values: [f64; 2],
    /// Results there. Shape: `[2][levels]`.
    pub ends: [Vec<LevelOutcome>; 2],
}

impl Ensemble<'_> {
    /// Results along each random input, started from the samples that were solved without help: they depend neither on
    /// the number of samples nor on the backend. An epistemic input stands in the middle of its interval.
    #[must_use]
    pub fn one_at_a_time(&self, anchors: &[Anchor]) -> OneAtATime {
        let first = anchors.len().min(FIRST_ANCHORS as usize);
        let solved = self.solver_from(&anchors[..first]);
        let laws = self.design.inputs();
        let medians = self.design.medians();
        let swing = |&input: &usize| {
            let values = ENDS.map(|p| laws[input].1.quantile(p));
            let ends = values.map(|value| {
                let mut inputs = medians.clone();
                inputs[input] = value;
                solved(&inputs)
            });
            Swing {
                input,
                values,
                ends,
            }
        };
        let has_order = |&&input: &&usize| !laws[input].0.numbers_draws();
        let ordered = self.design.drawn().par_iter().filter(has_order);
        let (median, swings) = rayon::join(|| solved(&medians), || ordered.map(swing).collect());
        OneAtATime { median, swings }
    }
}
