//! Contact parameters as the page shows them: labels, units and digits.

use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::uncertain::Uncertain;
use crate::page::display::{capitalised, with_digits};

/// Digits of a number at most.
const MOST_DIGITS: i32 = 6;

/// Of an axis or a column.
pub(super) fn label(parameter: ContactParameter) -> String {
    let name = capitalised(parameter.in_words());
    match parameter.unit() {
        None => name,
        Some(unit) => format!("{name} ({unit})"),
    }
}

/// `34.1 N/µm`.
pub(super) fn with_unit(parameter: ContactParameter, text: &str) -> String {
    match parameter.unit() {
        None => text.to_owned(),
        Some(unit) => format!("{text} {unit}"),
    }
}

/// A value of any of them.
pub(super) fn show(value: f64) -> String {
    with_digits(value, 3)
}

/// A value and both ends of its interval, with as many digits as tell these apart.
pub(super) fn show_all(found: Uncertain) -> [String; 3] {
    let shown =
        |digits: i32| [found.value, found.lower, found.upper].map(|v| with_digits(v, digits));
    let apart = |digits: &i32| {
        let [value, lower, upper] = shown(*digits);
        value != lower && value != upper
    };
    shown((3..MOST_DIGITS).find(apart).unwrap_or(MOST_DIGITS))
}
