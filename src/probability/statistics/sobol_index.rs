//! Sobol' indices by pick-freeze: evaluations in which all inputs but one are drawn anew, or only one.
//!
//! Row i of a design takes d + 2 evaluations: at A_i, at B_i, and for each input j at A_i with column j of B_i. A and B
//! must be independent of each other, as the halves of ONE sequence of 2d columns are (`sampling::pick_freeze`); two blocks
//! of rows of one d-dimensional low-discrepancy sequence are not and give indices that are plainly wrong.

use super::bootstrap::Bootstrap;
use super::sensitivity::{
    Index, SensitivityRefusal, all_solved, mean_and_variance, usable, varies,
};

/// Fewest rows of a design that intervals can be resampled from.
const FEWEST_ROWS: usize = 64;
/// The resampled interval is widened by this many n-ths of n rows: measured (`cargo bench --bench coverage`).
const SMALL_SAMPLE: f64 = 8.0;

/// First and total index of one input.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct SobolIndex {
    /// Share of the variance by the input alone (Janon et al., ESAIM: Probab. Stat. 18 (2014) 342–364).
    pub first: Index,
    /// Share by the input and all its interactions (Jansen, Comput. Phys. Commun. 117 (1999) 35–43).
    pub total: Index,
}

/// First and total indices, one per input, with bootstrap intervals over the rows of the design, widened for few rows.
///
/// Shape: `results` row after row, each at A, at B, then at A with column 0, 1, … of B, for d = `inputs` columns. With
/// points of a low-discrepancy sequence the interval is wider than the true error; [`super::moment_estimate`] of the estimates of several independently
/// scrambled sequences gives one that is not.
///
/// # Errors
///
/// A single failed evaluation (not finite) refuses all indices; so do results that do not vary, fewer than 64 rows (with
/// 16 the interval of a total index covers 76 % instead of 95 %), and settings that give no interval.
pub fn sobol_indices(
    results: &[f64],
    inputs: usize,
    bootstrap: &Bootstrap,
) -> Result<Vec<SobolIndex>, SensitivityRefusal> {
    let (found, multiple) = (results.len(), inputs + 2);
    if inputs == 0 || found % multiple != 0 {
        return Err(SensitivityRefusal::Shape { found, multiple });
    }
    usable(bootstrap)?;
    all_solved(results, FEWEST_ROWS * multiple)?;
    // About the mean, products of results keep their digits.
    let (mean, _) = mean_and_variance(results.iter().copied());
    if !varies(results.iter().copied()) {
        return Err(SensitivityRefusal::Constant);
    }
    let centred: Vec<f64> = results.iter().map(|y| y - mean).collect();
    let rows: Vec<&[f64]> = centred.chunks_exact(multiple).collect();
    let whole: Vec<usize> = (0..rows.len()).collect();
    let resamples: Vec<Vec<usize>> = (0..bootstrap.replicates)
        .map(|r| bootstrap.resample(r, rows.len()))
        .collect();
    let index = |estimator: fn(&[&[f64]], &[usize], usize) -> f64, j: usize| {
        let replicate = |r: u32| estimator(&rows, &resamples[r as usize], j);
        let interval = bootstrap.percentiles(replicate);
        let (lower, upper) = interval.ok_or(SensitivityRefusal::Constant)?;
        let estimate = estimator(&rows, &whole, j);
        let wider = 1.0 + SMALL_SAMPLE / rows.len() as f64;
        let from = |limit: f64| estimate + wider * (limit - estimate);
        Ok(Index::new(estimate, from(lower), from(upper)))
    };
    (0..inputs)
        .map(|j| {
            Ok(SobolIndex {
                first: index(janon, j)?,
                total: index(jansen, j)?,
            })
        })
        .collect()
}

/// Covariance over variance of the results at B and at A with column j of B, both estimated from both.
fn janon(rows: &[&[f64]], chosen: &[usize], j: usize) -> f64 {
    let n = chosen.len() as f64;
    let (mut product, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for &i in chosen {
        let (b, mixed) = (rows[i][1], rows[i][2 + j]);
        product += b * mixed;
        sum += (b + mixed) / 2.0;
        squares += (b * b + mixed * mixed) / 2.0;
    }
    let mean = sum / n;
    (product / n - mean * mean) / (squares / n - mean * mean)
}

/// Half the mean square of what column j changes at A, over the variance at A and B.
fn jansen(rows: &[&[f64]], chosen: &[usize], j: usize) -> f64 {
    let n = chosen.len() as f64;
    let (mut change, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for &i in chosen {
        let (a, b, mixed) = (rows[i][0], rows[i][1], rows[i][2 + j]);
        change += (a - mixed).powi(2) / 2.0;
        sum += (a + b) / 2.0;
        squares += (a * a + b * b) / 2.0;
    }
    let mean = sum / n;
    change / n / (squares / n - mean * mean)
}
