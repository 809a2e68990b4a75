//! Rules of a hysteresis test, whatever the format of its file. What a loop is, and whether there is one, is not asked here.

use std::path::Path;

use super::channels::Channels;
use super::quantity::{Dimension, Quantity};
use super::signals::HysteresisRecord;
use crate::file::FileError;

/// Samples of a test at least.
const FEWEST_SAMPLES: usize = 20;
/// Displacements from least to largest of a test that can be meant (m).
const SWING_M: [f64; 2] = [1e-10, 0.1];
/// Tangential forces from least to largest of a test that can be meant (N).
const SWING_N: [f64; 2] = [1e-6, 1e7];
/// Largest force that can be meant (N).
const LARGEST_FORCE_N: f64 = 1e7;
/// Share of a test in which the contact may be open.
const MOST_OPEN: f64 = 0.4;
/// Share of a test from which on its open contact is looked at: less is a fault of single samples.
const FEWEST_OPEN: f64 = 0.01;
/// Change of the tangential force while the contact is open, over its swing, that noise may be.
const OPEN_CHANGE: f64 = 0.2;
/// Work of the normal force over that of the tangential one, from which on the two must be exchanged...
const WORK_EXCHANGED: f64 = 3.0;
/// A force has one sign if it has it in this share of a test.
const ONE_SIGN: f64 = 0.95;
/// A force changes its sign if it has each sign in this share of a test.
const EACH_SIGN: f64 = 0.2;
/// Work done on the body that moves, over the work without its signs, from which on a sign must be wrong.
const WORK_GAINED: f64 = 0.2;
/// ...and over its own work without its signs.
const WORK_OF_NORMAL: f64 = 0.2;
/// Correlation of displacement and tangential force below which a sign must be wrong.
const OPPOSED: f64 = -0.5;

/// Where a fault is.
struct Place<'c> {
    path: &'c Path,
    channels: &'c Channels,
}

impl Place<'_> {
    /// Of the whole test, which begins on a line if the file has such.
    fn test(&self, rule: &str) -> FileError {
        let line = self.channels.lines.first().copied();
        FileError::content(self.path, line, format!("{}{rule}", self.label()))
    }

    /// Of a sample.
    fn sample(&self, at: usize, rule: &str) -> FileError {
        match self.channels.lines.get(at) {
            Some(line) => FileError::content(self.path, Some(*line), rule),
            None => {
                let rule = format!("{}sample {}: {rule}", self.label(), at + 1);
                FileError::content(self.path, None, rule)
            }
        }
    }

    fn label(&self) -> String {
        let label = self.channels.label.as_ref();
        label.map_or_else(String::new, |label| format!("test {label}: "))
    }
}

/// The record `name` of a test that keeps all rules.
///
/// # Errors
/// [`FileError`] with the first rule that is broken.
pub(super) fn checked(
    path: &Path,
    name: String,
    mut channels: Channels,
) -> Result<HysteresisRecord, FileError> {
    let place = Place {
        path,
        channels: &channels,
    };
    for quantity in Quantity::SIGNALS {
        place.samples(quantity)?;
    }
    place.rising()?;
    place.frequency()?;
    // before the swings: a normal force that does not change would be taken for a tangential one in a wrong unit
    place.normal_force()?;
    place.exchanged()?;
    place.swing()?;
    place.open()?;
    place.signs()?;
    let mut signal = |quantity| channels.signals.remove(&quantity);
    let mut needed = |quantity| signal(quantity).unwrap_or_default();
    Ok(HysteresisRecord {
        name,
        time: needed(Quantity::Time),
        displacement: needed(Quantity::Displacement),
        tangential_force: needed(Quantity::TangentialForce),
        normal_force: needed(Quantity::NormalForce),
        approach: signal(Quantity::Approach),
        conditions: channels.conditions,
    })
}

