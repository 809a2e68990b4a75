//! Why a harmonic balance problem cannot be set up.

use super::status::Status;

/// A model or sample that is not a harmonic balance problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProblemError {
    /// The eigenproblem of the free structure cannot be solved.
    #[error(transparent)]
    Linalg(#[from] crate::linalg::LinalgError),
    /// A rigid-body motion is held neither by the structure, nor by stuck contacts, nor by the retention.
    #[error(
        "the structure with all contacts stuck can move as a rigid body, or its own stiffness is lost beside that of its contacts: add contact stiffness, supports or retention, or check the units of the contact stiffness"
    )]
    NotHeld,
    /// A contact parameter is infinite or not a number; the law would take such a friction coefficient for stick.
    #[error("contact pair {pair}: every parameter must be a finite number")]
    NotFinite {
        /// Index of the pair.
        pair: usize,
    },
    /// The harmonic force moves no contact.
    #[error("the harmonic force does not move any contact pair: check the excitation")]
    NoLoad,
    /// A rigid-body motion is held by friction alone, so that the static equilibrium without friction is not defined.
    #[error(
        "without friction the contacts do not hold the structure: there is no static equilibrium where the sliders could start"
    )]
    NotHeldWithoutFriction,
    /// The frictionless static equilibrium for the anchors was not found.
    #[error("no static equilibrium without friction was found for the slider anchors")]
    NoStaticEquilibrium,
}

impl ProblemError {
    /// How a sample ends whose problem cannot be set up.
    #[must_use]
    pub fn status(&self) -> Status {
        match self {
            Self::Linalg(_) | Self::NotFinite { .. } => Status::NonFinite,
            Self::NotHeld | Self::NotHeldWithoutFriction | Self::NoStaticEquilibrium => {
                Status::NotHeld
            }
            Self::NoLoad => Status::NoPeakInBand,
        }
    }
}
