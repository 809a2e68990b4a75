//! Properties that the matrices of a structure must have.

use faer::linalg::cholesky::llt::factor::LltError;
use faer::{Mat, Side, c64};

/// Largest asymmetry accepted as round-off, relative to the largest entry.
const SYMMETRY_TOLERANCE: f64 = 1e-8;
/// Most negative eigenvalue accepted as round-off, of a matrix with unit diagonal.
pub const SEMIDEFINITE_TOLERANCE: f64 = 1e-9;
/// From so many significant digits on, the numbers of a file count as rounded to these.
const FEWEST_DIGITS: u32 = 6;
/// Factorisations that enclose a negative eigenvalue for its message.
const HALVINGS: usize = 10;
/// Least eigenvalue that counts as positive, of a matrix with unit diagonal.
const DEFINITE_TOLERANCE: f64 = 1e-12;

/// (A + Aᵀ)/2, if A is symmetric up to round-off.
///
/// # Errors
/// The rule that A breaks.
pub fn symmetric(a: &Mat<f64>) -> Result<Mat<f64>, String> {
    let n = a.nrows();
    let mut largest = 0.0_f64;
    let mut worst = (0.0_f64, 0, 0);
    for j in 0..n {
        for i in 0..n {
            largest = largest.max(a[(i, j)].abs());
            let difference = (a[(i, j)] - a[(j, i)]).abs();
            if difference > worst.0 {
                worst = (difference, i.max(j), i.min(j));
            }
        }
    }
    let (difference, i, j) = worst;
    if difference > SYMMETRY_TOLERANCE * largest {
        return Err(format!(
            "must be symmetric: entries ({0}, {1}) = {2} and ({1}, {0}) = {3} differ",
            i + 1,
            j + 1,
            a[(i, j)],
            a[(j, i)]
        ));
    }
    Ok(Mat::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] + a[(j, i)])))
}

/// # Errors
/// The rule, unless A is positive semidefinite up to round-off and to the rounding of its file, which states numbers with so
/// many `digits`.
pub fn positive_semidefinite(a: &Mat<f64>, digits: u32) -> Result<(), String> {
    let (scaled, largest) = unit_diagonal(a);
    semidefinite(|shift| cholesky(&scaled, shift).is_ok(), largest, digits)
}

/// The same of a matrix scaled to a unit diagonal, of which only two things are known: whether it is definite with a shift of
/// its diagonal, and the `largest` sum of absolute values in a row.
pub fn semidefinite(
    definite_with: impl Fn(f64) -> bool,
    largest: f64,
    digits: u32,
) -> Result<(), String> {
    let tolerance = SEMIDEFINITE_TOLERANCE + rounding(digits) * largest;
    if definite_with(tolerance) {
        return Ok(());
    }
    let eigenvalue = -most_negative(definite_with, tolerance, largest);
    not_negative(eigenvalue, tolerance, digits)
}

/// # Errors
/// The rule, if an `eigenvalue` of a matrix with unit diagonal is below `-tolerance`, which follows from the `digits`.
pub fn not_negative(eigenvalue: f64, tolerance: f64, digits: u32) -> Result<(), String> {
    if eigenvalue >= -tolerance {
        return Ok(());
    }
    let ratio = -eigenvalue / tolerance;
    let why = match digits {
        0..FEWEST_DIGITS => format!(
            "and its numbers, of {digits} digits, are taken as exact, since they have fewer than {FEWEST_DIGITS}: a sign or an entry is \
             wrong, or they are rounded and the file must state more digits"
        ),
        _ => format!(
            "{ratio:.1e} times what rounding to {digits} digits allows: a sign or an entry is wrong, or the numbers need more \
             digits (ANSYS: *SMAT has 16, *DMAT 9)"
        ),
    };
    Err(format!(
        "must be positive semidefinite, but scaled to a unit diagonal it has the negative eigenvalue {eigenvalue:.1e}, {why}"
    ))
}

/// # Errors
/// The rule, unless A is positive definite.
pub fn positive_definite(a: &Mat<f64>) -> Result<(), String> {
    if let Some(i) = (0..a.nrows()).find(|&i| a[(i, i)] <= 0.0) {
        let value = a[(i, i)];
        return Err(format!(
            "must be positive definite, but diagonal entry {} is {value}",
            i + 1
        ));
    }
    match dependent_row(a) {
        None => Ok(()),
        Some(row) => Err(format!(
            "must be positive definite, but has an eigenvalue that is zero or negative: row {} is a combination of rows before it",
            row + 1
        )),
    }
}

/// The first row (from 0) up to which A is not positive definite.
pub fn dependent_row(a: &Mat<f64>) -> Option<usize> {
    let (scaled, _) = unit_diagonal(a);
    let LltError::NonPositivePivot { index } = cholesky(&scaled, -DEFINITE_TOLERANCE).err()?;
    Some(index)
}

