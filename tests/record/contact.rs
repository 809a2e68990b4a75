//! The test of all files: a contact that sticks and slips, sampled as a rig does.

use std::path::PathBuf;

use crate::damage::{Reader, message};
use microslip::file::FileError;
use microslip::record::{HysteresisRecord, TestConditions, quantised, read_hysteresis};

/// Frequency of the motion (Hz).
pub(crate) const FREQUENCY_HZ: f64 = 100.0;
/// Samples of a period.
const PER_PERIOD: usize = 64;
/// Samples of the test.
pub(crate) const SAMPLES: usize = 2 * PER_PERIOD;
/// Amplitude of the motion (m).
const AMPLITUDE: f64 = 5e-6;
/// Tangential stiffness (N/m).
const STIFFNESS: f64 = 30e6;
/// Friction coefficient times normal force (N).
const LIMIT: f64 = 50.0;

/// A spring and a slider in series that start at rest, under a normal force of 100 N with a ripple of 1 N.
pub(crate) fn contact(name: &str) -> HysteresisRecord {
    let time: Vec<f64> = (0..SAMPLES).map(|i| i as f64 / 6400.0).collect();
    let phase = |t: f64| std::f64::consts::TAU * FREQUENCY_HZ * t;
    let displacement = time.iter().map(|t| AMPLITUDE * phase(*t).sin());
    let displacement: Vec<f64> = displacement.map(|x| quantised(x, 1e-9)).collect();
    let mut slider = 0.0;
    let tangential_force = displacement.iter().map(|x| {
        let force = (STIFFNESS * (x - slider)).clamp(-LIMIT, LIMIT);
        slider = x - force / STIFFNESS;
        quantised(force, 0.01)
    });
    let tangential_force = tangential_force.collect();
    let normal_force = time.iter().map(|t| 100.0 + phase(*t).cos());
    HysteresisRecord {
        name: name.to_owned(),
        normal_force: normal_force.map(|n| quantised(n, 0.01)).collect(),
        time,
        displacement,
        tangential_force,
        approach: None,
        conditions: TestConditions::default(),
    }
}

/// The same with a normal displacement and conditions.
pub(crate) fn whole_contact(name: &str) -> HysteresisRecord {
    let mut test = contact(name);
    let approach = test.normal_force.iter().map(|n| quantised(n / 50e6, 1e-9));
    test.approach = Some(approach.collect());
    test.conditions = TestConditions {
        frequency_hz: Some(FREQUENCY_HZ),
        specimen: Some("A".to_owned()),
        ..TestConditions::default()
    };
    test
}

/// Reads records, for damaged files.
pub(crate) const RECORDS: Reader = Reader(|name, bytes| message(read_as(name, bytes)));

/// What is read from a file with these bytes.
pub(crate) fn read_as(name: &str, bytes: &[u8]) -> Result<Vec<HysteresisRecord>, FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let tests = read_hysteresis(&[path])?;
    Ok(tests.into_iter().map(|test| test.record).collect())
}
