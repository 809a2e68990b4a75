//! MATLAB: variables of a `.mat` file of level 5, as versions 5 to 7 and SciPy write it, dense or sparse, compressed or not.
//!
//! Format: "MAT-File Format" of The MathWorks: elements of a type, a length and data, in one byte order. A reader of our own:
//! the crate at hand refuses the files that SciPy writes. A file of version 7.3 is HDF5 and is not read.

use std::io::Read;
use std::path::Path;

use flate2::read::ZlibDecoder;

use super::super::lines::MOST_ROWS;
use super::super::matrix::{Content, DOUBLE_DIGITS, ImportedMatrix, Rows, SINGLE_DIGITS};
use super::super::role::Role;
use super::arrays::{self, Kind, MOST_NUMBERS, Numbers, expanded, number};
use crate::file::{FileError, parquet::without_panic};

/// How the text at the beginning of a file begins.
const MAGIC: &[u8] = b"MATLAB";
/// Bytes of the header: text, version, byte order.
const HEADER: usize = 128;
/// Bytes of all compressed variables at most, after decompression.
const MOST_BYTES: u64 = 512 << 20;
/// Numbers of all variables at most.
const MOST_IN_ALL: usize = 64 << 20;
/// Variables of a file at most.
const MOST_VARIABLES: usize = 1000;
/// Dimensions of an array at most.
const MOST_DIMENSIONS: usize = 32;
/// Bytes of a variable's name at most.
const LONGEST_NAME: usize = 128;

/// Type of an element that holds an array.
const MATRIX: u32 = 14;
/// Type of an element that holds a compressed one.
const COMPRESSED: u32 = 15;
/// Class of sparse arrays.
const SPARSE: u8 = 5;
/// Class of numbers in single precision.
const SINGLE: u8 = 7;
/// Last class of numbers; the first is 6.
const LAST_CLASS: u8 = 15;

/// Whether the bytes begin as such a file, of any version.
pub(in crate::import) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads all variables that are square matrices or vectors of real numbers.
///
/// # Errors
/// [`FileError`] if the file is damaged, or a variable with a name such as K is none of these.
pub(in crate::import) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<ImportedMatrix>, FileError> {
    let fault = |rule: String| FileError::content(path, None, rule);
    // the library may panic on a damaged stream
    let damaged = || Err("is damaged: the library for compressed data cannot read it".to_owned());
    let variables = without_panic(|| variables(bytes, MOST_BYTES)).unwrap_or_else(damaged);
    let mut found = Vec::new();
    for variable in variables.map_err(fault)? {
        found.extend(variable.matrix(path)?);
    }
    match found.is_empty() {
        true => Err(fault("has no square matrix and no vector".to_owned())),
        false => Ok(found),
    }
}

/// All variables of numbers; decompressed they take `most` bytes at most.
fn variables(bytes: &[u8], most: u64) -> Result<Vec<Variable>, String> {
    let big_endian = big_endian(bytes)?;
    let mut rest = Reader {
        bytes: &bytes[HEADER..],
        big_endian,
    };
    let mut found = Vec::new();
    let (mut left, mut numbers) = (most, 0);
    while !rest.bytes.is_empty() {
        let number = found.len() + 1;
        if number > MOST_VARIABLES {
            return Err(format!("has more than {MOST_VARIABLES} variables"));
        }
        let at = |rule: String| format!("variable {number}: {rule}");
        let element = rest.next().map_err(at)?;
        let variable = match element.kind {
            COMPRESSED => {
                let content = inflated(element.bytes, left).map_err(at)?;
                let rest = left.checked_sub(content.len() as u64);
                left = rest.ok_or_else(|| format!("holds more than {} MiB", most >> 20))?;
                let mut inside = Reader {
                    bytes: &content,
                    big_endian,
                };
                let inner = inside.next().map_err(at)?;
                Variable::read(inner, big_endian)
            }
            _ => Variable::read(element, big_endian),
        };
        let variable = variable.map_err(at)?;
        numbers += variable.values.count();
        if numbers > MOST_IN_ALL {
            return Err(format!("holds more than {MOST_IN_ALL} numbers"));
        }
        found.push(variable);
    }
    Ok(found)
}

