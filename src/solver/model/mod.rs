//! The reduced model: matrices, contact pairs, loads and responses. Knows the
//! contacts' constants, but no contact law and no harmonic balance.
//!
//! A model by hand; [`matrices`] reads one from files, [`two_blade`] builds the rig.
//!
//! ```
//! # use microslip_solver as microslip;
//! use faer::Mat;
//! use microslip::model::{ContactPair, ReducedModel, Response};
//!
//! let one = |value: f64| Mat::from_fn(1, 1, |_, _| value);
//! let ground = ContactPair {
//!     name: "damper".to_owned(),
//!     t1: vec![(0, 1.0)], // slides by the displacement of coordinate 0
//!     t2: vec![],
//!     n: vec![], // constant normal force
//!     area: 1.0,
//!     interface: 0,
//! };
//! let model = ReducedModel {
//!     name: "oscillator".to_owned(),
//!     dof_names: vec!["x".to_owned()],
//!     mass: one(1.0),
//!     damping: one(10.0),
//!     stiffness: one(1e6),
//!     retention: None,
//!     contacts: vec![ground],
//!     static_force: vec![0.0],
//!     loads: vec![],
//!     cosine_force: vec![1.0], // N per unit of the excitation level
//!     sine_force: vec![0.0],
//!     responses: vec![Response { name: "x".to_owned(), row: vec![(0, 1.0)] }],
//!     mirror: None,
//! };
//! assert_eq!((model.n_dofs(), model.n_contacts()), (1, 1));
//! ```

mod bounded_lines;
mod complex_market;
pub mod disk;
pub mod interface;
pub mod lower_triangle;
mod masters;
pub mod matrices;
pub mod matrix_checks;
pub mod matrix_contacts;
pub mod matrix_market;
pub mod matrix_writer;
pub mod mirror;
pub mod model_text;
pub mod modes;
pub mod rigid;

mod craig_bampton;
mod dof_index;
pub mod two_blade;

pub use craig_bampton::{CraigBampton, ReductionError};
pub use mirror::Mirror;

use crate::fe::FeError;
use crate::linalg::LinalgError;
use crate::setting::BadSetting;
use faer::Mat;

/// Why a model cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A setting breaks a rule.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// The finite element mesh is no model.
    #[error(transparent)]
    Fe(#[from] FeError),
    /// A factorisation or eigenvalue problem has no answer.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
    /// A master node is clamped or not in the mesh.
    #[error("no free node at {position:?} m")]
    NoFreeNode {
        /// Where it was expected (m).
        position: [f64; 3],
    },
    /// The blade has no second mode that moves mainly in x.
    #[error("no neck bending among the first {searched} blade modes")]
    NoNeckBending {
        /// Number of modes searched.
        searched: usize,
    },
}

/// A linear form on the degrees of freedom: Σ weight · q_dof. Empty = the direction is absent.
pub type SparseRow = Vec<(usize, f64)>;

/// Linear part of a blade–damper model with everything that loads it and looks at it.
///
/// M q̈ + C q̇ + K q = f₀ + level · (f_c cos ωt + f_s sin ωt) − Σ B_t1ᵀ T₁ + B_t2ᵀ T₂ + B_nᵀ N.
///
/// Units: SI (or any consistent set). Shape: matrices n × n, forces `[n]`.
#[derive(Debug, Clone)]
pub struct ReducedModel {
    /// What the model is, for reports.
    pub name: String,
    /// One name per degree of freedom.
    pub dof_names: Vec<String>,
    /// M, symmetric positive definite.
    pub mass: Mat<f64>,
    /// C, symmetric positive semidefinite.
    pub damping: Mat<f64>,
    /// K, symmetric positive semidefinite; rigid-body modes that the contacts hold are allowed.
    pub stiffness: Mat<f64>,
    /// Stiffness added in the 0th harmonic only: holds the mean in-plane position of a strip in gross slip.
    pub retention: Option<Mat<f64>>,
    /// Contact pairs.
    pub contacts: Vec<ContactPair>,
    /// f₀.
    pub static_force: Vec<f64>,
    /// Further static forces, each added to f₀ times an input of the sample. Shape: loads × n.
    pub loads: Vec<Vec<f64>>,
    /// f_c per unit level.
    pub cosine_force: Vec<f64>,
    /// f_s per unit level.
    pub sine_force: Vec<f64>,
    /// Response coordinates; the amplitude of the first one defines resonance.
    pub responses: Vec<Response>,
    /// A mirror symmetry that the model is built with, if any.
    pub mirror: Option<Mirror>,
}

/// Kinematics of one node pair. Sign: relative displacement strip minus blade; n > 0 is compression.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPair {
    /// Name, unique in the model.
    pub name: String,
    /// First tangential relative displacement.
    pub t1: SparseRow,
    /// Second tangential relative displacement.
    pub t2: SparseRow,
    /// Normal approach.
    pub n: SparseRow,
    /// Area that the pair stands for (m²); shares the interface stiffness. 1 where it has no meaning.
    pub area: f64,
    /// Interface that the pair belongs to (0, 1, …).
    pub interface: usize,
}

/// A named coordinate whose amplitude is reported.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Name, unique in the model.
    pub name: String,
    /// Weights on the degrees of freedom.
    pub row: SparseRow,
}

impl ReducedModel {
    /// Number of degrees of freedom n.
    #[must_use]
    pub fn n_dofs(&self) -> usize {
        self.mass.nrows()
    }

    /// Number of contact pairs.
    #[must_use]
    pub fn n_contacts(&self) -> usize {
        self.contacts.len()
    }
}