/// The first row (from 0) up to which a Hermitian A is not positive definite.
pub fn dependent_wave_row(a: &Mat<c64>) -> Option<usize> {
    let n = a.nrows();
    let size = |i: usize| a[(i, i)].re.abs().max(f64::MIN_POSITIVE).sqrt();
    let scaled = Mat::from_fn(n, n, |i, j| match i == j {
        true if a[(i, i)].re > 0.0 => c64::new(1.0 - DEFINITE_TOLERANCE, 0.0),
        true => c64::new(0.0, 0.0),
        false => a[(i, j)] / (size(i) * size(j)),
    });
    let LltError::NonPositivePivot { index } = scaled.llt(Side::Lower).err()?;
    Some(index)
}

/// Largest relative error of a number that was rounded to so many digits. Numbers with few digits are taken as exact: people
/// write them, not programs.
pub fn rounding(digits: u32) -> f64 {
    match digits {
        0..FEWEST_DIGITS => 0.0,
        _ => 0.5 * 0.1_f64.powi(digits.min(18) as i32 - 1),
    }
}

/// D^(−1/2) A D^(−1/2), D = |diag A|, and its largest sum of absolute values in a row.
///
/// The scaling makes what follows independent of the units of the degrees of freedom. Errors of the entries that are at most
/// a share of them move the eigenvalues by at most that share of the sum (Weyl's inequality).
fn unit_diagonal(a: &Mat<f64>) -> (Mat<f64>, f64) {
    let n = a.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| match a[(i, i)].abs() {
            0.0 => 1.0,
            d => d.sqrt(),
        })
        .collect();
    let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] / (scale[i] * scale[j]));
    let sum = |j: usize| (0..n).map(|i| scaled[(i, j)].abs()).sum();
    let largest = (0..n).map(sum).fold(0.0, f64::max);
    (scaled, largest)
}

/// Whether A + shift has a Cholesky factor; else the first row that has none.
fn cholesky(a: &Mat<f64>, shift: f64) -> Result<(), LltError> {
    let mut shifted = a.clone();
    for i in 0..a.nrows() {
        shifted[(i, i)] += shift;
    }
    shifted.llt(Side::Lower).map(|_| ())
}

/// Size of the most negative eigenvalue, which is between the two bounds, to about two digits.
fn most_negative(definite_with: impl Fn(f64) -> bool, mut below: f64, above: f64) -> f64 {
    let mut above = above.max(2.0 * below);
    for _ in 0..HALVINGS {
        let middle = (below * above).sqrt();
        match definite_with(middle) {
            true => above = middle,
            false => below = middle,
        }
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Springs 1 and k between three masses, no support: λ = 0 is semidefinite, also with k = 1e12; a spring of −0.01
    /// to the ground is not.
    ///
    /// Seen to fail with a tolerance of 1e-3.
    #[test]
    fn definiteness_at_its_edge() {
        let chain = |k: f64, ground: f64| {
            let rows = [[1.0 + ground, -1.0, 0.0], [-1.0, 1.0 + k, -k], [0.0, -k, k]];
            Mat::from_fn(3, 3, |i, j| rows[i][j])
        };
        assert!(positive_semidefinite(&chain(1e12, 0.0), 17).is_ok());
        assert!(positive_semidefinite(&chain(100.0, -0.01), 3).is_err());
        assert!(positive_semidefinite(&Mat::zeros(2, 2), 1).is_ok());
        assert!(positive_definite(&Mat::identity(4, 4)).is_ok());
        let singular = Mat::from_fn(2, 2, |_, _| 1.0);
        let message = positive_definite(&singular).unwrap_err();
        assert!(message.contains("row 2 is a combination"), "{message}");
        assert!(positive_semidefinite(&singular, 1).is_ok());
    }

    /// A free chain of unequal springs, as a file with nine digits states it, has an eigenvalue of some -1e-9 by rounding; the
    /// same numbers with more digits have not, and with as many digits stated as there are it is a fault.
    ///
    /// Seen to fail with one tolerance for all files: "must be positive semidefinite, but has a negative eigenvalue".
    #[test]
    fn the_tolerance_follows_the_digits_of_the_file() {
        let n = 12;
        let spring = |i: usize| 1e7 / (3.0 + 0.7 * i as f64);
        let full = Mat::from_fn(n, n, |i, j| {
            let before = if i > 0 { spring(i) } else { 0.0 };
            let after = if i + 1 < n { spring(i + 1) } else { 0.0 };
            match i.abs_diff(j) {
                0 => before + after,
                1 => -spring(i.max(j)),
                _ => 0.0,
            }
        });
        let rounded = Mat::from_fn(n, n, |i, j| {
            let down = if i == j { 1.0 - 4e-9 } else { 1.0 };
            down * full[(i, j)]
        });
        assert!(positive_semidefinite(&full, 17).is_ok());
        assert!(positive_semidefinite(&rounded, 9).is_ok());
        let message = positive_semidefinite(&rounded, 16).unwrap_err();
        let expected = "the negative eigenvalue -4.0e-9, 4.0e0 times what rounding to 16 digits";
        assert!(message.contains(expected), "{message}");
    }
}
