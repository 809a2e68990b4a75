//! What every statement of a report holds with: probabilities of its quantiles, its confidence, the share that it bounds.

/// Probabilities of the quantiles in a report.
pub const PROBABILITIES: [f64; 3] = [0.05, 0.5, 0.95];
/// Confidence of every interval in a report.
pub const CONFIDENCE: f64 = 0.95;

/// Share of the population in every tolerance bound of a report.
pub const CONTENT: f64 = 0.95;
