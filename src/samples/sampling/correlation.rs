//! Correlated inputs: a Gaussian copula between the uniform numbers and the inputs' own distributions.
//!
//! z = Φ⁻¹(u) of independent u, z' = L z with L Lᵀ the correlation of the normal scores, u' = Φ(z'). Every input keeps
//! its distribution (Li & Hammond 1975, "normal to anything").

use super::Input;
use crate::setting::BadSetting;
use crate::special::{normal_cdf, normal_quantile};

/// What the values of correlations are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CorrelationKind {
    /// Pearson's correlation of the normal scores Φ⁻¹(F(x)).
    #[default]
    NormalScores,
    /// Spearman's rank correlation ρ of the inputs: that of the scores is 2 sin(π ρ / 6).
    Spearman,
}

/// Correlated inputs, by a Gaussian copula; without the table they are independent.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrelationTable {
    /// What the values are.
    #[serde(default)]
    #[schemars(extend("default" = "normal-scores"))]
    kind: CorrelationKind,
    /// Pairs of inputs with their correlations.
    #[schemars(length(min = 1))]
    pairs: Vec<CorrelatedPair>,
}

/// Two inputs and their correlation.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct CorrelatedPair {
    /// Names of two inputs.
    #[serde(deserialize_with = "crate::setting::exactly")]
    inputs: [String; 2],
    /// Their correlation, not 0: pairs that are not named are independent.
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 1, "not" = { "const": 0 }))]
    value: f64,
}

/// Correlations that another file states, of inputs that are identified together.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownCorrelation {
    /// Name of that file.
    pub origin: String,
    /// The inputs.
    pub inputs: Vec<Input>,
    /// Correlation of their normal scores. Shape: square, in the order of `inputs`.
    pub matrix: Vec<Vec<f64>>,
}

impl KnownCorrelation {
    /// The correlation of two inputs; `None` unless the file states both.
    fn of(&self, a: Input, b: Input) -> Option<f64> {
        let place = |input| self.inputs.iter().position(|other| *other == input);
        Some(self.matrix[place(a)?][place(b)?])
    }
}

/// Correlation matrix of the normal scores of `inputs`, in their order: what another file states, and what the table adds.
/// `None` if no input is correlated.
///
/// # Errors
/// [`BadSetting`] with a key relative to `[correlation]`, as [`CorrelationTable::matrix`].
pub(super) fn correlation_matrix(
    table: Option<&CorrelationTable>,
    known: Option<&KnownCorrelation>,
    inputs: &[Input],
) -> Result<Option<Vec<Vec<f64>>>, BadSetting> {
    match table {
        Some(table) => table.matrix(inputs, known).map(Some),
        None => Ok(Some(start(known, inputs)).filter(|matrix| *matrix != identity(inputs.len()))),
    }
}

/// What is known before the table.
fn start(known: Option<&KnownCorrelation>, inputs: &[Input]) -> Vec<Vec<f64>> {
    let mut matrix = identity(inputs.len());
    for (i, a) in inputs.iter().enumerate() {
        for (j, b) in inputs.iter().enumerate().filter(|(j, _)| *j != i) {
            matrix[i][j] = known.and_then(|known| known.of(*a, *b)).unwrap_or(0.0);
        }
    }
    matrix
}

/// Least pivot of a correlation matrix: below it an input follows from others up to rounding.
const LEAST_PIVOT: f64 = 1e-9;

