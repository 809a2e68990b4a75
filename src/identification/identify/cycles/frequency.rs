//! Frequency and phase of a motion.

use super::equations::{LeastSquares, least_squares};
use crate::identify::golden::smallest;
use libm::{atan2, cos, sin};
use std::f64::consts::TAU;

/// Fundamental of a signal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fundamental {
    /// Frequency (Hz).
    pub(super) frequency: f64,
    /// First instant after the start at which the fundamental is greatest (s).
    pub(super) first_top: f64,
    /// Share of the variance of the signal, its linear drift taken out, that the fundamental holds.
    pub(super) share: f64,
}

/// Level of the trigger over the amplitude: noise below it makes no crossing.
const TRIGGER: f64 = 0.3;
/// Steps of the search for the frequency.
const STEPS: usize = 20;
/// Part of the inverse of the record's length in which the frequency is sought around the one from crossings.
const SEARCH: f64 = 0.5;
/// Part of that distance beyond which the end of the interval was found, and no maximum.
const AT_END: f64 = 0.99;
/// Cycles over the whole record by which the phase of a stated frequency may be wrong.
const CLOCKS: f64 = 0.01;
/// Cycles of a record that is long enough to correct a stated frequency.
const LONG: f64 = 5.0;

/// Fundamental of `signal`, whose frequency (Hz) may be stated, and is counted from crossings. None where the signal does not swing.
pub(super) fn fundamental(
    time: &[f64],
    signal: &[f64],
    stated: Option<f64>,
) -> Option<Fundamental> {
    let rest = detrended(time, signal);
    let length = time[time.len() - 1] - time[0];
    let held = |frequency: &f64| fitted(time, &rest, *frequency)[2];
    // a stated frequency may be wrong: the one that is counted is sought, too, and that with the larger wave is the record's
    let starts = stated.into_iter().chain(from_crossings(time, &rest));
    let found = starts
        .map(|start| sharpened(time, &rest, start, SEARCH / length))
        .max_by(|a, b| held(a).total_cmp(&held(b)))?;
    // a stated frequency is exact but for the clocks of two instruments, which only a long record tells apart
    let kept = stated.filter(|stated| {
        let apart = (found - stated).abs() * length;
        apart < CLOCKS || length * found < LONG
    });
    let frequency = kept.unwrap_or(found);
    let [a, b, share] = fitted(time, &rest, frequency);
    let phase = atan2(b, a) / TAU;
    Some(Fundamental {
        frequency,
        first_top: time[0] + (phase - phase.floor()) / frequency,
        share,
    })
}

/// The signal less its regression line.
fn detrended(time: &[f64], signal: &[f64]) -> Vec<f64> {
    let n = time.len() as f64;
    let [t, x] = [time, signal].map(|v| v.iter().sum::<f64>() / n);
    let both = || time.iter().zip(signal);
    let product: f64 = both().map(|(a, b)| (a - t) * (b - x)).sum();
    let square: f64 = time.iter().map(|a| (a - t).powi(2)).sum();
    let slope = product / square;
    both().map(|(a, b)| b - x - slope * (a - t)).collect()
}

/// From the first to the last rise through the upper level; each must follow a fall below the lower one.
fn from_crossings(time: &[f64], rest: &[f64]) -> Option<f64> {
    let mean_square = rest.iter().map(|x| x * x).sum::<f64>() / rest.len() as f64;
    let level = TRIGGER * (2.0 * mean_square).sqrt();
    let (mut low, mut rises) = (false, Vec::new());
    for (t, x) in time.iter().zip(rest) {
        if *x < -level {
            low = true;
        } else if *x > level && low {
            low = false;
            rises.push(*t);
        }
    }
    let periods = rises.len().checked_sub(1).filter(|n| *n > 0)?;
    Some(periods as f64 / (rises[periods] - rises[0]))
}

/// The frequency near `start` whose wave holds most of the signal, by golden section within `reach`. An end of this interval is no
/// maximum: from there it is sought once more, so that the whole main lobe is reached.
fn sharpened(time: &[f64], rest: &[f64], start: f64, reach: f64) -> f64 {
    let within = |start: f64| {
        let ends = [(start - reach).max(0.5 * start), start + reach];
        smallest(ends, STEPS, |frequency| -fitted(time, rest, frequency)[2])
    };
    let found = within(start);
    match (found - start).abs() > AT_END * reach {
        true => within(found),
        false => found,
    }
}

/// Least squares a cos ωt + b sin ωt + c + d t: a, b, and the share of the variance that the wave holds; t from the first instant on.
fn fitted(time: &[f64], rest: &[f64], frequency: f64) -> [f64; 3] {
    let length = time[time.len() - 1] - time[0];
    let points = time.iter().zip(rest).map(|(t, x)| {
        let phase = TAU * frequency * (t - time[0]);
        let row = [1.0, (t - time[0]) / length, cos(phase), sin(phase)];
        (row, *x)
    });
    let LeastSquares {
        coefficients: [_, _, a, b],
        held,
        square,
    } = least_squares(points);
    [a, b, held / square.max(f64::MIN_POSITIVE)]
}
