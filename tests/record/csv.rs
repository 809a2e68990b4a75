//! Tables in text: every way to write them, and damages.

use microslip::record::{HysteresisRecord, read_hysteresis, write_hysteresis};

use crate::contact::{RECORDS, SAMPLES, contact, read_as, whole_contact};
use crate::damage::damaged;

/// The table that is written of tests.
pub(crate) fn written(tests: &[HysteresisRecord]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.csv");
    write_hysteresis(&path, tests, &["seed 7"]).unwrap();
    std::fs::read_to_string(path).unwrap()
}

/// Seen to fail with nine digits: displacements changed.
#[test]
fn what_is_written_is_read_back_to_the_bit() {
    let mut test = whole_contact("rig");
    let text = written(std::slice::from_ref(&test));
    assert_eq!(read_as("rig.csv", text.as_bytes()).unwrap(), [test.clone()]);
    let lines: Vec<&str> = text.lines().take(5).collect();
    let names = "time [s],relative displacement [um],tangential force [N],normal force [N],normal displacement [um]";
    assert_eq!(
        lines,
        [
            "# seed 7",
            "# frequency [Hz] = 100",
            "# specimen = A",
            names,
            "0,0,0,101,2.02"
        ]
    );
    for value in test.displacement.iter_mut().chain(&mut test.time) {
        *value = *value * 1.000_000_1 + 1e-13;
    }
    let text = written(std::slice::from_ref(&test));
    assert_eq!(read_as("rig.csv", text.as_bytes()).unwrap(), [test]);
}

/// Seen to fail with names of tests that are not quoted.
#[test]
fn several_tests_stand_in_one_file() {
    let mut tests = ["a", "b, second", "say \"c\""].map(whole_contact);
    tests[1].conditions.frequency_hz = Some(50.0);
    tests[2].conditions.specimen = Some("B".to_owned());
    tests[2].time.iter_mut().for_each(|t| *t += 1.0);
    let text = written(&tests);
    let mut found = read_as("rig.csv", text.as_bytes()).unwrap();
    let names: Vec<_> = found.iter().map(|test| test.name.clone()).collect();
    assert_eq!(names, ["rig a", "rig b, second", "rig say \"c\""]);
    for (found, test) in found.iter_mut().zip(&tests) {
        found.name.clone_from(&test.name);
    }
    assert_eq!(found, tests);
    let one = written(&tests[..1]).replace("[um]\n", "[um],test\n");
    let with_test = one.lines().map(|line| match line.as_bytes()[0] {
        b'0'..=b'9' => format!("{line},only\n"),
        _ => format!("{line}\n"),
    });
    let found = read_as("rig.csv", with_test.collect::<String>().as_bytes()).unwrap();
    assert_eq!(found[0].name, "rig", "one test has the name of the file");
}

/// The table of a test with other names and units, each column by its power of ten.
fn table(heading: &str, powers: [i32; 4], separator: &str, comma: bool) -> String {
    let test = contact("rig");
    let mut text = format!("{heading}\n");
    for at in 0..SAMPLES {
        let values = [
            test.time[at],
            test.displacement[at],
            test.tangential_force[at],
            test.normal_force[at],
        ];
        let cells = values.iter().zip(powers).map(|(value, power)| {
            let cell = microslip::file::shortest_decimal(*value, power);
            if comma { cell.replace('.', ",") } else { cell }
        });
        text += &(cells.collect::<Vec<_>>().join(separator) + "\n");
    }
    text
}

/// Seen to fail with the comma as the only separator.
#[test]
fn names_units_and_separators_of_laboratories_are_read() {
    let tables = [
        table(
            "time [s],relative displacement [um],tangential force [N],normal force [N]",
            [0, -6, 0, 0],
            ",",
            false,
        ),
        table("t [ms];x [mm];T [kN];N [mN]", [-3, -3, 3, -3], ";", true),
        table(
            "Time (s)\tDisplacement (\u{b5}m)\tFriction Force (N)\tNormal Load (N)",
            [0, -6, 0, 0],
            "\t",
            true,
        ),
        table(
            "time_us,relative_displacement_nm,tangential_force_n,normal_force_kn",
            [-6, -9, 0, 3],
            ",",
            false,
        ),
        table(
            "\u{feff}\"time [s]\" ; \"displacement [\u{3bc}m]\" ; \"T [N]\" ; \"N [N]\"",
            [0, -6, 0, 0],
            " ; ",
            false,
        ),
        table(
            "# rig 2\n\n# operator = somebody\ntime [s],x [m],T [N],N [N]",
            [0, 0, 0, 0],
            " , ",
            false,
        ),
    ];
    for text in tables {
        let found = read_as("rig.csv", text.as_bytes()).unwrap();
        assert_eq!(found, [contact("rig")], "{}", &text[..80]);
        let found = read_as("rig.csv", text.replace('\n', "\r\n").as_bytes()).unwrap();
        assert_eq!(found, [contact("rig")], "CRLF: {}", &text[..80]);
    }
}

