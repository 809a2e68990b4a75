//! Numbers for people: units, decimals, typographic signs.

pub use crate::units::count;
use std::ops::Range;

/// What stands where there is no number.
pub const DASH: &str = "–";

/// Unit in which the report shows displacements, one for the whole report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthUnit {
    /// Units per metre.
    pub per_metre: f64,
    /// Symbol.
    pub symbol: &'static str,
}

impl LengthUnit {
    /// The largest unit in which `largest_m` (m) is at least 1/2; µm when nothing is known.
    pub fn for_largest(largest_m: f64) -> Self {
        const UNITS: [(f64, &str); 5] = [
            (1.0, "m"),
            (1e3, "mm"),
            (1e6, "µm"),
            (1e9, "nm"),
            (1e12, "pm"),
        ];
        let found = UNITS
            .iter()
            .find(|(per_metre, _)| largest_m * per_metre >= 0.5);
        let &(per_metre, symbol) = found.unwrap_or(&UNITS[2]);
        Self { per_metre, symbol }
    }
}

/// Four significant digits, powers of ten where that is long.
pub fn significant(value: f64) -> String {
    with_digits(value, 4)
}

/// The given number of significant digits, powers of ten where that is long.
pub fn with_digits(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return DASH.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = exponent(value, digits);
    if PLAIN.contains(&exponent) {
        let decimals = (digits - 1 - exponent).clamp(0, 6) as usize;
        return minus_sign(&format!("{value:.decimals$}"));
    }
    power_of_ten(&format!("{value:.*e}", DIGITS_BEFORE_POWER as usize - 1))
}

/// Powers of ten of numbers that are written without one.
const PLAIN: Range<i32> = -3..5;
/// Digits before a power of ten.
const DIGITS_BEFORE_POWER: i32 = 3;

/// The power of ten of the number with so many digits: 9.999 is 10.00.
fn exponent(value: f64, digits: i32) -> i32 {
    let rounded = format!("{:.*e}", (digits - 1).max(0) as usize, value.abs());
    (rounded.split_once('e')).map_or(0, |(_, e)| e.parse().unwrap_or(0))
}

/// `1.25·10⁻⁷` of `1.25e-7`.
fn power_of_ten(text: &str) -> String {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let exponent = exponent.parse().unwrap_or(0);
    minus_sign(&format!("{mantissa}·10{}", superscript(exponent)))
}

/// The number with so many significant digits.
fn rounded(value: f64, digits: i32) -> f64 {
    let text = format!("{value:.*e}", (digits - 1).max(0) as usize);
    text.parse().unwrap_or(value)
}

/// Digits of a decimal that a number holds for certain: what somebody stated has no more, and what arithmetic adds lies beyond.
const STATED_DIGITS: i32 = f64::DIGITS as i32;

/// A number that somebody has stated, as it was written: all its digits, powers of ten where that is long.
pub fn stated(value: f64) -> String {
    if !value.is_finite() {
        return DASH.to_owned();
    }
    let value = rounded(value, STATED_DIGITS);
    match value == 0.0 || (-5..8).contains(&exponent(value, STATED_DIGITS)) {
        true => minus_sign(&value.to_string()),
        false => power_of_ten(&format!("{value:e}")),
    }
}

/// A share that somebody has stated, as a percentage with all its digits.
pub fn stated_percent(share: f64) -> String {
    format!("{} %", stated(100.0 * share))
}

/// A number beside a limit: with the given number of digits, and with more where these would move it to another side of the limit.
pub fn beside(value: f64, limit: f64, digits: i32) -> String {
    let shown = match exponent(value, digits) {
        plain if PLAIN.contains(&plain) => digits.max(plain + 1),
        _ => DIGITS_BEFORE_POWER,
    };
    on_its_side(value, limit, shown).unwrap_or_else(|| with_digits(value, digits))
}

/// A share beside a limit of it, likewise.
pub fn percent_beside(share: f64, limit: f64) -> String {
    let (value, limit) = (100.0 * share, 100.0 * limit);
    let more = on_its_side(value, limit, 2 + more_than_two_digits(value));
    more.map_or_else(|| percent(share), |text| format!("{text} %"))
}

