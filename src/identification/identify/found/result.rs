//! What is found of one test: plain data for tables, files and figures.

use super::parameter::ContactParameter;
use super::uncertain::Uncertain;
use crate::record::TestConditions;

/// What is found from one test: the mean of its steady loops.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TestResult {
    /// Name of the record.
    pub name: String,
    /// What was known of the test before.
    pub conditions: TestConditions,
    /// How it ended.
    pub status: TestStatus,
    /// Cycles of the record; absent where none could be cut out.
    pub cycles: Option<Cycles>,
    /// Estimates; absent where the loops have none.
    pub estimate: Option<TestEstimate>,
    /// Each whole cycle of the record, in the order of time.
    pub loops: Vec<LoopResult>,
    /// Points and lines for figures; absent where there is no estimate.
    pub figure: Option<LoopFigure>,
    /// What a reader should know, in sentences.
    pub notes: Vec<String>,
}

/// How the identification from one test ended.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind", content = "reason")]
pub enum TestStatus {
    /// The whole contact slips: friction coefficient and stiffness are found.
    Slips,
    /// The whole contact never slips: stiffness, and a lower bound of the friction coefficient.
    NoSlip,
    /// Nothing can be taken from it, and why.
    Unusable(String),
}

/// How a record was cut into cycles.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Cycles {
    /// Frequency of the motion (Hz).
    pub frequency_hz: f64,
    /// Whether the frequency was stated; else it is estimated from the displacement.
    pub frequency_stated: bool,
    /// Whole cycles of the record.
    pub whole: usize,
    /// Cycles at the start that are left out, because the loop still changes.
    pub run_in: usize,
    /// Cycles after the run-in, which are averaged.
    pub steady: usize,
    /// Samples per cycle.
    pub samples_per_cycle: f64,
    /// Drift of the displacement that was taken out (m/s).
    pub displacement_drift_m_per_s: f64,
    /// Drift of the tangential force that was taken out (N/s).
    pub tangential_force_drift_n_per_s: f64,
    /// Values taken out of the averages as spikes.
    pub spikes: usize,
    /// Resonance of the force measurement that was taken out of the tangential force; absent where it shows none.
    pub force_resonance: Option<ForceResonance>,
}

/// Resonance of a force cell with the mass before it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ForceResonance {
    /// Frequency (Hz) of the free vibration without damping.
    pub frequency_hz: f64,
    /// Damping over the critical one.
    pub damping_ratio: f64,
}

/// Parameters of the contact and what characterises the loop of one test.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TestEstimate {
    /// Mean normal force (N).
    pub normal_force_n: f64,
    /// Least and greatest normal force in the mean cycle (N).
    pub normal_force_range_n: [f64; 2],
    /// Half the swing of the displacement (m).
    pub displacement_amplitude_m: f64,
    /// Half the swing of the tangential force (N).
    pub tangential_force_amplitude_n: f64,
    /// Friction coefficient, from the plateaus of T/N; absent where the contact does not slip as a whole.
    pub friction: Option<Friction>,
    /// Lower bound of the friction coefficient where the contact does not slip as a whole: the T/N at both ends,
    /// whatever the offset of T.
    pub friction_at_least: Option<f64>,
    /// Tangential stiffness, from the stick branches.
    pub tangential: Tangential,
    /// Normal stiffness (N/µm), where normal motion was measured and is large enough.
    pub normal_stiffness_n_per_um: Option<Uncertain>,
    /// Energy per cycle (J).
    pub energy_j: Uncertain,
    /// Where slip begins.
    pub onset: Option<Onset>,
    /// How far the steady loops differ from each other; absent in files of versions that did not state it.
    #[serde(default)]
    pub loop_scatter: Option<LoopScatter>,
    /// Correlation of the errors of ln μ and ln k_t, by noise; 0 where one of them is absent.
    pub error_correlation: f64,
    /// Difference between the loop and that of an elastic-Coulomb contact with these parameters.
    pub misfit: Misfit,
}

impl TestEstimate {
    /// What the test says of a contact parameter.
    #[must_use]
    pub fn value(&self, parameter: ContactParameter) -> Option<Uncertain> {
        match parameter {
            ContactParameter::FrictionCoefficient => self.friction.map(|f| f.coefficient),
            ContactParameter::TangentialStiffnessNPerUm => Some(self.tangential.stiffness_n_per_um),
            ContactParameter::NormalStiffnessNPerUm => self.normal_stiffness_n_per_um,
        }
    }
}

