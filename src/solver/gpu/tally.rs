//! What the device did during a run: counts, audit, fallbacks.

use super::error::GpuError;
use super::report::{AdapterFacts, GpuReport};
use super::settings::Precision;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Notes that are kept; a device that fails more often than that has said enough.
const MOST_NOTES: usize = 20;

/// Counts while a run goes on.
#[derive(Debug)]
pub(super) struct Tally(Mutex<GpuReport>);

impl Tally {
    pub(super) fn new(adapter: &AdapterFacts, precision: Precision) -> Self {
        Self(Mutex::new(GpuReport {
            adapter: adapter.clone(),
            precision,
            lanes: 0,
            lanes_lost: 0,
            peaks_compared: 0,
            largest_frequency_difference: 0.0,
            largest_amplitude_difference: 0.0,
            peaks_beyond_limit: 0,
            evaluations: 0,
            states: 0,
            batches: 0,
            audited: 0,
            largest_force_difference: 0.0,
            largest_derivative_difference: 0.0,
            beyond_limit: 0,
            undecided: 0,
            fallbacks: 0,
            halved: 0,
            pass_seconds: BTreeMap::new(),
            notes: Vec::new(),
        }))
    }

    pub(super) fn report(&self) -> GpuReport {
        lock(&self.0).clone()
    }

    pub(super) fn batch(
        &self,
        evaluations: usize,
        states: usize,
        seconds: Option<&[(&'static str, f64)]>,
    ) {
        let mut report = lock(&self.0);
        report.batches += 1;
        report.evaluations += evaluations as u64;
        report.states += states as u64;
        for (pass, seconds) in seconds.into_iter().flatten() {
            *report.pass_seconds.entry((*pass).to_owned()).or_default() += seconds;
        }
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

    pub(super) fn undecided(&self, states: usize) {
        lock(&self.0).undecided += states as u64;
    }

    pub(super) fn halved(&self, error: &GpuError) {
        lock(&self.0).halved += 1;
        self.note(format!("{error}; halved"));
    }

    pub(super) fn fall_back(&self, error: &GpuError, evaluations: usize) {
        lock(&self.0).fallbacks += evaluations as u64;
        self.note(format!("{error}; the processor evaluates"));
    }

    /// The device is gone, and an evaluation did not go down.
    pub(super) fn not_asked(&self) {
        lock(&self.0).fallbacks += 1;
    }

    /// Adds the differences of an audited evaluation.
    pub(super) fn audit(&self, [force, derivative]: [f64; 2], beyond: bool) {
        let mut report = lock(&self.0);
        report.audited += 1;
        report.largest_force_difference = report.largest_force_difference.max(force);
        report.largest_derivative_difference = report.largest_derivative_difference.max(derivative);
        report.beyond_limit += u64::from(beyond);
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
