//! A virtual test rig: hysteresis tests of one blade and a strip, and resonances of two blades, with the errors of the
//! measuring chain and with the truth beside them.
//!
//! The rig is that of Gastaldi, Berruti & Gola 2018, Exp. Tech., doi 10.1007/s40799-018-0248-z: configuration a has one blade
//! and a strip whose far end is held by a measuring box, configuration b two blades. Physics and measuring chain are apart:
//! `loading` gives the pressure, `blade` what carries the platform, `motion` what the
//! contact does, `chain` what the instruments say of it. All random numbers
//! are functions of the seed, the test and what they are for (`noise`): the same file gives the same tests.

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
