//! Whether the rows of a table may be independent draws, as indices by ranks presume: neighbours in one column must be random in
//! the others.

use super::bootstrap::Bootstrap;
use super::sensitivity::{SensitivityRefusal, mean_and_variance};

/// Standard errors beyond which a table is none of independent rows.
const SURE: f64 = 4.0;
/// Least variance of the terms of a mean of squared differences, neighbours included: that of independent uniform ranks, γ₀ + 2 γ₁ =
/// 1.4 + 2 · 0.2.
const LEAST_SPREAD: f64 = 1.8;

/// Refuses rows that are visibly no independent draws, for a table of `columns` of equal length. Columns may depend on each other.
///
/// Rows in ascending order of one column, the other column as ranks r of variance s²: half the mean square difference of neighbours
/// over s² is 1 for independent columns and less for others. In a sequence of quasi-random points neighbours are
/// regularly far apart, and it is more. Rows that share a value of one column share one of another by chance alone, but for designs
/// that mix rows (Saltelli, Morris) and chains that repeat them.
///
/// What passes may still depend: of 200 Sobol' points every other table is told, of 500 all.
///
/// # Errors
///
/// [`SensitivityRefusal::RepeatedRows`], [`SensitivityRefusal::RegularRows`].
pub fn independent_rows(columns: &[Vec<f64>], seed: u64) -> Result<(), SensitivityRefusal> {
    let ranks: Vec<Ranks> = columns.iter().map(|column| Ranks::of(column)).collect();
    for (j, column) in columns.iter().enumerate() {
        if ranks[j].variance == 0.0 {
            continue;
        }
        let order = in_order(column, seed);
        let others = (0..columns.len()).filter(|&k| k != j && ranks[k].variance > 0.0);
        for k in others {
            if repeats(column, &columns[k], &ranks[k], &order) {
                return Err(SensitivityRefusal::RepeatedRows);
            }
            if is_regular(&ranks[k], &order) {
                return Err(SensitivityRefusal::RegularRows);
            }
        }
    }
    Ok(())
}

/// Ranks of the values of a column, equal values with their mean rank.
struct Ranks {
    ranks: Vec<f64>,
    variance: f64,
    /// Probability that two rows have the same value.
    equal: f64,
}

impl Ranks {
    fn of(column: &[f64]) -> Self {
        let n = column.len();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_unstable_by(|&a, &b| column[a].total_cmp(&column[b]));
        let (mut ranks, mut equal) = (vec![0.0; n], 0.0);
        let mut below = 0;
        for tied in order.chunk_by(|&a, &b| column[a] == column[b]) {
            let rank = below as f64 + 0.5 * (tied.len() as f64 - 1.0);
            tied.iter().for_each(|&i| ranks[i] = rank);
            equal += (tied.len() as f64 / n as f64).powi(2);
            below += tied.len();
        }
        let (_, variance) = mean_and_variance(ranks.iter().copied());
        Self {
            ranks,
            variance,
            equal,
        }
    }
}

/// Rows in ascending order of a column, those of the same value in random order.
fn in_order(column: &[f64], seed: u64) -> Vec<usize> {
    let draw = Bootstrap {
        seed,
        replicates: 1,
        confidence: 0.95,
    };
    let random = draw.permutation(0, column.len());
    let mut order: Vec<usize> = (0..column.len()).collect();
    order.sort_unstable_by(|&a, &b| {
        let by_value = column[a].total_cmp(&column[b]);
        by_value.then(random[a].cmp(&random[b]))
    });
    order
}

/// Whether neighbours with the same value of `column` have the same value of `other` more often than by chance.
fn repeats(column: &[f64], other: &[f64], ranks: &Ranks, order: &[usize]) -> bool {
    let tied = order.windows(2).filter(|w| column[w[0]] == column[w[1]]);
    let (mut ties, mut both) = (0.0, 0.0);
    for pair in tied {
        ties += 1.0;
        both += f64::from(u8::from(other[pair[0]] == other[pair[1]]));
    }
    let expected = ties * ranks.equal;
    both > expected + SURE * (expected * (1.0 - ranks.equal)).sqrt() + SURE
}

/// Whether neighbours are farther apart in another column than independent rows are.
fn is_regular(other: &Ranks, order: &[usize]) -> bool {
    let squares: Vec<f64> = (order.windows(2))
        .map(|w| (other.ranks[w[1]] - other.ranks[w[0]]).powi(2) / (2.0 * other.variance))
        .collect();
    let n = squares.len() as f64;
    let (mean, variance) = mean_and_variance(squares.iter().copied());
    let products = squares.windows(2).map(|w| (w[0] - mean) * (w[1] - mean));
    let spread = variance + 2.0 * products.sum::<f64>() / n;
    mean - 1.0 > SURE * (spread.max(LEAST_SPREAD) / n).sqrt()
}
