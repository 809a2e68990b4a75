//! MATLAB files: variables of level 5, as versions 5 to 7 and SciPy write them, dense or sparse, compressed or not; texts and
//! structures too.
//!
//! Format: "MAT-File Format" of The MathWorks: elements of a type, a length and data, in one byte order. A reader of our own:
//! the crate at hand refuses the files that SciPy writes. A file of version 7.3 is HDF5 and is not read.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::binary::{Kind, number};
use super::compressed_rows::expanded;
use super::parquet::without_panic;

/// How the text at the beginning of a file begins.
const MAGIC: &[u8] = b"MATLAB";
/// Bytes of the header: text, version, byte order.
const HEADER: usize = 128;
/// Bytes of all compressed variables at most, after decompression.
const MOST_BYTES: u64 = 512 << 20;
/// Numbers of a variable at most: those of a dense matrix of 5000 rows.
const MOST_NUMBERS: usize = 25_000_000;
/// Numbers of all variables at most.
const MOST_IN_ALL: usize = 64 << 20;
/// Variables of a file, or fields of a structure, at most.
const MOST_VARIABLES: usize = 1000;
/// Dimensions of an array at most.
const MOST_DIMENSIONS: usize = 32;
/// Bytes of a variable's name at most.
const LONGEST_NAME: usize = 128;
/// Structures inside each other at most.
const DEEPEST: usize = 2;

/// Type of an element that holds an array.
const MATRIX: u32 = 14;
/// Type of an element that holds a compressed one.
const COMPRESSED: u32 = 15;
/// Class of structures.
const STRUCTURE: u8 = 2;
/// Class of texts.
const TEXT: u8 = 4;
/// Class of sparse arrays.
const SPARSE: u8 = 5;
/// Class of numbers in single precision.
const SINGLE: u8 = 7;
/// Last class of numbers; the first is 6.
const LAST_CLASS: u8 = 15;

/// A variable of a file, or a field of a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Sizes of its dimensions; the first index runs fastest.
    pub shape: Vec<usize>,
    /// What it holds.
    pub values: Values,
}

/// What a variable holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers by columns.
    Dense {
        /// As many as the shape states.
        numbers: Vec<f64>,
        /// Whether its class is of single precision.
        single: bool,
    },
    /// Entries of a sparse matrix.
    Sparse {
        /// Row of each entry, from 0.
        rows: Vec<usize>,
        /// Column of each entry, from 0.
        columns: Vec<usize>,
        /// Value of each entry.
        numbers: Vec<f64>,
    },
    /// A text of one line.
    Text(String),
    /// The fields of a structure of one row and one column.
    Structure(Vec<Variable>),
    /// What is not read, in words.
    Other(&'static str),
}

/// Whether the bytes begin as such a file, of any version.
#[must_use]
pub fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// All variables.
///
/// # Errors
/// The rule that the file breaks.
pub fn read(bytes: &[u8]) -> Result<Vec<Variable>, String> {
    // the library may panic on a damaged stream
    let damaged = || Err("is damaged: the library for compressed data cannot read it".to_owned());
    without_panic(|| variables(bytes, MOST_BYTES)).unwrap_or_else(damaged)
}

/// All variables; decompressed they take `most` bytes at most.
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
                Variable::read(inner, big_endian, DEEPEST)
            }
            _ => Variable::read(element, big_endian, DEEPEST),
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
        _ => Err("is no MATLAB file of level 5: save it with save(FILE, '-v7')".to_owned()),
    }
}

/// Why a file of version 7.3 is refused.
pub const NEWER: &str =
    "is a MATLAB file of version 7.3 (HDF5), which is not read: save it with save(FILE, '-v7')";

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

