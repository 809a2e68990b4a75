//! Universal files with datasets 58 (functions of time), in text or binary (58b); other datasets are passed over.
//!
//! Format: "Universal Dataset Number 58, Function at Nodal DOF" (SDRC 1993) and "The Binary 58 Universal File Format" (UC-SDRL).
//! A dataset is a signal: ID line 1, else the label of the ordinate, names it, and the units stand with the axes. Datasets with the
//! same ID line 2 are a test; ID lines 3 to 5 may state conditions.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::channels::{Channels, MOST_NUMBERS, MOST_TESTS};
use super::super::quantity::{Quantity, Unit};
use super::super::signals::TestConditions;
use super::uff_lines::UffLines;
use crate::file::binary::{Kind, number};
use crate::file::{FileError, finite_number, scaled_number};

/// Line before and after each dataset.
const MARK: &str = "-1";
/// Type of an axis that is the time.
const TIME_AXIS: &str = "17";
/// Columns of an axis' label and of its unit.
const AXIS: [std::ops::Range<usize>; 2] = [26..46, 47..67];

/// Whether the bytes begin as such a file.
pub(in crate::record) fn begins(bytes: &[u8]) -> bool {
    let mut lines = UffLines::new(bytes);
    let first = lines.find(|line| !line.trim().is_empty());
    first.is_some_and(|line| line.trim() == MARK)
}

/// The tests of a file.
///
/// # Errors
/// [`FileError`] with the line and the rule that it breaks.
pub(in crate::record) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<Channels>, FileError> {
    let mut lines = UffLines::new(bytes);
    let tests = tests(&mut lines);
    tests.map_err(|rule| FileError::content(path, Some(lines.number), rule))
}

fn tests(lines: &mut UffLines<'_>) -> Result<Vec<Channels>, String> {
    let mut tests = Tests::default();
    let mut left = MOST_NUMBERS;
    while let Some(line) = lines.next() {
        match line.trim() {
            "" => continue,
            MARK => {}
            _ => return Err(format!("must be {MARK}, which begins a dataset")),
        }
        let kind = lines.need()?;
        let binary = match kind.split_whitespace().next() {
            Some("58") => None,
            Some("58b") => Some(Binary::of(&kind)?),
            _ => {
                lines.pass_to(MARK)?;
                continue;
            }
        };
        let head = Head::read(lines)?;
        let Some((quantity, unit)) = head.quantity().map_err(|(line, rule)| {
            lines.number = line;
            rule
        })?
        else {
            if let Some(binary) = binary {
                lines.take(binary.bytes)?;
            }
            lines.pass_to(MARK)?;
            continue;
        };
        if let Some((line, rule)) = head.not_read {
            lines.number = line;
            return Err(rule);
        }
        let needed = 2 * head.points;
        left = left
            .checked_sub(needed)
            .ok_or_else(|| format!("has more than {MOST_NUMBERS} numbers"))?;
        let [time, values] = match binary {
            Some(binary) => binary.numbers(lines, &head, unit)?,
            None => text_numbers(lines, &head, unit)?,
        };
        if lines.need()?.trim() != MARK {
            return Err(format!("must be {MARK}, which ends a dataset"));
        }
        tests.take(&head, quantity, time, values)?;
    }
    match tests.all.is_empty() {
        true => Err("has no function of time with a name such as tangential force".to_owned()),
        false => Ok(tests.all),
    }
}

/// Tests, found by the line that names them.
#[derive(Default)]
struct Tests {
    all: Vec<Channels>,
    by_label: BTreeMap<Option<String>, usize>,
}

