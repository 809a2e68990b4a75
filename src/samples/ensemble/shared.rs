//! What all samples of a study share: structure, contacts, inputs, solver.

use super::mistuned_disk::MistunedDisk;
use super::strips::Strips;
use crate::contact::ContactParameters;
use crate::hb::peak::maxima::PeakChoice;
use crate::hb::peak::search::PeakSettings;
use crate::hb::{HbSettings, LinearModel};
use crate::lockstep::LaneDevice;
use crate::sampling::{Design, Input};

/// What all samples of a study share.
#[derive(Debug, Clone, Copy)]
pub struct Ensemble<'a> {
    /// Nominal linear part of the model.
    pub linear: &'a LinearModel,
    /// Makes the strip of a sample, if the thickness of the strip is an input.
    pub strips: Option<&'a Strips>,
    /// The disk that samples are, if its blades differ; its tuned sector is `linear`.
    pub mistuned: Option<&'a MistunedDisk>,
    /// Nominal constants of the contact pairs.
    pub contacts: &'a [ContactParameters<f64>],
    /// Interface of each contact pair: 0 = left, 1 = right. Shape as `contacts`; read for inputs of one side only.
    pub interfaces: &'a [usize],
    /// Inputs that are static loads, in the order of [`crate::hb::structure::linear::ModalPart::loads`].
    pub loads: &'a [Input],
    /// Random inputs.
    pub design: &'a Design,
    /// Excitation levels, ascending.
    pub levels: &'a [f64],
    /// Solver.
    pub settings: &'a HbSettings,
    /// Where peaks are searched and how exactly.
    pub peak: PeakSettings,
    /// Which of the maxima is the peak.
    pub choice: PeakChoice,
    /// Numbers, as a study counts them, of the modes that maxima are attributed to, by their index among those that harmonic 1
    /// excites; empty where a study does not follow all modes.
    pub mode_numbers: &'a [u32],
    /// Samples with a forced response curve: 0 … this − 1.
    pub curve_samples: u64,
    /// A device that improves predicted peaks, if any. The processor computes everything that decides a result.
    pub gpu: Option<&'a LaneDevice>,
    /// How the peaks of a sample are computed.
    pub solver: SampleSolver,
}

/// How the peaks of a sample are computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SampleSolver {
    /// The balance equations.
    #[default]
    HarmonicBalance,
    /// A function with known answers.
    #[cfg(feature = "test-functions")]
    Function(super::test_function::TestFunction),
}
