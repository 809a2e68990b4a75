//! What a page is made of: sections of headings, sentences, figures and tables.
//!
//! Sections decide what is said; the template decides how it looks, so each stays small. Figures and tables carry their
//! own download: the SVG and CSV texts are part of the page.

use super::figure::Panel;
use super::level_mark::shape;
use serde::Serialize;

/// One section of the page.
#[derive(Debug, Clone, Serialize)]
pub struct Section {
    /// Anchor, for links inside the page and names of downloads.
    pub id: &'static str,
    /// Heading.
    pub title: String,
    /// Content, from top to bottom.
    pub blocks: Vec<Block>,
}

/// One part of a section.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "kind", content = "content", rename_all = "kebab-case")]
pub enum Block {
    /// A smaller heading.
    Heading(String),
    /// A paragraph.
    Sentence(String),
    /// A paragraph in small print.
    Hint(String),
    /// A paragraph that sets the reader at ease.
    Fine(String),
    /// What must be known before a number is used.
    Notices(Vec<String>),
    /// One plain sentence per judgement.
    Verdicts(Vec<Verdict>),
    /// Name and value of the numbers that matter most.
    Facts(Vec<(String, String)>),
    /// Marks and what they mean.
    Legend(Vec<Key>),
    /// Figures side by side.
    Figures(Row),
    /// Numbers.
    Table(Table),
}

/// A judgement in words.
#[derive(Debug, Clone, Serialize)]
pub struct Verdict {
    /// The judgement.
    pub word: String,
    /// Class of its badge.
    pub class: &'static str,
    /// Name of the criterion.
    pub name: String,
    /// What was found, asked and, if undecided, what would decide.
    pub sentence: String,
}

/// Figures side by side.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// How many fit into a wide window.
    pub columns: Columns,
    /// The figures.
    pub figures: Vec<Figure>,
}

/// How many figures fit into a wide window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Columns {
    /// Two.
    Two,
    /// Three.
    Three,
}

/// A panel in the page.
#[derive(Debug, Clone, Serialize)]
pub struct Figure {
    /// SVG, inline.
    svg: String,
    /// The same with its own style sheet, as the target of a link.
    link: String,
    /// File name of the download.
    file: String,
    /// What the reader must know; may be empty.
    caption: String,
}

/// One line of a legend.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Key {
    /// Shape.
    pub mark: Mark,
    /// Its class in the style sheet.
    pub class: String,
    /// Of a chip: the shape of its level.
    shape: Option<&'static str>,
    /// What it means.
    pub text: String,
}

/// Shape of a mark in a legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// A spot in the colour and the shape of a level.
    Chip,
    /// A line.
    Line,
    /// A filled band with its middle line.
    Band,
    /// A ring.
    Ring,
    /// A cross.
    Cross,
}

impl Key {
    /// A mark with its meaning.
    pub fn new(mark: Mark, class: &str, text: impl Into<String>) -> Self {
        Self {
            mark,
            class: class.to_owned(),
            shape: None,
            text: text.into(),
        }
    }

    /// The mark of excitation level `i`.
    pub fn level(i: usize, text: impl Into<String>) -> Self {
        Self {
            shape: Some(shape(i)),
            ..Self::new(Mark::Chip, &format!("l{i}"), text)
        }
    }
}

impl Figure {
    /// A panel with its download in the given style sheet; `file` without ending.
    pub fn new(panel: &Panel, style: &str, file: String, caption: String) -> Self {
        let link = data_link("image/svg+xml", &panel.standalone(style));
        Self {
            svg: panel.svg(),
            link,
            file: format!("{file}.svg"),
            caption,
        }
    }
}

impl Block {
    /// Figures two to a row.
    pub fn pairs(figures: Vec<Figure>) -> Self {
        Self::Figures(Row {
            columns: Columns::Two,
            figures,
        })
    }

    /// Figures three to a row.
    pub fn triples(figures: Vec<Figure>) -> Self {
        Self::Figures(Row {
            columns: Columns::Three,
            figures,
        })
    }
}

