//! Measured forced responses: tables of levels, frequencies and amplitudes.

use microslip::file::FileError;
use microslip::record::{ResponsePoint, ResponseRecord, read_response, write_response};

use crate::damage::{Reader, message};

fn read_as(text: &str) -> Result<ResponseRecord, FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blade.csv");
    std::fs::write(&path, text).unwrap();
    read_response(&path)
}

const TABLES: Reader = Reader(|_, bytes| message(read_as(std::str::from_utf8(bytes).unwrap())));

fn record(deviations: bool) -> ResponseRecord {
    let point = |i: u8| ResponsePoint {
        level_n: f64::from(1 + i / 2),
        frequency_hz: 1034.25 - 0.7 * f64::from(i),
        amplitude_m: 12.3e-6 * f64::from(1 + i),
        frequency_deviation_hz: deviations.then_some(0.3),
        amplitude_deviation_m: deviations.then_some(2e-7),
    };
    ResponseRecord {
        name: "blade".to_owned(),
        points: (0..6).map(point).collect(),
        // after a note and the names of the columns
        lines: (3..9).collect(),
    }
}

fn written(record: &ResponseRecord) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blade.csv");
    write_response(&path, record, &["seed 3"]).unwrap();
    std::fs::read_to_string(path).unwrap()
}

/// Seen to fail with amplitudes in mm.
#[test]
fn what_is_written_is_read_back_to_the_bit() {
    for deviations in [false, true] {
        let record = record(deviations);
        let text = written(&record);
        assert_eq!(read_as(&text).unwrap(), record, "{text}");
    }
    let text = "level (kN);frequency (kHz);peak amplitude (mm)\n0,001;1,03425;0,0123\n";
    let found = read_as(text).unwrap();
    assert_eq!(found.points[..], record(false).points[..1]);
}

/// Line 2 names the columns, line 5 is the third point.
const DAMAGES: &str = "
2 | level [N],resonance frequency [Hz]                                   | :2: must have a column amplitude [m]
2 | resonance frequency [Hz],amplitude [um]                              | :2: must have a column level [N]
2 | level [N],amplitude [um]                                             | :2: must have a column resonance frequency [Hz]
2 | level,resonance frequency [Hz],amplitude [um]                        | :2: level: has no unit
2 | level [N],resonance frequency,amplitude [um]                         | :2: resonance frequency: has no unit
2 | level [N],resonance frequency [Hz],amplitude                         | :2: amplitude: has no unit
2 | level [g],resonance frequency [Hz],amplitude [um]                    | :2: level [g]: must be in a unit of force
2 | level [N],resonance frequency [rad/s],amplitude [um]                 | :2: resonance frequency [rad/s]: must be in a unit of frequency
2 | level [N],resonance frequency [Hz],amplitude [m/s]                   | :2: amplitude [m/s]: must be in a unit of length
2 | level [N],resonance frequency [Hz],amplitude [um],Q [-],d [um]       | :2: column Q [-]: the first line without # must name columns among level,
2 | level [N],level [N],resonance frequency [Hz],amplitude [um],_        | :2: column level [N]: must be given once
frequency deviation [Hz] | frequency deviation [um]                      | :2: frequency deviation [um]: must be in a unit of frequency
amplitude deviation [um] | amplitude deviation                           | :2: amplitude deviation: has no unit
5 | 2,1032.85,36.9,0.3                                                   | :5: has 4 fields: must have 5
5 | 2,1032.85,36.9,0.3,0.2,1                                             | :5: has 6 fields: must have 5
5 | ,1032.85,36.9,0.3,0.2                                                | :5: level = (empty): must be a number
5 | 2,,36.9,0.3,0.2                                                      | :5: resonance frequency = (empty)
5 | 2,1032.85,,0.3,0.2                                                   | :5: amplitude = (empty)
5 | 2,1032.85,36.9,,0.2                                                  | :5: frequency deviation = (empty)
5 | 0,1032.85,36.9,0.3,0.2                                               | :5: level = 0 N: must be from 1e-15 to 1e12 N
5 | -2,1032.85,36.9,0.3,0.2                                              | :5: level = -2 N: must be from
5 | 2,0,36.9,0.3,0.2                                                     | :5: resonance frequency = 0 Hz: must be from
5 | 2,1032.85,-36.9,0.3,0.2                                              | :5: amplitude = -36.9 um: must be from
5 | 2,1032.85,36.9,-0.3,0.2                                              | :5: frequency deviation = -0.3 Hz: must be from
5 | 2,1032.85,36.9,0.3,0                                                 | :5: amplitude deviation = 0 um: must be from
5 | 2,1032.85,NaN,0.3,0.2                                                | :5: amplitude = NaN: must be a finite number
5 | 2,inf,36.9,0.3,0.2                                                   | :5: resonance frequency = inf: must be a finite number
5 | 2,1e20,36.9,0.3,0.2                                                  | :5: resonance frequency = 1e20 Hz: must be from
5 | 2,about 1000,36.9,0.3,0.2                                            | :5: resonance frequency = about 1000: must be a number
5 | 2,\"1032,85\",36.9,0.3,0.2                                           | :5: resonance frequency = 1032,85: must be a number without
5 | 2,\"1032.85,36.9,0.3,0.2                                             | :5: a field begins with a quote
5 | 2,1032.85\\0,36.9,0.3,0.2                                            | :5: has a null byte
";

/// Seen to fail with numbers of any size taken.
#[test]
fn damaged_responses_are_refused() {
    let text = written(&record(true));
    let count = TABLES.refuse("blade.csv", &text, DAMAGES);
    assert!(count >= 30, "{count} damages");
    let heading: Vec<&str> = text.lines().take(2).collect();
    let message = read_as(&heading.join("\n")).unwrap_err().to_string();
    assert!(
        message.contains(":2: has 0 rows: must have 1 to 100000"),
        "{message}"
    );
    assert!(
        read_as("").unwrap_err().to_string().contains("is empty"),
        "empty"
    );
}
