//! How a peak was found.

/// The route on which a search came to a peak, in the order in which a sample tries them.
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
    /// From the prediction by samples around it, by undamped Newton steps.
    Predicted,
    /// From that prediction, by damped steps onto the predicted phase.
    Damped,
    /// From the nearest solved sample, by steps along the straight line between the inputs.
    Followed,
    /// From the stuck structure over the levels, the maximum located on few harmonics.
    Tracked,
    /// The same, the maximum located on the harmonics of the study.
    TrackedOnAll,
    /// From the structure that slides without friction.
    Sliding,
    /// From a sweep through the whole band with one harmonic.
    SweptOnOne,
    /// The same with few harmonics.
    SweptOnFew,
    /// The same with the harmonics of the study.
    SweptOnAll,
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
        Self::SweptOnAll,
    ];

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
            Self::SweptOnAll => "swept-on-all",
        }
    }

    /// One sentence for the reader of a report.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Predicted => "undamped Newton steps from the prediction of the samples around it",
            Self::Damped => "damped Newton steps from that prediction",
            Self::Followed => {
                "steps from the nearest solved sample along the line between the inputs"
            }
            Self::Tracked => {
                "followed from the stuck structure over the levels, located on few harmonics"
            }
            Self::TrackedOnAll => {
                "followed from the stuck structure over the levels, located on all harmonics"
            }
            Self::Sliding => "searched from the structure that slides without friction",
            Self::SweptOnOne => {
                "highest maximum on the way through the whole band, on one harmonic"
            }
            Self::SweptOnFew => {
                "highest maximum on the way through the whole band, on few harmonics"
            }
            Self::SweptOnAll => {
                "highest maximum on the way through the whole band, on all harmonics"
            }
        }
    }
}