/// Columns in another order, and one that is passed over. Seen to fail with `_` as a part of names.
#[test]
fn further_columns_are_passed_over_by_their_names() {
    let text = written(&[contact("rig")]);
    let swapped = text.lines().map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        match cells[..] {
            [a, b, c, d] => {
                let note = if a == "0" || a.starts_with("0.") {
                    "20,5"
                } else {
                    "_temperature [K],_note"
                };
                format!("{d},{note},{a},{c},{b}\n")
            }
            _ => format!("{line}\n"),
        }
    });
    let found = read_as("rig.csv", swapped.collect::<String>().as_bytes()).unwrap();
    assert_eq!(found, [contact("rig")]);
}

/// Line 4 names the columns, line 5 is the first sample, line 132 the last one.
const DAMAGES: &str = r#"
4   | time [s],relative displacement [um],tangential force [N]                         | :4: must have a column normal force [N]
4   | relative displacement [um],tangential force [N],normal force [N]                 | :4: must have a column time [s]
4   | 0,1,2,3,4                                                                        | :4: column 0: the first line without # must name columns among time,
[s] |                                                                                  | :4: time: has no unit: must have one in brackets, as time [s]
[s] | []                                                                               | :4: time: has no unit
[s] | [um]                                                                             | :4: time [um]: must be in a unit of time: s, ms, us
[s] | [h]                                                                              | :4: time [h]: must be in a unit of time
[um] | [furlong]                                                                       | :4: relative displacement [furlong]: must be in a unit of length
[N] | [lbf]                                                                            | :4: tangential force [lbf]: must be in a unit of force: N, mN, kN
normal displacement | normal dispalcement                                              | begin its name with _ to pass over it
normal displacement | displacement                                                     | :4: column displacement [um]: must be given once
9   | 0.000625,1.5,45                                                                  | :9: has 3 fields: must have 5, as the first line
9   | 0.000625,1.5,45,100,2,2                                                          | :9: has 6 fields: must have 5
9   | 0.000625,,45,100,2                                                               | :9: relative displacement = (empty): must be a number
9   | 0.000625,NaN,45,100,2                                                            | :9: relative displacement = NaN: must be a finite number
9   | 0.000625,1.5,inf,100,2                                                           | :9: tangential force = inf: must be a finite number
9   | 0.000625,1.5,45,1e400,2                                                          | :9: normal force = 1e400: must be a finite number
9   | 0.000625,1.5,45,high,2                                                           | :9: normal force = high: must be a number
9   | 0.000625,1.5,45,"100,5",2                                                        | :9: normal force = 100,5: must be a number without marks of thousands
9   | 0.000625,1.5,45,"100,2                                                           | :9: a field begins with a quote: must end with one in the same line
9   | 0.000625,1.5,45,"100"0,2                                                         | :9: a quote ends a field: a separator or the end
9   | 0.000625,1.5,45,100\0,2                                                          | :9: has a null byte
9   | 0.000625,1.5,2e7,100,2                                                           | :9: tangential force = 2e7 N: must be at most 1e7 N in size
9   | 0.00046875,1.5,45,100,2                                                          | :9: time = 0.00046875 s: must be later than the sample before, 0.00046875 s
9   | 0,1.5,45,100,2                                                                   | :9: time = 0 s: must be later than the sample before
2   | # frequency = 100                                                                | :2: frequency: has no unit
2   | # frequency [Hz] = fast                                                          | :2: frequency = fast: must be a number
2   | # frequency [Hz] = 0                                                             | :2: frequency = 0 Hz: must be a finite number > 0
2   | # frequency [Hz] = -5                                                            | :2: frequency = -5 Hz: must be a finite number > 0
2   | # frequency [s] = 5                                                              | :2: frequency [s]: must be in a unit of frequency: Hz, kHz
2   | # frequency [kHz] = 100                                                          | frequency = 100000 Hz: must be below half of the sampling rate, which is 6400
2   | # specimen = B                                                                   | :3: specimen: must be stated once
3   | # specimen =                                                                     | :3: specimen: must not be empty
3   | # frequency [Hz] = 200                                                           | :3: frequency: must be stated once
"#;

