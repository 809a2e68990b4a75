//! Universal files: datasets 58 in text and binary, even and uneven, single and double precision.

use crate::contact::RECORDS;
use crate::contact::{SAMPLES, contact, read_as, whole_contact};
use crate::matlab::assert_near;
use microslip::record::HysteresisRecord;

/// How a file is written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Form {
    double: bool,
    even: bool,
    /// Byte order of numbers; text if absent.
    binary: Option<u8>,
}

/// The eight ways of the format in text and in both byte orders.
pub(crate) fn forms() -> Vec<Form> {
    let orders = [None, Some(1), Some(2)];
    let mut all = Vec::new();
    for binary in orders {
        for (double, even) in [(false, false), (false, true), (true, false), (true, true)] {
            all.push(Form {
                double,
                even,
                binary,
            });
        }
    }
    all
}

/// A signal: description, label and unit of the ordinate, values in that unit.
type Signal = (&'static str, &'static str, &'static str, Vec<f64>);

impl Form {
    /// A dataset of a test with this name in ID line 2.
    fn dataset(self, test: &str, time: &[f64], (id, label, unit, values): &Signal) -> Vec<u8> {
        let kind = if self.double { 4 } else { 2 };
        let n = values.len();
        let (spacing, step) = if self.even {
            (1, time[1] - time[0])
        } else {
            (0, 0.0)
        };
        let data = self.data(time, values);
        let first = match self.binary {
            None => "    58".to_owned(),
            Some(order) => format!(
                "    58b{order:6}{:6}{:12}{:12}     0     0           0           0",
                2,
                11,
                data.len()
            ),
        };
        let head = [
            "    -1".to_owned(),
            first,
            (*id).to_owned(),
            test.to_owned(),
            "23-Nov-26 10:00:00".to_owned(),
            "specimen = A".to_owned(),
            "frequency [Hz] = 100".to_owned(),
            "    1         0    0         0 NONE               1   1 NONE               0   0"
                .to_owned(),
            format!(
                "{kind:10}{n:10}{spacing:10}{:>13}{:>13}{:>13}",
                e13(time[0]),
                e13(step),
                e13(0.0)
            ),
            format!("{:10}    0    0    0 {:20} {:20}", 17, "Time", "s"),
            format!("{:10}    0    0    0 {label:20} {unit:20}", 0),
            format!("{:10}    0    0    0 {:20} {:20}", 0, "NONE", "NONE"),
            format!("{:10}    0    0    0 {:20} {:20}", 0, "NONE", "NONE"),
        ];
        let mut bytes = (head.join("\n") + "\n").into_bytes();
        bytes.extend(data);
        bytes.extend(b"    -1\n");
        bytes
    }

    fn data(self, time: &[f64], values: &[f64]) -> Vec<u8> {
        let Some(order) = self.binary else {
            let mut words = Vec::new();
            for (t, value) in time.iter().zip(values) {
                if !self.even {
                    words.push(format!("{:>13}", e13(*t)));
                }
                words.push(match self.double {
                    true => format!("{value:>20.11E}"),
                    false => format!("{:>13}", e13(*value)),
                });
            }
            let lines = words.chunks(4).map(|line| line.concat() + "\n");
            return lines.collect::<String>().into_bytes();
        };
        let single = |value: f64| match order {
            1 => (value as f32).to_le_bytes(),
            _ => (value as f32).to_be_bytes(),
        };
        let double = |value: f64| match order {
            1 => value.to_le_bytes(),
            _ => value.to_be_bytes(),
        };
        let mut bytes = Vec::new();
        for (t, value) in time.iter().zip(values) {
            if !self.even {
                bytes.extend(single(*t));
            }
            match self.double {
                true => bytes.extend(double(*value)),
                false => bytes.extend(single(*value)),
            }
        }
        bytes
    }

    fn test(self, name: &str, test: &HysteresisRecord) -> Vec<u8> {
        let um = |signal: &[f64]| signal.iter().map(|x| x * 1e6).collect::<Vec<_>>();
        let mut signals = vec![
            (
                "Relative displacement",
                "Displacement",
                "um",
                um(&test.displacement),
            ),
            ("NONE", "Friction force", "N", test.tangential_force.clone()),
            ("Normal Force", "Force", "N", test.normal_force.clone()),
            ("Temperature", "Temperature", "K", test.normal_force.clone()),
        ];
        if let Some(approach) = &test.approach {
            signals.push((
                "Normal displacement",
                "Displacement",
                "\u{b5}m",
                um(approach),
            ));
        }
        let sets = signals
            .iter()
            .map(|signal| self.dataset(name, &test.time, signal));
        sets.flatten().collect()
    }

    /// Units, a function of frequency, and a test.
    pub(crate) fn file(self) -> Vec<u8> {
        let units = "    -1\n   164\n         1SI: Meter (newton)\n  1.0  1.0  1.0\n    -1\n";
        let response = ("NONE", "Tangential force", "N", vec![1.0; 30]);
        let frequencies: Vec<f64> = (0..30).map(f64::from).collect();
        let response = self.dataset("1", &frequencies, &response);
        let at = response.windows(2).rposition(|two| two == b"17").unwrap();
        let mut response = response.clone();
        response[at + 1] = b'8';
        let text = String::from_utf8_lossy(&response[at..at + 60]).replace("Time", "Freq");
        response.splice(at..at + 60, text.bytes());
        [
            units.as_bytes(),
            &response,
            &self.test("NONE", &whole_contact("rig")),
        ]
        .concat()
    }
}

/// As Fortran's 1P,E13.5.
fn e13(value: f64) -> String {
    let text = format!("{value:.5E}");
    let (mantissa, exponent) = text.split_once('E').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    format!(
        "{mantissa}E{}{:02}",
        if exponent < 0 { '-' } else { '+' },
        exponent.abs()
    )
}

/// Seen to fail with the other byte order and with abscissas read as ordinates.
#[test]
fn datasets_of_every_form_are_read() {
    for form in forms() {
        let what = format!("{form:?}");
        let found = read_as("rig.csv", &form.file()).unwrap();
        assert_eq!(found.len(), 1, "{what}");
        assert_eq!(found[0].name, "rig", "{what}");
        assert_near(&found[0], &whole_contact("rig"), 1e-5, &what);
    }
    let form = forms()[3];
    let both = [
        form.test("a", &whole_contact("rig")),
        form.test("b", &whole_contact("rig")),
    ];
    let found = read_as("rig.unv", &both.concat()).unwrap();
    let names: Vec<_> = found.iter().map(|test| test.name.as_str()).collect();
    assert_eq!(names, ["rig a", "rig b"]);
    let latin: Vec<u8> = both[0]
        .iter()
        .copied()
        .filter(|byte| *byte != 0xc2)
        .collect();
    assert_near(
        &read_as("rig.uff", &latin).unwrap()[0],
        &found[0],
        0.0,
        "Latin-1",
    );
}

/// Line 9 has form and number of points, 10 and 11 the axes, 14 the first numbers; lines of the second dataset follow 47.
const DAMAGES: &str = "
1  | 0                                                                             | :1: column 0: the first line without # must name columns
2  |    151                                                                         | must have the signal relative displacement
9  | 4 128                                                                         | :9: must have type, number of points, spacing, first abscissa and step
9  | 5 128 1 0.0 1.5625E-04 0.0                                                    | :9: is complex: must be real
9  | 6 128 1 0.0 1.5625E-04 0.0                                                    | :9: is complex: must be real
9  | 3 128 1 0.0 1.5625E-04 0.0                                                    | :9: data type 3: must be 2 or 4, real numbers
9  | 4 0 1 0.0 1.5625E-04 0.0                                                      | :9: number of points: must be from 1 to 40000000
9  | 4 -5 1 0.0 1.5625E-04 0.0                                                     | :9: number of points: must be from 1
9  | 4 99999999999 1 0.0 1.5625E-04 0.0                                            | :9: number of points: must be from 1
9  | 4 30000000 1 0.0 1.5625E-04 0.0                                               | has more than 40000000 numbers
9  | 4 129 1 0.0 1.5625E-04 0.0                                                    | ends the dataset after 128 of 129 points
9  | 4 127 1 0.0 1.5625E-04 0.0                                                    | has more than the stated 127 points
9  | 4 125 1 0.0 1.5625E-04 0.0                                                    | has more than the stated 125 points
9  | 4 128 2 0.0 1.5625E-04 0.0                                                    | :9: spacing 2: must be 0 or 1
9  | 4 128 0 0.0 1.5625E-04 0.0                                                    | ends the dataset after 64 of 128 points
9  | 4 128 1 NaN 1.5625E-04 0.0                                                    | :9: NaN: must be a finite number
9  | 4 128 1 0.0 fast 0.0                                                          | :9: fast: must be a number
9  | 4 128 1 0.0 0.0 0.0                                                           | abscissa: must be that of the other datasets
9  | 4 128 1 0.0 2E-04 0.0                                                         | abscissa: must be that of the other datasets
Time                 s  | Time                 NONE                            | :10: time: has no unit
Time                 s  | Time                 mm                              | :10: time [mm]: must be in a unit of time
17    0    0    0 Time  | 18    0    0    0 Freq                               | must have the signal relative displacement
Displacement         um | Displacement         NONE                            | :11: relative displacement: has no unit
Displacement         um | Displacement                                         | :11: relative displacement: has no unit
Displacement         um | Displacement         N                               | :11: relative displacement [N]: must be in a unit of length
Displacement         um | Displacement         inch                            | :11: relative displacement [inch]: must be in a unit
3  | Normal displacement                                                           | normal displacement: must be given once for each ID line 2
3  | Friction force                                                                | :11: tangential force [um]: must be in a unit of force
4  | another test                                                                  | must have the signal
6  | specimen = B                                                                  | conditions: must be those of the other datasets
6  | specimen =                                                                    | specimen: must not be empty
7  | frequency = 100                                                               | frequency: has no unit
14 | NaN 1 2 3                                                                     | :14: NaN: must be a finite number
14 | 1 2 three 3                                                                   | :14: three: must be a number
14 | 1 2 1E999 3                                                                   | :14: 1E999: must be a finite number
14 | -1                                                                            | ends the dataset after 0 of 128 points
46 | 58                                                                            | :46: must be -1, which ends a dataset
47 | 58                                                                            | must be -1, which begins a dataset
48 | 151                                                                           | must have the signal tangential force
";

/// Seen to fail with abscissas that are not compared.
#[test]
fn damaged_datasets_are_refused() {
    let form = forms()[3];
    let whole = String::from_utf8(form.test("NONE", &whole_contact("rig"))).unwrap();
    let count = RECORDS.refuse("rig.unv", &whole, DAMAGES);
    assert!(count >= 30, "{count} damages");
    RECORDS.refuse_cuts(
        "rig.unv",
        whole.as_bytes(),
        &[0.01, 0.05, 0.1, 0.15, 0.3, 0.9, 0.99],
        "",
    );
    RECORDS.refuse_bytes(
        "rig.unv",
        b"    -1\n    58\n",
        "cut",
        ":2: the file ends inside a dataset",
    );
    let time = whole.replace(
        "\n        17    0    0    0 Time",
        "\n        18    0    0    0 Freq",
    );
    RECORDS.refuse_bytes(
        "rig.unv",
        time.as_bytes(),
        "no time",
        "has no function of time with a name such as tangential force",
    );
}

/// The first line of a binary dataset, and what the message must hold.
const BINARY_DAMAGES: [(&str, &str); 11] = [
    (
        "    58b",
        ":2: must have byte order, format, lines and bytes after 58b",
    ),
    (
        "    58b     3     2          11        1024",
        ":2: byte order 3: must be 1 or 2",
    ),
    (
        "    58b     1     1          11        1024",
        ":2: format of numbers 1: must be 2, IEEE 754",
    ),
    (
        "    58b     1     2          12        1024",
        ":2: lines before the numbers 12: must be 11",
    ),
    (
        "    58b     1     2          11        many",
        ":2: number of bytes: must be a whole number",
    ),
    (
        "    58b     1     2          11          -1",
        ":2: number of bytes: must be a whole number",
    ),
    (
        "    58b     1     2          11        1023",
        "has 1023 bytes: they do not fit 128 points of 8 bytes",
    ),
    (
        "    58b     1     2          11         512",
        "has 512 bytes: they do not fit 128 points of 8 bytes",
    ),
    (
        "    58b     1     2          11   900000000",
        "has 900000000 bytes: they do not fit",
    ),
    ("    58b     2     2          11        1024", ""),
    ("    58", ""),
];

/// Damages of binary datasets. Seen to fail without the check of their bytes.
#[test]
fn damaged_binary_datasets_are_refused() {
    let mut forms = forms().into_iter().skip(4);
    let form = forms.find(|form| form.double && form.even).unwrap();
    let whole = form.test("NONE", &contact("rig"));
    read_as("rig.unv", &whole).unwrap();
    let head = b"    58b     1     2          11        1024";
    assert!(
        whole.windows(head.len()).any(|bytes| bytes == head),
        "{SAMPLES} numbers of 8 bytes"
    );
    for (new, fragment) in BINARY_DAMAGES {
        let at = whole
            .windows(head.len())
            .position(|bytes| bytes == head)
            .unwrap();
        let end = at + whole[at..].iter().position(|byte| *byte == b'\n').unwrap();
        let mut damaged = whole.clone();
        damaged.splice(at..end, new.bytes());
        RECORDS.refuse_bytes("rig.unv", &damaged, new, fragment);
    }
    RECORDS.refuse_cuts("rig.unv", &whole, &[0.05, 0.2, 0.4, 0.6, 0.8, 0.99], "");
}