impl Tests {
    /// Adds a signal to its test.
    fn take(
        &mut self,
        head: &Head,
        quantity: Quantity,
        time: Vec<f64>,
        values: Vec<f64>,
    ) -> Result<(), String> {
        let label = Some(head.identity[1].clone()).filter(|id| !is_none(id));
        let next = self.all.len();
        let at = *self.by_label.entry(label.clone()).or_insert(next);
        if at == MOST_TESTS {
            return Err(format!("has more than {MOST_TESTS} tests"));
        }
        if at == next {
            self.all.push(Channels {
                label,
                ..Channels::default()
            });
        }
        let test = &mut self.all[at];
        match test.signals.get(&Quantity::Time) {
            None => test.insert(Quantity::Time, time)?,
            Some(known) if *known == time => {}
            Some(_) => {
                return Err(
                    "abscissa: must be that of the other datasets with the same ID line 2"
                        .to_owned(),
                );
            }
        }
        let conditions = head.conditions()?;
        if test.conditions == TestConditions::default() {
            test.conditions = conditions;
        } else if conditions != TestConditions::default() && conditions != test.conditions {
            return Err(
                "conditions: must be those of the other datasets with the same ID line 2"
                    .to_owned(),
            );
        }
        let inserted = test.insert(quantity, values);
        inserted.map_err(|rule| format!("{rule} for each ID line 2, which names a test"))
    }
}

/// Whether a field says that it is not used.
fn is_none(text: &str) -> bool {
    text.trim().is_empty() || text.trim().eq_ignore_ascii_case("none")
}

/// Name and unit of an axis.
struct Axis {
    line: u64,
    is_time: bool,
    label: String,
    unit: Option<String>,
}

/// What an ordinate is, and the units of abscissa and ordinate.
type Signal = (Quantity, [Unit; 2]);

/// Lines before the numbers.
struct Head {
    identity: Vec<String>,
    double: bool,
    /// Line and rule of a type that is not read; it matters for signals of a test alone.
    not_read: Option<(u64, String)>,
    points: usize,
    /// First abscissa and step; absent where each point has its own.
    even: Option<[f64; 2]>,
    abscissa: Axis,
    ordinate: Axis,
}

impl Head {
    fn read(lines: &mut UffLines<'_>) -> Result<Self, String> {
        let mut identity = Vec::new();
        for _ in 0..5 {
            identity.push(lines.need()?.trim().to_owned());
        }
        lines.need()?;
        let form = lines.need()?;
        let words: Vec<&str> = form.split_whitespace().collect();
        let [kind, points, spacing, first, step, ..] = words[..] else {
            return Err(
                "must have type, number of points, spacing, first abscissa and step".to_owned(),
            );
        };
        let not_read = match kind {
            "2" | "4" => None,
            "5" | "6" => Some("is complex: must be real".to_owned()),
            _ => Some(format!(
                "data type {kind:.20}: must be 2 or 4, real numbers"
            )),
        };
        let not_read = not_read.map(|rule| (lines.number, rule));
        let points = points
            .parse()
            .ok()
            .filter(|n| (1..=MOST_NUMBERS).contains(n));
        let points =
            points.ok_or_else(|| format!("number of points: must be from 1 to {MOST_NUMBERS}"))?;
        let even = match spacing {
            "0" => None,
            "1" => Some([finite_number(first)?, finite_number(step)?]),
            _ => return Err(format!("spacing {spacing:.20}: must be 0 or 1")),
        };
        let abscissa = Axis::read(lines)?;
        let ordinate = Axis::read(lines)?;
        lines.need()?;
        lines.need()?;
        Ok(Self {
            identity,
            double: kind == "4",
            not_read,
            points,
            even,
            abscissa,
            ordinate,
        })
    }

    /// What the ordinate is, and the units of both axes; nothing for functions that are no signal of a test.
    ///
    /// # Errors
    /// Line and rule.
    fn quantity(&self) -> Result<Option<Signal>, (u64, String)> {
        let is_time = self.abscissa.is_time
            || Quantity::named(&self.abscissa.label, &[Quantity::Time]).is_some();
        let names = [&self.identity[0], &self.ordinate.label];
        let known = &Quantity::SIGNALS[1..];
        let quantity = names
            .into_iter()
            .find_map(|name| Quantity::named(name, known));
        let Some(quantity) = quantity.filter(|_| is_time) else {
            return Ok(None);
        };
        let unit = |quantity: Quantity, axis: &Axis| {
            let unit = quantity.unit(axis.unit.as_deref());
            unit.map_err(|rule| (axis.line, rule))
        };
        let time = unit(Quantity::Time, &self.abscissa)?;
        let unit = unit(quantity, &self.ordinate)?;
        Ok(Some((quantity, [time, unit])))
    }