/// Byte order, by the last bytes of the header.
fn big_endian(bytes: &[u8]) -> Result<bool, String> {
    let short = || format!("is no MATLAB file: its header must have {HEADER} bytes");
    match bytes.get(HEADER - 4..HEADER).ok_or_else(short)? {
        [0, 1, b'I', b'M'] => Ok(false),
        [1, 0, b'M', b'I'] => Ok(true),
        [0, 2, b'I', b'M'] | [2, 0, b'M', b'I'] => Err(NEWER.to_owned()),
        _ => {
            Err("is no MATLAB file of level 5: save it with save(FILE, 'K', 'M', '-v7')".to_owned())
        }
    }
}

/// Why a file of version 7.3 is refused.
pub(in crate::import) const NEWER: &str = "is a MATLAB file of version 7.3 (HDF5), which is not read: save it with save(FILE, 'K', 'M', '-v7')";

/// At most `most` + 1 bytes of a compressed element.
fn inflated(bytes: &[u8], most: u64) -> Result<Vec<u8>, String> {
    let mut content = Vec::new();
    let read = ZlibDecoder::new(bytes)
        .take(most + 1)
        .read_to_end(&mut content);
    read.map_err(|error| format!("is damaged: {error}"))?;
    Ok(content)
}

/// Elements one after the other.
struct Reader<'b> {
    bytes: &'b [u8],
    big_endian: bool,
}

/// One element: its type and its data.
#[derive(Clone, Copy)]
struct Element<'b> {
    kind: u32,
    bytes: &'b [u8],
}

impl<'b> Reader<'b> {
    /// The next element. One of up to four bytes may have its type and its length in one word.
    fn next(&mut self) -> Result<Element<'b>, String> {
        let bytes = self.bytes;
        let word = |at: usize| {
            let bytes = bytes.get(at..at + 4).ok_or("ends early")?;
            let word = [bytes[0], bytes[1], bytes[2], bytes[3]];
            Ok::<u32, String>(match self.big_endian {
                true => u32::from_be_bytes(word),
                false => u32::from_le_bytes(word),
            })
        };
        let first = word(0)?;
        let (kind, length, start) = match first >> 16 {
            0 => (first, word(4)? as usize, 8),
            length @ 1..=4 => (first & 0xffff, length as usize, 4),
            length => {
                return Err(format!(
                    "has an element of {length} bytes in a word of four"
                ));
            }
        };
        let end = length.checked_add(start).filter(|end| *end <= bytes.len());
        let end = end.ok_or_else(|| {
            let rest = bytes.len() - start;
            format!("states {length} bytes, but only {rest} are left")
        })?;
        // data are filled up to eight bytes; compressed ones are not
        let next = match (kind, start) {
            (COMPRESSED, _) => end,
            (_, 4) => 8,
            _ => end.next_multiple_of(8),
        };
        self.bytes = bytes.get(next..).unwrap_or_default();
        Ok(Element {
            kind,
            bytes: &bytes[start..end],
        })
    }

    /// The next element, which must hold whole numbers ≥ 0.
    fn indices(&mut self, what: &str) -> Result<Vec<usize>, String> {
        let element = self.next()?;
        let numbers = element.numbers(self.big_endian)?;
        let whole = |value: f64| (value >= 0.0 && value.fract() == 0.0).then_some(value as usize);
        let indices: Option<Vec<usize>> = numbers.into_iter().map(whole).collect();
        indices.ok_or_else(|| format!("{what}: must be whole numbers >= 0"))
    }
}

