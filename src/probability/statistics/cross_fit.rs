//! What a surrogate says and what it is worth, by samples that did not shape it.
//!
//! The samples are drawn apart into parts. The results of each part are predicted by an expansion fitted to all others, so
//! that every solved sample is held out once: its error is one of prediction, and nothing that was chosen by the samples
//! hides in it. The surrogate's numbers are control variates: the expansion gives the exact or densely sampled value, and
//! the held-out samples what it is wrong by, with an interval. A good surrogate makes that interval narrow, a bad one wide;
//! neither makes it wrong.

use super::bootstrap::Bootstrap;
use super::chaos::{Chaos, ChaosRefusal, ChaosSettings, Effect, Polynomials, fit_chaos};
use super::mean::student;
use super::proportion::{Proportion, proportion};
use super::sensitivity::{Index, mean_and_variance};

/// Samples of a surrogate. Shape: `basis` one entry per input, one row of coordinates
/// ([`Polynomials::coordinate`]) and one result per sample; a result that is not finite is a failed sample.
#[derive(Debug, Clone, Copy)]
pub struct SurrogateSamples<'a> {
    /// Polynomials of each input.
    pub basis: &'a [Polynomials],
    /// Coordinates of the inputs.
    pub inputs: &'a [Vec<f64>],
    /// Results.
    pub results: &'a [f64],
}

/// How samples are held out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoldOutSettings {
    /// Number of parts.
    pub parts: usize,
    /// Samples that shape an expansion at most.
    pub most_fitted: usize,
    /// Seed of the draw.
    pub seed: u64,
}

/// Expansions of all samples and of all but one part.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossFit {
    /// Fitted to all samples: the surrogate's own form, for what reads terms and degree.
    pub whole: Chaos,
    parts: Vec<Chaos>,
    held: Vec<HeldOut>,
    seed: u64,
}

/// A sample and what is said of it by the expansion of the other parts.
#[derive(Debug, Clone, PartialEq)]
struct HeldOut {
    part: usize,
    sample: usize,
    inputs: Vec<f64>,
    /// Not finite for a failed sample.
    result: f64,
    predicted: f64,
}

/// Solver against surrogate at samples that did not shape it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct PredictionError {
    /// Solved samples, each held out once.
    pub samples: usize,
    /// 1 − mean square error / variance; 1 = exact, 0 or less = no better than the mean.
    pub q2: f64,
    /// Root mean square difference, in the unit of the result.
    pub rms: f64,
    /// Largest difference, in the unit of the result.
    pub largest: f64,
}

/// Shares of the result's variance by one input.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SurrogateIndices {
    /// By the input alone.
    pub first: Index,
    /// By the input and all its interactions.
    pub total: Index,
}

/// An exceedance probability by a surrogate and by the samples that it is wrong at.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct SurrogateExceedance {
    /// Threshold.
    pub threshold: f64,
    /// Share of the surrogate's own points above.
    pub surrogate_alone: f64,
    /// Solved samples above the threshold that it puts below.
    pub missed: usize,
    /// Solved samples not above the threshold that it puts above.
    pub false_alarms: usize,
    /// The share corrected by these, with its interval.
    pub probability: Proportion,
}

/// Fits expansions to all samples and to all but one part each.
///
/// # Errors
///
/// Fewer than 2 parts, or whatever [`fit_chaos`] refuses, of all samples or of those that one part leaves.
pub fn cross_fit(
    samples: &SurrogateSamples,
    hold_out: &HoldOutSettings,
    settings: &ChaosSettings,
) -> Result<CrossFit, ChaosRefusal> {
    let (n, parts, seed) = (samples.results.len(), hold_out.parts, hold_out.seed);
    if parts < 2 {
        return Err(ChaosRefusal::Parts);
    }
    let draw = Bootstrap {
        seed,
        replicates: 1,
        confidence: 0.5,
    };
    // drawn, not every k-th: a grid would lose whole planes
    let order = draw.permutation(0, n);
    let fit = |left_out: Option<usize>| {
        let kept = (0..n).filter(|place| left_out.is_none_or(|part| place % parts != part));
        let chosen = kept.take(hold_out.most_fitted).map(|place| order[place]);
        let (inputs, results): (Vec<_>, Vec<_>) = chosen
            .map(|i| (samples.inputs[i].clone(), samples.results[i]))
            .unzip();
        fit_chaos(samples.basis, &inputs, &results, settings)
    };
    let without = |part| {
        fit(Some(part)).map_err(|refusal| match refusal {
            ChaosRefusal::TooFew { valid, needed } => ChaosRefusal::TooFewLeft {
                left: valid,
                parts,
                needed,
                samples: (needed * parts).div_ceil(parts - 1),
            },
            other => other,
        })
    };
    let expansions: Vec<Chaos> = (0..parts).map(without).collect::<Result<_, _>>()?;
    let whole = fit(None)?;
    let held = (0..n).map(|place| {
        let (i, part) = (order[place], place % parts);
        HeldOut {
            part,
            sample: i,
            predicted: expansions[part].predict(&samples.inputs[i]),
            inputs: samples.inputs[i].clone(),
            result: samples.results[i],
        }
    });
    Ok(CrossFit {
        whole,
        held: held.collect(),
        parts: expansions,
        seed,
    })
}

