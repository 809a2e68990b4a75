//! Sparse polynomial chaos: a surrogate of a result over its inputs.
//!
//! Result ≈ Σ c_α Π_j ψ_{α_j}(input j) with orthonormal polynomials: Legendre over u in (0, 1), Hermite over standard
//! normal z. Terms are picked by orthogonal least squares, their number and the degree by the corrected leave-one-out
//! error, the coefficients follow by QR. That error chose the terms and is therefore no estimate of what the expansion is
//! worth: [`super::cross_fit()`] gives that. Sources: Blatman & Sudret, J. Comput. Phys. 230 (2011)
//! 2345–2367; Sudret, Reliab. Eng. Syst. Saf. 93 (2008) 964–979 (Sobol' indices from the coefficients); Chen, Billings &
//! Luo, Int. J. Control 50 (1989) 1873–1896 (orthogonal least squares).

use super::sensitivity::varies;
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use statrs::distribution::{ContinuousCDF, Normal};

/// Polynomials of one input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Polynomials {
    /// Legendre: the input is a uniform number u in [0, 1].
    Legendre,
    /// Hermite: the input is a standard normal number z.
    Hermite,
}

/// Least distance of a probability from 0 and 1 in the coordinate of Hermite polynomials.
const LEAST_PROBABILITY: f64 = 1e-15;

impl Polynomials {
    /// Polynomials that are orthogonal under an input's law if that is `gaussian`, else under that of its distribution function.
    #[must_use]
    pub fn of_law(gaussian: bool) -> Self {
        match gaussian {
            true => Self::Hermite,
            false => Self::Legendre,
        }
    }

    /// The input's coordinate where its distribution function is `u`, from 0 to 1.
    #[must_use]
    pub fn coordinate(self, u: f64) -> f64 {
        match self {
            Self::Legendre => u,
            Self::Hermite => {
                let u = u.clamp(LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY);
                Normal::standard().inverse_cdf(u)
            }
        }
    }

    /// ψ_0 … ψ_degree at x, orthonormal under the inputs' law.
    pub(super) fn values(self, x: f64, degree: usize) -> Vec<f64> {
        let mut values = vec![1.0; degree + 1];
        let t = match self {
            Self::Legendre => 2.0 * x - 1.0,
            Self::Hermite => x,
        };
        for k in 1..=degree {
            let before = if k == 1 { 0.0 } else { values[k - 2] };
            let n = (k - 1) as f64;
            values[k] = match self {
                Self::Legendre => ((2.0 * n + 1.0) * t * values[k - 1] - n * before) / (n + 1.0),
                Self::Hermite => t * values[k - 1] - n * before,
            };
        }
        let mut factorial = 1.0;
        for (k, value) in values.iter_mut().enumerate() {
            let k = k as f64;
            factorial *= k.max(1.0);
            *value *= match self {
                Self::Legendre => (2.0 * k + 1.0).sqrt(),
                Self::Hermite => 1.0 / f64::sqrt(factorial),
            };
        }
        values
    }

    fn holds(self, x: f64) -> bool {
        match self {
            Self::Legendre => (0.0..=1.0).contains(&x),
            Self::Hermite => x.is_finite(),
        }
    }
}

/// How far a fit looks for terms.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ChaosSettings {
    /// Highest degree tried.
    pub max_degree: usize,
    /// Most inputs in one term.
    pub max_interaction: usize,
    /// q of the hyperbolic norm (Σ α_j^q)^(1/q) ≤ degree, in (0, 1]; below 1 fewer interactions of high degree.
    pub hyperbolic: f64,
    /// A degree with more candidate terms than this is not tried.
    pub max_candidates: usize,
}

impl Default for ChaosSettings {
    fn default() -> Self {
        Self {
            max_degree: 10,
            max_interaction: 3,
            hyperbolic: 0.75,
            max_candidates: 1000,
        }
    }
}

/// One term of an expansion.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Term {
    /// Degree in each input.
    pub degrees: Vec<usize>,
    /// Coefficient, in the unit of the result.
    pub coefficient: f64,
}

