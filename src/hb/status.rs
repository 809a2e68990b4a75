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
    /// Converged, but the contacts bounce: a period-1 response is not to be trusted.
    BouncingContact,
    /// Newton's method used up its iterations.
    MaxIterations,
    /// Continuation could not go on with the smallest step.
    StepTooSmall,
    /// The search took all Newton iterations that a search may take.
    BudgetSpent,
    /// The slider of a contact has no steady cycle that the contact evaluation could find.
    NoSteadyCycle,
    /// A non-finite number turned up.
    NonFinite,
    /// The amplitude has no maximum inside the frequency band.
    NoPeakInBand,
    /// The branch left the band at the end where the sweep had begun, and went far away.
    LeftBand,
    /// Even with all contacts stuck the structure is not held: there is nothing to solve.
    NotHeld,
}

impl Status {
    /// Every status, in the order of reports.
    pub const ALL: [Self; 11] = [
        Self::Converged,
        Self::TruncationAboveThreshold,
        Self::BouncingContact,
        Self::MaxIterations,
        Self::StepTooSmall,
        Self::BudgetSpent,
        Self::NoSteadyCycle,
        Self::NonFinite,
        Self::NoPeakInBand,
        Self::LeftBand,
        Self::NotHeld,
    ];

    /// Whether the numbers that go with this status solve the balance equations.
    #[must_use]
    pub fn has_solution(self) -> bool {
        matches!(
            self,
            Self::Converged | Self::TruncationAboveThreshold | Self::BouncingContact
        )
    }

    /// Whether these numbers may stand for the blade: nothing says that they are not exact enough, or not what it does.
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
            Self::BouncingContact => "bouncing-contact",
            Self::MaxIterations => "max-iterations",
            Self::StepTooSmall => "step-too-small",
            Self::BudgetSpent => "budget-spent",
            Self::NoSteadyCycle => "no-steady-cycle",
            Self::NonFinite => "non-finite",
            Self::NoPeakInBand => "no-peak-in-band",
            Self::LeftBand => "left-band",
            Self::NotHeld => "not-held",
        }
    }

    /// One sentence for the reader of a report.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Converged => {
                "the balance equations hold and the truncation error is not above the threshold: more harmonics would change the amplitude by less"
            }
            Self::TruncationAboveThreshold => {
                "the balance equations hold, but with this many harmonics the amplitude is not certified: its truncation error is above the threshold, or not known because no solution was found with twice the harmonics; raise highest_harmonic of the alert if that is the highest harmonic of the sample"
            }
            Self::BouncingContact => {
                "the balance equations hold, but the strip bounces and a response with the period of the excitation is not to be trusted"
            }
            Self::MaxIterations => "Newton's method did not converge from any start that was tried",
            Self::StepTooSmall => "the continuation could not go on with the smallest step",
            Self::BudgetSpent => "the search took more Newton iterations than solver.budget allows",
            Self::NoSteadyCycle => {
                "the slider of a contact did not become periodic within the laps of one evaluation"
            }
            Self::NonFinite => "a number overflowed or was undefined",
            Self::NoPeakInBand => {
                "the amplitude has no maximum inside the frequency band of the study"
            }
            Self::LeftBand => {
                "the branch left the frequency band at the end where the walk had begun, and did not come back"
            }
            Self::NotHeld => {
                "contact stiffness and static load leave the structure with a free rigid-body motion"
            }
        }
    }
}