impl CrossFit {
    /// Solved samples.
    fn solved(&self) -> impl Iterator<Item = &HeldOut> + Clone {
        self.held.iter().filter(|held| held.result.is_finite())
    }

    /// Result minus prediction of each solved sample by the expansion of the other parts, with the number of the sample.
    pub fn held_out_errors(&self) -> impl Iterator<Item = (usize, f64)> + Clone {
        self.solved()
            .map(|held| (held.sample, held.result - held.predicted))
    }

    /// Seed of the draw of the parts.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// What the surrogate is worth.
    #[must_use]
    pub fn error(&self) -> PredictionError {
        let errors = || self.solved().map(|held| held.result - held.predicted);
        let (_, variance) = mean_and_variance(self.solved().map(|held| held.result));
        let samples = errors().count();
        let square = errors().map(|e| e * e).sum::<f64>() / samples as f64;
        PredictionError {
            samples,
            q2: 1.0 - square / variance,
            rms: square.sqrt(),
            largest: errors().fold(0.0, |most: f64, e| most.max(e.abs())),
        }
    }

    /// First and total index of each input, of the result and not of the surrogate alone.
    ///
    /// With the surrogate S, its terms M_j of input j (alone, or with all interactions) and the error R of a held-out
    /// sample, the share of input j in the variance of S + R is Var(M_j) + 2 E[M_j R] + (0 to Var(R)) over Var(S) + 2 Cov(S,
    /// R) + Var(R). Var(S) and Var(M_j) are exact, the others means over the samples. The estimate counts the last part as
    /// nobody's, the upper limit as the input's. What few samples do not show of R, in the tails of the inputs, shows in
    /// the scatter of Var(M_j)/Var(S) over the expansions of the parts: a jackknife that widens both limits.
    #[must_use]
    pub fn indices(&self, confidence: f64) -> Vec<SurrogateIndices> {
        let terms: Vec<Terms> = self.solved().map(|held| self.terms(held)).collect();
        let inputs = self.whole.polynomials.len();
        let index = |j: usize, of: fn(&Effect) -> f64| {
            let known = terms.iter().map(|t| (of(&t.inputs[j]), t.variance));
            let all = terms
                .iter()
                .map(|t| (of(&t.inputs[j]) + t.square, t.variance));
            let scatter = self.scatter(|chaos| share(chaos, j, of), confidence);
            let (estimate, below) = ratio(known, confidence);
            let (highest, above) = ratio(all, confidence);
            let limits = [
                estimate,
                estimate - below.hypot(scatter),
                highest + above.hypot(scatter),
            ];
            let [estimate, lower, upper] = limits.map(|v| v.clamp(0.0, 1.0));
            Index::new(estimate, lower, upper)
        };
        (0..inputs)
            .map(|j| SurrogateIndices {
                first: index(j, |e| e.first),
                total: index(j, |e| e.total),
            })
            .collect()
    }

    /// Half the interval of a number of the expansions by their scatter, each lacking one part (delete-a-group jackknife).
    fn scatter(&self, number: impl Fn(&Chaos) -> f64, confidence: f64) -> f64 {
        let n = self.parts.len() as f64;
        let numbers: Vec<f64> = self.parts.iter().map(number).collect();
        let (_, variance) = mean_and_variance(numbers.iter().copied());
        student(n - 1.0, confidence) * ((n - 1.0) * variance).sqrt()
    }

