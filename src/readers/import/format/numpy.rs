//! NumPy: arrays of `save` (`.npy`), `savez` (`.npz` with K, M, C, R, F, F0) and SciPy's `save_npz` (a sparse matrix).
//!
//! Format: numpy.lib.format. Its header is a dictionary of three keys; the crate that reads it brings a parser generator and
//! a library for stacks of its own, so it is read here. The archive is read by the crate `zip`.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use super::super::lines::MOST_ROWS;
use super::super::matrix::{DOUBLE_DIGITS, ImportedMatrix, SINGLE_DIGITS};
use super::arrays::{MOST_NUMBERS, dense, of_model};
use crate::file::binary::{Kind, number};
use crate::file::compressed_rows::expanded;
use crate::file::{FileError, parquet::without_panic};

/// How a file of one array begins.
const MAGIC: &[u8] = b"\x93NUMPY";
/// How an archive begins.
const ARCHIVE: &[u8] = b"PK\x03\x04";
/// Bytes of the header of an array at most.
const LONGEST_HEADER: usize = 10_000;
/// Bytes of all arrays of an archive at most, without compression.
const MOST_BYTES: u64 = 512 << 20;
/// Arrays of an archive at most.
const MOST_ARRAYS: usize = 100;

/// The rule of a file with nothing of a model.
const NONE: &str = "has no square matrix and no vector";

/// Whether the bytes begin as such a file.
pub(in crate::import) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || bytes.starts_with(ARCHIVE)
}

/// Reads all matrices and vectors.
pub(in crate::import) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<ImportedMatrix>, FileError> {
    let fault = |rule: String| FileError::content(path, None, rule);
    let mut arrays = match bytes.starts_with(MAGIC) {
        true => BTreeMap::from([(String::new(), Array::read(bytes).map_err(fault)?)]),
        false => {
            // the library may panic on a damaged file
            let damaged = || Err("is damaged: the ZIP library cannot read it".to_owned());
            let found = without_panic(|| archive(bytes, MOST_BYTES)).unwrap_or_else(damaged);
            found.map_err(fault)?
        }
    };
    if let Some(format) = arrays.remove("format") {
        return Ok(vec![sparse(path, &format, &arrays)?]);
    }
    let mut found = Vec::new();
    for (name, array) in arrays {
        let rule = match name.as_str() {
            "" => NONE,
            _ => {
                "must be a square matrix or a vector of real numbers (a sparse one: scipy.sparse.save_npz)"
            }
        };
        let matrix = array.matrix(path, name.clone());
        let matrix = matrix.and_then(|matrix| matrix.ok_or_else(|| fault(rule.to_owned())));
        found.extend(of_model(&name, matrix)?);
    }
    match found.is_empty() {
        true => Err(fault(NONE.to_owned())),
        false => Ok(found),
    }
}

/// Arrays by their names; together they have `most` bytes at most.
fn archive(bytes: &[u8], most: u64) -> Result<BTreeMap<String, Array>, String> {
    let damaged = |error: zip::result::ZipError| format!("is no ZIP archive of arrays: {error}");
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    if archive.len() > MOST_ARRAYS {
        return Err(format!("has more than {MOST_ARRAYS} arrays"));
    }
    let mut arrays = BTreeMap::new();
    let mut left = most;
    for at in 0..archive.len() {
        let file = archive.by_index(at).map_err(damaged)?;
        let name = file.name().map_err(damaged)?.into_owned();
        let Some(name) = name.strip_suffix(".npy") else {
            continue;
        };
        let mut content = Vec::new();
        let read = file.take(left + 1).read_to_end(&mut content);
        read.map_err(|error| format!("array {name:.40}: {error}"))?;
        let rest = left.checked_sub(content.len() as u64);
        left = rest.ok_or_else(|| format!("holds more than {} MiB", most >> 20))?;
        let array = Array::read(&content).map_err(|rule| format!("array {name:.40}: {rule}"))?;
        if arrays.insert(name.to_owned(), array).is_some() {
            return Err(format!("array {name:.40}: must be there once"));
        }
    }
    Ok(arrays)
}

