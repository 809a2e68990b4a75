//! One test of a contact: displacement and forces at the same instants.

/// Hysteresis test of one contact: signals at the same instants, in SI units, as measured: with noise, drift and offsets.
///
/// Sign: displacement and tangential force have the same sign while a contact that starts at rest sticks; the normal force is
/// positive in compression, and so is the approach.
#[derive(Debug, Clone, PartialEq)]
pub struct HysteresisRecord {
    /// Name for tables and messages: the file without its ending, with the label of the test where a file has several: `rig A1`.
    pub name: String,
    /// Instants (s), rising.
    pub time: Vec<f64>,
    /// Relative displacement in the direction of sliding (m).
    pub displacement: Vec<f64>,
    /// Tangential contact force T (N).
    pub tangential_force: Vec<f64>,
    /// Normal contact force N (N).
    pub normal_force: Vec<f64>,
    /// Relative normal displacement (m) where it was measured.
    pub approach: Option<Vec<f64>>,
    /// What is known of the test beside its signals.
    pub conditions: TestConditions,
}

impl HysteresisRecord {
    /// A test without samples of which nothing else is known.
    #[must_use]
    pub fn empty(name: String) -> Self {
        Self {
            name,
            time: Vec::new(),
            displacement: Vec::new(),
            tangential_force: Vec::new(),
            normal_force: Vec::new(),
            approach: None,
            conditions: TestConditions::default(),
        }
    }
}

/// What is known of a test beside its signals.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TestConditions {
    /// Frequency of the motion (Hz); estimated from the signals where it is not stated.
    pub frequency_hz: Option<f64>,
    /// Contact pair or specimen that was tested: tests of one specimen share its scatter.
    pub specimen: Option<String>,
    /// Share of the contact's area whose pressure is within a tenth of its mean, from 0 to 1, as a map of the pressure shows it. It tells
    /// how much of the contact may slip before the whole where noise hides it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub even_area: Option<f64>,
}
