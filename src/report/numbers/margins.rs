//! Distance of the resonance from the engine orders, and of the stress from the allowable one.

use super::allowable::{allowable_amplitude_m, allowable_mpa, factor};
use super::population::{Bound, Exceeded, Populations, Quantiles};
use crate::report::asked::requirement::{MarginBase, Operation, Stress};
use crate::report::run::input::ReportInput;
use crate::statistics::{Denominator, Side, frequency_margin};
use schemars::JsonSchema;
use serde::Serialize;

/// Margin of the resonance to one engine order.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct OrderMargin {
    /// Order k of the excitation.
    pub engine_order: u32,
    /// Speed of the resonance crossing 60 f/k (1/min): 5, 50, 95 %; empty without samples.
    pub crossing_rpm: Quantiles,
    /// Size of the smallest margin over the range of speeds, a share, 0 where the order crosses the resonance.
    pub range: Quantiles,
    /// Lower bound of that size.
    pub range_bound: Bound,
    /// Size of the margin at each speed that is held for long.
    pub dwell: Vec<DwellMargin>,
}

/// Margin at one speed.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DwellMargin {
    /// The speed (1/min).
    pub speed_rpm: f64,
    /// Size of the margin, a share: 5, 50, 95 %.
    pub quantiles: Quantiles,
}

/// Reserve of the alternating stress at one excitation level.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Reserve {
    /// Allowable alternating stress at the mean stress, after Goodman (MPa).
    pub allowable_mpa: f64,
    /// Amplitude of the first response coordinate at which it is reached (m).
    pub allowable_amplitude_m: f64,
    /// Allowable over actual alternating stress: 5, 50, 95 %; empty without samples.
    pub factor: Quantiles,
    /// Lower bound of that factor.
    pub factor_bound: Bound,
    /// Probability that the factor is below 1.
    pub exceedance: Option<Exceeded>,
}

/// Size of the smallest margin of a resonance to one engine order between two speeds; NaN for a failed sample.
fn margin_size(
    frequency_hz: f64,
    operation: &Operation,
    engine_order: u32,
    speeds: [f64; 2],
) -> f64 {
    signed_margin(frequency_hz, operation, engine_order, speeds).abs()
}

/// Smallest margin of a resonance to one engine order between two speeds, negative below it; NaN for a failed sample.
pub(in crate::report) fn signed_margin(
    frequency_hz: f64,
    operation: &Operation,
    engine_order: u32,
    [low, high]: [f64; 2],
) -> f64 {
    let denominator = match operation.margin_relative_to {
        MarginBase::EngineOrder => Denominator::EngineOrder,
        MarginBase::Resonance => Denominator::NaturalFrequency,
    };
    frequency_margin(frequency_hz, engine_order, low, high, denominator)
        .map_or(f64::NAN, |margin| margin.margin)
}

/// Size of the smallest margin to any engine order in the range of speeds; NaN for a failed sample.
pub(in crate::report) fn smallest_margin(frequency_hz: f64, operation: &Operation) -> f64 {
    let size = |order: &u32| margin_size(frequency_hz, operation, *order, operation.speed_rpm);
    let sizes = operation.engine_orders.iter().map(size);
    sizes.reduce(f64::min).unwrap_or(f64::NAN)
}

/// Margins of the resonance at level `i` to every engine order.
pub(in crate::report) fn order_margins(
    input: &ReportInput,
    i: usize,
    operation: &Operation,
) -> Vec<OrderMargin> {
    let margin = |&k: &u32| {
        let sizes = |speeds: [f64; 2]| {
            Populations::of(input, i, |p| {
                margin_size(p.frequency_hz, operation, k, speeds)
            })
        };
        let range = sizes(operation.speed_rpm);
        let crossing = Populations::of(input, i, |p| 60.0 * p.frequency_hz / f64::from(k));
        let dwell = operation.dwell_rpm.iter();
        OrderMargin {
            engine_order: k,
            crossing_rpm: crossing.quantiles(),
            range: range.quantiles(),
            range_bound: range.bound(Side::Lower),
            dwell: dwell
                .map(|&speed_rpm| DwellMargin {
                    speed_rpm,
                    quantiles: sizes([speed_rpm; 2]).quantiles(),
                })
                .collect(),
        }
    };
    operation.engine_orders.iter().map(margin).collect()
}

/// Reserve at level `i`.
pub(in crate::report) fn reserve(input: &ReportInput, i: usize, stress: &Stress) -> Reserve {
    let factors = Populations::of(input, i, |p| factor(p.amplitude_m, stress));
    let allowable_amplitude_m = allowable_amplitude_m(stress);
    let amplitudes = Populations::of(input, i, |p| p.amplitude_m);
    Reserve {
        allowable_mpa: allowable_mpa(stress),
        allowable_amplitude_m,
        factor: factors.quantiles(),
        factor_bound: factors.bound(Side::Lower),
        exceedance: amplitudes.exceedance(allowable_amplitude_m),
    }
}