/// An array as it is stored.
struct Array {
    shape: Vec<usize>,
    fortran: bool,
    numbers: ArrayNumbers,
}

enum ArrayNumbers {
    Real {
        values: Vec<f64>,
        digits: u32,
    },
    Text(String),
    Complex,
    /// Of a kind that is not read.
    Other,
}

impl Array {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let short = || "is no NumPy array, or ends early".to_owned();
        let version = bytes.strip_prefix(MAGIC).and_then(|rest| rest.first());
        let (length, start) = match (version, bytes.get(8..12)) {
            (Some(1), Some(n)) => (usize::from(n[0]) | usize::from(n[1]) << 8, 10),
            (Some(2 | 3), Some(n)) => {
                let length = u32::from_le_bytes([n[0], n[1], n[2], n[3]]);
                (usize::try_from(length).map_err(|_| short())?, 12)
            }
            _ => return Err(short()),
        };
        if length > LONGEST_HEADER {
            return Err(format!(
                "has a header of {length} bytes: at most {LONGEST_HEADER}"
            ));
        }
        let header = bytes.get(start..start + length).ok_or_else(short)?;
        let header = std::str::from_utf8(header).map_err(|_| short())?;
        let data = &bytes[start + length..];
        let shape = shape(header)?;
        let kind = quoted(header, "descr").ok_or("must state descr: a number type")?;
        let fortran = after(header, "fortran_order").ok_or("must state fortran_order")?;
        let count = shape
            .iter()
            .try_fold(1_usize, |n, size| n.checked_mul(*size));
        let count = count.filter(|count| *count <= MOST_NUMBERS);
        let count = count.ok_or_else(|| format!("has more than {MOST_NUMBERS} numbers"))?;
        Ok(Self {
            fortran: fortran.starts_with("True"),
            numbers: numbers(kind, count, data)?,
            shape,
        })
    }

    /// A square matrix or a vector; nothing for others.
    fn matrix(self, path: &Path, name: String) -> Result<Option<ImportedMatrix>, FileError> {
        let (values, digits) = match self.numbers {
            ArrayNumbers::Real { values, digits } => (values, digits),
            ArrayNumbers::Complex => {
                return Err(FileError::content(path, None, "is complex: must be real"));
            }
            ArrayNumbers::Text(_) | ArrayNumbers::Other => return Ok(None),
        };
        let numbers = super::arrays::Numbers { values, digits };
        dense(path, name, &self.shape, self.fortran, numbers)
    }

    /// Whole numbers that are not negative.
    fn indices(&self, name: &str) -> Result<Vec<usize>, String> {
        let ArrayNumbers::Real { values, .. } = &self.numbers else {
            return Err(format!("array {name}: must be whole numbers"));
        };
        let whole = |value: &f64| {
            let fits = value.fract() == 0.0 && (0.0..=1e9).contains(value);
            fits.then_some(*value as usize)
        };
        let indices: Option<Vec<usize>> = values.iter().map(whole).collect();
        indices.ok_or_else(|| format!("array {name}: must be whole numbers >= 0"))
    }
}

/// The text behind a key of the header.
fn after<'h>(header: &'h str, key: &str) -> Option<&'h str> {
    let at = header.find(&format!("'{key}'"))? + key.len() + 2;
    Some(header[at..].trim_start().strip_prefix(':')?.trim_start())
}

fn quoted<'h>(header: &'h str, key: &str) -> Option<&'h str> {
    after(header, key)?.strip_prefix('\'')?.split('\'').next()
}

/// `(12, 12)`, `(12,)`, `()`.
fn shape(header: &str) -> Result<Vec<usize>, String> {
    let rule = "must state its shape: whole numbers in parentheses";
    let inner = after(header, "shape").and_then(|rest| rest.strip_prefix('(')?.split_once(')'));
    let (inner, _) = inner.ok_or(rule)?;
    let sizes = inner
        .split(',')
        .map(str::trim)
        .filter(|size| !size.is_empty());
    let sizes: Result<Vec<usize>, _> = sizes.map(str::parse).collect();
    sizes.map_err(|_| rule.to_owned())
}