    fn terms(&self, held: &HeldOut) -> Terms {
        let chaos = &self.parts[held.part];
        let error = held.result - held.predicted;
        let parts = chaos.parts(&held.inputs);
        let variances = chaos.variances().into_iter().zip(parts);
        let corrected = |(variance, part): (Effect, Effect)| Effect {
            first: variance.first + 2.0 * part.first * error,
            total: variance.total + 2.0 * part.total * error,
        };
        let square = error * error;
        let about = held.predicted - chaos.mean();
        Terms {
            inputs: variances.map(corrected).collect(),
            square,
            variance: chaos.variance() + 2.0 * about * error + square,
        }
    }

    /// P(result > threshold): share of `points` above by the surrogate, plus the share of the samples above that it puts
    /// below, minus that of those which it puts above and are not.
    ///
    /// Each of the three shares has a Clopper-Pearson interval of a third of the risk, so that the whole holds for any
    /// surrogate, however many samples it is wrong at. Failed samples count as not exceeding for the lower limit and as
    /// exceeding for the upper one. `points` are spread over the expansions of the parts. `None` without points, or with
    /// confidence outside (0, 1).
    #[must_use]
    pub fn exceedance(
        &self,
        points: impl IntoIterator<Item = Vec<f64>>,
        threshold: f64,
        confidence: f64,
    ) -> Option<SurrogateExceedance> {
        let each = 1.0 - (1.0 - confidence) / 3.0;
        let (mut n, mut above) = (0, 0);
        for (place, point) in points.into_iter().enumerate() {
            let chaos = &self.parts[place % self.parts.len()];
            n += 1;
            above += usize::from(chaos.predict(&point) > threshold);
        }
        let alone = proportion(above, n, each)?;
        let solved = |says: bool, is: bool| {
            let differs =
                |h: &&HeldOut| (h.predicted > threshold) == says && (h.result > threshold) == is;
            self.solved().filter(differs).count()
        };
        let (missed, false_alarms) = (solved(false, true), solved(true, false));
        let failed = |says: bool| {
            let failed = self.held.iter().filter(|h| !h.result.is_finite());
            failed.filter(|h| (h.predicted > threshold) == says).count()
        };
        let share = |count: usize| proportion(count, self.held.len(), each);
        let valid = self.solved().count() as f64;
        let correction = (missed as f64 - false_alarms as f64) / valid.max(1.0);
        let lower = alone.lower + share(missed)?.lower - share(false_alarms + failed(true))?.upper;
        let upper = alone.upper + share(missed + failed(false))?.upper - share(false_alarms)?.lower;
        Some(SurrogateExceedance {
            threshold,
            surrogate_alone: alone.estimate,
            missed,
            false_alarms,
            probability: Proportion {
                estimate: (alone.estimate + correction).clamp(0.0, 1.0),
                lower: lower.clamp(0.0, 1.0),
                upper: upper.clamp(0.0, 1.0),
            },
        })
    }
}

/// What one held-out sample says of the variance and of the shares of the inputs.
struct Terms {
    inputs: Vec<Effect>,
    /// Square of the error.
    square: f64,
    variance: f64,
}

/// Share of one input in the variance of an expansion; 0 in a constant one.
fn share(chaos: &Chaos, j: usize, of: fn(&Effect) -> f64) -> f64 {
    match chaos.variance() {
        variance if variance > 0.0 => of(&chaos.variances()[j]) / variance,
        _ => 0.0,
    }
}

/// Ratio of two means and half its interval by linearisation; open where the denominator is not positive.
fn ratio(pairs: impl Iterator<Item = (f64, f64)> + Clone, confidence: f64) -> (f64, f64) {
    let (mut a, mut b, mut n) = (0.0, 0.0, 0.0);
    for (numerator, denominator) in pairs.clone() {
        (a, b, n) = (a + numerator, b + denominator, n + 1.0);
    }
    if b <= 0.0 {
        return (0.0, f64::INFINITY);
    }
    let ratio = a / b;
    let squares: f64 = pairs.map(|(x, y)| (x - ratio * y).powi(2)).sum();
    let error = (squares / (n - 1.0) / n).sqrt() * n / b;
    (ratio, student(n - 1.0, confidence) * error)
}
