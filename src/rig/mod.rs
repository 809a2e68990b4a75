//! A virtual test rig: hysteresis tests of one blade and a strip, and resonances of two blades, with the errors of the
//! measuring chain and with the truth beside them.
//!
//! The rig is that of Gastaldi, Berruti & Gola 2018, Exp. Tech., doi 10.1007/s40799-018-0248-z: configuration a has one blade
//! and a strip whose far end is held by a measuring box, configuration b two blades. Physics and measuring chain are apart:
//! `loading` gives the pressure, `blade` what carries the platform, `motion` what the
//! contact does, `chain` what the instruments say of it. All random numbers
//! are functions of the seed, the test and what they are for (`noise`): the same file gives the same tests.
//!
//! ```
//! use microslip::identify::{IdentifySettings, identify_test};
//! use microslip::rig::Rig;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//!
//! let text = r#"
//! name = "one test under air"
//! seed = 1
//! [contact]
//! friction_coefficient = 0.6
//! tangential_stiffness_n_per_um = 233
//! [loading]
//! kind = "air"
//! [excitation]
//! amplitude_um = 5
//! cycles = 20
//! frequencies_hz = [100]
//! "#;
//! let rig = Rig::parse("rig.toml".as_ref(), text)?;
//! let stand = rig.stand()?;
//! let test = rig.test(&stand, 0);
//! let found = identify_test(&test.record, &IdentifySettings::default());
//! let friction = found.estimate.and_then(|estimate| estimate.friction).ok_or("no slip")?;
//! // both cells keep 1 % in 95 % of the tests
//! let truth = test.truth.friction_coefficient;
//! assert!((friction.coefficient.value / truth - 1.0).abs() < 0.03);
//! # Ok(())
//! # }
//! ```

pub mod air;
pub mod blade;
mod blade_march;
pub mod chain;
pub mod excitation;
pub mod loading;
pub mod motion;
pub mod noise;
mod platform;
pub mod read;
pub mod response;
pub mod settings;
pub mod stand;
pub mod step_sine;
pub mod support;
pub mod virtual_test;
pub mod write;

pub use read::Rig;
pub use response::MeasuredResonance;
pub use stand::Stand;
pub use virtual_test::{PlatformMotion, Slip, Specimen, VirtualTest};
pub use write::{RigSummary, write_tests};