/// `count` numbers of a kind such as `<f8`.
fn numbers(kind: &str, count: usize, data: &[u8]) -> Result<ArrayNumbers, String> {
    let (order, rest) = kind.split_at_checked(1).unwrap_or(("", ""));
    let big_endian = order == ">";
    let (width, kind) = match rest {
        "f8" => (8, Kind::Float),
        "f4" => (4, Kind::Float),
        "i8" => (8, Kind::Signed),
        "i4" => (4, Kind::Signed),
        "i2" => (2, Kind::Signed),
        "i1" => (1, Kind::Signed),
        "u8" => (8, Kind::Unsigned),
        "u4" => (4, Kind::Unsigned),
        "u2" => (2, Kind::Unsigned),
        "u1" | "b1" => (1, Kind::Unsigned),
        _ if rest.starts_with('S') && data.len() <= 16 => {
            let text = String::from_utf8_lossy(data);
            return Ok(ArrayNumbers::Text(text.trim_end_matches('\0').to_owned()));
        }
        _ if rest.starts_with('c') => return Ok(ArrayNumbers::Complex),
        _ => return Ok(ArrayNumbers::Other),
    };
    if data.len() != count * width {
        return Err(format!(
            "has {} bytes: {count} numbers of {width} bytes are stated",
            data.len()
        ));
    }
    let digits = if rest == "f4" {
        SINGLE_DIGITS
    } else {
        DOUBLE_DIGITS
    };
    let values = data.chunks_exact(width);
    let values = values.map(|n| number(n, kind, big_endian)).collect();
    Ok(ArrayNumbers::Real { values, digits })
}

/// A matrix of `save_npz`: csr, csc or coo.
fn sparse(
    path: &Path,
    format: &Array,
    arrays: &BTreeMap<String, Array>,
) -> Result<ImportedMatrix, FileError> {
    let fault = |rule: String| FileError::content(path, None, rule);
    let array = |name: &str| {
        let found = arrays.get(name);
        found.ok_or_else(|| fault(format!("must have the array {name}")))
    };
    let indices = |name: &str| array(name)?.indices(name).map_err(fault);
    let ArrayNumbers::Text(format) = &format.numbers else {
        return Err(fault("array format: must be csr, csc or coo".to_owned()));
    };
    let [n, columns] = indices("shape")?[..] else {
        return Err(fault("array shape: must be two numbers".to_owned()));
    };
    if n != columns || !(1..=MOST_ROWS).contains(&n) {
        let rule = format!("is {n} x {columns}: must be square, of 1 to {MOST_ROWS} rows");
        return Err(fault(rule));
    }
    let ArrayNumbers::Real { values, digits } = &array("data")?.numbers else {
        return Err(fault("array data: must be real numbers".to_owned()));
    };
    let (first, second) = match format.as_str() {
        "coo" => (indices("row")?, indices("col")?),
        "csr" | "csc" => {
            let pointers = indices("indptr")?;
            (
                expanded("array indptr", &pointers, n, values.len()).map_err(fault)?,
                indices("indices")?,
            )
        }
        _ => {
            return Err(fault(format!(
                "format {format:.20}: must be csr, csc or coo"
            )));
        }
    };
    if first.len() != values.len() || second.len() != values.len() {
        let rule = format!(
            "has {} numbers, but {} and {} indices",
            values.len(),
            first.len(),
            second.len()
        );
        return Err(fault(rule));
    }
    let numbers = super::arrays::Numbers {
        values: values.clone(),
        digits: *digits,
    };
    let places = first.into_iter().zip(second);
    super::arrays::sparse(path, String::new(), n, places, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// An archive of some kilobytes whose array would fill the memory. Seen to fail without the bound: it was read.
    #[test]
    fn a_small_archive_of_a_large_array_is_refused() {
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let options = zip::write::SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated);
        writer.start_file("K.npy", options).unwrap();
        writer.write_all(&vec![0; 3 << 20]).unwrap();
        let file = writer.finish().unwrap().into_inner();
        assert!(file.len() < 1 << 15, "{} bytes", file.len());
        let refused = archive(&file, 2 << 20).err();
        assert_eq!(refused.as_deref(), Some("holds more than 2 MiB"));
    }
}