/// Seen to fail without the checks of the number of fields, of needed and of repeated columns, of the order of times, of the
/// number of samples and of the sampling rate, one after the other.
#[test]
fn damaged_tables_are_refused() {
    let text = written(&[whole_contact("rig")]);
    let count = RECORDS.refuse("rig.csv", &text, DAMAGES);
    assert!(count >= 30, "{count} damages");
    let rows: Vec<&str> = text.lines().collect();
    let short = rows[..20].join("\n");
    RECORDS.refuse_bytes(
        "rig.csv",
        short.as_bytes(),
        "16 samples",
        "has 16 samples: must have 20 at least",
    );
    let heading = rows[..4].join("\n");
    RECORDS.refuse_bytes(
        "rig.csv",
        heading.as_bytes(),
        "no rows",
        ":4: must be followed by rows of numbers",
    );
    RECORDS.refuse_bytes("rig.csv", b"", "empty", "is empty");
    RECORDS.refuse_bytes("rig.csv", b"# nothing\n\n", "comments", "is empty");
    RECORDS.refuse_bytes("rig.csv", b"\xff\xfet\0", "UTF-16", "is UTF-16 text");
    RECORDS.refuse_bytes(
        "rig.csv",
        &[text.as_bytes(), b"\xb5"].concat(),
        "Latin-1",
        "is no UTF-8",
    );
    let long = damaged(&text, &format!("A | {}", "A".repeat(101)));
    RECORDS.refuse_bytes(
        "rig.csv",
        long.as_bytes(),
        "long name",
        ":3: specimen: has 101 characters: must have at most 100",
    );
    let wide = damaged(&text, &format!("4 | {}", vec!["_"; 1001].join(",")));
    RECORDS.refuse_bytes(
        "rig.csv",
        wide.as_bytes(),
        "wide",
        ":4: has more than 1000 columns",
    );
}

/// Damages of decimal commas. Seen to fail without the memory of the first mark.
#[test]
fn marks_of_decimals_are_not_mixed() {
    let text = table("t [ms];x [mm];T [kN];N [mN]", [-3, -3, 3, -3], ";", true);
    let damages = "
        9 | 1.09375;0,005;0,05;100000     | :9: time = 1.09375: decimal point and decimal comma must not both be used
        9 | 1,09375;0,005;0,05;1.000,5    | :9: normal force = 1.000,5: must be a number without marks of thousands
        9 | 1,09375;0,005;0,05;1,000,000  | :9: normal force = 1.000,000: must be a number
        9 | 1,09375;0,005;0,05            | :9: has 3 fields: must have 4
    ";
    assert_eq!(RECORDS.refuse("rig.csv", &text, damages), 4);
}

/// Damages of a file with several tests. Seen to fail with rows of a test joined wherever they stand.
#[test]
fn rows_of_a_test_stand_together() {
    let mut tests = ["a", "b"].map(whole_contact);
    tests[1].conditions.frequency_hz = Some(50.0);
    tests[1].conditions.specimen = Some("B".to_owned());
    let text = written(&tests);
    let names: Vec<&str> = text.lines().skip(1).take(1).collect();
    assert!(
        names[0].ends_with(",test,frequency [Hz],specimen"),
        "{names:?}"
    );
    let damages = "
        20 | 0.1,1,1,100,2,b,100,A    | :21: test a: rows of a test must stand together
        20 | 0.1,1,1,100,2,,100,A     | :20: test: must not be empty
        20 | 0.1,1,1,100,2,a,50,A     | :20: frequency = 50 Hz: must be 100 Hz in the whole test
        20 | 0.1,1,1,100,2,a,100,B    | :20: specimen B: must be A in the whole test
        20 | 0.1,1,1,100,2,a,0,A      | :20: frequency = 0 Hz: must be 100 Hz in the whole test
        20 | 0.1,1,1,100,2,a,100,A    | :21: time = 0.00
        1  | # specimen = A           | :3: specimen: must be stated once
        1  | # frequency [Hz] = 5     | :3: frequency: must be stated once
    ";
    assert_eq!(RECORDS.refuse("rig.csv", &text, damages), 8);
    let cut: Vec<&str> = text.lines().take(2 + SAMPLES + 5).collect();
    RECORDS.refuse_bytes(
        "rig.csv",
        cut.join("\n").as_bytes(),
        "short",
        "test b: has 5 samples: must have 20 at least",
    );
}

/// Seen to fail without the check: a file given twice counted twice.
#[test]
fn tests_of_several_files_have_names_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["rig.csv", "other.csv"].map(|name| folder.path().join(name));
    for path in &paths {
        std::fs::write(path, written(&[contact("rig")])).unwrap();
    }
    let found = read_hysteresis(&paths).unwrap();
    assert_eq!(found.len(), 2, "{found:?}");
    let twice = [paths[0].clone(), paths[0].clone()];
    let message = read_hysteresis(&twice).unwrap_err().to_string();
    assert!(
        message.contains("test rig: its name must differ from that in"),
        "{message}"
    );
    let absent = read_hysteresis(&[folder.path().join("absent.csv")]);
    assert!(
        absent.unwrap_err().to_string().contains("absent.csv"),
        "the file is named"
    );
    let whole = read_hysteresis(&[folder.path().to_owned()]).unwrap_err();
    assert!(
        whole.to_string().contains("is a folder, not a file"),
        "{whole}"
    );
}
