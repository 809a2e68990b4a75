//! Numbers as bytes.

/// How the bytes of a number are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Of 4 or 8 bytes.
    Float,
    /// Whole, with a sign.
    Signed,
    /// Whole, ≥ 0.
    Unsigned,
}

/// The next so many `bytes` of what is left.
///
/// # Errors
/// With both numbers, if fewer are left; nothing is taken then.
pub fn take<'b>(rest: &mut &'b [u8], bytes: usize) -> Result<&'b [u8], String> {
    let left = rest.len();
    let taken = rest.split_at_checked(bytes);
    let (taken, after) =
        taken.ok_or_else(|| format!("states {bytes} bytes, but only {left} are left"))?;
    *rest = after;
    Ok(taken)
}

/// The number that one to eight `bytes` are.
#[must_use]
pub fn number(bytes: &[u8], kind: Kind, big_endian: bool) -> f64 {
    let width = bytes.len();
    let mut bits = [0; 8];
    bits[..width].copy_from_slice(bytes);
    if big_endian {
        bits[..width].reverse();
    }
    let raw = u64::from_le_bytes(bits);
    match kind {
        Kind::Float if width == 4 => f64::from(f32::from_bits(raw as u32)),
        Kind::Float => f64::from_bits(raw),
        Kind::Signed => {
            // the sign moves to the first bit and back
            let free = 64 - 8 * width;
            ((raw << free) as i64 >> free) as f64
        }
        Kind::Unsigned => raw as f64,
    }
}
