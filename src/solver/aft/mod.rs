//! Alternating frequency–time evaluation of contact forces on a batch of harmonic states.
//!
//! One contact, t1 = 1 µm · cos θ, with a spring of 10 N/µm and a Coulomb limit of 5 N: the first harmonic of its traction is less
//! than that of the spring, and has a part in phase with the velocity.
//!
//! ```
//! # use microslip_solver as microslip;
//! use microslip::aft::{AftBatch, AftForces, AftPlan, AftScratch, AftSettings, Laps, Want, evaluate};
//! use microslip::contact::{ContactParameters, Events, FrictionLaw};
//! use microslip::harmonics::HarmonicSet;
//!
//! let settings = AftSettings {
//!     n_time: 64,
//!     law: FrictionLaw::Box,
//!     events: Events::Located,
//!     laps: Laps::Periodic,
//! };
//! let harmonics = HarmonicSet::up_to(1); // coefficients: mean, cos, sin
//! let contact = ContactParameters {
//!     k_n: 0.0,
//!     k_t: [10e6, 0.0],
//!     mu: 0.5,
//!     n_0: 10.0,
//!     anchor: [0.0; 2],
//! };
//! let batch = AftBatch {
//!     n_states: 1,
//!     displacement: vec![0.0, 1e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], // t1, t2, n
//!     parameters: vec![contact],
//! };
//! let mut forces: AftForces<f64> = AftForces::default();
//! let plan = AftPlan::new(&harmonics, settings);
//! evaluate(&plan, &batch, Want::Forces, &mut AftScratch::default(), &mut forces);
//! let [cosine, sine] = [forces.forces[1], forces.forces[2]];
//! assert!((cosine - 5.0).abs() < 1e-9); // N
//! // work per cycle −π u T_s = 4 L (u − L/k_t): the area of the hysteresis
//! assert!((-std::f64::consts::PI * 1e-6 * sine - 1e-5).abs() < 1e-14); // J
//! ```

mod batch;
mod box_law;
mod circle_law;
mod evaluate;
mod forces;
mod lanes;
mod plan;
pub mod settings;
mod signals;
mod vector;

pub use batch::{AftBatch, Want};
pub use evaluate::{AftReal, AftScratch, evaluate};
pub use forces::{AftForces, Periodicity, StateCounts, StateSummary, Tangent, TangentBlock};
pub use plan::AftPlan;
pub use settings::{AftSettings, Laps};
