//! MATLAB files of tests: vectors, structures of vectors, units in names or in a structure.

use crate::contact::{SAMPLES, contact, read_as, whole_contact};
use crate::damage::{refuse_bytes, refuse_cuts};
use crate::mat_file::*;
use microslip::record::HysteresisRecord;

/// Class of structures.
const STRUCTURE_CLASS: u32 = 2;
/// Class of texts.
const TEXT_CLASS: u32 = 4;

impl Form {
    pub(crate) fn column(self, name: &str, values: &[f64], power: i32) -> Vec<u8> {
        let values = values.iter().map(|v| v * 10_f64.powi(-power));
        let data = (DOUBLE, self.reals(values.clone()));
        self.variable(name, DOUBLE_CLASS, &[values.count(), 1], &[data])
    }

    /// A text in UTF-16, as MATLAB writes it, or in UTF-8, as SciPy does where it can.
    fn text(self, name: &str, text: &str) -> Vec<u8> {
        let data = match self.small {
            true => (16, text.as_bytes().to_vec()),
            false => {
                let pairs = text.encode_utf16().map(|code| match self.big_endian {
                    true => code.to_be_bytes(),
                    false => code.to_le_bytes(),
                });
                (4, pairs.flatten().collect())
            }
        };
        self.variable(name, TEXT_CLASS, &[1, text.chars().count()], &[data])
    }

    /// Fields have names of their own list, and stand without them.
    fn structure(self, name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let names = fields.iter().flat_map(|(name, _)| {
            let mut name = name.as_bytes().to_vec();
            name.resize(32, 0);
            name
        });
        let length = self.wholes([32]);
        let small = Self {
            small: true,
            ..self
        };
        let parts = [
            small.element(INT32, &length),
            self.element(INT8, &names.collect::<Vec<_>>()),
        ];
        let fields = fields.iter().map(|(_, field)| field.clone());
        let data: Vec<u8> = parts.into_iter().chain(fields).flatten().collect();
        self.raw_variable(name, STRUCTURE_CLASS, &[1, 1], &data)
    }

    /// Without compression, which is of whole variables.
    fn inside(self) -> Self {
        Self {
            compressed: false,
            ..self
        }
    }

    /// Names with units: µm and N.
    pub(crate) fn test(self) -> Vec<u8> {
        let test = whole_contact("rig");
        self.file(&[
            self.column("time_s", &test.time, 0),
            self.column("displacement_um", &test.displacement, -6),
            self.column("tangential_force_N", &test.tangential_force, 0),
            self.column("normal_force_N", &test.normal_force, 0),
            self.column("normal_displacement_um", &test.approach.unwrap(), -6),
            self.column("frequency_hz", &[100.0], 0),
            self.text("specimen", "A"),
            self.column("N", &[3.0], 0),
            self.column("temperature", &[20.0, 21.0], 0),
            self.text("note", "first"),
        ])
    }

    /// Two structures; their units stand in a third one.
    pub(crate) fn tests(self) -> Vec<u8> {
        let form = self.inside();
        let test = contact("rig");
        let fields = [
            ("t", form.column("", &test.time, -3)),
            ("x", form.column("", &test.displacement, 0)),
            ("T", form.column("", &test.tangential_force, 3)),
            ("N", form.column("", &test.normal_force, 0)),
        ];
        let units = [("t", "ms"), ("x", "m"), ("T", "kN"), ("N", "N")];
        let units = units.map(|(name, unit)| (name, form.text("", unit)));
        self.file(&[
            self.structure("first", &fields),
            self.structure("second", &fields),
            self.structure("units", &units),
            self.structure("rig", &[("name", form.text("", "rig 2"))]),
        ])
    }
}

/// Equal but for one rounding of a product with a power of ten.
pub(crate) fn assert_near(
    found: &HysteresisRecord,
    test: &HysteresisRecord,
    tolerance: f64,
    what: &str,
) {
    assert_eq!(found.conditions, test.conditions, "{what}");
    let pairs = [
        (&found.time, &test.time),
        (&found.displacement, &test.displacement),
        (&found.tangential_force, &test.tangential_force),
        (&found.normal_force, &test.normal_force),
    ];
    let approach = found.approach.iter().zip(&test.approach);
    assert_eq!(found.approach.is_some(), test.approach.is_some(), "{what}");
    for (found, test) in pairs.into_iter().chain(approach) {
        assert_eq!(found.len(), test.len(), "{what}");
        for (a, b) in found.iter().zip(test) {
            assert!(
                (a - b).abs() <= tolerance * b.abs(),
                "{what}: {a} is not {b}"
            );
        }
    }
}

