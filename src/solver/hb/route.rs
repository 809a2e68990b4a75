//! How a peak was found.

/// How the search found a peak; a sample tries these routes in this order.
//
// The searches: `peak::predicted::correct`, `peak::predicted::maximum_near`, `peak::track`, `peak::band`. The descriptions
// stand in the JSON Schema of the outputs.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum PeakRoute {
    /// Undamped Newton steps from a prediction by neighbouring samples.
    Predicted,
    /// Damped Newton steps from the same prediction onto the predicted phase.
    Damped,
    /// Continuation from the nearest solved sample along the straight line between the inputs.
    Followed,
    /// The phase resonance followed from rest over rising amplitude; the maximum located with few harmonics.
    Tracked,
    /// The same; the maximum located with the harmonics of the study.
    TrackedOnAll,
    /// Continuation from the resonance of the structure that slides without friction.
    Sliding,
    /// Highest maximum of a sweep through the whole band with one harmonic.
    SweptOnOne,
    /// The same with few harmonics.
    SweptOnFew,
    /// Highest maximum on the branch through a maximum that another route has led to, or beside that branch on the one that a sweep through
    /// the band follows.
    OnBranch,
}

impl PeakRoute {
    /// Every route, in the order in which they are tried.
    pub const ALL: [Self; 9] = [
        Self::Predicted,
        Self::Damped,
        Self::Followed,
        Self::Tracked,
        Self::TrackedOnAll,
        Self::Sliding,
        Self::SweptOnOne,
        Self::SweptOnFew,
        Self::OnBranch,
    ];

    /// Whether the peak was found from those of other samples, and not from the structure at rest or the band.
    #[must_use]
    pub fn is_from_others(self) -> bool {
        matches!(self, Self::Predicted | Self::Damped | Self::Followed)
    }

    /// Whether the route leads to the highest maximum of those that it meets, whatever its mode.
    #[must_use]
    pub fn is_of_any_mode(self) -> bool {
        matches!(self, Self::Sliding | Self::SweptOnOne | Self::SweptOnFew)
    }

    /// Name in files and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Predicted => "predicted",
            Self::Damped => "damped",
            Self::Followed => "followed",
            Self::Tracked => "tracked",
            Self::TrackedOnAll => "tracked-on-all",
            Self::Sliding => "sliding",
            Self::SweptOnOne => "swept-on-one",
            Self::SweptOnFew => "swept-on-few",
            Self::OnBranch => "on-branch",
        }
    }

    /// One sentence for the reader of a report.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Predicted => "Newton's method from a prediction by neighbouring samples",
            Self::Damped => "damped Newton steps from the prediction by neighbouring samples",
            Self::Followed => {
                "continuation from the nearest solved sample along the straight line between the inputs"
            }
            Self::Tracked => {
                "phase resonance followed from rest over rising amplitude; maximum located with few harmonics"
            }
            Self::TrackedOnAll => {
                "phase resonance followed from rest over rising amplitude; maximum located with all harmonics"
            }
            Self::Sliding => "continuation from the resonance of the structure without friction",
            Self::SweptOnOne => {
                "highest maximum of a sweep through the whole band with one harmonic"
            }
            Self::SweptOnFew => {
                "highest maximum of a sweep through the whole band with few harmonics"
            }
            Self::OnBranch => "higher maximum on the branch through a lower one, or met by a sweep",
        }
    }
}
