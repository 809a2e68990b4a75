//! MATLAB files of tests: vectors, structures of vectors, units in names or in a structure.

use crate::contact::RECORDS;
use crate::contact::{SAMPLES, contact, read_as, whole_contact};
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

/// A variable that replaces one of the file, and what the message must hold.
type Damages = Vec<(Vec<u8>, &'static str)>;

/// In place of the displacements.
fn displacement_damages(form: Form) -> Damages {
    let x = contact("rig").displacement;
    let with = |at: usize, value: f64| {
        let mut changed = x.clone();
        changed[at] = value;
        changed
    };
    let own = |values: &[f64]| form.column("displacement_um", values, -6);
    let data = (DOUBLE, form.reals(x.iter().copied()));
    let wide = form.variable("x", DOUBLE_CLASS, &[2, 64], std::slice::from_ref(&data));
    let complex = DOUBLE_CLASS | COMPLEX;
    let complex = form.variable("x", complex, &[128, 1], &[data.clone(), data]);
    vec![
        (form.column("other", &x, 0), "must have the signal relative"),
        (form.column("displacement", &x, 0), "ment: has no unit"),
        (
            form.column("displacement_N", &x, 0),
            "[N]: must be in a unit",
        ),
        (form.column("displacement_m", &x, -6), "is its unit right?"),
        (form.column("time_ms", &x, 0), "time: must be given once"),
        (
            own(&x[1..]),
            "relative displacement has 127 samples and time 128",
        ),
        (
            own(&with(6, f64::NAN)),
            "sample 7: relative displacement = NaN",
        ),
        (
            own(&with(0, f64::INFINITY)),
            "sample 1: relative displacement = inf",
        ),
        (own(&with(5, 3.0)), "relative displacement changes by"),
        (form.text("x_um", "none"), "x_um: must be a vector of real"),
        (wide, "x: must be a vector of real numbers"),
        (complex, "x: must be a vector of real numbers"),
    ]
}

/// In place of the times.
fn time_damages(form: Form) -> Damages {
    let test = contact("rig");
    let standing = vec![1.0; SAMPLES];
    vec![
        (
            form.column("time_s", &test.displacement, 0),
            "must be later than",
        ),
        (
            form.column("time_s", &standing, 0),
            "sample 2: time = 1 s: must",
        ),
        (
            form.column("time_um", &test.time, 0),
            "time [um]: must be in a unit",
        ),
        (form.column("time", &test.time, 0), "time: has no unit"),
    ]
}

/// In place of the normal forces.
fn force_damages(form: Form) -> Damages {
    let n = contact("rig").normal_force;
    let negative: Vec<f64> = n.iter().map(|n| -n).collect();
    vec![
        (
            form.column("normal_force_lbf", &n, 0),
            "must have the signal normal force",
        ),
        (
            form.column("normal_force", &n, 0),
            "normal force: has no unit",
        ),
        (
            form.column("normal_force_kn", &[1e5; SAMPLES], 0),
            "sample 1: normal force = 1e8 N",
        ),
        (
            form.column("normal_force_N", &negative, 0),
            "normal force is negative",
        ),
    ]
}

/// In place of the frequency.
fn frequency_damages(form: Form) -> Damages {
    let own = |values: &[f64]| form.column("frequency_hz", values, 0);
    vec![
        (
            form.column("frequency", &[100.0], 0),
            "frequency: has no unit",
        ),
        (
            form.column("frequency_s", &[100.0], 0),
            "frequency [s]: must be in a unit",
        ),
        (
            form.column("frequency_kHz", &[100.0], 0),
            "must be below half of the sampling",
        ),
        (own(&[100.0, 100.0]), "frequency: must be one real number"),
        (
            own(&[-1.0]),
            "frequency = -1 Hz: must be a finite number > 0",
        ),
        (
            own(&[f64::NAN]),
            "frequency = NaN Hz: must be a finite number > 0",
        ),
    ]
}

/// In place of a note.
fn note_damages(form: Form) -> Damages {
    let tests = form.tests()[128..].to_vec();
    let long = "A".repeat(101);
    vec![
        (
            form.text("specimen_id", "A"),
            "specimen: must be stated once",
        ),
        (
            form.column("specimen", &[1.0], 0),
            "specimen: must be a text",
        ),
        (form.text("specimen", " "), "specimen: must not be empty"),
        (
            form.text("specimen", "A\nB"),
            "specimen: must be a text of one line",
        ),
        (form.text("specimen", &long), "specimen: has 101 characters"),
        (
            tests,
            "has signals in structures and beside them: must have either",
        ),
    ]
}

/// Seen to fail with numbers that are not finite taken, and with lengths that are not compared.
#[test]
fn damaged_files_are_refused() {
    let form = Form::default();
    let whole = form.test();
    let damages = [
        ("displacement_um", displacement_damages(form)),
        ("time_s", time_damages(form)),
        ("normal_force_N", force_damages(form)),
        ("frequency_hz", frequency_damages(form)),
        ("note", note_damages(form)),
    ];
    let mut count = 0;
    for (name, damages) in damages {
        for (new, fragment) in damages {
            let file = replaced(&whole, name, &new);
            RECORDS.refuse_bytes("rig.mat", &file, &format!("{name}: {fragment}"), fragment);
            count += 1;
        }
    }
    assert!(count >= 30, "{count} damages");
    RECORDS.refuse_cuts(
        "rig.mat",
        &whole,
        &[0.003, 0.01, 0.02, 0.3, 0.5, 0.7, 0.9, 0.999],
        "",
    );
    RECORDS.refuse_bytes(
        "rig.mat",
        &whole[..128],
        "empty",
        "has no signal of a test: must have vectors such as time_s",
    );
    RECORDS.refuse_bytes("rig.mat", b"\x89HDF\r\n\x1a\n", "HDF5", "version 7.3");
    let packed = Form {
        compressed: true,
        ..form
    };
    RECORDS.refuse_cuts("rig.mat", &packed.test(), &[0.3, 0.6, 0.9], "variable");
}

/// The file with another variable in place of the one of this name.
pub(crate) fn replaced(file: &[u8], name: &str, new: &[u8]) -> Vec<u8> {
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
        RECORDS.refuse_bytes("rig.mat", &file, fragment, fragment);
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