impl Element<'_> {
    /// Its numbers, which may be stored in fewer bytes than their class has.
    fn numbers(&self, big_endian: bool) -> Result<Vec<f64>, String> {
        let (width, kind) = match self.kind {
            1 => (1, Kind::Signed),
            2 => (1, Kind::Unsigned),
            3 => (2, Kind::Signed),
            4 => (2, Kind::Unsigned),
            5 => (4, Kind::Signed),
            6 => (4, Kind::Unsigned),
            7 => (4, Kind::Float),
            9 => (8, Kind::Float),
            12 => (8, Kind::Signed),
            13 => (8, Kind::Unsigned),
            kind => return Err(format!("has data of type {kind}: must be numbers")),
        };
        let (count, bytes) = (self.bytes.len() / width, self.bytes.len());
        if count > MOST_NUMBERS {
            return Err(format!("has more than {MOST_NUMBERS} numbers"));
        }
        if count * width != bytes {
            return Err(format!(
                "has {bytes} bytes: must be numbers of {width} bytes"
            ));
        }
        let numbers = self.bytes.chunks_exact(width);
        Ok(numbers.map(|n| number(n, kind, big_endian)).collect())
    }
}

/// A variable of a file.
struct Variable {
    name: String,
    shape: Vec<usize>,
    values: Values,
}

/// What a variable holds.
enum Values {
    /// By columns.
    Dense(Numbers),
    /// Rows of the entries, where each column begins, values.
    Sparse {
        rows: Vec<usize>,
        columns: Vec<usize>,
        numbers: Numbers,
    },
    /// What is not read, in words.
    Other(&'static str),
}

impl Variable {
    fn read(element: Element<'_>, big_endian: bool) -> Result<Self, String> {
        if element.kind != MATRIX {
            return Err(format!(
                "is of type {}: must be {MATRIX}, an array",
                element.kind
            ));
        }
        if element.bytes.is_empty() {
            let (name, shape) = (String::new(), Vec::new());
            return Ok(Self {
                name,
                shape,
                values: Values::Other("empty"),
            });
        }
        let mut parts = Reader {
            bytes: element.bytes,
            big_endian,
        };
        let flags = parts.next()?;
        let (6, Some(&[a, b, c, d])) = (flags.kind, flags.bytes.first_chunk::<4>()) else {
            return Err("must begin with its flags".to_owned());
        };
        let (flags, class) = if big_endian { (c, d) } else { (b, a) };
        let shape = parts.indices("dimensions")?;
        if !(2..=MOST_DIMENSIONS).contains(&shape.len()) {
            let n = shape.len();
            return Err(format!(
                "has {n} dimensions: must have 2 to {MOST_DIMENSIONS}"
            ));
        }
        let name = parts.next()?;
        if !matches!(name.kind, 1 | 2 | 16) || name.bytes.len() > LONGEST_NAME {
            return Err(format!("has no name of at most {LONGEST_NAME} bytes"));
        }
        let name = String::from_utf8_lossy(name.bytes).into_owned();
        let complex = flags & 0x08 != 0;
        let values = match class {
            _ if complex => Ok(Values::Other("complex")),
            SPARSE => Values::sparse(&mut parts, &shape),
            6..=LAST_CLASS => Values::dense(&mut parts, &shape, class),
            1..=LAST_CLASS => Ok(Values::Other("no array of numbers")),
            16..=18 => Ok(Values::Other("no array of numbers")),
            class => Err(format!("has the class {class}, which is none")),
        };
        let values = values.map_err(|rule| format!("{name:.40}: {rule}"))?;
        Ok(Self {
            name,
            shape,
            values,
        })
    }

    /// A square matrix or a vector of real numbers. Others are passed over, unless they have the name of a matrix or a force.
    fn matrix(self, path: &Path) -> Result<Option<ImportedMatrix>, FileError> {
        // MATLAB tells k from K: a number or a text k is none of the model
        let small_letter = self.name.len() == 1 && self.name.chars().all(char::is_lowercase);
        let meant = Role::of_word(&self.name).is_some() && !small_letter;
        let number = self.shape.iter().all(|size| *size == 1);
        match self.content(path) {
            Ok(_) if number && !meant => Ok(None),
            Err(_) if !meant => Ok(None),
            content => content.map(Some),
        }
    }

