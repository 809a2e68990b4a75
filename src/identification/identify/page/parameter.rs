//! Words and units of the contact parameters, and where a test has them.

use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::result::TestEstimate;
use crate::identify::found::uncertain::Uncertain;
use crate::page::display::{capitalised, with_digits};

/// Digits of a number at most.
const MOST_DIGITS: i32 = 6;

/// All, in the order of the page.
pub(super) const ALL: [ContactParameter; 3] = [
    ContactParameter::FrictionCoefficient,
    ContactParameter::TangentialStiffnessNPerUm,
    ContactParameter::NormalStiffnessNPerUm,
];

/// In sentences.
pub(super) fn name(parameter: ContactParameter) -> &'static str {
    match parameter {
        ContactParameter::FrictionCoefficient => "friction coefficient",
        ContactParameter::TangentialStiffnessNPerUm => "tangential stiffness",
        ContactParameter::NormalStiffnessNPerUm => "normal stiffness",
    }
}

/// Of an axis or a column.
pub(super) fn label(parameter: ContactParameter) -> String {
    let name = capitalised(name(parameter));
    match parameter {
        ContactParameter::FrictionCoefficient => name,
        _ => format!("{name} (N/µm)"),
    }
}

/// `34.1 N/µm`.
pub(super) fn with_unit(parameter: ContactParameter, text: &str) -> String {
    match parameter {
        ContactParameter::FrictionCoefficient => text.to_owned(),
        _ => format!("{text} N/µm"),
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

/// What one test says of it.
pub(super) fn of_test(parameter: ContactParameter, estimate: &TestEstimate) -> Option<Uncertain> {
    match parameter {
        ContactParameter::FrictionCoefficient => estimate.friction.map(|f| f.coefficient),
        ContactParameter::TangentialStiffnessNPerUm => Some(estimate.tangential.stiffness_n_per_um),
        ContactParameter::NormalStiffnessNPerUm => estimate.normal_stiffness_n_per_um,
    }
}
