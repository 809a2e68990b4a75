//! TDMS files of hysteresis tests, as LabVIEW and DAQmx write them: a group is a test.
//!
//! The name of a channel says what it is; its unit stands in the name or in the property `unit_string`. The time is a channel, or
//! follows from the properties of waveforms, `wf_start_offset` and `wf_increment` (s).

use std::collections::BTreeSet;
use std::path::Path;

use super::super::channels::{Channels, MOST_NUMBERS};
use super::super::condition::{SPECIMEN, is_one_of};
use super::super::quantity::{Quantity, name_and_unit};
use super::super::signals::TestConditions;
use super::tdms_bytes::Value;
use super::tdms_segments::{self, Object, TAG};
use crate::file::FileError;

/// Property with the unit of a channel.
const UNIT: &str = "unit_string";
/// Property with the time between two samples (s).
const STEP: &str = "wf_increment";
/// Property with the time of the first sample (s).
const FIRST: &str = "wf_start_offset";
/// Property with the number of scales that are to be applied to samples.
const SCALES: &str = "NI_Number_Of_Scales";

/// Whether the bytes begin as such a file.
pub(in crate::record) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(TAG)
}

/// The tests of a file: its groups with channels of signals. Other channels are passed over.
///
/// # Errors
/// [`FileError`] with segment, object or channel and the rule that it breaks.
pub(in crate::record) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<Channels>, FileError> {
    tests(bytes).map_err(|rule| FileError::content(path, None, rule))
}

fn quantity(channel: &str) -> Option<Quantity> {
    Quantity::named(name_and_unit(channel).0, &Quantity::SIGNALS)
}

fn tests(bytes: &[u8]) -> Result<Vec<Channels>, String> {
    let objects = tdms_segments::read(bytes, |channel| quantity(channel).is_some())?;
    let mut tests: Vec<Channels> = Vec::new();
    let mut numbers = 0;
    let mut groups: Vec<&String> = Vec::new();
    let mut known = BTreeSet::new();
    for name in objects.iter().filter_map(|object| object.path.first()) {
        if known.insert(name) {
            groups.push(name);
        }
    }
    for name in groups {
        let inside = |object: &&Object| object.path.first() == Some(name);
        let channels = objects.iter().filter(inside).filter(|o| o.path.len() == 2);
        let channels = channels.filter(|channel| !channel.samples.is_empty());
        let channels: Vec<&Object> = channels.collect();
        let mut test = test(&channels).map_err(|rule| format!("group {name:.40}: {rule}"))?;
        if test.signals.is_empty() {
            continue;
        }
        numbers += test.signals.values().map(Vec::len).sum::<usize>();
        if numbers > MOST_NUMBERS {
            return Err(format!("has more than {MOST_NUMBERS} numbers"));
        }
        let above = |object: &&Object| object.path.is_empty() || object.path == [name.clone()];
        for object in objects.iter().filter(above) {
            take_conditions(&mut test.conditions, object)?;
        }
        test.label = Some(name.clone());
        tests.push(test);
    }
    match tests.is_empty() {
        true => Err("has no group with channels such as tangential force".to_owned()),
        false => Ok(tests),
    }
}

/// The signals of a group.
fn test(channels: &[&Object]) -> Result<Channels, String> {
    let mut test = Channels::default();
    let mut waveform = None;
    for channel in channels {
        let name = &channel.path[1];
        let Some(quantity) = quantity(name) else {
            continue;
        };
        let at = |rule: String| format!("channel {name:.40}: {rule}");
        if matches!(channel.properties.get(SCALES), Some(Value::Number(n)) if *n > 0.0) {
            return Err(at(
                "has samples to be scaled, which are not read: save scaled ones".to_owned(),
            ));
        }
        let stated = match channel.properties.get(UNIT) {
            Some(Value::Text(unit)) => Some(unit.as_str()),
            _ => None,
        };
        let unit = quantity
            .unit(name_and_unit(name).1.or(stated))
            .map_err(at)?;
        let signal = channel.samples.iter().map(|value| unit.to_si(*value));
        let signal: Vec<f64> = signal.collect();
        if let Some(Value::Number(step)) = channel.properties.get(STEP) {
            let first = match channel.properties.get(FIRST) {
                Some(Value::Number(first)) => *first,
                _ => 0.0,
            };
            let own = ([first, *step], signal.len());
            if *waveform.get_or_insert(own) != own {
                let rule = format!(
                    "{STEP}, {FIRST} and number of samples: must be those of the other channels"
                );
                return Err(at(rule));
            }
        }
        test.insert(quantity, signal).map_err(at)?;
    }
    let has_time = test.signals.is_empty() || test.signals.contains_key(&Quantity::Time);
    if !has_time {
        let ([first, step], n) = waveform.ok_or_else(|| {
            format!("must have a channel time or channels with the property {STEP}")
        })?;
        let time = (0..n).map(|at| first + step * at as f64).collect();
        test.insert(Quantity::Time, time)?;
    }
    Ok(test)
}

/// Takes the conditions among the properties of a file or a group.
fn take_conditions(conditions: &mut TestConditions, object: &Object) -> Result<(), String> {
    for (property, value) in &object.properties {
        let (name, unit) = name_and_unit(property);
        let quantity = Quantity::named(name, &Quantity::CONDITIONS);
        match (value, quantity) {
            (Value::Text(text), _) if is_one_of(name, &SPECIMEN) => {
                conditions.set_specimen(text)?;
            }
            (Value::Number(value), Some(quantity)) => {
                let unit = quantity.unit(unit)?;
                conditions.set(quantity, unit.to_si(*value))?;
            }
            _ => {}
        }
    }
    Ok(())
}
