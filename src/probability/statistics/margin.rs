//! Design margins: engine orders, mean stress, reserve factor, and the verdict on a criterion.

use super::limit::Interval;

/// What a frequency margin is a share of; both are in use, so it is always stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Denominator {
    /// (f − kΩ/60) / (kΩ/60).
    EngineOrder,
    /// (f − kΩ/60) / f.
    NaturalFrequency,
}

/// The margin of smallest size over a speed range.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FrequencyMargin {
    /// Margin, a share; positive = the mode lies above the engine order. 0 where the line crosses it in the range.
    pub margin: f64,
    /// Speed of this margin (rev/min).
    pub speed_rpm: f64,
    /// Engine order k.
    pub engine_order: u32,
    /// What the margin is a share of.
    pub denominator: Denominator,
}

/// Margin of a mode of `frequency_hz` to the engine order k over the speeds from `lowest_rpm` to `highest_rpm` (rev/min).
///
/// `None` unless the frequency, the order and the speeds are positive and the speeds ascend.
#[must_use]
pub fn frequency_margin(
    frequency_hz: f64,
    engine_order: u32,
    lowest_rpm: f64,
    highest_rpm: f64,
    denominator: Denominator,
) -> Option<FrequencyMargin> {
    let sound = frequency_hz > 0.0 && frequency_hz.is_finite() && highest_rpm.is_finite();
    let range = lowest_rpm > 0.0 && lowest_rpm <= highest_rpm;
    if !sound || !range || engine_order == 0 {
        return None;
    }
    // |margin| grows away from the crossing, so the nearest speed of the range has the smallest.
    let crossing_rpm = 60.0 * frequency_hz / f64::from(engine_order);
    let speed_rpm = crossing_rpm.clamp(lowest_rpm, highest_rpm);
    let line_hz = f64::from(engine_order) * speed_rpm / 60.0;
    let margin = if speed_rpm == crossing_rpm {
        0.0
    } else {
        match denominator {
            Denominator::EngineOrder => (frequency_hz - line_hz) / line_hz,
            Denominator::NaturalFrequency => (frequency_hz - line_hz) / frequency_hz,
        }
    };
    Some(FrequencyMargin {
        margin,
        speed_rpm,
        engine_order,
        denominator,
    })
}

/// Goodman's allowable alternating stress σ_e (1 − σ_m/σ_u), in the unit of the stresses.
///
/// `endurance` σ_e at zero mean, `ultimate` σ_u, `mean` σ_m, tension positive. 0 from σ_m = σ_u on; a compressive mean is
/// not credited (σ_e). `None` unless σ_e and σ_u are positive and all are finite.
/// Limits of use: Nicholas & Zuiker, Int. J. Fract. 80 (1996) 219–235.
#[must_use]
pub fn goodman_allowable(endurance: f64, mean: f64, ultimate: f64) -> Option<f64> {
    let sound = endurance > 0.0 && ultimate > 0.0 && mean.is_finite();
    let sound = sound && endurance.is_finite() && ultimate.is_finite();
    sound.then(|| endurance * (1.0 - mean / ultimate).clamp(0.0, 1.0))
}

/// Reserve factor allowable / applied, above 1 = in reserve; the margin of safety is one less.
///
/// `None` unless the allowable is not negative and the applied load positive, both finite.
#[must_use]
pub fn reserve_factor(allowable: f64, applied: f64) -> Option<f64> {
    let sound = allowable >= 0.0 && applied > 0.0 && allowable.is_finite() && applied.is_finite();
    sound.then(|| allowable / applied)
}

/// What a criterion asks of a number.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// The number must not exceed this.
    AtMost(f64),
    /// The number must not fall below this.
    AtLeast(f64),
}

/// Verdict on a criterion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "UPPERCASE")]
pub enum Judgement {
    /// The whole interval meets the criterion.
    Pass,
    /// No part of the interval meets it.
    Fail,
    /// The limit lies inside the interval, or the side that decides is unbounded: more samples are needed, or fewer failed.
    Undecided,
}

/// Judges a number that is known as a confidence interval; failed samples enter by the interval, never by a guess.
#[must_use]
pub fn judge(interval: Interval, criterion: Criterion) -> Judgement {
    let (lower, upper) = (interval.lower.value(), interval.upper.value());
    let (pass, fail) = match criterion {
        Criterion::AtMost(limit) => (
            upper.is_some_and(|v| v <= limit),
            lower.is_some_and(|v| v > limit),
        ),
        Criterion::AtLeast(limit) => (
            lower.is_some_and(|v| v >= limit),
            upper.is_some_and(|v| v < limit),
        ),
    };
    match (pass, fail) {
        (true, _) => Judgement::Pass,
        (false, true) => Judgement::Fail,
        (false, false) => Judgement::Undecided,
    }
}
