//! Bulk data entries of Nastran: small, large and free fields, with their continuations.

use std::borrow::Cow;
use std::path::Path;

use super::super::lines::Lines;
use crate::file::FileError;

/// One entry: its name and all its fields, blank ones included.
#[derive(Debug)]
pub(in crate::import) struct Card<'t> {
    /// Name, such as DMIG.
    pub(in crate::import) name: String,
    /// Fields after the name, with their lines.
    pub(in crate::import) fields: Vec<(u64, &'t str)>,
}

/// Columns of the name of a fixed entry, and of a small field.
const NAME: usize = 8;
/// Columns of all fields of a fixed line; behind them stands the marker of a continuation, as wide as a name.
const DATA: usize = 64;

impl Card<'_> {
    /// Field `at`, blank where there is none.
    pub(in crate::import) fn field(&self, at: usize) -> &str {
        self.fields.get(at).map_or("", |(_, field)| field)
    }

    /// The fault of a field's line.
    pub(in crate::import) fn fault(
        &self,
        path: &Path,
        at: usize,
        rule: impl Into<String>,
    ) -> FileError {
        let line = self.fields.get(at).or(self.fields.last());
        FileError::content(path, line.map(|(line, _)| *line), rule)
    }
}

/// Calls `take` with every entry whose name is among `names`.
pub(in crate::import) fn each_card(
    path: &Path,
    text: &str,
    names: &[&str],
    mut take: impl FnMut(Card<'_>) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let text = without_tabs(text);
    let mut current: Option<Card<'_>> = None;
    let mut lines = Lines::new(path, &text);
    while let Some(line) = lines.next() {
        let line = line.split('$').next().unwrap_or_default().trim_end();
        if line.is_empty() {
            continue;
        }
        if !line.is_ascii() {
            // of entries that are read: others may hold titles
            if current.is_some() {
                return Err(lines.fault("must be plain text (ASCII)"));
            }
            continue;
        }
        let (name, large, fields) = split(line);
        if name.is_empty() {
            if let Some(card) = &mut current {
                add(card, &fields, large, lines.number).map_err(|rule| lines.fault(rule))?;
            }
            continue;
        }
        if let Some(card) = current.take() {
            take(card)?;
        }
        if names.contains(&name.as_str()) {
            let mut card = Card {
                name,
                fields: Vec::new(),
            };
            add(&mut card, &fields, large, lines.number).map_err(|rule| lines.fault(rule))?;
            current = Some(card);
        }
    }
    current.map_or(Ok(()), take)
}

/// Tabs lead to the next of the columns 9, 17, ..., as in Nastran; between commas they are blanks like others.
fn without_tabs(text: &str) -> Cow<'_, str> {
    if !text.contains('\t') {
        return Cow::Borrowed(text);
    }
    let mut expanded = String::with_capacity(2 * text.len());
    for line in text.lines() {
        let begin = expanded.len();
        for (at, part) in line.split('\t').enumerate() {
            if at > 0 {
                let column = expanded.len() - begin;
                expanded.extend(std::iter::repeat_n(' ', NAME - column % NAME));
            }
            expanded.push_str(part);
        }
        expanded.push('\n');
    }
    Cow::Owned(expanded)
}

/// Takes the fields of a line: eight, or four large ones.
///
/// # Errors
/// The rule if something stands behind them that is no marker of a continuation.
fn add<'t>(card: &mut Card<'t>, fields: &[&'t str], large: bool, line: u64) -> Result<(), String> {
    let many = if large { 4 } else { 8 };
    let is_marker = |at: usize, field: &str| at == many && field.starts_with(['+', '*']);
    let mut behind = (0..).zip(fields).skip(many);
    let data = behind.find(|(at, field)| !field.is_empty() && !is_marker(*at, field));
    if let Some((_, field)) = data {
        return Err(format!(
            "{field:.20}: stands behind the {many} fields of a line: must be blank, or the marker of a continuation (+ or *)"
        ));
    }
    let blank = std::iter::repeat(&"");
    let filled = fields.iter().chain(blank).take(many);
    card.fields.extend(filled.map(|field| (line, *field)));
    Ok(())
}

/// Name (empty for a continuation), whether fields are large, fields.
fn split(line: &str) -> (String, bool, Vec<&str>) {
    let (name, fields): (&str, Vec<&str>) = match line.split_once(',') {
        Some((name, rest)) => (name.trim(), rest.split(',').map(str::trim).collect()),
        None => {
            let (name, rest) = line.split_at(NAME.min(line.len()));
            (name.trim(), Vec::from([rest]))
        }
    };
    let large = name.starts_with('*') || name.ends_with('*');
    let fields = match line.contains(',') {
        true => fields,
        false => fixed(fields.first().copied().unwrap_or_default(), large),
    };
    let continues = name.is_empty() || name.starts_with(['+', '*']);
    let name = match continues {
        true => String::new(),
        false => name.trim_end_matches('*').to_ascii_uppercase(),
    };
    (name, large, fields)
}

/// Fields of fixed width; then a blank in place of the marker of a continuation, and what stands behind it.
fn fixed(rest: &str, large: bool) -> Vec<&str> {
    let width = if large { 2 * NAME } else { NAME };
    let between = |from: usize, to: usize| rest[from.min(rest.len())..to.min(rest.len())].trim();
    let fields = (0..DATA).step_by(width).map(|at| between(at, at + width));
    let behind = between(DATA + NAME, rest.len());
    fields.chain(["", behind]).collect()
}
