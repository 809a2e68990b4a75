//! MATLAB files of hysteresis tests.
//!
//! Signals are vectors with the names of columns, the unit at the end of the name (`time_s`, `displacement_um`) or in a structure
//! `units` under the name of the vector (`units.time = 's'`). Several tests are structures of such vectors.

use std::path::Path;

use super::super::channels::{Channels, MOST_TESTS};
use super::super::condition::{SPECIMEN, is_one_of};
use super::super::quantity::{Quantity, name_and_unit};
use crate::file::FileError;
use crate::file::matlab::{self, Values, Variable};

/// Name of the structure of units.
const UNITS: &str = "units";

/// The tests of a file: its vectors, or its structures of vectors. Other variables are passed over.
///
/// # Errors
/// [`FileError`] with the variable and the rule that it breaks.
pub(in crate::record) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<Channels>, FileError> {
    tests(bytes).map_err(|rule| FileError::content(path, None, rule))
}

fn tests(bytes: &[u8]) -> Result<Vec<Channels>, String> {
    let variables = matlab::read(bytes)?;
    let units = fields(&variables, UNITS).unwrap_or_default();
    let whole = channels(&variables, units)?;
    let mut tests = Vec::new();
    for variable in variables.iter().filter(|variable| variable.name != UNITS) {
        let Values::Structure(fields) = &variable.values else {
            continue;
        };
        let name = &variable.name;
        let test = channels(fields, units).map_err(|rule| format!("structure {name}: {rule}"))?;
        if !test.signals.is_empty() {
            let label = Some(name.clone());
            tests.push(Channels { label, ..test });
        }
    }
    match (whole.signals.is_empty(), tests.is_empty()) {
        (true, true) => Err(
            "has no signal of a test: must have vectors such as time_s, displacement_um, tangential_force_N, normal_force_N"
                .to_owned(),
        ),
        (false, false) => Err("has signals in structures and beside them: must have either".to_owned()),
        (false, true) => Ok(vec![whole]),
        (true, false) if tests.len() > MOST_TESTS => Err(format!("has more than {MOST_TESTS} tests")),
        (true, false) => Ok(tests),
    }
}

/// The fields of the structure `name`.
fn fields<'v>(variables: &'v [Variable], name: &str) -> Option<&'v [Variable]> {
    let found = variables.iter().find(|variable| variable.name == name)?;
    match &found.values {
        Values::Structure(fields) => Some(fields),
        _ => None,
    }
}

/// Signals and conditions among variables; `units` hold for those that have none of their own.
fn channels(variables: &[Variable], units: &[Variable]) -> Result<Channels, String> {
    let units = fields(variables, UNITS).unwrap_or(units);
    let mut channels = Channels::default();
    for variable in variables {
        let (name, unit) = name_and_unit(&variable.name);
        let stated = units.iter().find(|unit| unit.name == variable.name);
        let unit = unit.or_else(|| text(stated?));
        let is_number = variable.shape.iter().all(|size| *size == 1);
        if is_one_of(name, &SPECIMEN) {
            let text = text(variable).ok_or_else(|| format!("{name}: must be a text"))?;
            channels.conditions.set_specimen(text)?;
        } else if let Some(quantity) = Quantity::named(name, &Quantity::CONDITIONS) {
            let unit = quantity.unit(unit)?;
            let (true, Values::Dense { numbers, .. }) = (is_number, &variable.values) else {
                return Err(format!("{name}: must be one real number"));
            };
            channels.conditions.set(quantity, unit.to_si(numbers[0]))?;
        } else if let Some(quantity) = Quantity::named(name, &Quantity::SIGNALS) {
            // a number N is not the normal force
            if is_number {
                continue;
            }
            let shown = &variable.name;
            let (Values::Dense { numbers, .. }, [_, 1] | [1, _]) =
                (&variable.values, &variable.shape[..])
            else {
                return Err(format!("{shown:.40}: must be a vector of real numbers"));
            };
            let unit = quantity.unit(unit)?;
            let signal = numbers.iter().map(|value| unit.to_si(*value)).collect();
            channels.insert(quantity, signal)?;
        }
    }
    Ok(channels)
}

fn text(variable: &Variable) -> Option<&str> {
    match &variable.values {
        Values::Text(text) => Some(text),
        _ => None,
    }
}