/// Seen to fail with numbers of the other byte order, and with values taken for SI units.
#[test]
fn signals_of_every_form_are_read() {
    for form in forms() {
        let what = format!("{form:?}");
        let found = read_as("rig.any", &form.test()).unwrap();
        assert_near(&found[0], &whole_contact("rig"), 1e-15, &what);
        let found = read_as("rig.mat", &form.tests()).unwrap();
        let names: Vec<_> = found.iter().map(|test| test.name.as_str()).collect();
        assert_eq!(names, ["rig first", "rig second"], "{what}");
        for test in &found {
            assert_near(test, &contact("rig"), 1e-15, &what);
        }
    }
}

/// A variable of the file that replaces the one of its name, and what the message must hold.
fn damages(form: Form) -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let test = contact("rig");
    let x = &test.displacement;
    let with = |at: usize, value: f64| {
        let mut changed = x.clone();
        changed[at] = value;
        changed
    };
    let complex = (DOUBLE, form.reals(x.iter().copied()));
    vec![
        (
            "displacement_um",
            form.column("other", x, 0),
            "must have the signal relative displacement",
        ),
        (
            "displacement_um",
            form.column("displacement", x, 0),
            "relative displacement: has no unit",
        ),
        (
            "displacement_um",
            form.column("displacement_N", x, 0),
            "relative displacement [N]: must be in a unit of length",
        ),
        (
            "displacement_um",
            form.column("displacement_um", &x[1..], -6),
            "relative displacement has 127 samples and time 128: must have as many",
        ),
        (
            "displacement_um",
            form.column("displacement_um", &with(6, f64::NAN), -6),
            "sample 7: relative displacement = NaN: must be a finite number",
        ),
        (
            "displacement_um",
            form.column("displacement_um", &with(0, f64::INFINITY), -6),
            "sample 1: relative displacement = inf",
        ),
        (
            "displacement_um",
            form.column("displacement_um", &with(5, 3.0), -6),
            "relative displacement changes by",
        ),
        (
            "displacement_um",
            form.column("displacement_m", x, -6),
            "is its unit right?",
        ),
        (
            "displacement_um",
            form.text("displacement_um", "none"),
            "displacement_um: must be a vector of real numbers",
        ),
        (
            "displacement_um",
            form.variable(
                "displacement_um",
                DOUBLE_CLASS,
                &[2, 64],
                &[complex.clone()],
            ),
            "displacement_um: must be a vector",
        ),
        (
            "displacement_um",
            form.variable(
                "displacement_um",
                DOUBLE_CLASS | COMPLEX,
                &[128, 1],
                &[complex.clone(), complex],
            ),
            "displacement_um: must be a vector",
        ),
        (
            "displacement_um",
            form.column("time_ms", x, 0),
            "time: must be given once",
        ),
        ("time_s", form.column("time_s", &with(9, 0.0), 0), "sample"),
        (
            "time_s",
            form.column("time_s", &vec![1.0; SAMPLES], 0),
            "sample 2: time = 1 s: must be later than the sample before, 1 s",
        ),
        (
            "time_s",
            form.column("time_um", &test.time, 0),
            "time [um]: must be in a unit of time",
        ),
        (
            "tangential_force_N",
            form.column("tangential_force_lbf", x, 0),
            "must have the signal tangential force",
        ),
        (
            "normal_force_N",
            form.column("normal_force", &test.normal_force, 0),
            "normal force: has no unit",
        ),
        (
            "normal_force_N",
            form.column("normal_force_kn", &[1e5; SAMPLES], 0),
            "sample 1: normal force = 1e8 N: must be at most 1e7 N",
        ),
        (
            "normal_force_N",
            form.column("normal_force_N", &[-1.0; SAMPLES], 0),
            "normal force is negative",
        ),
        (
            "frequency_hz",
            form.column("frequency", &[100.0], 0),
            "frequency: has no unit",
        ),
        (
            "frequency_hz",
            form.column("frequency_hz", &[100.0, 100.0], 0),
            "frequency: must be one real number",
        ),
        (
            "frequency_hz",
            form.column("frequency_hz", &[-1.0], 0),
            "frequency = -1 Hz: must be a finite number > 0",
        ),
        (
            "frequency_hz",
            form.column("frequency_hz", &[f64::NAN], 0),
            "frequency = NaN Hz: must be a finite number > 0",
        ),
        (
            "frequency_hz",
            form.column("frequency_kHz", &[100.0], 0),
            "frequency = 100000 Hz: must be below half of the sampling rate",
        ),
        (
            "specimen",
            form.column("specimen", &[1.0], 0),
            "specimen: must be a text",
        ),
        (
            "specimen",
            form.text("specimen", " "),
            "specimen: must not be empty",
        ),
        (
            "specimen",
            form.text("specimen", "A\nB"),
            "specimen: must be a text of one line",
        ),
        (
            "note",
            form.text("specimen_id", "A"),
            "specimen: must be stated once",
        ),
        (
            "note",
            form.tests()[128..].to_vec(),
            "has signals in structures and beside them: must have either",
        ),
    ]
}

