//! Which bands of whole curves a study wants on its page.

use serde::{Deserialize, Serialize};

/// How the bands of whole curves are formed.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Bands {
    /// Pointwise quantiles, stretched by one factor until they hold the stated share of whole curves.
    #[default]
    Simultaneous,
    /// What the deepest curves span, of as many as hold that share; needs more samples.
    Depth,
    /// As `simultaneous`, each curve over its frequency divided by that of its peak: the scatter of the shape without that of
    /// the place.
    PeakAligned,
}
