//! `rig.toml`: what is tested, with which rig and which instruments.

use std::path::{Path, PathBuf};

use super::air::AirSettings;
use super::blade::BladeSettings;
use super::chain::{CellSettings, VibrometerSettings};
use super::excitation::Excitation;
use super::loading::{Loading, PunchSettings};
use super::settings::{ContactTruth, PressedBy, ResponseSettings, StripSettings};
use super::support::SupportSettings;
use crate::Error;
use crate::setting::BadSetting;
use crate::study::settings::document::Document;
use crate::study::{ModelSettings, Study};
use crate::units::rad_s_to_hz;

/// Tests of all specimens at most: half an hour of a processor.
const MOST_TESTS: u64 = 100_000;
/// Samples of all tests at most, with the run-in: some hours of a processor.
const MOST_SAMPLES: f64 = 1e10;
/// Vibration of a blade in all tests at most (s): a day of a processor.
const MOST_VIBRATION_S: f64 = 1e5;
/// Tests slower than this part of the box's own frequency hardly move it.
const SLOW: f64 = 200.0;
/// Top-level keys.
const KEYS: [&str; 11] = [
    "name",
    "seed",
    "contact",
    "strip",
    "loading",
    "support",
    "excitation",
    "blade",
    "force_cells",
    "vibrometer",
    "response",
];

/// A virtual rig and its tests.
#[derive(Debug, Clone)]
pub struct Rig {
    /// The file.
    pub path: PathBuf,
    /// Name, for reports.
    pub name: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The truth.
    pub contact: ContactTruth,
    /// The strip.
    pub strip: StripSettings,
    /// What presses it.
    pub loading: Loading,
    /// Measuring box and its support.
    pub support: SupportSettings,
    /// Step-sine of the platform, or of the force on the blade.
    pub excitation: Excitation,
    /// What carries the platform; absent, its motion is given.
    pub blade: Option<BladeSettings>,
    /// Force cells.
    pub force_cells: CellSettings,
    /// Vibrometer.
    pub vibrometer: VibrometerSettings,
    /// Configuration b, if wanted.
    pub response: Option<ResponseSettings>,
    /// Its study: read with the rig, so that a wrong one costs no simulation.
    pub study: Option<Study>,
}