/// A table and its download.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    title: String,
    file: String,
    heads: Vec<Head>,
    #[serde(skip)]
    fields: Vec<&'static str>,
    rows: Vec<TableRow>,
    link: String,
}

/// Head of a column.
#[derive(Debug, Clone, Serialize)]
struct Head {
    text: String,
    /// Class of the first cell below it.
    class: String,
}

/// One row of a table.
#[derive(Debug, Clone, Serialize)]
struct TableRow {
    quiet: bool,
    cells: Vec<Cell>,
}

/// One cell of a table.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Cell {
    text: String,
    small: Vec<String>,
    warning: Option<String>,
    /// Class of the cell in the style sheet.
    class: String,
    /// Class of a badge around the text.
    badge: Option<&'static str>,
    /// Excitation level whose mark stands before the text.
    chip: Option<Chip>,
    /// Strength of the background (%).
    shade: Option<f64>,
    #[serde(skip)]
    raw: Vec<String>,
}

/// Mark of an excitation level.
#[derive(Debug, Clone, Copy, Serialize)]
struct Chip {
    level: usize,
    shape: &'static str,
}

impl Table {
    /// An empty table; `columns` are the head in the page and the fields in the download, the latter with their units.
    pub fn new(
        title: impl Into<String>,
        file: &str,
        columns: impl IntoIterator<Item = (String, &'static [&'static str])>,
    ) -> Self {
        let (heads, fields): (Vec<String>, Vec<_>) = columns.into_iter().unzip();
        let head = |text: String| Head {
            text,
            class: String::new(),
        };
        Self {
            title: title.into(),
            file: format!("{file}.csv"),
            heads: heads.into_iter().map(head).collect(),
            fields: fields.concat(),
            rows: Vec::new(),
            link: String::new(),
        }
    }

    /// As [`Table::new`], with columns that are known beforehand.
    pub fn of(
        title: impl Into<String>,
        file: &str,
        columns: &[(&str, &'static [&'static str])],
    ) -> Self {
        let owned = |(head, fields): &(&str, &'static [&'static str])| (head.to_string(), *fields);
        Self::new(title, file, columns.iter().map(owned))
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<Cell>) {
        self.rows.push(TableRow {
            quiet: false,
            cells,
        });
    }

    /// Adds a row that matters little.
    pub fn quiet_row(&mut self, cells: Vec<Cell>) {
        self.rows.push(TableRow { quiet: true, cells });
    }

    /// The table with its download, as a part of a section.
    pub fn block(mut self) -> Block {
        let first = self.rows.first().map_or(&[][..], |row| &row.cells);
        for (head, cell) in self.heads.iter_mut().zip(first) {
            head.class.clone_from(&cell.class);
        }
        self.link = data_link("text/csv;charset=utf-8", &self.csv());
        Block::Table(self)
    }

    /// RFC 4180, one line per row, numbers in full.
    fn csv(&self) -> String {
        let mut table = csv::WriterBuilder::new()
            .terminator(csv::Terminator::CRLF)
            .flexible(true)
            .from_writer(Vec::new());
        // writing to memory does not fail
        let _ = table.write_record(&self.fields);
        for row in &self.rows {
            let fields = row.cells.iter().flat_map(|c| &c.raw);
            let _ = table.write_record(fields.map(|f| no_formula(f)));
        }
        let text = table.into_inner().unwrap_or_default();
        String::from_utf8(text).unwrap_or_default()
    }
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        let text = text.into();
        Self {
            raw: vec![text.clone()],
            text,
            ..Self::default()
        }
    }

    /// A number as shown and as it is; empty in the download where it is absent.
    pub fn number(text: impl Into<String>, value: Option<f64>) -> Self {
        Self {
            raw: vec![full(value)],
            text: text.into(),
            ..Self::default()
        }
    }

    /// A whole number.
    #[must_use]
    pub fn whole(n: u64) -> Self {
        Self::number(n.to_string(), Some(n as f64))
    }

    /// With further numbers for the download, such as the limits of an interval.
    pub fn with_raw(mut self, values: impl IntoIterator<Item = Option<f64>>) -> Self {
        self.raw.extend(values.into_iter().map(full));
        self
    }

    /// With a further text for the download.
    pub fn with_raw_text(mut self, text: impl Into<String>) -> Self {
        self.raw.push(text.into());
        self
    }

    /// With a line in small print below, if there is one.
    pub fn with_small(mut self, text: impl Into<String>) -> Self {
        let text = text.into();
        if !text.is_empty() {
            self.small.push(text);
        }
        self
    }

    /// With a line in small print that stands out.
    pub fn with_warning(mut self, text: Option<String>) -> Self {
        self.warning = text;
        self
    }

    /// On a badge of the given class.
    pub fn with_badge(mut self, class: &'static str) -> Self {
        self.badge = Some(class);
        self
    }

    /// With the mark of a level before it.
    pub fn with_chip(mut self, level: usize) -> Self {
        self.chip = Some(Chip {
            level,
            shape: shape(level),
        });
        self
    }

    /// With a class of the style sheet.
    pub fn with_class(mut self, class: &str) -> Self {
        class.clone_into(&mut self.class);
        self
    }

    /// With a background of the given strength (%).
    pub fn with_shade(mut self, class: &str, strength: f64) -> Self {
        self.shade = Some(strength.round());
        self.with_class(class)
    }
}