    fn conditions(&self) -> Result<TestConditions, String> {
        let mut conditions = TestConditions::default();
        for line in &self.identity[2..] {
            conditions.take_line(line)?;
        }
        Ok(conditions)
    }

    /// Abscissas (s) with a constant step.
    fn times(&self, [first, step]: [f64; 2], unit: Unit) -> Vec<f64> {
        let times = (0..self.points).map(|at| unit.to_si(first + step * at as f64));
        times.collect()
    }
}

impl Axis {
    fn read(lines: &mut UffLines<'_>) -> Result<Self, String> {
        let line = lines.need()?;
        let [label, unit] = AXIS.map(|columns| {
            let all = line.chars().skip(columns.start);
            let field: String = all.take(columns.len()).collect();
            field.trim().to_owned()
        });
        Ok(Self {
            line: lines.number,
            is_time: line.split_whitespace().next() == Some(TIME_AXIS),
            label,
            unit: Some(unit).filter(|unit| !is_none(unit)),
        })
    }
}

/// Times and values of a dataset in text.
fn text_numbers(
    lines: &mut UffLines<'_>,
    head: &Head,
    [time, unit]: [Unit; 2],
) -> Result<[Vec<f64>; 2], String> {
    let (mut times, mut values) = (Vec::new(), Vec::new());
    while values.len() < head.points {
        let line = lines.need()?;
        if line.trim() == MARK {
            let (n, found) = (head.points, values.len());
            return Err(format!("ends the dataset after {found} of {n} points"));
        }
        for word in line.split_whitespace() {
            if values.len() == head.points {
                return Err(format!("has more than the stated {} points", head.points));
            }
            match head.even.is_none() && times.len() == values.len() {
                true => times.push(scaled_number(word, time.power)?),
                false => values.push(scaled_number(word, unit.power)?),
            }
        }
    }
    if let Some(even) = head.even {
        times = head.times(even, time);
    }
    if times.len() != values.len() {
        return Err(format!("has more than the stated {} points", head.points));
    }
    Ok([times, values])
}

/// How the numbers of a binary dataset are stored.
struct Binary {
    big_endian: bool,
    bytes: usize,
}

impl Binary {
    fn of(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, order, format, head, bytes, ..] = words[..] else {
            return Err("must have byte order, format, lines and bytes after 58b".to_owned());
        };
        let big_endian = match order {
            "1" => false,
            "2" => true,
            _ => return Err(format!("byte order {order:.20}: must be 1 or 2")),
        };
        if format != "2" {
            return Err(format!(
                "format of numbers {format:.20}: must be 2, IEEE 754"
            ));
        }
        if head != "11" {
            return Err(format!("lines before the numbers {head:.20}: must be 11"));
        }
        let bytes = bytes
            .parse()
            .map_err(|_| "number of bytes: must be a whole number")?;
        Ok(Self { big_endian, bytes })
    }

    /// Each point has a value, before it where spacing is uneven an abscissa: in single precision, or as the value.
    fn numbers(
        &self,
        lines: &mut UffLines<'_>,
        head: &Head,
        [time, unit]: [Unit; 2],
    ) -> Result<[Vec<f64>; 2], String> {
        let width = if head.double { 8 } else { 4 };
        let stated = self.bytes;
        let both = stated / head.points;
        let known = match head.even {
            Some(_) => both == width,
            None => both == width + 4 || both == 2 * width,
        };
        if !known || both * head.points != stated {
            let points = head.points;
            return Err(format!(
                "has {stated} bytes: they do not fit {points} points of {width} bytes"
            ));
        }
        let bytes = lines.take(stated)?;
        let (mut times, mut values) = (Vec::new(), Vec::new());
        for point in bytes.chunks_exact(both) {
            let (abscissa, value) = point.split_at(both - width);
            if !abscissa.is_empty() {
                times.push(time.to_si(number(abscissa, Kind::Float, self.big_endian)));
            }
            values.push(unit.to_si(number(value, Kind::Float, self.big_endian)));
        }
        if let Some(even) = head.even {
            times = head.times(even, time);
        }
        Ok([times, values])
    }
}
