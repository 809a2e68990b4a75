//! Whether the rows of a table may be independent draws, as indices by ranks presume: neighbours in one column must be random in
//! the others.

use super::distribution::centred_ranks;
use super::given_data::ascending;
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
    let columns: Vec<Column> = (columns.iter())
        .map(|values| Column::new(values, seed))
        .filter(|column| column.variance > 0.0)
        .collect();
    for (j, column) in columns.iter().enumerate() {
        let others = columns.iter().enumerate().filter(|(k, _)| *k != j);
        for (_, other) in others {
            if column.repeats(other) {
                return Err(SensitivityRefusal::RepeatedRows);
            }
            if column.is_regular(other) {
                return Err(SensitivityRefusal::RegularRows);
            }
        }
    }
    Ok(())
}

/// A column of the table.
struct Column<'a> {
    values: &'a [f64],
    /// Rows in ascending order, those of the same value in random order.
    order: Vec<usize>,
    /// Ranks less their mean, and their variance.
    ranks: Vec<f64>,
    variance: f64,
    /// Probability that two rows have the same value.
    equal: f64,
}

impl<'a> Column<'a> {
    fn new(values: &'a [f64], seed: u64) -> Self {
        let order = ascending(values, seed);
        let ranks = centred_ranks(values);
        let (_, variance) = mean_and_variance(ranks.iter().copied());
        let ties = order.chunk_by(|&a, &b| values[a] == values[b]);
        let equal = ties.map(|tie| (tie.len() as f64 / values.len() as f64).powi(2));
        Self {
            values,
            equal: equal.sum(),
            order,
            ranks,
            variance,
        }
    }

    /// Whether neighbours with the same value have the same value of `other`, too, more often than by chance.
    fn repeats(&self, other: &Self) -> bool {
        let is_same = |of: &Self, pair: &[usize]| of.values[pair[0]] == of.values[pair[1]];
        let tied: Vec<_> = (self.order.windows(2))
            .filter(|pair| is_same(self, pair))
            .collect();
        let both = tied.iter().filter(|pair| is_same(other, pair)).count() as f64;
        let expected = tied.len() as f64 * other.equal;
        both > expected + SURE * (expected * (1.0 - other.equal)).sqrt() + SURE
    }

    /// Whether neighbours are farther apart in `other` than in independent rows.
    fn is_regular(&self, other: &Self) -> bool {
        let squares: Vec<f64> = (self.order.windows(2))
            .map(|w| (other.ranks[w[1]] - other.ranks[w[0]]).powi(2) / (2.0 * other.variance))
            .collect();
        let n = squares.len() as f64;
        let (mean, variance) = mean_and_variance(squares.iter().copied());
        let products = squares.windows(2).map(|w| (w[0] - mean) * (w[1] - mean));
        let spread = variance + 2.0 * products.sum::<f64>() / n;
        mean - 1.0 > SURE * (spread.max(LEAST_SPREAD) / n).sqrt()
    }
}