/// A fitted expansion.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Chaos {
    /// Polynomials of each input.
    pub polynomials: Vec<Polynomials>,
    /// Terms, the constant one first.
    pub terms: Vec<Term>,
    /// Degree chosen.
    pub degree: usize,
    /// Samples fitted.
    pub valid: usize,
    /// Failed samples: where they lie the expansion extrapolates.
    pub failed: usize,
}

/// What one input does in an expansion: alone, and with all its interactions.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effect {
    /// By the input alone.
    pub first: f64,
    /// By the input and all its interactions.
    pub total: f64,
}

/// Why there is no expansion.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ChaosRefusal {
    /// Too few solved samples.
    #[error("{valid} solved samples are too few, {needed} are needed")]
    TooFew {
        /// Solved samples.
        valid: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The same where a part of the samples is held out of the fit.
    #[error(
        "{left} solved samples are left where one of {parts} parts is held out, {needed} are needed: that takes {samples} solved ones"
    )]
    TooFewLeft {
        /// Solved samples outside the part.
        left: usize,
        /// Number of parts.
        parts: usize,
        /// Samples needed outside the part.
        needed: usize,
        /// Solved samples of which enough are left.
        samples: usize,
    },
    /// The result does not vary.
    #[error("the result does not vary")]
    Constant,
    /// An input outside the domain of the polynomials.
    #[error("input {input} of sample {sample} lies outside the domain of the polynomials")]
    Domain {
        /// Sample, from 0.
        sample: usize,
        /// Input, from 0.
        input: usize,
    },
    /// No degree has few enough terms.
    #[error("no degree has at least one and at most the allowed number of candidate terms")]
    NoCandidates,
    /// Parts to hold out that are fewer than two or more than the solved samples.
    #[error("samples are held out in 2 parts at least")]
    Parts,
}

/// Fewest samples of an expansion.
const FEWEST: usize = 16;

/// Fits an expansion to samples. Shape: `basis` one entry per input, one row of inputs and one result per sample, not
/// finite = failed sample.
///
/// # Errors
///
/// Fewer than 16 solved samples, a result that does not vary, inputs outside the domain, settings without any term.
pub fn fit_chaos(
    basis: &[Polynomials],
    inputs: &[Vec<f64>],
    results: &[f64],
    settings: &ChaosSettings,
) -> Result<Chaos, ChaosRefusal> {
    assert_eq!(inputs.len(), results.len(), "one result per sample");
    let solved: Vec<usize> = (0..results.len())
        .filter(|&i| results[i].is_finite())
        .collect();
    let valid = solved.len();
    if valid < FEWEST {
        return Err(ChaosRefusal::TooFew {
            valid,
            needed: FEWEST,
        });
    }
    for &sample in &solved {
        let mut held = inputs[sample].iter().zip(basis).map(|(&x, b)| b.holds(x));
        if let Some(input) = held.position(|held| !held) {
            return Err(ChaosRefusal::Domain { sample, input });
        }
    }
    let values: Vec<f64> = solved.iter().map(|&i| results[i]).collect();
    if !varies(values.iter().copied()) {
        return Err(ChaosRefusal::Constant);
    }
    let rows: Vec<&[f64]> = solved.iter().map(|&i| inputs[i].as_slice()).collect();
    let (degree, picked) =
        best_degree(basis, &rows, &values, settings).ok_or(ChaosRefusal::NoCandidates)?;
    let columns: Vec<Vec<f64>> = picked
        .terms
        .iter()
        .map(|term| column(&rows, term, basis))
        .collect();
    let coefficients = least_squares(&columns, &values);
    let terms = picked.terms.into_iter().zip(coefficients);
    Ok(Chaos {
        polynomials: basis.to_vec(),
        terms: terms
            .map(|(degrees, coefficient)| Term {
                degrees,
                coefficient,
            })
            .collect(),
        degree,
        valid,
        failed: results.len() - valid,
    })
}

/// Terms picked from the candidates of one degree, with their leave-one-out mean square.
struct Picked {
    terms: Vec<Vec<usize>>,
    error: f64,
}