impl CorrelationTable {
    /// Correlation matrix of the normal scores of `inputs`, with what is `known` of them. Shape: square, in their order.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[correlation]`: an input that is not among `inputs`, a pair twice or already known,
    /// a value outside of −1 … 1, or values that contradict each other.
    pub fn matrix(
        &self,
        inputs: &[Input],
        known: Option<&KnownCorrelation>,
    ) -> Result<Vec<Vec<f64>>, BadSetting> {
        let mut matrix = start(known, inputs);
        BadSetting::unless(!self.pairs.is_empty(), "pairs", "[]", "must not be empty")?;
        for (k, pair) in self.pairs.iter().enumerate() {
            let [i, j] = pair
                .places(inputs)
                .map_err(|bad| bad.under(&format!("pairs[{k}]")))?;
            let key = format!("pairs[{k}]");
            let written = format!("{:?}", pair.inputs);
            pair.check_unknown(known, [inputs[i], inputs[j]])
                .map_err(|bad| bad.under(&key))?;
            let once = i != j && matrix[i][j] == 0.0;
            let rule = "must be two different inputs, and no other pair the same two";
            BadSetting::unless(once, &format!("{key}.inputs"), written, rule)?;
            let inside = pair.value.abs() < 1.0 && pair.value != 0.0;
            let rule = "must be between -1 and 1, and not 0";
            BadSetting::unless(inside, &format!("{key}.value"), pair.value, rule)?;
            let score = match self.kind {
                CorrelationKind::NormalScores => pair.value,
                CorrelationKind::Spearman => {
                    2.0 * libm::sin(std::f64::consts::PI * pair.value / 6.0)
                }
            };
            (matrix[i][j], matrix[j][i]) = (score, score);
        }
        match cholesky(&matrix) {
            Ok(_) => Ok(matrix),
            Err(i) => {
                let name = inputs[i].name();
                let rule = format!(
                    "must make a positive definite matrix: the correlations of {name} contradict those of the inputs before it"
                );
                Err(BadSetting::new(
                    "pairs",
                    format!("[..., {name}, ...]"),
                    rule,
                ))
            }
        }
    }
}

impl CorrelatedPair {
    /// Refuses a pair whose correlation another file states.
    fn check_unknown(
        &self,
        known: Option<&KnownCorrelation>,
        [a, b]: [Input; 2],
    ) -> Result<(), BadSetting> {
        let stated = known.and_then(|known| Some((known.of(a, b)?, &known.origin)));
        let rule = match stated.filter(|_| a != b) {
            Some((value, origin)) => {
                format!("must be absent: {origin} states the correlation of these two, {value}")
            }
            None => return Ok(()),
        };
        Err(BadSetting::new(
            "inputs",
            format!("{:?}", self.inputs),
            rule,
        ))
    }

    fn places(&self, inputs: &[Input]) -> Result<[usize; 2], BadSetting> {
        let place = |name: &String| {
            let at = inputs.iter().position(|input| input.name() == name);
            let known: Vec<_> = inputs.iter().map(|input| input.name()).collect();
            at.ok_or_else(|| {
                let rule = format!("must be inputs with a distribution: {}", known.join(", "));
                BadSetting::new("inputs", format!("{name:?}"), rule)
            })
        };
        Ok([place(&self.inputs[0])?, place(&self.inputs[1])?])
    }
}

/// L of the normal scores of correlated inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Copula {
    factor: Vec<Vec<f64>>,
}

impl Copula {
    /// The copula of a positive definite correlation matrix of the normal scores; `None` if it is none.
    #[must_use]
    pub fn new(correlation: &[Vec<f64>]) -> Option<Self> {
        Some(Self {
            factor: cholesky(correlation).ok()?,
        })
    }

    /// L z: correlated normal scores of independent ones. Shape: `[inputs]`.
    #[must_use]
    pub fn scores(&self, z: &[f64]) -> Vec<f64> {
        let row = |row: &Vec<f64>| row.iter().zip(z).map(|(l, z)| l * z).sum();
        self.factor.iter().map(row).collect()
    }

    /// Correlates independent uniform numbers. Numbers of uncorrelated inputs keep every bit; none is ever 0 or 1.
    ///
    /// Shape: `u` `[inputs]`, in the order of the matrix.
    pub(crate) fn correlate(&self, u: &mut [f64]) {
        let z: Vec<f64> = u.iter().map(|u| normal_quantile(*u)).collect();
        for (i, (u, row)) in u.iter_mut().zip(&self.factor).enumerate() {
            if row[..i].iter().any(|l| *l != 0.0) {
                let score: f64 = row.iter().zip(&z).map(|(l, z)| l * z).sum();
                let end = 0.5 * f64::EPSILON;
                *u = normal_cdf(score).clamp(end, 1.0 - end);
            }
        }
    }
}

/// Unit matrix.
pub(super) fn identity(n: usize) -> Vec<Vec<f64>> {
    (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect()
}

/// Lower factor L of L Lᵀ = `a` with a unit diagonal, or the first row that depends on those above it.
pub(super) fn cholesky(a: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, usize> {
    let n = a.len();
    let mut l = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = a[i][j] - known;
            if i == j {
                if rest.is_nan() || rest < LEAST_PIVOT {
                    return Err(i);
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    Ok(l)
}
