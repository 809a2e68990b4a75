//! The structure of all tests, with known numbers: a free chain of equal masses with springs along x, y and z.
//!
//! Between neighbours k along x, 2k along y, 3k along z. Along each axis one rigid-body mode, and
//! f_j = √(k/m)/π · sin(jπ/2N), j = 1 … N − 1.

use microslip::import::matrix::{Content, Rows};
use microslip::import::symmetric::Symmetric;
use microslip::import::{ImportedMatrix, Reading, read};
use std::path::Path;

use crate::damage::{Reader, message};

/// Masses.
pub(crate) const N: usize = 4;
/// Rows.
pub(crate) const ROWS: usize = 3 * N;
/// Stiffness along x (N/m).
pub(crate) const K: f64 = 1.0e6;
/// One mass (kg).
pub(crate) const M: f64 = 0.25;
/// Numbers of the nodes.
pub(crate) const NODES: [i64; N] = [11, 7, 120, 4];

/// Entry of K; rows are node by node.
pub(crate) fn stiffness(row: usize, column: usize) -> f64 {
    let (i, j) = (row / 3, column / 3);
    let k = K * (1 + row % 3) as f64;
    let ends = f64::from(u8::from(i > 0)) + f64::from(u8::from(i + 1 < N));
    match (row % 3 == column % 3, i.abs_diff(j)) {
        (true, 0) => k * ends,
        (true, 1) => -k,
        _ => 0.0,
    }
}

/// Entry of M.
pub(crate) fn mass(row: usize, column: usize) -> f64 {
    if row == column { M } else { 0.0 }
}

/// Node and component of a row.
pub(crate) fn dof(row: usize) -> (i64, usize) {
    (NODES[row / 3], row % 3 + 1)
}

pub(crate) fn name(row: usize) -> String {
    let (node, component) = dof(row);
    format!("{node}.{component}")
}

/// Flexible frequencies (Hz), ascending.
pub(crate) fn frequencies_hz() -> Vec<f64> {
    let along = |axis: usize| {
        let omega = (K * (1 + axis) as f64 / M).sqrt();
        (1..N).map(move |j| {
            let angle = j as f64 * std::f64::consts::PI / (2.0 * N as f64);
            omega / std::f64::consts::PI * angle.sin()
        })
    };
    let mut all: Vec<f64> = (0..3).flat_map(along).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Entries that are not zero of the lower triangle, column by column.
pub(crate) fn lower(entry: fn(usize, usize) -> f64) -> Vec<(usize, usize, f64)> {
    let places = (0..ROWS).flat_map(|column| (column..ROWS).map(move |row| (row, column)));
    let entries = places.map(|(row, column)| (row, column, entry(row, column)));
    entries.filter(|(.., value)| *value != 0.0).collect()
}

/// Reads models, for damaged files.
pub(crate) const MODELS: Reader = Reader(|name, bytes| message(read_as(name, bytes)));

/// Writes a file, reads it, and gives what was found.
pub(crate) fn read_as(name: &str, text: &[u8]) -> Result<Reading, microslip::file::FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    read(&path)
}

/// Requires that a matrix is that of the chain, whatever the order of its rows.
pub(crate) fn assert_is(matrix: &ImportedMatrix, entry: fn(usize, usize) -> f64, what: &str) {
    let Content::Symmetric(found) = &matrix.content else {
        panic!("{what}: is no matrix");
    };
    assert_eq!(found.n, ROWS, "{what}");
    let order: Vec<usize> = match &matrix.rows {
        Rows::Numbered(n) => (0..*n).collect(),
        Rows::Named(names) => {
            let at = |name: String| (0..ROWS).find(|&row| self::name(row) == name);
            names
                .iter()
                .map(|dof| at(dof.to_string()).unwrap())
                .collect()
        }
    };
    let dense = dense(found);
    for i in 0..ROWS {
        for j in 0..ROWS {
            let expected = entry(order[i], order[j]);
            let difference = (dense[i][j] - expected).abs();
            assert!(
                difference <= 1e-8 * expected.abs(),
                "{what}: ({i}, {j}) = {}, not {expected}",
                dense[i][j]
            );
        }
    }
}

fn dense(matrix: &Symmetric) -> Vec<Vec<f64>> {
    let mut dense = vec![vec![0.0; matrix.n]; matrix.n];
    for &(row, column, value) in &matrix.lower {
        assert!(row >= column, "lower triangle");
        dense[row][column] = value;
        dense[column][row] = value;
    }
    dense
}

/// A number as Fortran writes it: `0.123456789012D+03`.
pub(crate) fn fortran(value: f64, digits: usize, letter: char) -> String {
    let text = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = text.split_once('e').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    let sign = if mantissa.starts_with('-') { "-" } else { "" };
    let plain: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let exponent = if value == 0.0 { 0 } else { exponent + 1 };
    let direction = if exponent < 0 { '-' } else { '+' };
    format!("{sign}0.{plain}{letter}{direction}{:02}", exponent.abs())
}

/// The file itself is the chain.
pub(crate) fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}
