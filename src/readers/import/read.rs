//! One file: which format it has, and what its reader finds.

use std::path::{Path, PathBuf};

use super::dof::Dof;
use super::format::{
    abaqus_matrix, abaqus_substructure, calculix, harwell_boeing, matlab, nastran_dmig,
    nastran_names, numpy, op4_binary, op4_text,
};
use super::lines::{Lines, MOST_ROWS, words};
use super::matrix::{Content, Entries, ImportedMatrix, Rows, Storage};
use crate::file::{self, FileError};
use crate::model::matrix_market::{Collects, Entry, MatrixShape, read_entries};

/// What a file holds.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The file.
    pub path: PathBuf,
    /// Its format, in words.
    pub format: &'static str,
    /// Matrices and vectors.
    pub matrices: Vec<ImportedMatrix>,
    /// Names of the rows of other files.
    pub names: Option<Vec<Dof>>,
    /// Whether its matrices are arrays, whose names people choose.
    pub(super) arrays: bool,
}

/// Matrices, and names of rows.
type Contents = (Vec<ImportedMatrix>, Option<Vec<Dof>>);

/// Formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    MatrixMarket,
    AbaqusMatrix,
    AbaqusSubstructure,
    CalculixMatrix,
    CalculixNames,
    HarwellBoeing,
    AnsysMapping,
    NastranBulk,
    Op4Text,
    Op4Binary,
    Numpy,
    Matlab,
}

/// Bytes of a file of matrices at most: a blade of 200 000 degrees of freedom takes about one GiB.
const LONGEST_FILE: u64 = 8 << 30;
/// Lines that are looked at to find the format.
const LOOKED_AT: usize = 200;

/// Reads a file by the format that its name or its beginning shows.
///
/// # Errors
/// [`FileError`] if it cannot be read, is of no known format, or breaks a rule of it.
pub fn read(path: &Path) -> Result<Reading, FileError> {
    let bytes = file::read_bytes(path, LONGEST_FILE)?;
    let reading = |format: Format, matrices, names| Reading {
        path: path.to_owned(),
        format: format.in_words(),
        matrices,
        names,
        arrays: matches!(format, Format::Numpy | Format::Matlab),
    };
    if op4_binary::begins(&bytes) {
        let matrices = op4_binary::read(path, &bytes)?;
        return Ok(reading(Format::Op4Binary, matrices, None));
    }
    if numpy::begins(&bytes) {
        return Ok(reading(Format::Numpy, numpy::read(path, &bytes)?, None));
    }
    if let Some((_, rule)) = REFUSED.iter().find(|(begin, _)| bytes.starts_with(begin)) {
        return Err(FileError::content(path, None, *rule));
    }
    let mat = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("mat"));
    if file::matlab::begins(&bytes) || mat {
        return Ok(reading(Format::Matlab, matlab::read(path, &bytes)?, None));
    }
    let text = file::text_of(path, bytes)?;
    let format = Format::of(path, &text)
        .ok_or_else(|| FileError::content(path, None, UNKNOWN.to_owned()))?;
    let (matrices, names) = format.read(path, &text)?;
    Ok(reading(format, matrices, names))
}

/// How files begin that are known, and not read.
const REFUSED: [(&[u8], &str); 1] = [(b"\x89HDF", file::matlab::NEWER)];

const UNKNOWN: &str = "is of no format that is read: see `microslip import --help`";

impl Format {
    /// Matrices and names of a text.
    fn read(self, path: &Path, text: &str) -> Result<Contents, FileError> {
        let matrices = match self {
            Self::MatrixMarket => vec![matrix_market(path)?],
            Self::AbaqusMatrix => vec![abaqus_matrix::read(path, text)?],
            Self::AbaqusSubstructure => abaqus_substructure::read(path, text)?,
            Self::CalculixMatrix => vec![calculix::read_matrix(path, text)?],
            Self::HarwellBoeing => harwell_boeing::read(path, text)?,
            Self::Op4Text | Self::Op4Binary | Self::Numpy | Self::Matlab => {
                op4_text::read(path, text)?
            }
            Self::CalculixNames => {
                return Ok((Vec::new(), Some(calculix::read_names(path, text)?)));
            }
            Self::AnsysMapping => {
                return Ok((Vec::new(), Some(harwell_boeing::read_mapping(path, text)?)));
            }
            Self::NastranBulk => {
                let matrices = nastran_dmig::read(path, text)?;
                let names = nastran_names::read(path, text)?;
                if matrices.is_empty() && names.is_none() {
                    let rule = "has no DMIG entry and no entry with names (EXTRN, ASET, ASET1, GRID, SPOINT)";
                    return Err(FileError::content(path, None, rule));
                }
                return Ok((matrices, names));
            }
        };
        Ok((matrices, None))
    }