fn full(value: Option<f64>) -> String {
    value
        .filter(|v| v.is_finite())
        .map_or_else(String::new, |v| v.to_string())
}

/// A text that a spreadsheet would take for a formula with an apostrophe, which makes it a text.
fn no_formula(field: &str) -> String {
    // white space before it does not stop every spreadsheet
    let text = field.trim_start();
    let formula = text.starts_with(['=', '+', '-', '@']) && text.parse::<f64>().is_err();
    match formula {
        true => format!("'{field}"),
        false => field.to_owned(),
    }
}

/// A link that holds its own content (RFC 2397), percent-encoded so that it needs no escaping in the page.
fn data_link(media_type: &str, content: &str) -> String {
    use std::fmt::Write;
    let mut link = format!("data:{media_type},");
    for byte in content.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' => link.push(char::from(byte)),
            b'-' | b'.' | b'_' | b'~' | b'/' | b'=' | b',' | b';' | b'(' | b')' => {
                link.push(char::from(byte));
            }
            _ => {
                let _ = write!(link, "%{byte:02X}");
            }
        }
    }
    link
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail without the apostrophe, and with a line end of one character.
    #[test]
    fn tables_are_csv() {
        let columns: [(String, &'static [&'static str]); 2] = [
            ("Name".to_owned(), &["name"]),
            ("Value".to_owned(), &["value_hz", "lower_hz"]),
        ];
        let mut table = Table::new("t", "t", columns);
        let number = Cell::number("1.23", Some(1.234_567_890_123)).with_raw([Some(f64::NAN)]);
        table.row(vec![Cell::text("a, \"b\""), number]);
        table.row(vec![Cell::text("=f(1,2)"), Cell::number("", None)]);
        let expected =
            "name,value_hz,lower_hz\r\n\"a, \"\"b\"\"\",1.234567890123,\r\n\"'=f(1,2)\",\r\n";
        assert_eq!(table.csv(), expected);
    }

    /// A name is never a formula; numbers stay numbers. Seen to fail without the look at the first character, and without
    /// that past white space.
    #[test]
    fn texts_are_no_formulas() {
        for formula in [
            "=1+1",
            "+1+1",
            "-a1",
            "@sum(a1)",
            "=cmd(1,2)",
            "\t=1+1",
            " =1",
        ] {
            assert_eq!(no_formula(formula), format!("'{formula}"));
        }
        for other in ["-1.5e-3", "+2", "a=b", "", "margin -5 %"] {
            assert_eq!(no_formula(other), other);
        }
    }

    /// Nothing that HTML or a URL could misread is left. Seen to fail with `%` passed through.
    #[test]
    fn links_are_encoded() {
        let link = data_link("text/csv", "50 % <a href=\"x#y\">µ:&");
        assert_eq!(
            link,
            "data:text/csv,50%20%25%20%3Ca%20href=%22x%23y%22%3E%C2%B5%3A%26"
        );
    }
}
