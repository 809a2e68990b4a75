//! One test of configuration a: the record that a laboratory would have, and the truth.

use super::chain::{Chain, Instruments};
use super::loading::LoadMap;
use super::motion::{Interface, March, Motion};
use super::noise::{Noise, Purpose};
use super::read::Rig;
use super::stand::Stand;
use crate::model::ModelError;
use crate::record::{HysteresisRecord, TestConditions};
use crate::units::{hz_to_rad_s, m_to_um, n_per_um_to_n_per_m};

/// Traction over its limit from which a direction counts as in gross slip.
const GROSS: f64 = 1.0 - 1e-9;

/// True contact of a specimen.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Specimen {
    /// Friction coefficient.
    pub friction_coefficient: f64,
    /// Tangential stiffness of the interface (N/µm).
    pub tangential_stiffness_n_per_um: f64,
    /// Normal stiffness of the interface (N/µm). The air or the weights decide the load: it moves nothing in configuration a.
    pub normal_stiffness_n_per_um: f64,
}

/// How far the contact slipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Slip {
    /// All pairs slipped, in both directions: the traction reached μN.
    Gross,
    /// Some pairs stuck throughout, or in one direction.
    Partial,
}

/// First harmonic of the platform of a blade.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PlatformMotion {
    /// Amplitude (µm).
    pub amplitude_um: f64,
    /// Phase after the force (degrees), from 0 to below 360: 90 at a resonance that little else moves.
    pub lag_deg: f64,
}

impl PlatformMotion {
    /// Of the samples of a record of whole cycles, whose force is a sine from its start.
    fn new(motion: &Motion, frequency_hz: f64) -> Self {
        let samples = motion.time.iter().zip(&motion.platform);
        let [sine, cosine] = samples.fold([0.0; 2], |[sine, cosine], (t, p)| {
            let phase = hz_to_rad_s(frequency_hz) * t;
            [sine + p * libm::sin(phase), cosine + p * libm::cos(phase)]
        });
        let amplitude = 2.0 * sine.hypot(cosine) / motion.time.len() as f64;
        Self {
            amplitude_um: m_to_um(amplitude),
            lag_deg: libm::atan2(-cosine, sine).to_degrees().rem_euclid(360.0),
        }
    }
}

/// A test and what is true of it.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualTest {
    /// What was measured.
    pub record: HysteresisRecord,
    /// True signals.
    pub motion: Motion,
    /// Index of the specimen, 0-based.
    pub specimen: u64,
    /// Its contact.
    pub truth: Specimen,
    /// What the test drew once.
    pub instruments: Instruments,
    /// Whether slip was reached.
    pub slip: Slip,
    /// Motion of the platform, where a blade carries it.
    pub platform: Option<PlatformMotion>,
    /// Samples at which an instrument was at the end of its range.
    pub out_of_range: usize,
}

impl Rig {
    /// Tests of configuration a: specimens × frequencies × repetitions.
    #[must_use]
    pub fn number_of_tests(&self) -> u64 {
        self.contact.specimens * self.tests_of_specimen()
    }

    /// Load on every contact pair.
    ///
    /// # Errors
    /// [`ModelError`] if the contact grid cannot be made.
    pub fn load_map(&self) -> Result<LoadMap, ModelError> {
        self.loading.map(&self.strip)
    }

    fn tests_of_specimen(&self) -> u64 {
        self.excitation.repetitions * self.excitation.frequencies_hz.len() as u64
    }

    /// The true contact of a specimen, 0-based.
    #[must_use]
    pub fn specimen(&self, index: u64) -> Specimen {
        let mut noise = Noise::new(self.seed, Purpose::Specimen, index);
        let mut factor = |percent: f64| libm::exp(1e-2 * percent * noise.normal());
        let contact = &self.contact;
        let friction = factor(contact.friction_scatter_percent);
        let stiffness = factor(contact.stiffness_scatter_percent);
        Specimen {
            friction_coefficient: friction * contact.friction_coefficient,
            tangential_stiffness_n_per_um: stiffness * contact.tangential_stiffness_n_per_um,
            normal_stiffness_n_per_um: stiffness * contact.normal_stiffness_n_per_um,
        }
    }

    /// The test `index`, 0-based: the frequencies run fastest, then the repetitions, then the specimens.
    ///
    /// `stand` is [`Rig::stand`], the same for all tests.
    #[must_use]
    pub fn test(&self, stand: &Stand, index: u64) -> VirtualTest {
        let specimen = index / self.tests_of_specimen();
        let frequencies = &self.excitation.frequencies_hz;
        let frequency_hz = frequencies[index as usize % frequencies.len()];
        let truth = self.specimen(specimen);
        let stream = |purpose| Noise::new(self.seed, purpose, index);
        let march = March {
            structure: &stand.structure,
            excitation: &self.excitation,
            blade: stand.blade.as_ref(),
            fluctuation: self.loading.fluctuation(),
            load: stand.map.loads.iter().sum(),
        };
        let k_t = n_per_um_to_n_per_m(truth.tangential_stiffness_n_per_um);
        let interface = Interface::new(&stand.map, k_t, truth.friction_coefficient);
        let motion = march.run(interface, frequency_hz, &mut stream(Purpose::Regulator));
        let chain = Chain {
            support: &self.support,
            cells: &self.force_cells,
            vibrometer: &self.vibrometer,
        };
        let instruments = chain.instruments(self.seed, index);
        let measured = chain.measured(&motion, &instruments, &mut stream(Purpose::Signals));
        let gross = motion.mobilised.iter().all(|share| *share >= GROSS);
        VirtualTest {
            record: HysteresisRecord {
                name: format!("test-{:04}", index + 1),
                time: motion.time.clone(),
                displacement: measured.displacement,
                tangential_force: measured.tangential,
                normal_force: measured.normal,
                approach: None,
                conditions: TestConditions {
                    frequency_hz: Some(frequency_hz),
                    specimen: Some(format!("specimen-{}", specimen + 1)),
                    even_area: Some(stand.map.even_area()),
                },
            },
            platform: (stand.blade.as_ref()).map(|_| PlatformMotion::new(&motion, frequency_hz)),
            slip: if gross { Slip::Gross } else { Slip::Partial },
            motion,
            specimen,
            truth,
            instruments,
            out_of_range: measured.out_of_range,
        }
    }
}