/// The degree of least error; the search ends after two degrees without gain.
fn best_degree(
    basis: &[Polynomials],
    rows: &[&[f64]],
    values: &[f64],
    settings: &ChaosSettings,
) -> Option<(usize, Picked)> {
    let mut best: Option<(usize, Picked)> = None;
    for degree in 1..=settings.max_degree {
        let candidates = candidates(rows[0].len(), degree, settings);
        if candidates.len() > settings.max_candidates {
            break;
        }
        let picked = pick_terms(rows, values, candidates, basis);
        match &best {
            Some((_, least)) if picked.error >= least.error => {}
            _ => best = Some((degree, picked)),
        }
        if best.as_ref().is_some_and(|(at, _)| degree >= at + 2) {
            break;
        }
    }
    best
}

/// Degrees of all terms within the hyperbolic norm, the constant first.
fn candidates(inputs: usize, degree: usize, settings: &ChaosSettings) -> Vec<Vec<usize>> {
    let q = settings.hyperbolic;
    let budget = (degree as f64).powf(q) * (1.0 + 1e-12);
    let mut found = vec![(Vec::new(), 0.0, 0)];
    for _ in 0..inputs {
        let mut longer = Vec::new();
        for (term, used, active) in &found {
            for k in 0..=degree {
                let (used, active) = (used + (k as f64).powf(q), active + usize::from(k > 0));
                if used > budget || active > settings.max_interaction {
                    break;
                }
                let mut term: Vec<usize> = Vec::clone(term);
                term.push(k);
                longer.push((term, used, active));
            }
        }
        found = longer;
    }
    found.into_iter().map(|(term, ..)| term).collect()
}

/// Values of one term at all rows.
fn column(rows: &[&[f64]], term: &[usize], basis: &[Polynomials]) -> Vec<f64> {
    let factor = |((&x, &k), basis): ((&f64, &usize), &Polynomials)| match k {
        0 => 1.0,
        _ => basis.values(x, k)[k],
    };
    let value = |row: &&[f64]| row.iter().zip(term).zip(basis).map(factor).product();
    rows.iter().map(value).collect()
}

/// Adds the term most correlated with the residual, one at a time; keeps the number of least leave-one-out error.
///
/// With orthonormal columns q of the terms so far, h_i = Σ q_i² and the error is the mean of (r_i / (1 − h_i))², corrected
/// for k terms of n samples by n/(n − k) (1 + k/n) (Chapelle, Vapnik & Bengio, Mach. Learn. 48 (2002) 9–23).
fn pick_terms(
    rows: &[&[f64]],
    values: &[f64],
    candidates: Vec<Vec<usize>>,
    basis: &[Polynomials],
) -> Picked {
    let n = values.len();
    let mut columns: Vec<Vec<f64>> = candidates.iter().map(|t| column(rows, t, basis)).collect();
    let (mut residual, mut leverage) = (values.to_vec(), vec![0.0; n]);
    let (mut order, mut best, mut least) = (Vec::new(), 0, f64::INFINITY);
    let mut next = 0; // the constant
    // More terms than half the samples never generalise; nor do many added without gain.
    while order.len() < n / 2 && order.len() < best + 20 {
        let norm = dot(&columns[next], &columns[next]).sqrt();
        let q: Vec<f64> = columns[next].iter().map(|v| v / norm).collect();
        order.push(next);
        let along = dot(&q, &residual);
        for i in 0..n {
            residual[i] -= along * q[i];
            leverage[i] += q[i] * q[i];
        }
        let error = leave_one_out(&residual, &leverage, order.len());
        if error < least {
            (best, least) = (order.len(), error);
        }
        next = match project_and_pick(&mut columns, &q, &residual, &order) {
            Some(next) => next,
            None => break,
        };
    }
    let terms = order[..best].iter().map(|&i| candidates[i].clone());
    Picked {
        terms: terms.collect(),
        error: least,
    }
}

