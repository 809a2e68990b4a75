//! The share of the area about the mean pressure, in every format.

use crate::contact::{RECORDS, contact, read_as, whole_contact};
use crate::csv::written;
use crate::mat_file::Form;
use crate::matlab::replaced;
use crate::tdms::{DOUBLE, real, text, whole, word};
use crate::uff58::forms;

const NAME: &str = "area within a tenth of the mean pressure";

/// The share that the only test of a file states.
fn stated(name: &str, bytes: &[u8]) -> Option<f64> {
    read_as(name, bytes).unwrap()[0].conditions.even_area
}

/// A table in text: what is written is read back, several tests have a column, and values that break a rule are refused.
#[test]
fn tables_state_it() {
    let mut tests = ["a", "b"].map(whole_contact);
    for test in &mut tests {
        test.conditions.even_area = Some(0.77);
    }
    let one = written(&tests[..1]);
    assert!(
        one.contains(&format!("\n# {NAME} [%] = 77\n")),
        "{one:.200}"
    );
    assert_eq!(stated("rig.csv", one.as_bytes()), Some(0.77));
    tests[1].conditions.even_area = Some(0.0);
    let several = written(&tests);
    let found = read_as("rig.csv", several.as_bytes()).unwrap();
    let shares: Vec<_> = found.iter().map(|t| t.conditions.even_area).collect();
    assert_eq!(shares, [Some(0.77), Some(0.0)]);
    let damages = format!(
        "
        5 | 0.1,1,1,100,2,a,50   | :6: {NAME} = 77 %: must be 50 % in the whole test
        5 | 0.1,1,1,100,2,a,     | :5: {NAME} = (empty): must be a number
        1 | # even area [%] = 77 | :5: {NAME}: must be stated once
        "
    );
    assert_eq!(RECORDS.refuse("rig.csv", &several, &damages), 3);
    let damages = format!(
        "
        1 | # even area = 77              | :1: {NAME}: has no unit: must have one in brackets, as {NAME} [%]
        1 | # even area [Hz] = 77         | :1: {NAME} [Hz]: must be in a unit of a share: %
        1 | # even area [%] = 100.1       | :1: {NAME} = 100.1 %: must be from 0 to 100 %
        1 | # even area [%] = -1          | :1: {NAME} = -1 %: must be from 0 to 100 %
        1 | # even area [%] = most        | :1: {NAME} = most: must be a number
        1 | # even_area_percent = 77      | :3: {NAME}: must be stated once
        "
    );
    assert_eq!(RECORDS.refuse("rig.csv", &one, &damages), 6);
    let absent = written(&[contact("rig")]);
    assert_eq!(stated("rig.csv", absent.as_bytes()), None);
}

#[test]
fn files_of_matlab_state_it() {
    let form = Form::default();
    let file = |name: &str, values: &[f64]| {
        let variable = form.column(name, values, 0);
        replaced(&form.test(), "temperature", &variable)
    };
    assert_eq!(
        stated("rig.mat", &file("even_area_percent", &[77.0])),
        Some(0.77)
    );
    for (name, values, rule) in [
        ("even_area", &[77.0][..], "has no unit"),
        ("even_area_percent", &[101.0], "= 101 %: must be from 0 to"),
        ("even_area_percent", &[f64::NAN], "= NaN %: must be from 0"),
        (
            "even_area_percent",
            &[77.0, 77.0],
            "must be one real number",
        ),
    ] {
        RECORDS.refuse_bytes("rig.mat", &file(name, values), name, rule);
    }
}

/// In place of a property of the same length.
#[test]
fn tdms_files_state_it() {
    let started = [text("started"), word(0x44), vec![0; 16]].concat();
    let file = |value: f64| {
        let whole = whole();
        let own = [text("even-area [ % ]"), word(DOUBLE), real(value)].concat();
        assert_eq!(own.len(), started.len(), "length of a property");
        let place = (whole.windows(started.len())).position(|at| at == started);
        let mut bytes = whole.clone();
        bytes[place.unwrap()..][..own.len()].copy_from_slice(&own);
        bytes
    };
    assert_eq!(stated("rig.tdms", &file(77.0)), Some(0.77));
    let rule = format!("{NAME} = 177 %: must be from 0 to 100 %");
    RECORDS.refuse_bytes("rig.tdms", &file(177.0), "too much", &rule);
}

/// In place of the date.
#[test]
fn universal_files_state_it() {
    // text, double precision, even spacing
    let text = String::from_utf8(forms()[3].file()).unwrap();
    let with = |line: &str| text.replace("23-Nov-26 10:00:00", line);
    let found = stated("rig.uff", with("even area [%] = 77").as_bytes());
    assert_eq!(found, Some(0.77));
    let rule = format!("{NAME}: has no unit");
    let damaged = with("even area = 77");
    RECORDS.refuse_bytes("rig.uff", damaged.as_bytes(), "no unit", &rule);
}