impl Variable {
    /// A variable with at most `depth` structures inside each other.
    fn read(element: Element<'_>, big_endian: bool, depth: usize) -> Result<Self, String> {
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
        let one_row = shape.len() == 2 && shape[0] == 1;
        let values = match class {
            _ if complex => Ok(Values::Other("complex")),
            SPARSE => Values::sparse(&mut parts, &shape),
            6..=LAST_CLASS => Values::dense(&mut parts, &shape, class),
            TEXT if one_row => Values::text(&mut parts),
            STRUCTURE if one_row && shape[1] == 1 && depth > 0 => {
                Values::structure(&mut parts, depth - 1)
            }
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
}

impl Values {
    fn count(&self) -> usize {
        match self {
            Self::Dense { numbers, .. } | Self::Sparse { numbers, .. } => numbers.len(),
            Self::Structure(fields) => fields.iter().map(|field| field.values.count()).sum(),
            Self::Text(_) | Self::Other(_) => 0,
        }
    }

    fn dense(parts: &mut Reader<'_>, shape: &[usize], class: u8) -> Result<Self, String> {
        let numbers = parts.next()?.numbers(parts.big_endian)?;
        let count = shape
            .iter()
            .try_fold(1_usize, |n, size| n.checked_mul(*size));
        if count != Some(numbers.len()) {
            return Err(format!(
                "has {} numbers, which do not fill {shape:?}",
                numbers.len()
            ));
        }
        let single = class == SINGLE;
        Ok(Self::Dense { numbers, single })
    }

    /// Lists of rows and numbers may be longer than needed.
    fn sparse(parts: &mut Reader<'_>, shape: &[usize]) -> Result<Self, String> {
        let (mut rows, pointers) = (parts.indices("rows")?, parts.indices("columns")?);
        let mut numbers = parts.next()?.numbers(parts.big_endian)?;
        let entries = pointers.last().copied().unwrap_or(0);
        if entries > rows.len().min(numbers.len()) {
            let (rows, values) = (rows.len(), numbers.len());
            return Err(format!(
                "has {entries} entries, but {rows} rows and {values} numbers"
            ));
        }
        let columns = expanded("columns", &pointers, shape[1].min(MOST_NUMBERS), entries)?;
        rows.truncate(entries);
        numbers.truncate(entries);
        Ok(Self::Sparse {
            rows,
            columns,
            numbers,
        })
    }

    /// Characters in UTF-8, or a number for each.
    fn text(parts: &mut Reader<'_>) -> Result<Self, String> {
        let element = parts.next()?;
        if element.kind == 16 {
            let text = String::from_utf8_lossy(element.bytes);
            return Ok(Self::Text(text.into_owned()));
        }
        let numbers = match element.kind {
            // UTF-16, as whole numbers of two bytes
            17 => Element { kind: 4, ..element }.numbers(parts.big_endian)?,
            _ => element.numbers(parts.big_endian)?,
        };
        let characters = numbers.into_iter().map(|code| {
            let character = char::from_u32(code as u32);
            character.unwrap_or(char::REPLACEMENT_CHARACTER)
        });
        Ok(Self::Text(characters.collect()))
    }

    /// Names of the same length, filled with null bytes, and a variable without a name for each.
    fn structure(parts: &mut Reader<'_>, depth: usize) -> Result<Self, String> {
        let length = parts.indices("length of names")?;
        let names = parts.next()?;
        let length = match length[..] {
            [length] if (1..=LONGEST_NAME).contains(&length) => length,
            _ => {
                return Err(format!(
                    "names of fields: must have 1 to {LONGEST_NAME} bytes"
                ));
            }
        };
        let names = names.bytes.chunks(length);
        if names.len() > MOST_VARIABLES {
            return Err(format!("has more than {MOST_VARIABLES} fields"));
        }
        let mut fields = Vec::new();
        for name in names {
            let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
            let name = String::from_utf8_lossy(name).into_owned();
            let field = Variable::read(parts.next()?, parts.big_endian, depth);
            let field = field.map_err(|rule| format!("field {name:.40}: {rule}"))?;
            fields.push(Variable { name, ..field });
        }
        Ok(Self::Structure(fields))
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