/// The number with as many digits, more than those shown, as it takes to see on which side of the limit it lies; absent where those
/// shown do.
fn on_its_side(value: f64, limit: f64, shown: i32) -> Option<String> {
    let side = |of: f64| of.partial_cmp(&limit);
    let seen = |digits: &i32| side(rounded(value, *digits)) == side(value);
    if seen(&shown) {
        return None;
    }
    let digits = (shown + 1..STATED_DIGITS).find(seen);
    Some(stated(rounded(value, digits.unwrap_or(STATED_DIGITS))))
}

/// A number as short as it can be written: values of inputs.
pub fn short(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() <= 7 {
        minus_sign(&plain)
    } else {
        significant(value)
    }
}

/// A frequency: two decimals from 100 Hz on, four digits below.
pub fn hertz(value: f64) -> String {
    if value.is_finite() && value.abs() >= 100.0 {
        format!("{value:.2}")
    } else {
        significant(value)
    }
}

/// A share as a percentage with two digits; with as many as it takes to tell it from the whole.
pub fn percent(share: f64) -> String {
    let value = 100.0 * share;
    match value.abs() {
        0.0 => "0 %".to_owned(),
        small if small < 9.95 => format!("{} %", with_digits(value, 2)),
        large if large.is_finite() => {
            format!("{value:.0$} %", more_than_two_digits(value) as usize)
        }
        _ => DASH.to_owned(),
    }
}

/// Digits that it takes, beyond two, to tell a percentage from the whole.
fn more_than_two_digits(percentage: f64) -> i32 {
    match percentage.abs() {
        most if (99.5..100.0).contains(&most) => {
            let decimals = -(100.0 - most).log10().floor();
            decimals.clamp(1.0, 12.0) as i32
        }
        _ => 0,
    }
}

/// A duration in the unit that fits.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if !s.is_finite() => DASH.to_owned(),
        s if s < 60.0 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{:.0} min {:.0} s", (s / 60.0).floor(), s % 60.0),
        s => format!(
            "{:.0} h {:.0} min",
            (s / 3600.0).floor(),
            (s % 3600.0) / 60.0
        ),
    }
}

/// A whole number in superscript digits.
pub fn superscript(number: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
    number.to_string().chars().map(digit).collect()
}

/// The text with a true minus sign instead of a hyphen.
pub fn minus_sign(text: &str) -> String {
    text.replace('-', "−")
}

/// The text of a number with a true minus sign, and without a sign where all its digits are 0.
pub fn signed(text: &str) -> String {
    let digits = text.trim_start_matches(['-', '+']);
    match digits.parse::<f64>() == Ok(0.0) {
        true => digits.to_owned(),
        false => minus_sign(text),
    }
}

/// The text with a capital letter at the start.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// `1 % … 5 %`, or `1 %` where both ends are shown alike.
pub fn from_to(ends: [f64; 2], show: impl Fn(f64) -> String) -> String {
    let [low, high] = ends.map(show);
    match low == high {
        true => low,
        false => format!("{low} … {high}"),
    }
}

/// `µm/N`; `µm per level` where the unit of the level is a sentence.
pub fn per_level(symbol: &str, unit: &str) -> String {
    match unit.contains(' ') {
        true => format!("{symbol} per level"),
        false => format!("{symbol}/{unit}"),
    }
}

