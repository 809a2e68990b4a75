//! One test as a file states it: its signals by quantity, in SI units, before its rules are checked.

use std::collections::BTreeMap;

use super::quantity::Quantity;
use super::signals::TestConditions;

/// Samples of all signals of a file at most: 320 MB.
pub(super) const MOST_NUMBERS: usize = 40_000_000;
/// Tests of a file at most.
pub(super) const MOST_TESTS: usize = 10_000;

/// Signals of one test and what is stated beside them.
#[derive(Debug, Default)]
pub(super) struct Channels {
    /// Name of the test inside its file.
    pub(super) label: Option<String>,
    /// Samples in SI units.
    pub(super) signals: BTreeMap<Quantity, Vec<f64>>,
    /// What is known beside the signals.
    pub(super) conditions: TestConditions,
    /// Line of each sample where the file is a text with a row for each; empty for others.
    pub(super) lines: Vec<u64>,
}

impl Channels {
    /// Takes a signal.
    ///
    /// # Errors
    /// The rule, if there is one of this quantity.
    pub(super) fn insert(&mut self, quantity: Quantity, signal: Vec<f64>) -> Result<(), String> {
        match self.signals.insert(quantity, signal) {
            None => Ok(()),
            Some(_) => Err(format!("{}: must be given once", quantity.name())),
        }
    }
}