/// Seen to fail with each rule's check taken out.
#[test]
fn damaged_files_are_refused() {
    let form = Form::default();
    let whole = form.test();
    let count = damages(form).len();
    for (name, new, fragment) in damages(form) {
        let file = replaced(&whole, name, &new);
        refuse_bytes("rig.mat", &file, &format!("{name}: {fragment}"), fragment);
    }
    assert!(count >= 28, "{count} damages");
    refuse_cuts(
        "rig.mat",
        &whole,
        &[0.003, 0.01, 0.02, 0.3, 0.5, 0.7, 0.9, 0.999],
        "",
    );
    refuse_bytes(
        "rig.mat",
        &whole[..128],
        "empty",
        "has no signal of a test: must have vectors such as time_s",
    );
    refuse_bytes("rig.mat", b"\x89HDF\r\n\x1a\n", "HDF5", "version 7.3");
    let packed = Form {
        compressed: true,
        ..form
    };
    refuse_cuts("rig.mat", &packed.test(), &[0.3, 0.6, 0.9], "variable");
}

/// The file with another variable in place of the one of this name.
fn replaced(file: &[u8], name: &str, new: &[u8]) -> Vec<u8> {
    let mut at = 128;
    let mut all = file[..128].to_vec();
    while at < file.len() {
        let length = u32::from_le_bytes(file[at + 4..at + 8].try_into().unwrap()) as usize;
        let variable = &file[at..at + 8 + length];
        let word = u32::from_le_bytes(variable[44..48].try_into().unwrap()) as usize;
        let own = match variable[42..44] {
            [0, 0] => &variable[48..48 + word],
            _ => &variable[44..44 + usize::from(variable[42])],
        };
        match own == name.as_bytes() {
            true => all.extend(new),
            false => all.extend(variable),
        }
        at += 8 + length;
    }
    all
}

/// Structures that are damaged. Seen to fail without the bound of a field's name.
#[test]
fn damaged_structures_are_refused() {
    let form = Form::default();
    let whole = form.tests();
    let damage = |from: &[u8], to: &[u8], fragment: &str| {
        let at = whole.windows(from.len()).position(|bytes| bytes == from);
        let mut file = whole.clone();
        file.splice(at.unwrap()..at.unwrap() + from.len(), to.iter().copied());
        refuse_bytes("rig.mat", &file, fragment, fragment);
    };
    let length = [5, 0, 4, 0, 32, 0, 0, 0];
    damage(
        &length,
        &[5, 0, 4, 0, 0, 0, 0, 0],
        "first: names of fields: must have 1 to 128 bytes",
    );
    damage(
        &length,
        &[5, 0, 4, 0, 129, 0, 0, 0],
        "first: names of fields: must have 1 to 128 bytes",
    );
    damage(&length, &[5, 0, 4, 0, 16, 0, 0, 0], "first: ");
    damage(
        b"m\0s\0",
        b"m\0z\0",
        "structure first: time [mz]: must be in a unit of time",
    );
    damage(
        b"k\0N\0",
        b"M\0N\0",
        "structure first: tangential force [MN]: must be in a unit of force",
    );
}
