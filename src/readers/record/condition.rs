//! Conditions of a test that a file states beside its signals: `frequency [Hz] = 100`, `specimen = A`.

use super::quantity::{Quantity, is_name, name_and_unit, written_unit as unit};
use super::signals::TestConditions;
use crate::file::{scaled_number, shortest_decimal};

/// Names of a specimen in a file.
pub(super) const SPECIMEN: [&str; 3] = ["specimen", "specimen id", "contact pair"];
/// Names of a test in a file.
pub(super) const TEST: [&str; 3] = ["test", "test id", "test name"];
/// Characters of a test's or specimen's name at most.
const LONGEST_LABEL: usize = 100;

/// Whether a name is one of `known`.
pub(super) fn is_one_of(name: &str, known: &[&str]) -> bool {
    known.iter().any(|own| is_name(name, own))
}

/// The name of a test or specimen.
///
/// # Errors
/// The rule, if it is blank, too long or more than one line.
pub(super) fn label(what: &str, text: &str) -> Result<String, String> {
    let text = text.trim();
    if text.chars().any(char::is_control) {
        return Err(format!("{what}: must be a text of one line"));
    }
    match text.chars().count() {
        0 => Err(format!("{what}: must not be empty")),
        1..=LONGEST_LABEL => Ok(text.to_owned()),
        n => Err(format!(
            "{what}: has {n} characters: must have at most {LONGEST_LABEL}"
        )),
    }
}

impl TestConditions {
    /// Takes a line such as `frequency [Hz] = 100`. Other lines are words of the laboratory and are passed over.
    ///
    /// # Errors
    /// The rule that a condition breaks.
    pub(super) fn take_line(&mut self, line: &str) -> Result<(), String> {
        let Some((heading, value)) = line.split_once('=') else {
            return Ok(());
        };
        let (name, unit) = name_and_unit(heading);
        if is_one_of(name, &SPECIMEN) {
            return self.set_specimen(value);
        }
        let Some(quantity) = Quantity::named(name, &Quantity::CONDITIONS) else {
            return Ok(());
        };
        let unit = quantity.unit(unit)?;
        // no list of numbers stands here: a comma is that of a decimal
        let value = value.trim().replacen(',', ".", 1);
        let value = scaled_number(&value, unit.power);
        let named = |rule| format!("{} = {rule}", quantity.name());
        self.set(quantity, value.map_err(named)?)
    }

    /// # Errors
    /// The rule, if it is blank or stated before.
    pub(super) fn set_specimen(&mut self, text: &str) -> Result<(), String> {
        match self.specimen.replace(label("specimen", text)?) {
            None => Ok(()),
            Some(_) => Err("specimen: must be stated once".to_owned()),
        }
    }

    /// Takes a number in SI units; one of another quantity is passed over.
    ///
    /// # Errors
    /// The rule that it breaks.
    pub(super) fn set(&mut self, quantity: Quantity, value: f64) -> Result<(), String> {
        match quantity {
            Quantity::Frequency => self.set_frequency(value),
            Quantity::EvenArea => self.set_even_area(value),
            _ => Ok(()),
        }
    }

    /// # Errors
    /// The rule, if it is not from 0 to 1 or stated before.
    fn set_even_area(&mut self, value: f64) -> Result<(), String> {
        let name = Quantity::EvenArea.name();
        if !(0.0..=1.0).contains(&value) {
            let (unit, power) = unit(Quantity::EvenArea);
            let shown = shortest_decimal(value, power);
            return Err(format!("{name} = {shown} {unit}: must be from 0 to 100 %"));
        }
        match self.even_area.replace(value) {
            None => Ok(()),
            Some(_) => Err(format!("{name}: must be stated once")),
        }
    }

    /// # Errors
    /// The rule, if it is not above 0 (Hz) or stated before.
    fn set_frequency(&mut self, value: f64) -> Result<(), String> {
        if !(value.is_finite() && value > 0.0) {
            return Err(format!(
                "frequency = {value} Hz: must be a finite number > 0"
            ));
        }
        match self.frequency_hz.replace(value) {
            None => Ok(()),
            Some(_) => Err("frequency: must be stated once".to_owned()),
        }
    }
}
