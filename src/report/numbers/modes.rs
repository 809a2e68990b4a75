//! The maxima of each mode, where a study follows all modes.

use super::distribution::Distribution;
use super::outer_points::nested;
use super::peaks::usable_peak;
use crate::ensemble::outcome::LevelOutcome;
use crate::report::run::input::ReportInput;
use crate::statistics::{Share, Sorted, quantile, share};
use std::collections::BTreeSet;

/// The maximum of one mode over the samples of one excitation level.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ModeSummary {
    /// Number of the mode among the stuck frequencies, 1 for the lowest.
    pub mode: u32,
    /// Its stuck frequency at nominal inputs (Hz); absent where it lies outside the band and so does the free frequency.
    pub stuck_frequency_hz: Option<f64>,
    /// Samples that have a maximum of this mode, with limits of their share; unknown are those without one in which the search for a
    /// mode did not end, and those without a solution.
    pub present: Share,
    /// Samples whose peak is of this mode.
    pub highest: usize,
    /// Samples with further, lower maxima of this mode, which do not count.
    pub further: usize,
    /// Resonance frequency (Hz) of the samples that have it; what the unknown ones leave open stands in its bounds.
    pub frequency_hz: Distribution,
    /// Amplitude (m) of these samples.
    pub amplitude_m: Distribution,
    /// Median and smallest value of how clearly these maxima are of this mode: 1 where no other mode comes near.
    pub clearness: Option<[f64; 2]>,
}

/// A maximum of a sample.
struct ModeMaximum {
    mode: u32,
    share: f64,
    frequency_hz: f64,
    amplitude_m: f64,
}

/// The maxima of a level with their modes, the highest first; empty without a solution.
fn maxima(level: &LevelOutcome) -> Vec<ModeMaximum> {
    let (Some(peak), Some(modes)) = (usable_peak(level), level.around.modes()) else {
        return Vec::new();
    };
    let others = level.around.others().iter();
    let others = others.map(|other| [other.frequency_hz, other.amplitude_m]);
    let places = std::iter::once([peak.frequency_hz, peak.amplitude_m]).chain(others);
    (places.zip(&modes.of_maxima))
        .map(|([frequency_hz, amplitude_m], of)| ModeMaximum {
            mode: of.number,
            share: of.share,
            frequency_hz,
            amplitude_m,
        })
        .collect()
}

/// One entry per mode that is followed or found, ascending; none where the study does not follow all modes, and where the samples are
/// those of several outer points.
pub(super) fn of_modes(
    input: &ReportInput,
    records: &[&LevelOutcome],
    confidence: f64,
) -> Option<Vec<ModeSummary>> {
    let followed = &input.record.provenance.followed_modes;
    if followed.is_empty() || nested(input.outcomes) {
        return None;
    }
    let found: Vec<Vec<ModeMaximum>> = records.iter().map(|level| maxima(level)).collect();
    let is_unknown = |level: &&LevelOutcome| {
        let unfinished = level
            .around
            .modes()
            .is_none_or(|modes| modes.unfinished > 0);
        unfinished || usable_peak(level).is_none()
    };
    let unknown: Vec<bool> = records.iter().map(is_unknown).collect();
    let attributed = found.iter().flatten().filter(|of| of.mode > 0);
    let numbers: BTreeSet<u32> = (followed.iter().map(|of| of.mode))
        .chain(attributed.map(|of| of.mode))
        .collect();
    let summary = |mode: u32| {
        // the highest of a sample stands for the mode
        let own = found
            .iter()
            .map(|maxima| maxima.iter().filter(move |of| of.mode == mode));
        let present: Vec<&ModeMaximum> = own.clone().filter_map(|mut own| own.next()).collect();
        let further = own
            .clone()
            .filter(|own| own.clone().nth(1).is_some())
            .count();
        let lost = own
            .zip(&unknown)
            .filter(|(own, lost)| **lost && own.clone().next().is_none());
        let lost = lost.count();
        let absent = records.len() - present.len() - lost;
        let distribution = |value: fn(&ModeMaximum) -> f64| {
            Distribution::of(present.iter().map(|of| value(of)), lost, confidence)
        };
        let clear = Sorted::finite(present.iter().map(|of| of.share));
        let of_peak = found.iter().filter_map(|maxima| maxima.first());
        let stuck = followed.iter().find(|of| of.mode == mode);
        Some(ModeSummary {
            mode,
            stuck_frequency_hz: stuck.map(|of| of.stuck_frequency_hz),
            present: share(present.len(), absent, lost, confidence)?,
            highest: of_peak.filter(|of| of.mode == mode).count(),
            further,
            frequency_hz: distribution(|of| of.frequency_hz),
            amplitude_m: distribution(|of| of.amplitude_m),
            clearness: Option::zip(quantile(&clear, 0.5), clear.order_statistic(1))
                .map(|(median, lowest)| [median, lowest]),
        })
    };
    Some(numbers.into_iter().filter_map(summary).collect())
}
