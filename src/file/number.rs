//! Numbers as programs write them: with the exponents of Fortran, and with how many digits.

/// Characters of a number at most: no program writes longer ones.
const LONGEST_NUMBER: usize = 64;

/// The number that a word states. Fortran's `1.5D+03`, and `1.5+3` without a letter, are read as `1.5e+03`.
#[must_use]
pub fn parse_number(word: &str) -> Option<f64> {
    if word.len() > LONGEST_NUMBER || !word.is_ascii() {
        return None;
    }
    if let Ok(value) = word.parse() {
        return Some(value);
    }
    let end = mantissa_end(word);
    let (mantissa, exponent) = word.split_at(end);
    let exponent = exponent.trim_start_matches(['D', 'd', 'E', 'e']);
    let plain = mantissa.bytes().all(|b| !b.is_ascii_alphabetic());
    if !plain || exponent.is_empty() || word.len() - end > exponent.len() + 1 {
        return None;
    }
    format!("{mantissa}e{exponent}").parse().ok()
}

/// Digits of the mantissa from the first that is not 0. Zeros at the end of an integer do not count: `210000` has two.
#[must_use]
pub fn significant_digits(word: &str) -> u32 {
    let mantissa = &word[..mantissa_end(word)];
    let digits = mantissa.bytes().filter(u8::is_ascii_digit);
    let digits: Vec<u8> = digits.skip_while(|b| *b == b'0').collect();
    let kept = match mantissa.contains('.') {
        true => digits.len(),
        false => digits
            .iter()
            .rposition(|b| *b != b'0')
            .map_or(0, |at| at + 1),
    };
    u32::try_from(kept).unwrap_or(u32::MAX)
}

/// Where the exponent begins.
fn mantissa_end(word: &str) -> usize {
    let bytes = word.as_bytes();
    let begins = |&at: &usize| match bytes[at] {
        b'D' | b'd' | b'E' | b'e' => true,
        b'+' | b'-' => at > 0,
        _ => false,
    };
    (0..bytes.len()).find(begins).unwrap_or(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with the standard library's `parse` alone.
    #[test]
    fn numbers_of_fortran_are_read() {
        let numbers = [
            ("1.5", 1.5),
            ("-2.5D+03", -2500.0),
            ("3.d2", 300.0),
            ("3.+5", 3e5),
            ("-1.-3", -1e-3),
            ("2.61306980E+010", 2.613_069_8e10),
            (".5", 0.5),
            ("7", 7.0),
        ];
        for (word, value) in numbers {
            assert_eq!(parse_number(word), Some(value), "{word}");
        }
        let others = [
            "", "-", "1.5DD3", "D5", "1.5D", "1,5", "0x10", "1.5 3", "e", "+-3", "1e+-3", "é1",
        ];
        for word in others {
            assert_eq!(parse_number(word), None, "{word}");
        }
        assert_eq!(parse_number(&"1".repeat(100)), None);
    }

    /// Seen to fail with zeros before the first digit counted.
    #[test]
    fn digits_are_counted_from_the_first_that_is_not_zero() {
        let words = [
            ("2.61306980E+010", 9),
            ("0.982478009259333D+02", 15),
            ("-0.010", 2),
            ("210000", 2),
            ("1e6", 1),
            ("3.+5", 1),
            ("0.0", 0),
            ("", 0),
        ];
        for (word, digits) in words {
            assert_eq!(significant_digits(word), digits, "{word}");
        }
    }
}
