//! Distance of the resonance from the engine orders, and of the stress from the allowable one.

use super::assessment::CONTENT;
use super::requirement::{MarginBase, Operation, Stress};
use super::summary::{CONFIDENCE, PROBABILITIES};
use crate::statistics::{
    Denominator, Exceedance, Observed, QuantileEstimate, Side, ToleranceBound, exceedance,
    frequency_margin, goodman_allowable, quantile_estimate, reserve_factor, tolerance_bound,
};
use serde::Serialize;

/// m → µm.
const UM_PER_M: f64 = 1e6;

/// Margin of the resonance to one engine order.
#[derive(Debug, Clone, Serialize)]
pub struct OrderMargin {
    /// Order k of the excitation.
    pub engine_order: u32,
    /// Speed of the resonance crossing 60 f/k (1/min): 5, 50, 95 %; empty without samples.
    pub crossing_rpm: Vec<QuantileEstimate>,
    /// Size of the smallest margin over the range of speeds, a share, 0 where the order crosses the resonance.
    pub range: Vec<QuantileEstimate>,
    /// Lower bound of that size.
    pub range_bound: ToleranceBound,
    /// Size of the margin at each speed that is held for long.
    pub dwell: Vec<DwellMargin>,
}

/// Margin at one speed.
#[derive(Debug, Clone, Serialize)]
pub struct DwellMargin {
    /// The speed (1/min).
    pub speed_rpm: f64,
    /// Size of the margin, a share: 5, 50, 95 %.
    pub quantiles: Vec<QuantileEstimate>,
}

/// Reserve of the alternating stress at one excitation level.
#[derive(Debug, Clone, Serialize)]
pub struct Reserve {
    /// Allowable alternating stress at the mean stress, after Goodman (MPa).
    pub allowable_mpa: f64,
    /// Amplitude of the first response coordinate at which it is reached (m).
    pub allowable_amplitude_m: f64,
    /// Allowable over actual alternating stress: 5, 50, 95 %; empty without samples.
    pub factor: Vec<QuantileEstimate>,
    /// Lower bound of that factor.
    pub factor_bound: ToleranceBound,
    /// Probability that the factor is below 1.
    pub exceedance: Option<Exceedance>,
}

/// Size of the smallest margin of a resonance to one engine order between two speeds; NaN for a failed sample.
pub(super) fn margin_size(
    frequency_hz: f64,
    operation: &Operation,
    engine_order: u32,
    [low, high]: [f64; 2],
) -> f64 {
    let denominator = match operation.margin_relative_to {
        MarginBase::EngineOrder => Denominator::EngineOrder,
        MarginBase::Resonance => Denominator::NaturalFrequency,
    };
    frequency_margin(frequency_hz, engine_order, (low, high), denominator)
        .map_or(f64::NAN, |margin| margin.margin.abs())
}

/// Size of the smallest margin to any engine order in the range of speeds; NaN for a failed sample.
pub(super) fn smallest_margin(frequency_hz: f64, operation: &Operation) -> f64 {
    let size = |order: &u32| margin_size(frequency_hz, operation, *order, operation.speed_rpm);
    let sizes = operation.engine_orders.iter().map(size);
    sizes.reduce(f64::min).unwrap_or(f64::NAN)
}

fn quantiles(observed: &Observed) -> Vec<QuantileEstimate> {
    let estimate = |&p: &f64| quantile_estimate(observed, p, CONFIDENCE);
    PROBABILITIES.iter().filter_map(estimate).collect()
}

/// Margins of the resonance frequencies (Hz, NaN = failed) to every engine order.
pub(super) fn order_margins(frequency_hz: &[f64], operation: &Operation) -> Vec<OrderMargin> {
    let margin = |&k: &u32| {
        let sizes = |speeds: [f64; 2]| {
            let size = |&f: &f64| margin_size(f, operation, k, speeds);
            Observed::of(frequency_hz.iter().map(size))
        };
        let range = sizes(operation.speed_rpm);
        let crossing = frequency_hz.iter().map(|f| 60.0 * f / f64::from(k));
        let dwell = operation.dwell_rpm.iter();
        OrderMargin {
            engine_order: k,
            crossing_rpm: quantiles(&Observed::of(crossing)),
            range: quantiles(&range),
            range_bound: tolerance_bound(&range, Side::Lower, CONTENT, CONFIDENCE),
            dwell: dwell
                .map(|&speed_rpm| DwellMargin {
                    speed_rpm,
                    quantiles: quantiles(&sizes([speed_rpm; 2])),
                })
                .collect(),
        }
    };
    operation.engine_orders.iter().map(margin).collect()
}

/// Allowable alternating stress (MPa); the settings are checked, so it exists.
pub(super) fn allowable_mpa(stress: &Stress) -> f64 {
    let allowable = goodman_allowable(
        stress.endurance_limit_mpa,
        stress.mean_stress_mpa,
        stress.ultimate_strength_mpa,
    );
    allowable.unwrap_or(f64::NAN)
}

/// Amplitude at which the allowable stress is reached (m).
pub(super) fn allowable_amplitude_m(stress: &Stress) -> f64 {
    allowable_mpa(stress) / stress.modal_stress_mpa_per_um / UM_PER_M
}

/// Reserve factor of an amplitude (m); NaN for a failed sample.
pub(super) fn factor(amplitude_m: f64, stress: &Stress) -> f64 {
    let applied = amplitude_m * UM_PER_M * stress.modal_stress_mpa_per_um;
    reserve_factor(allowable_mpa(stress), applied).unwrap_or(f64::NAN)
}

/// Reserve of the amplitudes (m, NaN = failed).
pub(super) fn reserve(amplitude_m: &[f64], stress: &Stress) -> Reserve {
    let factors = Observed::of(amplitude_m.iter().map(|&a| factor(a, stress)));
    let allowable_amplitude_m = allowable_amplitude_m(stress);
    let amplitudes = Observed::of(amplitude_m.iter().copied());
    Reserve {
        allowable_mpa: allowable_mpa(stress),
        allowable_amplitude_m,
        factor: quantiles(&factors),
        factor_bound: tolerance_bound(&factors, Side::Lower, CONTENT, CONFIDENCE),
        exceedance: exceedance(&amplitudes, allowable_amplitude_m, CONFIDENCE),
    }
}
