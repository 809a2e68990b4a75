//! Means and probabilities with the help of a control variate: the same samples and further ones on few harmonics
//! (`statistics::control_variate`). Whatever it says is labelled so: no other number of a report comes from it.

use super::allowable::amplitude_limits_m;
use super::peaks::values;
use crate::ensemble::outcome::PeakRecord;
use crate::report::run::input::ReportInput;
use crate::statistics::{
    ControlledExceedance, ControlledMean, ControlledSamples, Exceedance, Interval, Limit, Observed,
    exceedance,
};
use schemars::JsonSchema;
use serde::Serialize;

/// What the control variate says at one excitation level.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelControlVariate {
    /// Highest harmonic of the control.
    pub highest_harmonic: usize,
    /// Samples that the control has beside those of the study.
    pub further: usize,
    /// Samples of the control without a solution, of all: they count as the mean of the others.
    pub failed: usize,
    /// Mean of the resonance frequency (Hz); absent with fewer than 20 solved samples.
    pub frequency_hz: Option<ControlledMean>,
    /// Mean of the amplitude (m); absent with fewer than 20 solved samples.
    pub amplitude_m: Option<ControlledMean>,
    /// Probabilities of exceeding the limits of the amplitude (m) that the study states; empty without.
    pub exceedances: Vec<ControlledAndPlain>,
}

/// An exceedance probability by control variate beside that of the samples alone.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct ControlledAndPlain {
    /// By control variate; threshold in m.
    pub controlled: ControlledExceedance,
    /// By the samples alone.
    pub samples: Option<Exceedance>,
}

/// Amplitudes have no upper end; frequencies of failed samples are not bounded either.
const NOT_NEGATIVE: Interval = Interval {
    lower: Limit::Value(0.0),
    upper: Limit::Unbounded,
};

/// The control variate at level `i`; absent where the study wants none.
pub(in crate::report) fn control_variate(
    input: &ReportInput,
    i: usize,
) -> Option<LevelControlVariate> {
    let settings = input.record.control_variate?;
    let n = input.outcomes.len();
    let (same, further) = input.control.split_at_checked(n)?;
    let confidence = input.record.confidence();
    let of = |value: fn(&PeakRecord) -> f64| {
        [input.outcomes, same, further].map(|samples| values(samples, i, value))
    };
    let (frequency, amplitude) = (of(|p| p.frequency_hz), of(|p| p.amplitude_m));
    let failed = frequency[1..].iter().flatten().filter(|f| !f.is_finite());
    let controlled = controlled(&amplitude);
    let observed = Observed::of(amplitude[0].iter().copied());
    let both = |limit: f64| {
        Some(ControlledAndPlain {
            controlled: controlled.exceedance(limit, confidence)?,
            samples: exceedance(&observed, limit, confidence),
        })
    };
    Some(LevelControlVariate {
        highest_harmonic: settings.highest_harmonic(),
        further: further.len(),
        failed: failed.count(),
        frequency_hz: self::controlled(&frequency).mean(NOT_NEGATIVE, confidence),
        amplitude_m: controlled.mean(NOT_NEGATIVE, confidence),
        exceedances: (amplitude_limits_m(input.record, i).into_iter())
            .filter_map(both)
            .collect(),
    })
}

fn controlled([results, controls, further]: &[Vec<f64>; 3]) -> ControlledSamples<'_> {
    ControlledSamples {
        results,
        controls,
        further,
    }
}
