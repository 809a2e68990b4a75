//! What the device did during a run: lanes, comparisons, failures.

use super::error::GpuError;
use super::report::{AdapterFacts, GpuReport};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Notes that are kept; a device that fails more often than that has said enough.
const MOST_NOTES: usize = 20;

/// Counts while a run goes on.
#[derive(Debug)]
pub(super) struct Tally(Mutex<GpuReport>);

impl Tally {
    pub(super) fn new(adapter: &AdapterFacts) -> Self {
        Self(Mutex::new(GpuReport {
            adapter: adapter.clone(),
            lanes: 0,
            lanes_lost: 0,
            peaks_compared: 0,
            largest_frequency_difference: 0.0,
            largest_amplitude_difference: 0.0,
            peaks_beyond_limit: 0,
            halved: 0,
            notes: Vec::new(),
        }))
    }

    pub(super) fn report(&self) -> GpuReport {
        lock(&self.0).clone()
    }

    pub(super) fn lanes(&self, lanes: usize, lost: usize) {
        let mut report = lock(&self.0);
        report.lanes += lanes as u64;
        report.lanes_lost += lost as u64;
    }

    pub(super) fn compared(&self, [frequency, amplitude]: [f64; 2], beyond: bool) {
        let mut report = lock(&self.0);
        report.peaks_compared += 1;
        let larger = f64::max;
        report.largest_frequency_difference =
            larger(report.largest_frequency_difference, frequency);
        report.largest_amplitude_difference =
            larger(report.largest_amplitude_difference, amplitude);
        report.peaks_beyond_limit += u64::from(beyond);
    }

    /// A batch that the device refused.
    pub(super) fn halved(&self, error: &GpuError) {
        lock(&self.0).halved += 1;
        self.note(format!("{error}; halved"));
    }

    /// Keeps what failed, each failure once.
    pub(super) fn note(&self, note: String) {
        let mut report = lock(&self.0);
        if report.notes.len() < MOST_NOTES && !report.notes.contains(&note) {
            report.notes.push(note);
        }
    }
}

/// Locks; a thread that panicked while it held the lock has left nothing half done that others read.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
