//! What the solver may have wrong in one peak, as far as the peak itself says it.
//!
//! A force that is missing changes the amplitude at resonance by the share e if it acts in phase with the velocity. Acting
//! in phase with the displacement it moves the resonance by about e times the half-power half-width, that is by e ζ of the
//! frequency. ζ is that of the linear structure times input over viscous work.

use crate::ensemble::outcome::{CurvePoint, PeakRecord};
use crate::report::run::record::{LinearRecord, RunRecord};

/// Error of the place of a peak over the change of the frequency at which its search stops. Searches from other starts stop up to nine times
/// this change apart.
const SEARCHES_APART: f64 = 10.0;

/// Share of the input work that the balance misses; absent where there is no work.
pub(in crate::report) fn work_imbalance(peak: &PeakRecord) -> Option<f64> {
    let dissipated = peak.work_viscous_j + peak.work_friction_j;
    let imbalance = (peak.work_input_j - dissipated).abs() / peak.work_input_j.abs();
    imbalance.is_finite().then_some(imbalance)
}

/// Relative error of the frequency at which a peak was located.
pub(in crate::report) fn place_error(record: &RunRecord) -> f64 {
    SEARCHES_APART * record.frequency_tolerance
}

/// Relative change of the frequency of a peak by the harmonics left out; absent where it cannot be estimated.
pub(in crate::report) fn harmonics_shift(
    damping_ratio: Option<f64>,
    peak: &PeakRecord,
) -> Option<f64> {
    let losses = peak.work_input_j / peak.work_viscous_j;
    let shift = peak.truncation_error.get()? * damping_ratio? * losses;
    (shift.is_finite() && shift >= 0.0).then_some(shift)
}

/// Damping ratio of a linear limit of the structure: half-power half-width of its resonance over the frequency; absent where
/// the stored curve does not show a resonance with both flanks.
pub(in crate::report) fn half_power_ratio(linear: &LinearRecord) -> Option<f64> {
    linear.frequency_hz?;
    let curve = &linear.curve;
    let higher = |a: &usize, b: &usize| curve[*a].amplitude_m.total_cmp(&curve[*b].amplitude_m);
    let top = (0..curve.len()).max_by(higher)?;
    let level = curve[top].amplitude_m / 2f64.sqrt();
    let crossing = |[inner, outer]: [&CurvePoint; 2]| {
        let share = (inner.amplitude_m - level) / (inner.amplitude_m - outer.amplitude_m);
        (outer.amplitude_m < level)
            .then_some(inner.frequency_hz + share * (outer.frequency_hz - inner.frequency_hz))
    };
    let pair = |i: usize, j: usize| crossing([&curve[i], &curve[j]]);
    let below = (0..top).rev().find_map(|i| pair(i + 1, i))?;
    let above = (top + 1..curve.len()).find_map(|i| pair(i - 1, i))?;
    let ratio = 0.5 * (above - below) / curve[top].frequency_hz;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio)
}
