//! How a solve ended.

/// Outcome of one nonlinear solve; data, never an error.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Converged, stated truncation error not above the threshold (or not asked for).
    Converged,
    /// Converged, but the stated truncation error is above the threshold, or not known, and the solution has no more
    /// harmonics: the study allows none, or it was not found with more.
    TruncationAboveThreshold,
    /// Converged, with any truncation error, but a small disturbance grows from period to period: the structure does not stay in this
    /// vibration.
    Unstable,
    /// Converged and not assessed for stability, but a part that only contacts hold lifts off for most of the time.
    BouncingContact,
    /// Newton's method used up its iterations.
    MaxIterations,
    /// Continuation could not go on with the smallest step.
    StepTooSmall,
    /// The search used up the Newton iterations that the study allows.
    BudgetSpent,
    /// The slider of a contact has no steady cycle that the contact evaluation could find.
    NoSteadyCycle,
    /// A number overflowed or is undefined.
    NonFinite,
    /// The amplitude has no maximum inside the frequency band.
    NoPeakInBand,
    /// The branch left the band at the end where the sweep began, and did not return.
    LeftBand,
    /// With all contacts stuck the structure can still move as a rigid body: there is nothing to solve.
    NotHeld,
    /// The program met a defect of its own.
    Panicked,
}

impl Status {
    /// Every status, in the order of reports.
    pub const ALL: [Self; 13] = [
        Self::Converged,
        Self::TruncationAboveThreshold,
        Self::Unstable,
        Self::BouncingContact,
        Self::MaxIterations,
        Self::StepTooSmall,
        Self::BudgetSpent,
        Self::NoSteadyCycle,
        Self::NonFinite,
        Self::NoPeakInBand,
        Self::LeftBand,
        Self::NotHeld,
        Self::Panicked,
    ];

    /// Whether the numbers that go with this status solve the balance equations.
    #[must_use]
    pub fn has_solution(self) -> bool {
        matches!(
            self,
            Self::Converged
                | Self::TruncationAboveThreshold
                | Self::Unstable
                | Self::BouncingContact
        )
    }

    /// Whether verdicts may use these numbers: the error is not above the threshold, and the solution is neither unstable nor bouncing.
    #[must_use]
    pub fn is_trusted(self) -> bool {
        matches!(self, Self::Converged)
    }

    /// Name in files and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::TruncationAboveThreshold => "truncation-above-threshold",
            Self::Unstable => "unstable",
            Self::BouncingContact => "bouncing-contact",
            Self::MaxIterations => "max-iterations",
            Self::StepTooSmall => "step-too-small",
            Self::BudgetSpent => "budget-spent",
            Self::NoSteadyCycle => "no-steady-cycle",
            Self::NonFinite => "non-finite",
            Self::NoPeakInBand => "no-peak-in-band",
            Self::LeftBand => "left-band",
            Self::NotHeld => "not-held",
            Self::Panicked => "panicked",
        }
    }

    /// One sentence for the reader of a report.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Converged => {
                "the balance equations hold, and the stated truncation error is not above the threshold"
            }
            Self::TruncationAboveThreshold => {
                "the balance equations hold, but the truncation error is above the threshold, or not known because no solution was found with more harmonics to compare it with; if the sample has the alert's highest_harmonic, raise it"
            }
            Self::Unstable => {
                "the balance equations hold, but a small disturbance grows from period to period: the structure does not stay in this vibration"
            }
            Self::BouncingContact => {
                "the balance equations hold and stability was not assessed, but a part that only contacts hold, such as the strip, lifts off for most of the time: its real vibration may not have the period of the excitation"
            }
            Self::MaxIterations => "Newton's method did not converge from any of the starts",
            Self::StepTooSmall => "the continuation of the branch failed with the smallest step",
            Self::BudgetSpent => {
                "the search needed more Newton iterations than solver.budget allows"
            }
            Self::NoSteadyCycle => {
                "the motion of a friction slider did not become periodic within the passes over the period of one contact evaluation"
            }
            Self::NonFinite => "a number overflowed or is undefined",
            Self::NoPeakInBand => "the amplitude has no maximum inside the frequency band",
            Self::LeftBand => {
                "the branch of solutions left the frequency band at the end where the continuation began, and did not return"
            }
            Self::NotHeld => {
                "with all contacts stuck the structure can still move as a rigid body; or the sliders start from a rest without friction that does not exist"
            }
            Self::Panicked => {
                "the program met a defect of its own: please report it with the study and the inputs of the sample"
            }
        }
    }
}
