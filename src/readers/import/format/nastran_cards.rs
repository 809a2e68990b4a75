//! Bulk data entries of Nastran: small, large and free fields, with their continuations.

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

/// Columns of the name of a fixed entry.
const NAME: usize = 8;

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
pub(in crate::import) fn each_card<'t>(
    path: &'t Path,
    text: &'t str,
    names: &[&str],
    mut take: impl FnMut(Card<'t>) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let mut current: Option<Card<'t>> = None;
    let mut lines = Lines::new(path, text);
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
                add(card, &fields, large, lines.number);
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
            add(&mut card, &fields, large, lines.number);
            current = Some(card);
        }
    }
    current.map_or(Ok(()), take)
}

/// Fields of a line: eight, or four large ones.
fn add<'t>(card: &mut Card<'t>, fields: &[&'t str], large: bool, line: u64) {
    let many = if large { 4 } else { 8 };
    let blank = std::iter::repeat(&"");
    let filled = fields.iter().chain(blank).take(many);
    card.fields.extend(filled.map(|field| (line, *field)));
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

/// Fields of fixed width, as far as column 72.
fn fixed(rest: &str, large: bool) -> Vec<&str> {
    let width = if large { 16 } else { 8 };
    let end = rest.len().min(64);
    let starts = (0..end).step_by(width);
    starts
        .map(|at| rest[at..end.min(at + width)].trim())
        .collect()
}
