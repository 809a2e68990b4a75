//! Multi-harmonic balance with coupled static and dynamic equations.
//!
//! A [`LinearModel`] (once per study) and contact parameters (once per sample) make a [`Problem`]; a [`Balance`] is
//! that problem on a harmonic set. Start reading at `equations`, then `newton`, `peak`. A mass on a spring and a friction damper, as
//! in [`model`](crate::model), at two frequencies:
//!
//! ```
//! # use microslip_solver as microslip;
//! # use faer::Mat;
//! # use microslip::model::{ContactPair, ReducedModel, Response};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let one = |value: f64| Mat::from_fn(1, 1, |_, _| value);
//! # let model = ReducedModel {
//! #     name: "oscillator".to_owned(),
//! #     dof_names: vec!["x".to_owned()],
//! #     mass: one(1.0),
//! #     damping: one(10.0),
//! #     stiffness: one(1e6),
//! #     retention: None,
//! #     contacts: vec![ContactPair {
//! #         name: "damper".to_owned(),
//! #         t1: vec![(0, 1.0)],
//! #         t2: vec![],
//! #         n: vec![],
//! #         area: 1.0,
//! #         interface: 0,
//! #     }],
//! #     static_force: vec![0.0],
//! #     loads: vec![],
//! #     cosine_force: vec![1.0],
//! #     sine_force: vec![0.0],
//! #     responses: vec![Response { name: "x".to_owned(), row: vec![(0, 1.0)] }],
//! #     mirror: None,
//! # };
//! use microslip::aft::{AftSettings, Laps};
//! use microslip::contact::{ContactParameters, Events, FrictionLaw};
//! use microslip::harmonics::HarmonicSet;
//! use microslip::hb::branch::sweep::SweepDirection;
//! use microslip::hb::response::values::{SlowSweep, at_frequencies};
//! use microslip::hb::structure::resonance::Band;
//! use microslip::hb::{
//!     HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, StabilityScope,
//! };
//!
//! let linear = LinearModel::new(&model)?;
//! // 1 N/um, and slip at 0.3 times 10 N
//! let damper = ContactParameters { k_n: 0.0, k_t: [1e6, 0.0], mu: 0.3, n_0: 10.0, anchor: [0.0; 2] };
//! let problem = Problem::new(&linear, vec![damper], 1.0, SliderAnchor::Unloaded)?;
//! let settings = HbSettings {
//!     harmonics: HarmonicSet::up_to(9),
//!     aft: AftSettings {
//!         n_time: 256,
//!         law: FrictionLaw::Box,
//!         events: Events::Located,
//!         laps: Laps::Periodic,
//!     },
//!     anchor: SliderAnchor::Unloaded,
//!     newton: NewtonSettings::default(),
//!     alert: None,
//!     stability: StabilityScope::Off,
//! };
//! let sweep = SlowSweep {
//!     band: Band { low: 800.0, high: 1600.0 }, // rad/s
//!     direction: SweepDirection::Upward,
//!     omega: &[1000.0, 1400.0],
//! };
//! let level = 5.0; // N
//! for solution in at_frequencies(&problem, &settings, level, sweep, |_progress| ()).solutions {
//!     assert!(solution.status.has_solution() && solution.contact.slip > 0.0);
//!     let work = solution.work; // J per period
//!     assert!((work.input - work.viscous - work.friction).abs() < 1e-6 * work.input);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Whole studies stand at `microslip::study`.

pub mod branch;
pub mod equations;
pub mod error;
pub mod newton;
pub mod peak;
pub mod response;
pub mod route;
pub mod settings;
pub mod solution;
pub mod stability;
pub mod status;
pub mod structure;

pub use equations::balance::Balance;
pub use equations::effort::WorkCount;
pub use equations::problem::Problem;
pub use error::ProblemError;
pub use route::PeakRoute;
pub use settings::{AlertSettings, HbSettings, NewtonSettings, SliderAnchor, StabilityScope};
pub use solution::{ContactFractions, CycleWork, Solution};
pub use stability::Stability;
pub use status::Status;
pub use structure::linear::LinearModel;
