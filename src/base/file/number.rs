//! Numbers as programs write them: with the exponents of Fortran, and with how many digits.

/// Characters of a number at most: no program writes longer ones.
const LONGEST_NUMBER: usize = 64;
/// Characters of a word that a message shows.
const SHOWN: usize = 40;
/// Decimal exponent up to which a number is written without one.
const LONGEST_PLAIN: u32 = 15;

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

/// The finite number that a word states.
///
/// # Errors
/// The rule, unless it is one.
pub fn finite_number(word: &str) -> Result<f64, String> {
    let shown: String = word.chars().take(SHOWN).collect();
    let value = parse_number(word).ok_or_else(|| format!("{shown}: must be a number"))?;
    match value.is_finite() {
        true => Ok(value),
        false => Err(format!("{shown}: must be a finite number")),
    }
}

/// The number that a word states times ten to `power`, as if its decimal point were moved: rounded once, unlike a product.
///
/// # Errors
/// The rule, unless it is a finite number.
pub fn scaled_number(word: &str, power: i32) -> Result<f64, String> {
    let value = finite_number(word)?;
    if power == 0 || value == 0.0 {
        return Ok(value);
    }
    let (mantissa, exponent) = word.split_at(mantissa_end(word));
    let exponent = exponent.trim_start_matches(['D', 'd', 'E', 'e']);
    let exponent = match exponent {
        "" => Some(0),
        exponent => exponent.parse::<i32>().ok(),
    };
    let moved = exponent.and_then(|exponent| exponent.checked_add(power));
    let moved = moved.and_then(|exponent| format!("{mantissa}e{exponent}").parse::<f64>().ok());
    let shown: String = word.chars().take(SHOWN).collect();
    let finite = moved.filter(|value| value.is_finite());
    finite.ok_or_else(|| format!("{shown}: must be a finite number"))
}

/// The shortest decimal that [`scaled_number`] reads back as `value` with the same `power`: `1.25e-5` is `12.5` with power −6.
#[must_use]
pub fn shortest_decimal(value: f64, power: i32) -> String {
    let scientific = format!("{value:e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    let exponent = exponent.parse::<i32>().unwrap_or_default() - power;
    if value == 0.0 {
        return "0".to_owned();
    }
    if exponent.unsigned_abs() > LONGEST_PLAIN {
        return format!("{mantissa}e{exponent}");
    }
    let (sign, mantissa) = match mantissa.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", mantissa),
    };
    let digits = mantissa.replace('.', "");
    // digits before the point
    let before = exponent + 1;
    let zeros = |n: i32| "0".repeat(usize::try_from(n).unwrap_or_default());
    match usize::try_from(before).unwrap_or_default() {
        0 => format!("{sign}0.{}{digits}", zeros(-before)),
        n if n >= digits.len() => {
            let length = i32::try_from(digits.len()).unwrap_or_default();
            format!("{sign}{digits}{}", zeros(before - length))
        }
        n => format!("{sign}{}.{}", &digits[..n], &digits[n..]),
    }
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

    /// Seen to fail with a product in place of the moved point: 12.3 um was not 1.23e-5 m.
    #[test]
    fn a_moved_point_is_rounded_once() {
        let words = [
            ("12.3", -6, 1.23e-5),
            ("-0.07", -3, -7e-5),
            ("1.5D+03", 3, 1.5e6),
            ("3.+5", -6, 0.3),
            ("0", -6, 0.0),
            ("2.61306980E+010", -9, 26.130_698),
        ];
        for (word, power, value) in words {
            assert_eq!(scaled_number(word, power), Ok(value), "{word}");
        }
        for word in ["", "1,5", "NaN", "inf", "1e999", "9e307"] {
            assert!(scaled_number(word, 3).is_err(), "{word}");
        }
    }

    /// Seen to fail with one digit less than the shortest.
    #[test]
    fn the_shortest_decimal_reads_back() {
        let texts = [
            (1.23e-5, -6, "12.3"),
            (-1.0, -3, "-1000"),
            (2.5e-9, -6, "0.0025"),
            (1234.5, 3, "1.2345"),
            (0.0, -6, "0"),
            (-0.0, -6, "0"),
            (1e30, 0, "1e30"),
            (1e-20, 0, "1e-20"),
            (0.1 + 0.2, 0, "0.30000000000000004"),
        ];
        for (value, power, text) in texts {
            assert_eq!(shortest_decimal(value, power), text);
        }
        let mut value = 1.0e-30_f64;
        for step in 0..2000 {
            value *= 1.0 + 0.07 / f64::from(1 + step % 7);
            for power in [-9, -6, -3, 0, 3] {
                let text = shortest_decimal(value, power);
                assert_eq!(scaled_number(&text, power), Ok(value), "{text} {power}");
            }
        }
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