/// Takes the direction q out of all columns; index of the one then most correlated with the residual.
///
/// `None` when all others lie in the span of those picked.
fn project_and_pick(
    columns: &mut [Vec<f64>],
    q: &[f64],
    residual: &[f64],
    picked: &[usize],
) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (j, column) in columns.iter_mut().enumerate() {
        if picked.contains(&j) {
            continue;
        }
        let along = dot(q, column);
        for (v, q) in column.iter_mut().zip(q) {
            *v -= along * q;
        }
        // Orthonormal polynomials have mean square 1, so this is what rounding and collinearity leave.
        let square = dot(column, column);
        if square < 1e-10 * column.len() as f64 {
            continue;
        }
        let gain = dot(column, residual).powi(2) / square;
        if best.is_none_or(|(_, most)| gain > most) {
            best = Some((j, gain));
        }
    }
    best.map(|(j, _)| j)
}

fn leave_one_out(residual: &[f64], leverage: &[f64], terms: usize) -> f64 {
    let (n, k) = (residual.len() as f64, terms as f64);
    let square = |(r, h): (&f64, &f64)| (r / (1.0 - h).max(1e-12)).powi(2);
    let error = residual.iter().zip(leverage).map(square).sum::<f64>() / n;
    error * n / (n - k) * (1.0 + k / n)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Coefficients of the columns, by QR.
fn least_squares(columns: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
    let matrix = Mat::from_fn(values.len(), columns.len(), |i, j| columns[j][i]);
    let right = Mat::from_fn(values.len(), 1, |i, _| values[i]);
    let solution = matrix.qr().solve_lstsq(right);
    (0..columns.len()).map(|j| solution[(j, 0)]).collect()
}

impl Chaos {
    /// Value of the expansion. Shape: one number per input, in the domain of its polynomials.
    #[must_use]
    pub fn predict(&self, inputs: &[f64]) -> f64 {
        self.values(inputs).iter().sum()
    }

    /// Polynomials of each input up to the highest degree that it has in a term.
    fn powers(&self, inputs: &[f64]) -> Vec<Vec<f64>> {
        let highest = |j: usize| self.terms.iter().map(|t| t.degrees[j]).max().unwrap_or(0);
        let powers = inputs.iter().zip(&self.polynomials).enumerate();
        powers
            .map(|(j, (&x, basis))| basis.values(x, highest(j)))
            .collect()
    }

    /// Value of each term.
    fn values(&self, inputs: &[f64]) -> Vec<f64> {
        let powers = self.powers(inputs);
        let term = |term: &Term| {
            let factors = term.degrees.iter().zip(&powers).map(|(&k, v)| v[k]);
            term.coefficient * factors.product::<f64>()
        };
        self.terms.iter().map(term).collect()
    }

    /// Mean of the expansion under the inputs' law.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let constant = self
            .terms
            .iter()
            .filter(|t| t.degrees.iter().all(|k| *k == 0));
        constant.map(|t| t.coefficient).sum()
    }

    /// Variance of the expansion under the inputs' law.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let varying = self
            .terms
            .iter()
            .filter(|t| t.degrees.iter().any(|k| *k > 0));
        varying.map(|t| t.coefficient.powi(2)).sum()
    }

    /// Variance by each input, read from the coefficients.
    #[must_use]
    pub fn variances(&self) -> Vec<Effect> {
        self.effects(|i| self.terms[i].coefficient.powi(2))
    }

    /// Value of the terms with each input at a point.
    #[must_use]
    pub fn parts(&self, inputs: &[f64]) -> Vec<Effect> {
        let values = self.values(inputs);
        self.effects(|i| values[i])
    }

    /// Sums of a number of each term, per input.
    fn effects(&self, number: impl Fn(usize) -> f64) -> Vec<Effect> {
        let mut effects = vec![Effect::default(); self.polynomials.len()];
        for (i, term) in self.terms.iter().enumerate() {
            let active = term.degrees.iter().filter(|k| **k > 0).count();
            for (effect, k) in effects.iter_mut().zip(&term.degrees) {
                if *k > 0 {
                    effect.total += number(i);
                    effect.first += if active == 1 { number(i) } else { 0.0 };
                }
            }
        }
        effects
    }
}