    fn content(self, path: &Path) -> Result<ImportedMatrix, FileError> {
        let Self {
            name,
            shape,
            values,
        } = self;
        let shown = format!("array {name:.40}");
        let fault = |rule: String| FileError::content(path, None, format!("{shown}: {rule}"));
        let sizes: Vec<_> = shape.iter().map(usize::to_string).collect();
        let sizes = sizes.join(" x ");
        let neither = || {
            fault(format!(
                "is {sizes}: must be square or a vector, of 1 to {MOST_ROWS} rows"
            ))
        };
        match values {
            Values::Other(what) => Err(fault(format!("is {what}: must be real numbers"))),
            Values::Dense(numbers) => {
                let found = arrays::dense(path, name, &shape, true, numbers)?;
                found.ok_or_else(neither)
            }
            Values::Sparse {
                rows,
                columns,
                numbers,
            } => match shape[..] {
                [n, 1] if (2..=MOST_ROWS).contains(&n) => Ok(ImportedMatrix {
                    name,
                    path: path.to_owned(),
                    rows: Rows::Numbered(n),
                    digits: numbers.digits,
                    content: Content::Column(filled(n, &rows, &numbers.values).map_err(fault)?),
                }),
                [n, m] if n == m && (1..=MOST_ROWS).contains(&n) => {
                    let places = rows.into_iter().zip(columns);
                    arrays::sparse(path, name, n, places, numbers)
                }
                _ => Err(neither()),
            },
        }
    }
}

/// The column of `n` rows with these entries.
fn filled(n: usize, rows: &[usize], values: &[f64]) -> Result<Vec<f64>, String> {
    let mut column = vec![0.0; n];
    for (&row, value) in rows.iter().zip(values) {
        let place = column.get_mut(row).filter(|_| value.is_finite());
        let rule = || format!("entry {row} = {value}: must be finite and inside {n} rows");
        *place.ok_or_else(rule)? = *value;
    }
    Ok(column)
}

impl Values {
    fn count(&self) -> usize {
        match self {
            Self::Dense(numbers) | Self::Sparse { numbers, .. } => numbers.values.len(),
            Self::Other(_) => 0,
        }
    }

    fn dense(parts: &mut Reader<'_>, shape: &[usize], class: u8) -> Result<Self, String> {
        let values = parts.next()?.numbers(parts.big_endian)?;
        let count = shape
            .iter()
            .try_fold(1_usize, |n, size| n.checked_mul(*size));
        if count != Some(values.len()) {
            return Err(format!(
                "has {} numbers, which do not fill {shape:?}",
                values.len()
            ));
        }
        let digits = if class == SINGLE {
            SINGLE_DIGITS
        } else {
            DOUBLE_DIGITS
        };
        Ok(Self::Dense(Numbers { values, digits }))
    }

    /// Lists of rows and numbers may be longer than needed.
    fn sparse(parts: &mut Reader<'_>, shape: &[usize]) -> Result<Self, String> {
        let (mut rows, pointers) = (parts.indices("rows")?, parts.indices("columns")?);
        let mut values = parts.next()?.numbers(parts.big_endian)?;
        let entries = pointers.last().copied().unwrap_or(0);
        if entries > rows.len().min(values.len()) {
            let (rows, values) = (rows.len(), values.len());
            return Err(format!(
                "has {entries} entries, but {rows} rows and {values} numbers"
            ));
        }
        let columns = expanded("columns", &pointers, shape[1].min(MOST_NUMBERS), entries)?;
        rows.truncate(entries);
        values.truncate(entries);
        let digits = DOUBLE_DIGITS;
        Ok(Self::Sparse {
            rows,
            columns,
            numbers: Numbers { values, digits },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// A stream of some kilobytes that would fill the memory. Seen to fail without the bound: it was read.
    #[test]
    fn a_small_file_of_a_large_variable_is_refused() {
        let mut header = b"MATLAB 5.0 MAT-file".to_vec();
        header.resize(HEADER - 4, b' ');
        header.extend([0, 1, b'I', b'M']);
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(&vec![0; 3 << 20]).unwrap();
        let stream = encoder.finish().unwrap();
        assert!(stream.len() < 1 << 15, "{} bytes", stream.len());
        let tag = [
            COMPRESSED.to_le_bytes(),
            (stream.len() as u32).to_le_bytes(),
        ]
        .concat();
        let file = [header, tag, stream].concat();
        let refused = variables(&file, 2 << 20).err();
        assert_eq!(refused.as_deref(), Some("holds more than 2 MiB"));
    }
}
