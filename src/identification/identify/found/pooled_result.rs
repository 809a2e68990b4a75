//! What is found from all tests together: plain data for tables, files and figures.

use super::parameter::ContactParameter;
use super::uncertain::Uncertain;

/// All tests together: y = m + specimen + test + error, for the logarithms of the parameters.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pooled {
    /// Each parameter that at least one test has.
    pub parameters: Vec<PooledParameter>,
    /// Covariance of ln parameters between specimens (zero where each test has its own specimen). Shape: square, as `parameters`.
    pub between_specimens: Vec<Vec<f64>>,
    /// Covariance of ln parameters between tests; of one specimen where specimens are stated.
    pub between_tests: Vec<Vec<f64>>,
    /// Covariance of the means of ln parameters, the errors of the measuring chain included.
    pub of_mean: Vec<Vec<f64>>,
    /// Covariance of ln parameters at a further contact, that of the distributions: with the factors for few specimens and the errors
    /// of the measuring chain.
    pub predictive: Vec<Vec<f64>>,
    /// Correlation of the same.
    pub correlation: Vec<Vec<f64>>,
    /// Specimens; a test whose specimen is not stated counts as one of its own.
    pub specimens: usize,
    /// Dependence of the parameters on load and frequency.
    pub trends: Vec<Trend>,
    /// Greatest lower bound of the friction coefficient from tests that do not slip.
    pub friction_at_least: Option<f64>,
}

/// One parameter over all tests.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PooledParameter {
    /// Which one.
    pub parameter: ContactParameter,
    /// Tests that have it.
    pub tests: usize,
    /// Specimens of these tests; 0 in a file of an earlier version.
    #[serde(default)]
    pub specimens: usize,
    /// Its median over contacts, in the unit of its name, for the tested interface. Standard errors are those of a value, not of
    /// its logarithm.
    pub median: Uncertain,
    /// Standard deviation of its logarithm between contacts; absent with one test.
    pub log_scatter: Option<f64>,
    /// Standard deviation of its logarithm at a further contact, with the factor for few specimens.
    pub predictive_log_standard_deviation: f64,
    /// Factor for few specimens that it holds: Student's over the normal quantile. Of one specimen it is that for few tests.
    pub few_tests_factor: f64,
    /// Interval of a further contact at the stated confidence, for the tested interface.
    pub further_contact: [f64; 2],
}

/// Dependence of one parameter on the load or the frequency: parameter ∝ (load or frequency)^exponent.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trend {
    /// Which parameter.
    pub parameter: ContactParameter,
    /// On what.
    pub over: TrendOver,
    /// Tests that it is from.
    pub tests: usize,
    /// Exponent.
    pub exponent: f64,
    /// Interval of it at the stated confidence; the parameter depends on it where 0 is outside.
    pub interval: [f64; 2],
}

/// What a parameter may depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrendOver {
    /// Mean normal force.
    NormalForce,
    /// Frequency of the motion.
    Frequency,
}
