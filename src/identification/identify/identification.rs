//! From records to the distribution of the contact parameters.

use super::found::identified::{FORMAT, GivenPressure, Identified};
use super::found::result::{TestResult, TestStatus};
use super::one_loop::slip_limits::KnownPressure;
use super::one_test::test_estimate::{identify_pressed_test, identify_test};
use super::pooling::joint::joint;
use super::pooling::pooled::pool;
use super::settings::IdentifySettings;
use crate::file::{FileError, FileRecord};
use crate::record::{HysteresisRecord, TestInFile, read_hysteresis, read_pressure_map};
use crate::setting::BadSetting;
use rayon::prelude::*;
use std::path::PathBuf;

/// Why nothing is identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A setting breaks a rule.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// No test can be used; each with its reason.
    #[error("no test can be used: {0}")]
    NoTest(String),
    /// The page template is broken.
    #[error("page of the identification: {0}")]
    Page(#[from] minijinja::Error),
}

/// [`identify`] of the tests in files, which the result names with their hashes. `pressure_map` is that of the contact in all of them.
///
/// # Errors
/// [`IdentifyError`] if a setting breaks a rule, a file cannot be read, or no test can be used.
pub fn identify_files(
    paths: &[PathBuf],
    pressure_map: Option<&PathBuf>,
    settings: &IdentifySettings,
) -> Result<Identified, IdentifyError> {
    settings.validate()?;
    let record = |path: &PathBuf| FileRecord::of_file(path);
    let given = pressure_map.map(|path| -> Result<_, FileError> {
        Ok((KnownPressure::new(&read_pressure_map(path)?), record(path)?))
    });
    let (pressure, map_file) = given.transpose()?.unzip();
    let tests = read_hysteresis(paths)?;
    let files = paths.iter().map(record).chain(map_file.clone().map(Ok));
    let files = files.collect::<Result<_, _>>()?;
    let place = |test: &TestInFile| {
        let line = test
            .line
            .map_or_else(String::new, |line| format!(":{line}"));
        format!("{}{line}: {}", test.path.display(), test.record.name)
    };
    let (records, places): (Vec<_>, Vec<_>) = (tests.into_iter())
        .map(|test| {
            let place = place(&test);
            (test.record, place)
        })
        .unzip();
    let identified = identify_at(&records, &places, settings, pressure.as_ref())?;
    let pressure_map = pressure
        .zip(map_file)
        .map(|(pressure, file)| GivenPressure {
            file,
            cells: pressure.cells(),
            even_area: pressure.even_area(),
        });
    Ok(Identified {
        files,
        pressure_map,
        ..identified
    })
}

/// Contact parameters from hysteresis tests: each test apart, all together, and the distribution of a further contact. The files are
/// the caller's. The result does not depend on the number of threads.
///
/// # Errors
/// [`IdentifyError`] if a setting breaks a rule or no test can be used.
pub fn identify(
    records: &[HysteresisRecord],
    settings: &IdentifySettings,
) -> Result<Identified, IdentifyError> {
    let names: Vec<String> = records.iter().map(|record| record.name.clone()).collect();
    identify_at(records, &names, settings, None)
}