    fn of(path: &Path, text: &str) -> Option<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "sti" | "mas" => return Some(Self::CalculixMatrix),
            "dof" => return Some(Self::CalculixNames),
            "mapping" => return Some(Self::AnsysMapping),
            "pch" | "asm" | "dmig" | "bdf" => return Some(Self::NastranBulk),
            "op4" => return Some(Self::Op4Text),
            _ => {}
        }
        if text.len() >= 14 && text.as_bytes()[..14].eq_ignore_ascii_case(BANNER) {
            return Some(Self::MatrixMarket);
        }
        if is_harwell_boeing(text) {
            return Some(Self::HarwellBoeing);
        }
        Self::of_lines(path, text)
    }

    /// By the first line that is no comment.
    fn of_lines(path: &Path, text: &str) -> Option<Self> {
        for line in Lines::new(path, text).take(LOOKED_AT) {
            let upper = line.to_ascii_uppercase();
            if upper.starts_with("*USER ELEMENT") || upper.starts_with("** ELEMENT NODES") {
                return Some(Self::AbaqusSubstructure);
            }
            if upper.starts_with("DMIG") {
                return Some(Self::NastranBulk);
            }
            if op4_text::is_header(line) {
                return Some(Self::Op4Text);
            }
            if upper.is_empty() || upper.starts_with(['*', '$']) {
                continue;
            }
            return match words(line).count() {
                5 => Some(Self::AbaqusMatrix),
                3 if line.contains(',') => Some(Self::AbaqusMatrix),
                3 => Some(Self::CalculixMatrix),
                _ => None,
            };
        }
        None
    }

    fn in_words(self) -> &'static str {
        match self {
            Self::MatrixMarket => "Matrix Market",
            Self::AbaqusMatrix => "Abaqus matrix",
            Self::AbaqusSubstructure => "Abaqus substructure",
            Self::CalculixMatrix => "CalculiX matrix",
            Self::CalculixNames => "CalculiX names",
            Self::HarwellBoeing => "Harwell-Boeing (ANSYS HBMAT)",
            Self::AnsysMapping => "ANSYS mapping",
            Self::NastranBulk => "Nastran bulk data",
            Self::Op4Text => "Nastran OUTPUT4 (text)",
            Self::Op4Binary => "Nastran OUTPUT4 (binary)",
            Self::Numpy => "NumPy arrays",
            Self::Matlab => "MATLAB",
        }
    }
}

/// How a Matrix Market file begins.
const BANNER: &[u8; 14] = b"%%MatrixMarket";

/// Whether the third line begins with a type such as RSA, and the fourth with a format.
fn is_harwell_boeing(text: &str) -> bool {
    let mut lines = text.lines().skip(2);
    let (kind, format) = (lines.next(), lines.next());
    let kind = kind.unwrap_or_default().as_bytes();
    let is_kind = kind.len() > 3
        && b"RCP".contains(&kind[0].to_ascii_uppercase())
        && b"SUHZR".contains(&kind[1].to_ascii_uppercase())
        && b"AE".contains(&kind[2].to_ascii_uppercase());
    is_kind && format.unwrap_or_default().trim_start().starts_with('(')
}

/// A Matrix Market file: a symmetric matrix, or a vector where it has one column.
fn matrix_market(path: &Path) -> Result<ImportedMatrix, FileError> {
    let (Market { shape, entries }, digits) = read_entries(path, MOST_ROWS)?;
    let MatrixShape { rows, columns, .. } = shape;
    let content = match columns {
        1 if rows > 1 => Content::Column(entries.column(path, rows)?),
        _ if rows != columns => {
            let rule = format!("is {rows} x {columns}: must be square, or have one column");
            return Err(FileError::content(path, None, rule));
        }
        _ => {
            let storage = match shape.symmetric {
                true => Storage::Triangle,
                false => Storage::Full,
            };
            Content::Symmetric(entries.symmetric(path, rows, storage)?)
        }
    };
    Ok(ImportedMatrix {
        name: String::new(),
        path: path.to_owned(),
        rows: Rows::Numbered(rows),
        content,
        digits,
    })
}

/// Entries of a Matrix Market file.
struct Market {
    shape: MatrixShape,
    entries: Entries,
}

impl Collects for Market {
    fn empty(shape: MatrixShape, _: bool) -> Self {
        Self {
            shape,
            entries: Entries::default(),
        }
    }

    fn add(&mut self, entry: Entry) -> Result<(), String> {
        // a dense file states zeros too
        if entry.value != 0.0 {
            (self.entries).add(entry.row, entry.column, entry.value, entry.line);
        }
        Ok(())
    }
}
