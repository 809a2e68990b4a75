//! Whether an instrument was at the end of its range: values that it cannot show are all shown as the last one that it can.

use crate::identify::cycles::mean_loop::{OF_MEDIAN_DEVIATION, median};
use crate::record::HysteresisRecord;
use std::f64::consts::TAU;

/// Least number of equal values at an end.
const FEWEST: usize = 20;
/// Least share of all values that are equal at an end.
const LEAST_SHARE: f64 = 0.02;
/// How many times as often as any other value the one at the end is there.
const MORE_OFTEN: usize = 10;
/// How many times the steps of the values, and what a smooth signal has, the noise must be: a signal with less may stay at one value by itself.
const NOISIER: f64 = 3.0;
/// Standard deviation of the third differences of white noise over its own: √20.
const THIRD_DIFFERENCE: f64 = 4.472_135_954_999_58;

/// A sentence for each signal that was at the end of its range; `samples` are those of a cycle.
pub(super) fn range_ends(record: &HysteresisRecord, samples: f64) -> Vec<String> {
    let signals = [
        ("tangential force", "N", 1.0, &record.tangential_force),
        ("normal force", "N", 1.0, &record.normal_force),
        ("displacement", "um", 1e6, &record.displacement),
    ];
    let note = |(name, unit, factor, signal): (&str, &str, f64, &Vec<f64>)| {
        let end = at_an_end(signal, samples)?;
        let percent = 100.0 * end.count as f64 / signal.len() as f64;
        let value = (1e6 * factor * end.value).round() / 1e6;
        Some(format!(
            "the {name} stays at {value} {unit} in {percent:.0} % of the samples: the instrument was at the end of its range, and what lay beyond is not known"
        ))
    };
    signals.into_iter().filter_map(note).collect()
}

/// A value at which a signal stays.
struct RangeEnd {
    value: f64,
    count: usize,
}

/// The largest or smallest value of a noisy signal that is there far more often than any other one.
fn at_an_end(signal: &[f64], samples: f64) -> Option<RangeEnd> {
    let mut sorted = signal.to_vec();
    sorted.sort_by(f64::total_cmp);
    let equal: Vec<&[f64]> = sorted.chunk_by(|a, b| a == b).collect();
    let [first, inner @ .., last] = &equal[..] else {
        return None;
    };
    let often = inner.iter().map(|same| same.len()).max()?;
    let (end, other) = match first.len() > last.len() {
        true => (first, last),
        false => (last, first),
    };
    let least = FEWEST.max((LEAST_SHARE * signal.len() as f64).ceil() as usize);
    if end.len() < least || end.len() < MORE_OFTEN * often {
        return None;
    }
    let ends = [end[0], other[0]];
    let step = (equal.windows(2).map(|pair| pair[1][0] - pair[0][0])).fold(f64::INFINITY, f64::min);
    let smooth = 0.5 * (last[0] - first[0]) * (TAU / samples).powi(3);
    let noise = noise_inside(signal, ends)?;
    (noise > NOISIER * step.max(smooth)).then_some(RangeEnd {
        value: end[0],
        count: end.len(),
    })
}

/// Standard deviation of the noise, by third differences of samples away from both ends.
fn noise_inside(signal: &[f64], ends: [f64; 2]) -> Option<f64> {
    let inside = signal
        .windows(4)
        .filter(|w| w.iter().all(|x| !ends.contains(x)));
    let third = inside.map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs());
    let differences = median(&mut third.collect::<Vec<_>>())?;
    Some(OF_MEDIAN_DEVIATION * differences / THIRD_DIFFERENCE)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: f64 = 197.7123;

    /// A hundred cycles between plateaus at ±1, all of other lengths, with noise of this width, in steps, within a range.
    fn plateaus(width: f64, step: f64, range: f64) -> Vec<f64> {
        let at = |i: usize| {
            let noise = (i as f64 * 0.618_033_988_749_895).fract() - 0.5;
            let time = i as f64 * (1.0 - 1e-6 * i as f64);
            let slope = 1.5 * (TAU * time / SAMPLES).sin();
            let shown = ((slope.clamp(-1.0, 1.0) + width * noise) / step).round() * step;
            shown.clamp(-range, range)
        };
        (0..20_000).map(at).collect()
    }

    /// A noisy signal that stays at a value is at an end. One without noise, and one whose steps hide the noise, may stay at it by themselves. Seen to
    /// fail without the comparison with what a smooth signal has, and without that with the steps.
    #[test]
    fn only_noise_tells_an_end_from_a_plateau() {
        let found = |signal: &[f64]| at_an_end(signal, SAMPLES).map(|end| end.value.abs());
        assert_eq!(found(&plateaus(0.1, 1e-6, 0.99)), Some(0.99), "clipped");
        assert_eq!(found(&plateaus(0.1, 1e-6, 10.0)), None, "within its range");
        assert_eq!(found(&plateaus(0.0, 1e-9, 10.0)), None, "without noise");
        assert_eq!(found(&plateaus(0.04, 0.05, 10.0)), None, "in coarse steps");
    }
}