impl Rig {
    /// Reads and checks a rig file and the study that it names.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be read, [`Error::Study`] with file, line, key and rule otherwise.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = crate::file::read_text(path)?;
        Self::parse(path, &text)
    }

    /// Checks `text`, the content of `path`, and the study that it names.
    ///
    /// # Errors
    /// [`Error::File`] if the study cannot be read, [`Error::Study`] with file, line, key and rule.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let mut document = Document::parse(path, text)?;
        let mut rig = Self {
            path: path.to_owned(),
            name: document.required("name")?,
            seed: document.take("seed")?.unwrap_or(0),
            contact: document.take("contact")?.unwrap_or_default(),
            strip: document.take("strip")?.unwrap_or_default(),
            loading: loading(&mut document)?,
            support: document.take("support")?.unwrap_or_default(),
            excitation: document.take("excitation")?.unwrap_or_default(),
            blade: document.take("blade")?,
            force_cells: document.take("force_cells")?.unwrap_or_default(),
            vibrometer: document.take("vibrometer")?.unwrap_or_default(),
            response: document.take("response")?,
            study: None,
        };
        document.finish(&KEYS)?;
        document.checked(rig.validate())?;
        rig.study = rig.response_study(&document)?;
        Ok(rig)
    }

    fn validate(&self) -> Result<(), BadSetting> {
        let blank = self.name.trim().is_empty();
        BadSetting::unless(!blank, "name", "\"\"", "must not be empty")?;
        let under = |section: &'static str| move |bad: BadSetting| bad.under(section);
        self.contact.validate().map_err(under("contact"))?;
        self.strip.validate().map_err(under("strip"))?;
        let loading = self.loading.validate(&self.strip);
        loading.map_err(under("loading"))?;
        self.support.validate().map_err(under("support"))?;
        self.excitation.validate().map_err(under("excitation"))?;
        if let Some(blade) = &self.blade {
            blade.validate(&self.strip).map_err(under("blade"))?;
            let checked = blade.check_frequencies(&self.excitation.frequencies_hz);
            checked.map_err(under("excitation"))?;
            let rule = "must not be given with [blade], whose force_n moves the platform";
            let given = self.excitation.amplitude_um;
            let written = given.unwrap_or_default();
            BadSetting::unless(given.is_none(), "excitation.amplitude_um", written, rule)?;
        }
        self.check_work()?;
        self.force_cells.validate().map_err(under("force_cells"))?;
        self.vibrometer.validate().map_err(under("vibrometer"))?;
        match &self.response {
            Some(response) => response.validate().map_err(under("response")),
            None => Ok(()),
        }
    }

    /// Refuses tests that would take days.
    fn check_work(&self) -> Result<(), BadSetting> {
        let specimens = self.contact.specimens;
        let tests = self.number_of_tests();
        let rule = format!("must give at most {MOST_TESTS} tests, not {tests}");
        BadSetting::unless(tests <= MOST_TESTS, "contact.specimens", specimens, &rule)?;
        let excitation = &self.excitation;
        let cycles = excitation.cycles + excitation.run_in_cycles;
        let samples = tests as f64 * cycles as f64 * excitation.samples_per_cycle as f64;
        let rule = format!(
            "gives {samples:.1e} samples in all tests, must give at most {MOST_SAMPLES:.0e}"
        );
        let few = samples <= MOST_SAMPLES;
        BadSetting::unless(few, "excitation.cycles", excitation.cycles, &rule)?;
        let Some(blade) = &self.blade else {
            return Ok(());
        };
        let cycles = (cycles + blade.settling_cycles) as f64;
        let periods: f64 = excitation.frequencies_hz.iter().map(|f| 1.0 / f).sum();
        let vibration_s = (specimens * excitation.repetitions) as f64 * cycles * periods;
        let rule = format!(
            "gives {vibration_s:.1e} s of vibration in all tests, must give at most {MOST_VIBRATION_S:.0e} s"
        );
        let short = vibration_s <= MOST_VIBRATION_S;
        BadSetting::unless(short, "blade.settling_cycles", blade.settling_cycles, &rule)
    }

    /// The study of `[response]`, which must be one of two blades.
    fn response_study(&self, document: &Document<'_>) -> Result<Option<Study>, Error> {
        let Some(settings) = &self.response else {
            return Ok(None);
        };
        let read = Study::read(&self.folder().join(&settings.study));
        let study = read.map_err(|error| match error {
            Error::File(error) => document.bad_file(error),
            other => other,
        })?;
        let ModelSettings::TwoBladeStrip { blades, .. } = &study.model else {
            let rule = "must be \"two-blade-strip\" for a virtual rig";
            let kind = BadSetting::new("model.kind", study.model.kind(), rule);
            return Err(study.bad_setting(&kind));
        };
        if settings.pressed_by == PressedBy::Loading {
            let pressed = self.loading.validate(&StripSettings::of(blades));
            document.checked(pressed.map_err(|bad| bad.under("loading")))?;
        }
        let checked = settings.check_band(rad_s_to_hz(study.frequency.band[0]));
        document.checked(checked.map_err(|bad| bad.under("response")))?;
        Ok(Some(study))
    }

    /// What may be meant but spoils the records: a sampling rate that does not show the vibration of the box after each start of slip.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let (samples, of_box) = (
            self.excitation.samples_per_cycle,
            self.support.own_frequency_hz(),
        );
        let is_folded = |f: &f64| f * (samples as f64) < 2.0 * of_box && f * SLOW > of_box;
        let mut folded = self.excitation.frequencies_hz.iter().copied();
        let warning = folded.find(is_folded).map(|frequency| {
            format!(
                "excitation.samples_per_cycle = {samples}: at {frequency} Hz the sampling rate is below twice the {of_box:.0} Hz of the measuring \
                 box: its vibration looks like a slower one, and what `identify` finds may miss the truth by more than its interval"
            )
        });
        warning.into_iter().collect()
    }

    /// Folder of the file: what its file names are relative to.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }
}

/// Reads `[loading]` by its `kind`.
fn loading(document: &mut Document<'_>) -> Result<Loading, Error> {
    let kind = document.take_string("loading", "kind")?;
    match kind.as_str() {
        "air" => Ok(Loading::Air(document.required::<AirSettings>("loading")?)),
        "punch" => Ok(Loading::Punch(
            document.required::<PunchSettings>("loading")?,
        )),
        _ => {
            let rule = "must be \"air\" or \"punch\"";
            Err(document.bad_setting(&BadSetting::new("loading.kind", kind, rule)))
        }
    }
}
