//! Matrix Market files: the dense or sparse real matrices that a user brings.

use std::path::Path;

use faer::Mat;
use nalgebra_sparse::CooMatrix;
use nalgebra_sparse::io::{
    MatrixMarketError, MatrixMarketErrorKind, load_coo_from_matrix_market_str,
};

use super::matrices::MatricesError;

/// Largest number of rows or columns: a dense matrix of this size takes 3.2 GB.
const LARGEST: usize = 20_000;

/// Reads a real or integer matrix, `coordinate` or `array`, `general` or `symmetric` (lower triangle stored).
///
/// Entries given twice are added. Comment lines may stand between header and size line only.
///
/// # Errors
/// [`MatricesError::File`] if it cannot be read, [`MatricesError::Matrix`] on anything but such a matrix.
pub(super) fn read_matrix(path: &Path) -> Result<Mat<f64>, MatricesError> {
    let text = std::fs::read_to_string(path).map_err(|source| MatricesError::File {
        path: path.to_owned(),
        source,
    })?;
    check_size_line(&text).map_err(|(line, rule)| MatricesError::matrix(path, Some(line), rule))?;
    let coordinates: CooMatrix<f64> =
        load_coo_from_matrix_market_str(&as_real(text)).map_err(|error| {
            let (line, rule) = explain(&error);
            MatricesError::matrix(path, line, rule)
        })?;
    let mut matrix = Mat::zeros(coordinates.nrows(), coordinates.ncols());
    for (i, j, value) in coordinates.triplet_iter() {
        if !value.is_finite() {
            let rule = format!(
                "entry ({}, {}) = {value}: must be a finite number",
                i + 1,
                j + 1
            );
            return Err(MatricesError::matrix(path, None, rule));
        }
        matrix[(i, j)] += value;
    }
    Ok(matrix)
}

/// An `integer` matrix under a `real` header: the library reads integers into integer types only.
fn as_real(text: String) -> String {
    let header = text.lines().next().unwrap_or_default().to_ascii_lowercase();
    if !header.contains(" integer ") {
        return text;
    }
    let values = &text[header.len()..];
    format!("{}{values}", header.replace(" integer ", " real "))
}

/// Refuses sizes that the reader's own arithmetic could not hold, before it sees them.
fn check_size_line(text: &str) -> Result<(), (usize, String)> {
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    match lines.next() {
        Some((_, header))
            if header
                .to_ascii_lowercase()
                .starts_with("%%matrixmarket matrix") => {}
        Some((i, _)) => return Err((i + 1, HEADER_RULE.to_owned())),
        None => return Err((1, "the file is empty".to_owned())),
    }
    let Some((i, size)) = lines.find(|(_, line)| !line.trim_start().starts_with('%')) else {
        return Err((1, "the size line is missing".to_owned()));
    };
    for word in size.split_whitespace().take(2) {
        let rows: usize = word.parse().unwrap_or(usize::MAX);
        if rows == 0 || rows > LARGEST {
            return Err((
                i + 1,
                format!("size {word}: must be an integer from 1 to {LARGEST}"),
            ));
        }
    }
    Ok(())
}

const HEADER_RULE: &str = "must start with a Matrix Market header such as \
    `%%MatrixMarket matrix coordinate real symmetric`";

/// Line, where known, and one plain sentence for what the library's reader refuses.
fn explain(error: &MatrixMarketError) -> (Option<usize>, String) {
    let line = error
        .message()
        .split_once("--> ")
        .and_then(|(_, place)| place.split(':').next()?.trim().parse().ok());
    let rule = match error.kind() {
        MatrixMarketErrorKind::ParsingError if line == Some(1) => HEADER_RULE.to_owned(),
        MatrixMarketErrorKind::ParsingError => {
            "is not a line of a Matrix Market file (row column value, \
             or one value in array format)"
                .to_owned()
        }
        MatrixMarketErrorKind::TypeMismatch => "must be a real or integer matrix".to_owned(),
        MatrixMarketErrorKind::ZeroError => "indices must start at 1".to_owned(),
        MatrixMarketErrorKind::SparseFormatError(_) => {
            "an index is beyond the size that the size line states".to_owned()
        }
        MatrixMarketErrorKind::NotLowerTriangle => {
            "a symmetric matrix must store its lower triangle (row >= column) only".to_owned()
        }
        MatrixMarketErrorKind::NonSquare => "a symmetric matrix must be square".to_owned(),
        _ => error
            .message()
            .lines()
            .next()
            .unwrap_or("cannot be read")
            .to_owned(),
    };
    (line, rule)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Mat<f64>, MatricesError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mtx");
        std::fs::write(&path, text).unwrap();
        read_matrix(&path)
    }

    /// Seen to fail with `=` instead of `+=` for the entry.
    #[test]
    fn every_storage_of_one_matrix_reads_the_same() {
        let storages = [
            "%%MatrixMarket matrix array real general\n2 2\n4\n-1\n-1\n3.5\n",
            "%%MatrixMarket matrix array real symmetric\n% comment\n2 2\n4\n-1\n3.5\n",
            "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 4\n2 1 -1.0e0\n2 2 3.5\n",
            "%%matrixmarket matrix coordinate real general\n2 2 5\n1 1 4\n2 1 -1\n1 2 -1\n2 2 3\n2 2 .5\n",
            "%%MatrixMarket matrix coordinate INTEGER symmetric\n2 2 4\n1 1 4\n2 1 -1\n2 2 3\n2 2 0.5\n",
            "%%MatrixMarket matrix array real general\r\n2 2\r\n4\r\n-1\r\n-1\r\n3.5\r\n",
        ];
        for text in storages {
            let a = read(text).unwrap();
            let entries = [a[(0, 0)], a[(1, 0)], a[(0, 1)], a[(1, 1)]];
            assert_eq!(entries, [4.0, -1.0, -1.0, 3.5], "{text}");
        }
    }

    #[test]
    fn what_is_no_real_matrix_is_refused_without_panic() {
        let header = "%%MatrixMarket matrix coordinate real general";
        let sizes = [
            "2 2",
            "2 2 1",
            "2 2 1\n3 1 1.0",
            "2 2 1\n1 1",
            "0 0 0",
            "-1 2 1",
            "2 2 1\n1 1 1e",
            "a b c",
        ];
        for size in sizes {
            assert!(read(&format!("{header}\n{size}\n")).is_err(), "{size}");
        }
        assert!(read("%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n").is_err());
        assert!(read("%%MatrixMarket vector array real general\n1\n1\n").is_err());
    }
}
