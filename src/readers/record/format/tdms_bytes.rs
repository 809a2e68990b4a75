//! Numbers, texts and properties of a TDMS file, all with the least byte first.

use crate::file::binary::{Kind, number, take};

/// Bytes of a text at most.
const LONGEST_TEXT: usize = 1 << 16;
/// Type of texts.
pub(super) const TEXT: u32 = 0x20;

/// Bytes from the beginning to the end of a part of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bytes<'b> {
    pub(super) rest: &'b [u8],
}

/// Value of a property.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Text(String),
    /// A time or a complex number.
    Other,
}

impl<'b> Bytes<'b> {
    /// So many bytes.
    pub(super) fn take(&mut self, bytes: usize) -> Result<&'b [u8], String> {
        take(&mut self.rest, bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let bytes = self.take(N)?.first_chunk::<N>();
        bytes.copied().ok_or_else(|| "ends early".to_owned())
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, String> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn text(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        if length > LONGEST_TEXT {
            return Err(format!(
                "has a text of {length} bytes: must have at most {LONGEST_TEXT}"
            ));
        }
        let text = std::str::from_utf8(self.take(length)?);
        text.map(str::to_owned)
            .map_err(|_| "has a text that is no UTF-8".to_owned())
    }

    /// A property: its name and its value.
    pub(super) fn property(&mut self) -> Result<(String, Value), String> {
        let name = self.text()?;
        let kind = self.u32()?;
        let value = match (real(kind), kind) {
            (Some((width, meant)), _) => Value::Number(number(self.take(width)?, meant, false)),
            (None, TEXT) => Value::Text(self.text()?),
            (None, _) => {
                let width = other_width(kind);
                let width = width.ok_or_else(|| {
                    format!("property {name:.40}: has the type {kind:#x}, which is none")
                })?;
                self.take(width)?;
                Value::Other
            }
        };
        Ok((name, value))
    }
}

/// Width and kind of real numbers.
pub(super) fn real(kind: u32) -> Option<(usize, Kind)> {
    match kind {
        1 => Some((1, Kind::Signed)),
        2 => Some((2, Kind::Signed)),
        3 => Some((4, Kind::Signed)),
        4 => Some((8, Kind::Signed)),
        5 => Some((1, Kind::Unsigned)),
        6 => Some((2, Kind::Unsigned)),
        7 => Some((4, Kind::Unsigned)),
        8 => Some((8, Kind::Unsigned)),
        9 | 0x19 => Some((4, Kind::Float)),
        10 | 0x1a => Some((8, Kind::Float)),
        _ => None,
    }
}

/// Bytes of a value that is no real number and no text: nothing, a truth value, a time, extended or complex numbers.
pub(super) fn other_width(kind: u32) -> Option<usize> {
    match kind {
        0 => Some(0),
        0x21 => Some(1),
        0x44 | 11 | 0x1b | 0x10_000d => Some(16),
        0x08_000c => Some(8),
        _ => None,
    }
}