/// Friction coefficient of a test.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Friction {
    /// Half the difference of the two plateaus of T/N, free of the offset of T.
    pub coefficient: Uncertain,
    /// |T/N| of the plateau at the greatest and at the least displacement, as measured: with the offset of T.
    pub sides: [f64; 2],
    /// Offset of T that the plateaus show (N).
    pub tangential_offset_n: f64,
    /// Energy per cycle over slip distance and normal force: a second estimate of the coefficient.
    pub from_energy: Option<f64>,
    /// `from_energy` / `coefficient` − 1.
    pub energy_difference: Option<f64>,
    /// Slip distance per cycle, both ways together (m).
    pub slip_distance_m: f64,
}

/// Tangential stiffness of a test.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tangential {
    /// Stiffness of the contact (N/µm), the rig's stiffness in series taken out.
    pub stiffness_n_per_um: Uncertain,
    /// After the reversal at the greatest displacement and after that at the least, the rig's stiffness taken out.
    pub sides_n_per_um: [Option<Uncertain>; 2],
    /// Slope as measured, with the rig's stiffness in series (N/µm).
    pub measured_n_per_um: f64,
    /// Samples of the mean cycle in both windows.
    pub samples: [usize; 2],
    /// Share of the swing of T where each window ends.
    pub window_end: [f64; 2],
    /// Whether parts of the contact slip before the whole, so that the branch is straightened before its slope is taken.
    pub bent: [bool; 2],
}

/// Standard deviations of the steady loops, over their means, with the noise of each loop; absent of fewer than two loops that have the value.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LoopScatter {
    /// Of the friction coefficient.
    pub friction_coefficient: Option<f64>,
    /// Of the tangential stiffness, the mean of both sides.
    pub tangential_stiffness: Option<f64>,
    /// Of the energy per cycle.
    pub energy: Option<f64>,
}

/// Where slip begins: the knee of the loop.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Onset {
    /// Displacement from the middle of the stick branch to where the whole contact slips: μ N / k (m).
    pub elastic_limit_m: f64,
    /// Displacement after a reversal where the branch leaves its first slope, mean of both (m).
    pub first_slip_m: f64,
    /// The same as a share of the swing of T; near 1 all of the contact slips at once.
    pub first_slip_share: f64,
}

/// Difference between a loop and that of an elastic-Coulomb contact with the parameters found.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Misfit {
    /// Root of the mean square of the difference, over the swing of the tangential force.
    pub relative_rms: f64,
    /// Whether it is large: the contact is not one of these equations, and the parameters say less.
    pub large: bool,
}

/// What is found from one cycle.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LoopResult {
    /// Place in the record, from 0.
    pub cycle: usize,
    /// Time at which it begins (s).
    pub start_s: f64,
    /// Whether it is one of the steady loops that are averaged.
    pub steady: bool,
    /// Mean normal force (N).
    pub normal_force_n: f64,
    /// Friction coefficient.
    pub friction_coefficient: Option<LoopValue>,
    /// The same from energy, slip distance and load.
    pub friction_from_energy: Option<f64>,
    /// Tangential stiffness after the reversal at the greatest and at the least displacement (N/µm).
    pub tangential_stiffness_n_per_um: [Option<LoopValue>; 2],
    /// Normal stiffness (N/µm).
    pub normal_stiffness_n_per_um: Option<LoopValue>,
    /// Energy of the cycle (J).
    pub energy_j: f64,
}

/// Value of one loop with its standard error, from the differences inside the loop.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LoopValue {
    /// The value.
    pub value: f64,
    /// Its standard error; absent where there are too few samples.
    pub standard_error: Option<f64>,
}

/// The mean steady loop of a test and what was fitted to it, for figures. All columns have the same length, over one cycle that
/// begins at the greatest displacement.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LoopFigure {
    /// Relative displacement (m), about the middle of its swing.
    pub displacement_m: Vec<f64>,
    /// Tangential force (N), its offset taken out where plateaus show it.
    pub tangential_force_n: Vec<f64>,
    /// Normal force (N).
    pub normal_force_n: Vec<f64>,
    /// Approach (m), where it was measured.
    pub approach_m: Option<Vec<f64>>,
    /// T/N.
    pub force_ratio: Vec<f64>,
    /// Tangential force of the elastic-Coulomb contact with the parameters found (N); absent where its parameters are.
    pub fitted_force_n: Option<Vec<f64>>,
    /// Measured less fitted force (N).
    pub residual_n: Option<Vec<f64>>,
    /// First and last sample of the windows of the stick branches, after both reversals.
    pub stick_windows: [Option<[usize; 2]>; 2],
    /// First and last sample of the plateaus, before the next reversal: that at the least displacement, that at the greatest.
    pub plateaus: [Option<[usize; 2]>; 2],
    /// Lines through the stick branches: two points (displacement in m, force in N).
    pub stick_lines: [Option<[[f64; 2]; 2]>; 2],
}