impl<'c> Place<'c> {
    fn signal(&self, quantity: Quantity) -> &'c [f64] {
        let signal = self.channels.signals.get(&quantity);
        signal.map_or(&[], Vec::as_slice)
    }

    /// A signal is there if it must be, is as long as the time, and has finite numbers of a size that can be meant.
    fn samples(&self, quantity: Quantity) -> Result<(), FileError> {
        let name = quantity.name();
        if !self.channels.signals.contains_key(&quantity) {
            return match quantity {
                Quantity::Approach => Ok(()),
                _ => Err(self.test(&format!("must have the signal {name}"))),
            };
        }
        let (signal, n) = (self.signal(quantity), self.signal(Quantity::Time).len());
        if signal.len() != n {
            let m = signal.len();
            let rule = format!("{name} has {m} samples and time {n}: must have as many");
            return Err(self.test(&rule));
        }
        if n < FEWEST_SAMPLES {
            let rule = format!("has {n} samples: must have {FEWEST_SAMPLES} at least");
            return Err(self.test(&rule));
        }
        if let Some(at) = signal.iter().position(|value| !value.is_finite()) {
            let rule = format!("{name} = {}: must be a finite number", signal[at]);
            return Err(self.sample(at, &rule));
        }
        if quantity.dimension() != Dimension::Force {
            return Ok(());
        }
        match signal.iter().position(|v| v.abs() > LARGEST_FORCE_N) {
            None => Ok(()),
            Some(at) => {
                let value = signal[at];
                let rule =
                    format!("{name} = {value:e} N: must be at most {LARGEST_FORCE_N:e} N in size");
                Err(self.sample(at, &rule))
            }
        }
    }

    fn rising(&self) -> Result<(), FileError> {
        let time = self.signal(Quantity::Time);
        match time.windows(2).position(|two| two[1] <= two[0]) {
            None => Ok(()),
            Some(at) => {
                let (before, value) = (time[at], time[at + 1]);
                let rule =
                    format!("time = {value} s: must be later than the sample before, {before} s");
                Err(self.sample(at + 1, &rule))
            }
        }
    }

    /// A stated frequency fits the sampling.
    fn frequency(&self) -> Result<(), FileError> {
        let Some(frequency) = self.channels.conditions.frequency_hz else {
            return Ok(());
        };
        let time = self.signal(Quantity::Time);
        let rate = (time.len() - 1) as f64 / (time[time.len() - 1] - time[0]);
        if frequency < 0.5 * rate {
            return Ok(());
        }
        let rule = format!(
            "frequency = {frequency} Hz: must be below half of the sampling rate, which is {rate:.6} Hz"
        );
        Err(self.test(&rule))
    }

    /// The contact moves, by a distance that can be meant.
    fn swing(&self) -> Result<(), FileError> {
        let signals = [
            (Quantity::Displacement, SWING_M),
            (Quantity::TangentialForce, SWING_N),
        ];
        for (quantity, [least, most]) in signals {
            let swing = swing(self.signal(quantity));
            if !(least..=most).contains(&swing) {
                let (name, unit) = (quantity.name(), quantity.dimension().si());
                let rule = format!(
                    "{name} changes by {swing:e} {unit}: must change by {least:e} to {most:e} {unit}; is its unit right?"
                );
                return Err(self.test(&rule));
            }
        }
        Ok(())
    }

    /// The normal force is positive in compression, and is not exchanged with the tangential one.
    fn normal_force(&self) -> Result<(), FileError> {
        let force = self.signal(Quantity::NormalForce);
        let first = force.iter().position(|n| *n <= 0.0).unwrap_or(0);
        let (positive, negative) = signs(force);
        let tangential = signs(self.signal(Quantity::TangentialForce));
        let one_sign = tangential.0.max(tangential.1) >= ONE_SIGN;
        if positive.min(negative) >= EACH_SIGN && one_sign {
            let rule = "normal force changes its sign and tangential force does not: are the two exchanged?";
            return Err(self.test(rule));
        }
        if negative >= ONE_SIGN {
            let rule = "normal force is negative: must be positive in compression; change its sign";
            return Err(self.sample(first, rule));
        }
        if 1.0 - positive <= MOST_OPEN {
            return Ok(());
        }
        let rule = format!(
            "normal force is <= 0 in {:.0} % of the samples: must be positive (compression) in {:.0} % at least",
            100.0 * (1.0 - positive),
            100.0 * (1.0 - MOST_OPEN)
        );
        Err(self.sample(first, &rule))
    }

    /// The force that swings most and does the work is the tangential one, unless that cannot be a normal force.
    fn exchanged(&self) -> Result<(), FileError> {
        let x = self.signal(Quantity::Displacement);
        let forces = [Quantity::NormalForce, Quantity::TangentialForce];
        let [normal, tangential] = forces.map(|force| work(&without_mean(self.signal(force)), x));
        let swings = forces.map(|force| swing(self.signal(force)));
        let swaps = swings[0] > swings[1] && swings[1] > SWING_N[0];
        let works = normal.done.abs() > WORK_OF_NORMAL * normal.size;
        let (positive, _) = signs(self.signal(Quantity::TangentialForce));
        if !(swaps && works && positive >= ONE_SIGN)
            || normal.done.abs() <= WORK_EXCHANGED * tangential.done.abs()
        {
            return Ok(());
        }
        let rule = "normal force does more work over the relative displacement than tangential force: are the two exchanged?";
        Err(self.test(rule))
    }

    /// An open contact carries no tangential force: it stays where its zero is.
    fn open(&self) -> Result<(), FileError> {
        let normal = self.signal(Quantity::NormalForce);
        let tangential = self.signal(Quantity::TangentialForce);
        let both = normal.iter().zip(tangential);
        let mut open: Vec<f64> = both.filter(|(n, _)| **n <= 0.0).map(|(_, t)| *t).collect();
        if (open.len() as f64) < FEWEST_OPEN * normal.len() as f64 {
            return Ok(());
        }
        open.sort_by(f64::total_cmp);
        // a few samples at both ends may be spikes
        let spared = open.len() / 20;
        let change = open[open.len() - 1 - spared] - open[spared];
        if change <= OPEN_CHANGE * swing(tangential) {
            return Ok(());
        }
        let first = normal.iter().position(|n| *n <= 0.0).unwrap_or(0);
        let rule = format!(
            "normal force is <= 0 in {:.0} % of the samples, in which tangential force changes by {change:.4} N: an open contact carries none; is the zero of the \
             normal force right?",
            100.0 * open.len() as f64 / normal.len() as f64
        );
        Err(self.sample(first, &rule))
    }

    /// A contact takes energy, and its force grows with the displacement while it sticks.
    fn signs(&self) -> Result<(), FileError> {
        let x = self.signal(Quantity::Displacement);
        let force = without_mean(self.signal(Quantity::TangentialForce));
        let work = work(&force, x);
        let x = without_mean(x);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let both = product(&x, &force);
        let correlation = both / (product(&x, &x) * product(&force, &force)).sqrt();
        if work.done >= -WORK_GAINED * work.size && correlation >= OPPOSED {
            return Ok(());
        }
        let rule = "tangential force falls where relative displacement grows: must grow with it while the contact sticks; \
                    change the sign of one, or take the inertia of the moved mass out of the force";
        Err(self.test(rule))
    }
}

/// Work of a force over a displacement, and the same without its signs.
struct Work {
    done: f64,
    size: f64,
}

fn work(force: &[f64], x: &[f64]) -> Work {
    let steps = force.windows(2).zip(x.windows(2));
    let steps = steps.map(|(force, x)| 0.5 * (force[0] + force[1]) * (x[1] - x[0]));
    let (done, size) = steps.fold((0.0, 0.0), |(done, size), step| {
        (done + step, size + step.abs())
    });
    Work { done, size }
}

/// Shares of values above and below 0.
fn signs(signal: &[f64]) -> (f64, f64) {
    let share = |count: usize| count as f64 / signal.len() as f64;
    let positive = signal.iter().filter(|value| **value > 0.0).count();
    let negative = signal.iter().filter(|value| **value < 0.0).count();
    (share(positive), share(negative))
}

/// Largest value without the least.
fn swing(signal: &[f64]) -> f64 {
    let largest = signal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest - signal.iter().copied().fold(f64::INFINITY, f64::min)
}

fn without_mean(signal: &[f64]) -> Vec<f64> {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    signal.iter().map(|value| value - mean).collect()
}