/// [`identify`] of tests, which the error names by their `places`.
fn identify_at(
    records: &[HysteresisRecord],
    places: &[String],
    settings: &IdentifySettings,
    pressure: Option<&KnownPressure>,
) -> Result<Identified, IdentifyError> {
    settings.validate()?;
    let test = |record| match pressure {
        None => identify_test(record, settings),
        Some(pressure) => identify_pressed_test(record, settings, pressure),
    };
    let tests: Vec<TestResult> = records.par_iter().map(test).collect();
    let reasons = tests
        .iter()
        .zip(places)
        .filter_map(|(test, place)| match &test.status {
            TestStatus::Unusable(reason) => Some((place, reason)),
            _ => None,
        });
    let reasons: Vec<(&String, &String)> = reasons.collect();
    if reasons.len() == tests.len() {
        let each = reasons
            .iter()
            .map(|(place, reason)| format!("{place} {reason}"));
        return Err(IdentifyError::NoTest(each.collect::<Vec<_>>().join("; ")));
    }
    let pooled = pool(&tests, settings);
    let joint = joint(&pooled, settings)?;
    let unused = (reasons.iter()).map(|(place, reason)| format!("not used: {place} {reason}"));
    Ok(Identified {
        format: FORMAT,
        inputs: joint.inputs,
        correlation: joint.correlation,
        notes: unused.chain(joint.notes).collect(),
        settings: Some(*settings),
        pressure_map: None,
        pooled: Some(pooled),
        tests,
        files: Vec::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Uncertain;
    use crate::record::{PressureCell, PressureMap};
    use crate::sampling::stream::uniform;
    use crate::special::normal_quantile;
    use std::f64::consts::TAU;

    /// Tangential stiffness (N/m), friction coefficient and normal force (N).
    const STIFFNESS: f64 = 50e6;
    const FRICTION: f64 = 0.6;
    const NORMAL: f64 = 100.0;

    /// Half of the area at the mean, the rest from a fifth of it to nearly twice the mean: no knee of the family.
    fn map() -> PressureMap {
        let cell = |fifths: u8| PressureCell {
            pressure_pa: 2e5 * f64::from(fifths),
            area_m2: if fifths == 5 { 8e-6 } else { 1e-6 },
        };
        PressureMap {
            cells: (1..10).map(cell).collect(),
        }
    }

    /// Elastic-Coulomb elements side by side, one for each cell, under a harmonic motion; noise in the displacement.
    fn record(map: &PressureMap, seed: u64) -> HysteresisRecord {
        let area: f64 = map.cells.iter().map(|cell| cell.area_m2).sum();
        let force = |cell: &PressureCell| cell.pressure_pa * cell.area_m2;
        let whole: f64 = map.cells.iter().map(force).sum();
        let mut forces = vec![0.0_f64; map.cells.len()];
        let mut before = 0.0;
        let mut record = HysteresisRecord::empty(format!("elements {seed}"));
        for i in 0..8240_u32 {
            let cycle = f64::from(i) / 400.0;
            let motion = 8e-6 * (TAU * (cycle + 0.1)).sin();
            for (cell, element) in map.cells.iter().zip(&mut forces) {
                let limit = FRICTION * NORMAL * force(cell) / whole;
                let stiffness = STIFFNESS * cell.area_m2 / area;
                *element = (*element + stiffness * (motion - before)).clamp(-limit, limit);
            }
            before = motion;
            let noise = 1e-7 * normal_quantile(uniform(seed, u64::from(i), 0));
            record.time.push(cycle / 100.0);
            record.displacement.push(motion + noise);
            record.tangential_force.push(forces.iter().sum());
            record.normal_force.push(NORMAL);
        }
        record
    }

    fn stiffness(test: &TestResult) -> Uncertain {
        let estimate = test.estimate.as_ref().unwrap();
        estimate.tangential.stiffness_n_per_um
    }

    /// Seen to fail with the share of the map about the mean in place of its limits.
    #[test]
    fn a_pressure_map_tells_the_stiffness_more_closely() {
        let settings = IdentifySettings::default();
        let known = KnownPressure::new(&map());
        let truth = 1e-6 * STIFFNESS;
        let tests = (0..20).map(|seed| {
            let record = record(&map(), seed);
            [
                stiffness(&identify_test(&record, &settings)),
                stiffness(&identify_pressed_test(&record, &settings, &known)),
            ]
        });
        let tests: Vec<[Uncertain; 2]> = tests.collect();
        println!("{tests:#?}");
        let sum = |of: &dyn Fn(&Uncertain) -> f64| {
            [0, 1].map(|way| tests.iter().map(|test| of(&test[way])).sum::<f64>())
        };
        let widths = sum(&|k_t| k_t.upper - k_t.lower);
        let squares = sum(&|k_t| (k_t.value / truth - 1.0).powi(2));
        let held = sum(&|k_t| f64::from(u8::from(k_t.lower <= truth && truth <= k_t.upper)));
        println!("{widths:?} {squares:?} {held:?}");
        assert!(widths[1] < 0.8 * widths[0], "{widths:?}");
        assert!(squares[1] < 0.5 * squares[0], "{squares:?}");
        assert!(held[1] >= 17.0, "{held:?} of 20 hold the truth");
    }

    /// Seen to fail with no difference told below half of the area.
    #[test]
    fn another_stated_share_is_told_and_the_map_is_used() {
        let settings = IdentifySettings::default();
        let known = KnownPressure::new(&map());
        assert!((known.even_area() - 0.5).abs() < 1e-12, "{known:?}");
        let mut record = record(&map(), 1);
        let silent = identify_pressed_test(&record, &settings, &known);
        record.conditions.even_area = Some(0.54);
        let near = identify_pressed_test(&record, &settings, &known);
        record.conditions.even_area = Some(0.79);
        let far = identify_pressed_test(&record, &settings, &known);
        assert_eq!(near.notes, silent.notes);
        assert_eq!(stiffness(&far), stiffness(&silent));
        let note = far.notes.last().unwrap();
        let told = "79 % of the area are stated to be within a tenth of the mean pressure, the pressure map has 50 %";
        assert!(note.starts_with(told), "{note}");
    }
}