/// `10 N`; `level 10` where the unit is a sentence.
pub fn level_name(level: f64, unit: &str) -> String {
    let level = stated(level);
    match unit.contains(' ') {
        true => format!("level {level}"),
        false => format!("{level} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with the exponent rounded instead of floored, with that of the number before it is rounded, and with shares in whole
    /// percent up to 1.
    #[test]
    fn numbers_are_short_and_exact() {
        assert_eq!(significant(3.2654), "3.265");
        assert_eq!(significant(0.01), "0.01000");
        assert_eq!(significant(1095.4), "1095");
        assert_eq!(significant(-2.5e-7), "−2.50·10⁻⁷");
        assert_eq!(significant(0.0), "0");
        // rounded to the next power of ten
        assert_eq!(significant(9.9996), "10.00");
        assert_eq!(significant(-9.999_6e-8), "−1.00·10⁻⁷");
        assert_eq!(percent(0.997), "99.7 %");
        assert_eq!(percent(0.999_999_999_9), "99.99999999 %");
        assert_eq!(
            (percent(1.0), percent(0.994)),
            ("100 %".into(), "99 %".into())
        );
        assert_eq!((short(300.0), short(0.1)), ("300".into(), "0.1".into()));
        assert_eq!(hertz(2968.304), "2968.30");
        assert_eq!(
            (percent(0.0), percent(0.0234), percent(0.5)),
            ("0 %".into(), "2.3 %".into(), "50 %".into())
        );
        assert_eq!(
            (duration(12.34), duration(75.0), duration(7260.0)),
            ("12.3 s".into(), "1 min 15 s".into(), "2 h 1 min".into())
        );
        assert_eq!(LengthUnit::for_largest(3.8e-6).symbol, "µm");
        assert_eq!(LengthUnit::for_largest(0.0).symbol, "µm");
        assert_eq!(LengthUnit::for_largest(f64::NAN).symbol, "µm");
    }

    /// What a user has stated is quoted as it was written, without what arithmetic adds to it. Seen to fail with four digits.
    #[test]
    fn stated_numbers_are_quoted_in_full() {
        for (value, expected) in [
            (885.6501, "885.6501"),
            (500.0, "500"),
            (0.1 + 0.2, "0.3"),
            (-1.000_000_1, "−1.0000001"),
            (0.0, "0"),
            (0.000_02, "0.00002"),
            (2.5e-6, "2.5·10⁻⁶"),
            (1e30, "1·10³⁰"),
        ] {
            assert_eq!(stated(value), expected);
        }
        for (share, expected) in [
            (0.975, "97.5 %"),
            (0.1249, "12.49 %"),
            (1e-6, "0.0001 %"),
            (0.999_999_999_999_9, "99.99999999999 %"),
        ] {
            assert_eq!(stated_percent(share), expected);
        }
        assert_ne!(level_name(1.0, "N"), level_name(1.000_000_1, "N"));
    }

    /// A number beside a limit is shown on the side where it lies, with more digits only where that takes them. Seen to fail with the
    /// usual digits.
    #[test]
    fn numbers_stay_on_their_side_of_a_limit() {
        for (value, limit, expected) in [
            (885.66, 885.6501, "885.7"),
            (885.6501, 885.6501, "885.6501"),
            (885.68, 885.7, "885.68"),
            (500.000_3, 500.0, "500.0003"),
            (499.999_97, 500.0, "499.99997"),
            (-0.000_999_96, -0.001, "−0.00099996"),
            (12_345.4, 12_345.0, "12345.4"),
            (1.234e7, 1.23e7, "12340000"),
            (500.0, 500.0, "500.0"),
            (f64::NAN, 500.0, DASH),
        ] {
            assert_eq!(beside(value, limit, 4), expected, "{value} at {limit}");
        }
        for (share, limit, expected) in [
            (0.1249, 0.1249, "12.49 %"),
            (0.1251, 0.1249, "13 %"),
            (0.1248, 0.1249, "12 %"),
            (0.997, 0.9971, "99.7 %"),
            (0.999_04, 0.999, "99.904 %"),
            (1.0, 0.999, "100 %"),
            (0.0, 1e-6, "0 %"),
        ] {
            assert_eq!(percent_beside(share, limit), expected, "{share} at {limit}");
        }
    }

    /// Seen to fail with the sign of what is rounded to 0, and with a plural of one.
    #[test]
    fn signs_and_nouns_follow_the_number() {
        let signs = ["-0.004", "0.004", "-0.12"].map(|text| {
            let value: f64 = text.parse().unwrap();
            signed(&format!("{value:+.2}"))
        });
        assert_eq!(signs, ["0.00", "0.00", "−0.12"]);
        let counts = [0, 1, 2].map(|n| count(n, "curve"));
        assert_eq!(counts, ["0 curves", "1 curve", "2 curves"]);
    }
}
