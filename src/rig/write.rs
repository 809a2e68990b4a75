//! The files of a rig: one record per test, the pressure map, resonances, and the truth.
//!
//! `test-0001.csv`, … and `pressure-map.csv`: what a laboratory has. `response-0001.csv`, …: resonances of each specimen in configuration b, and
//! `steps-0001.csv`, …: the steps that they were measured by. `truth.json`: what a laboratory does not know.

use std::io::Write;
use std::path::Path;

use super::chain::Instruments;
use super::loading::PressureFacts;
use super::read::Rig;
use super::response::MeasuredResonance;
use super::stand::BladeFrequencies;
use super::virtual_test::{PlatformMotion, Slip, Specimen, VirtualTest};
use crate::Error;
use crate::file::{replace, write_folder};
use crate::record::{
    ResponsePoint, ResponseRecord, write_hysteresis, write_pressure_map, write_response,
};
use crate::units::{m_to_um, um_to_m};
use rayon::prelude::*;

/// Version of `truth.json`.
const FORMAT: u32 = 1;

/// The pressure map: one, since all tests have one loading.
const PRESSURE_MAP: &str = "pressure-map.csv";

/// What was written, and what is true: `truth.json`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RigSummary {
    /// Version of the format.
    pub format: u32,
    /// Name of the rig.
    pub name: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Normal load of the interface (N).
    pub load_n: f64,
    /// Pressure map.
    pub pressure: PressureFacts,
    /// Share of the area of the contact pairs within a tenth of their mean pressure, as the tests state it.
    pub even_area: f64,
    /// Natural frequencies of the blade, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blade: Option<BladeFrequencies>,
    /// Specimens, in their order.
    pub specimens: Vec<Specimen>,
    /// Tests of configuration a.
    pub tests: Vec<TestTruth>,
    /// Resonances of configuration b.
    pub resonances: Vec<MeasuredResonance>,
}

/// What is true of a test.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TestTruth {
    /// File of the record.
    pub file: String,
    /// Index of its specimen, 0-based.
    pub specimen: u64,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Whether slip was reached.
    pub slip: Slip,
    /// Largest |T| over the Coulomb limit of the interface, in both directions.
    pub mobilised: [f64; 2],
    /// Motion of the platform, where a blade carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub platform: Option<PlatformMotion>,
    /// Gains, offset and drifts of the instruments.
    pub instruments: Instruments,
    /// Samples at which an instrument was at the end of its range.
    pub out_of_range: usize,
}

impl TestTruth {
    fn new(test: &VirtualTest) -> Self {
        Self {
            file: format!("{}.csv", test.record.name),
            specimen: test.specimen,
            frequency_hz: test.record.conditions.frequency_hz.unwrap_or_default(),
            slip: test.slip,
            mobilised: test.motion.mobilised,
            platform: test.platform,
            instruments: test.instruments,
            out_of_range: test.out_of_range,
        }
    }
}

/// Makes all tests and writes them into `output`, which must not exist or be empty. `done` is called after each test.
///
/// # Errors
/// [`Error::File`] if the folder has content or cannot be written; what the study of `[response]` or a model refuses.
pub fn write_tests(rig: &Rig, output: &Path, done: impl Fn() + Sync) -> Result<RigSummary, Error> {
    let stand = rig.stand()?;
    let map = &stand.map;
    let mut summary = RigSummary {
        format: FORMAT,
        name: rig.name.clone(),
        seed: rig.seed,
        load_n: map.loads.iter().sum(),
        pressure: map.pressure,
        even_area: map.even_area(),
        blade: rig.blade_frequencies(&stand),
        specimens: (0..rig.contact.specimens)
            .map(|i| rig.specimen(i))
            .collect(),
        tests: Vec::new(),
        resonances: Vec::new(),
    };
    write_folder(output, |folder| -> Result<(), Error> {
        let note = format!("virtual rig \"{}\", seed {}", rig.name, rig.seed);
        let written = |index| -> Result<TestTruth, Error> {
            let test = rig.test(&stand, index);
            let truth = TestTruth::new(&test);
            let path = folder.join(&truth.file);
            write_hysteresis(&path, std::slice::from_ref(&test.record), &[note.as_str()])?;
            done();
            Ok(truth)
        };
        // first: what the model of the study refuses costs no simulation
        summary.resonances = rig.resonances()?;
        let path = folder.join(PRESSURE_MAP);
        write_pressure_map(&path, &map.pressure_map(), &[note.as_str()])?;
        let tests = (0..rig.number_of_tests()).into_par_iter().map(written);
        summary.tests = tests.collect::<Result<_, _>>()?;
        for specimen in summary.resonances.chunk_by(|a, b| a.specimen == b.specimen) {
            write_specimen(folder, specimen, &note)?;
        }
        replace(&folder.join("truth.json"), |file| {
            serde_json::to_writer_pretty(&mut *file, &summary)?;
            writeln!(file)
        })?;
        Ok(())
    })?;
    Ok(summary)
}

/// The steps that the resonances of one specimen were measured by, if there are such: no reader of the program takes them, a laboratory has them.
fn write_steps(path: &Path, resonances: &[MeasuredResonance], note: &str) -> Result<(), Error> {
    if resonances
        .iter()
        .all(|resonance| resonance.steps.is_empty())
    {
        return Ok(());
    }
    replace(path, |file| {
        writeln!(file, "# {note}\nlevel [N],frequency [Hz],amplitude [um]")?;
        for resonance in resonances {
            for step in &resonance.steps {
                let amplitude = m_to_um(step.amplitude_m);
                writeln!(
                    file,
                    "{},{},{amplitude}",
                    resonance.level, step.frequency_hz
                )?;
            }
        }
        Ok(())
    })?;
    Ok(())
}

/// Resonances of one specimen; a level without a peak becomes a comment.
fn write_specimen(
    folder: &Path,
    resonances: &[MeasuredResonance],
    note: &str,
) -> Result<(), Error> {
    let Some(first) = resonances.first() else {
        return Ok(());
    };
    let name = format!("response-{:04}", first.specimen + 1);
    write_steps(
        &folder.join(format!("steps-{:04}.csv", first.specimen + 1)),
        resonances,
        note,
    )?;
    // nothing is stated of a number that is exact: readers take deviations above 0 alone
    let stated = |deviation: f64| (deviation > 0.0).then_some(deviation);
    let point = |resonance: &MeasuredResonance| {
        let peak = resonance.peak?;
        Some(ResponsePoint {
            level_n: resonance.level,
            frequency_hz: peak.frequency_hz,
            amplitude_m: um_to_m(peak.amplitude_um),
            frequency_deviation_hz: stated(peak.frequency_deviation_hz),
            amplitude_deviation_m: stated(um_to_m(peak.amplitude_deviation_um)),
        })
    };
    let points: Vec<_> = resonances.iter().filter_map(point).collect();
    if points.is_empty() {
        return Ok(());
    }
    let missing = resonances.iter().filter(|r| r.peak.is_none());
    let missing = missing.map(|r| format!("level {} N: no peak, {}", r.level, r.status));
    let notes: Vec<String> = [note.to_owned()].into_iter().chain(missing).collect();
    let notes: Vec<&str> = notes.iter().map(String::as_str).collect();
    let path = folder.join(format!("{name}.csv"));
    let record = ResponseRecord {
        name,
        points,
        lines: Vec::new(),
    };
    write_response(&path, &record, &notes)?;
    Ok(())
}
