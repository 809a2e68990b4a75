//! MATLAB files of level 5, written by the rules of the format.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

/// How a file is written.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Form {
    pub(crate) big_endian: bool,
    pub(crate) compressed: bool,
    /// Data of up to four bytes go into the word of their length.
    pub(crate) small: bool,
}

/// Types of data.
pub(crate) const INT8: u32 = 1;
pub(crate) const INT32: u32 = 5;
pub(crate) const UINT32: u32 = 6;
pub(crate) const DOUBLE: u32 = 9;
/// Classes.
pub(crate) const DOUBLE_CLASS: u32 = 6;
pub(crate) const COMPLEX: u32 = 0x800;

impl Form {
    pub(crate) fn word(self, value: u32) -> [u8; 4] {
        match self.big_endian {
            true => value.to_be_bytes(),
            false => value.to_le_bytes(),
        }
    }

    pub(crate) fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let length = data.len() as u32;
        let mut bytes = match self.small && (1..=4).contains(&length) {
            true => self.word(length << 16 | kind).to_vec(),
            false => [self.word(kind), self.word(length)].concat(),
        };
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    pub(crate) fn wholes(self, values: impl IntoIterator<Item = usize>) -> Vec<u8> {
        let words = values.into_iter().map(|value| self.word(value as u32));
        words.flatten().collect()
    }

    pub(crate) fn reals(self, values: impl IntoIterator<Item = f64>) -> Vec<u8> {
        let bytes = |value: f64| match self.big_endian {
            true => value.to_be_bytes(),
            false => value.to_le_bytes(),
        };
        values.into_iter().flat_map(bytes).collect()
    }

    /// A variable with its data, each with its type.
    pub(crate) fn variable(
        self,
        name: &str,
        flags: u32,
        shape: &[usize],
        data: &[(u32, Vec<u8>)],
    ) -> Vec<u8> {
        let elements = data.iter().map(|(kind, data)| self.element(*kind, data));
        let elements: Vec<_> = elements.collect();
        self.raw_variable(name, flags, shape, &elements.concat())
    }

    /// A variable with the elements of its data.
    pub(crate) fn raw_variable(
        self,
        name: &str,
        flags: u32,
        shape: &[usize],
        elements: &[u8],
    ) -> Vec<u8> {
        let flags = [self.word(flags), self.word(0)].concat();
        let wide = Self {
            small: false,
            ..self
        };
        let parts = [
            wide.element(UINT32, &flags),
            self.element(INT32, &self.wholes(shape.iter().copied())),
            self.element(INT8, name.as_bytes()),
            elements.to_vec(),
        ];
        let whole = wide.element(14, &parts.concat());
        if !self.compressed {
            return whole;
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&whole).unwrap();
        let stream = encoder.finish().unwrap();
        [&self.word(15)[..], &self.word(stream.len() as u32), &stream].concat()
    }

    pub(crate) fn header(self) -> Vec<u8> {
        let mut header =
            b"MATLAB 5.0 MAT-file Platform: posix, Created on: Mon Nov 23 2026".to_vec();
        header.resize(124, b' ');
        header.extend(match self.big_endian {
            true => [1, 0, b'M', b'I'],
            false => [0, 1, b'I', b'M'],
        });
        header
    }

    pub(crate) fn file(self, variables: &[Vec<u8>]) -> Vec<u8> {
        [self.header(), variables.concat()].concat()
    }
}

/// Every way to write a file.
pub(crate) fn forms() -> Vec<Form> {
    let bit = |n: u8, of: u8| n >> of & 1 == 1;
    let form = |n: u8| Form {
        big_endian: bit(n, 0),
        compressed: bit(n, 1),
        small: bit(n, 2),
    };
    (0..8).map(form).collect()
}
