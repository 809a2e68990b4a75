//! The measuring chain: what force cells and vibrometer say of the motion.

use super::motion::Motion;
use super::noise::{Noise, Purpose};
use super::support::SupportSettings;
use crate::record::quantised;
use crate::setting::{BadSetting, positive, within};
use crate::units::um_to_m;

/// Numbers of an instrument that can be meant, in the units of their keys.
const ANY: [f64; 2] = [0.0, 1e6];
/// Standard deviations of a normal law from its mean to a limit that 95 % keep.
pub(super) const DEVIATIONS_OF_LIMIT: f64 = 1.959_964;

/// When the gains of the force cells are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Calibration {
    /// Anew for each test, as where the cells are calibrated before each: tests together average it out.
    PerTest,
    /// Once for all tests of a rig: their errors are the same.
    PerRig,
}

/// Both force cells.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CellSettings {
    /// Largest force (N): a cell shows no more.
    pub range_n: f64,
    /// Error of a cell's gain (%), which 95 % of the gains keep; drawn for each cell.
    pub error_percent: f64,
    /// When the gains are drawn.
    pub calibration: Calibration,
    /// Standard deviation of the noise of a sample (N).
    pub noise_n: f64,
    /// Standard deviation of the drift (N/s), constant through a test.
    pub drift_n_per_s: f64,
}

impl Default for CellSettings {
    fn default() -> Self {
        Self {
            range_n: 200.0,
            error_percent: 1.0,
            calibration: Calibration::PerTest,
            noise_n: 0.05,
            drift_n_per_s: 0.02,
        }
    }
}

/// The differential vibrometer.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VibrometerSettings {
    /// Resolution (µm): the step of its values.
    pub resolution_um: f64,
    /// Sensitivity (µm/V).
    pub sensitivity_um_per_v: f64,
    /// Largest voltage (V).
    pub range_v: f64,
    /// Standard deviation of the noise of a sample, before the steps (µm).
    pub noise_um: f64,
    /// Standard deviation of the drift (µm/s), constant through a test.
    pub drift_um_per_s: f64,
}

impl Default for VibrometerSettings {
    fn default() -> Self {
        Self {
            resolution_um: 0.08,
            sensitivity_um_per_v: 20.0,
            range_v: 10.0,
            // half a step: the resolution of a vibrometer is that of its noise
            noise_um: 0.04,
            drift_um_per_s: 0.1,
        }
    }
}

impl CellSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[force_cells]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        positive("range_n", self.range_n)?;
        within("range_n", self.range_n, ANY)?;
        within("error_percent", self.error_percent, [0.0, 20.0])?;
        within("noise_n", self.noise_n, ANY)?;
        within("drift_n_per_s", self.drift_n_per_s, ANY)
    }
}

impl VibrometerSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[vibrometer]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        positive("sensitivity_um_per_v", self.sensitivity_um_per_v)?;
        positive("range_v", self.range_v)?;
        for (key, value) in [
            ("resolution_um", self.resolution_um),
            ("sensitivity_um_per_v", self.sensitivity_um_per_v),
            ("range_v", self.range_v),
            ("noise_um", self.noise_um),
            ("drift_um_per_s", self.drift_um_per_s),
        ] {
            within(key, value, ANY)?;
        }
        Ok(())
    }
}

/// What a test draws once.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Instruments {
    /// Gains of the cells for T and N.
    pub gains: [f64; 2],
    /// Offset of the force's line (mm).
    pub offset_mm: f64,
    /// Drifts of the cells (N/s).
    pub drift_n_per_s: [f64; 2],
    /// Drift of the vibrometer (µm/s).
    pub drift_um_per_s: f64,
}

/// Signals as the instruments give them. Shape of each: `[samples]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Relative displacement (m).
    pub displacement: Vec<f64>,
    /// T (N).
    pub tangential: Vec<f64>,
    /// N (N).
    pub normal: Vec<f64>,
    /// Samples at which an instrument was at the end of its range.
    pub out_of_range: usize,
}

/// The whole chain.
#[derive(Debug, Clone, Copy)]
pub struct Chain<'a> {
    /// Support of the cells.
    pub support: &'a SupportSettings,
    /// Force cells.
    pub cells: &'a CellSettings,
    /// Vibrometer.
    pub vibrometer: &'a VibrometerSettings,
}

impl Chain<'_> {
    /// The instruments of the test with this index.
    #[must_use]
    pub fn instruments(&self, seed: u64, test: u64) -> Instruments {
        let calibrated = match self.cells.calibration {
            Calibration::PerTest => test,
            Calibration::PerRig => 0,
        };
        let mut gains = Noise::new(seed, Purpose::Gains, calibrated);
        let deviation = 1e-2 * self.cells.error_percent / DEVIATIONS_OF_LIMIT;
        let gains = [0, 1].map(|_| 1.0 + deviation * gains.normal());
        let mut noise = Noise::new(seed, Purpose::Instruments, test);
        let drift_n_per_s = [0, 1].map(|_| self.cells.drift_n_per_s * noise.normal());
        let drift_um_per_s = self.vibrometer.drift_um_per_s * noise.normal();
        let offset_mm = loop {
            let offset = self.support.offset_mm * noise.normal();
            if offset.abs() <= self.support.largest_offset_mm {
                break offset;
            }
        };
        Instruments {
            gains,
            offset_mm,
            drift_n_per_s,
            drift_um_per_s,
        }
    }

    /// What the instruments say of a motion.
    #[must_use]
    pub fn measured(
        &self,
        motion: &Motion,
        instruments: &Instruments,
        noise: &mut Noise,
    ) -> Measured {
        let n = motion.time.len();
        let mut measured = Measured {
            displacement: Vec::with_capacity(n),
            tangential: Vec::with_capacity(n),
            normal: Vec::with_capacity(n),
            out_of_range: 0,
        };
        let most_seen = um_to_m(self.vibrometer.range_v * self.vibrometer.sensitivity_um_per_v);
        for (i, &t) in motion.time.iter().enumerate() {
            let read = self
                .support
                .decoupled(motion.felt[i], instruments.offset_mm);
            let forces = [0, 1].map(|cell| {
                let drifted =
                    instruments.gains[cell] * read[cell] + instruments.drift_n_per_s[cell] * t;
                drifted + self.cells.noise_n * noise.normal()
            });
            let added_um =
                instruments.drift_um_per_s * t + self.vibrometer.noise_um * noise.normal();
            let seen = motion.displacement[i] + um_to_m(added_um);
            let seen = quantised(seen, um_to_m(self.vibrometer.resolution_um));
            let most = self.cells.range_n;
            let out = forces.iter().any(|f| f.abs() > most) || seen.abs() > most_seen;
            measured.out_of_range += usize::from(out);
            let [tangential, normal] = forces.map(|force| force.clamp(-most, most));
            measured.tangential.push(tangential);
            measured.normal.push(normal);
            measured
                .displacement
                .push(seen.clamp(-most_seen, most_seen));
        }
        measured
    }
}
