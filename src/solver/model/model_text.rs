//! Texts of `[model]` of a study file: names, forces, contact pairs, as [`super::matrices`] reads them.

use std::fmt::Write as _;

use super::matrix_contacts::ContactTable;

impl ContactTable {
    /// The table `[[model.contact]]` with an empty line before it; with units beside the numbers if it is in `si`.
    #[must_use]
    pub fn text(&self, si: bool) -> String {
        let unit = |unit: &str| match si {
            true => format!(" # {unit}"),
            false => String::new(),
        };
        let mut text = format!("\n[[model.contact]]\nname = {}\n", quoted(&self.name));
        for (key, row, name, stiffness) in [
            ("t1", &self.t1, "k_t1", self.k_t1),
            ("t2", &self.t2, "k_t2", self.k_t2),
            ("n", &self.n, "k_n", self.k_n),
        ] {
            if let (Some(row), Some(k)) = (row, stiffness) {
                let row = inline(row.iter());
                let _ = writeln!(text, "{key} = {row}\n{name} = {k:e}{}", unit("N/m"));
            }
        }
        let _ = writeln!(text, "mu = {:?}", self.mu);
        let _ = match (self.gap, self.n_0) {
            (Some(gap), _) => writeln!(text, "gap = {gap:?}{}", unit("m")),
            (None, n_0) => writeln!(text, "n_0 = {:?}{}", n_0.unwrap_or(0.0), unit("N")),
        };
        if self.interface > 0 {
            let _ = writeln!(text, "interface = {}", self.interface);
        }
        text
    }
}

/// `{ "12.1" = 1.0, "34.1" = -1.0 }`.
pub fn inline<'e>(entries: impl Iterator<Item = (&'e String, &'e f64)>) -> String {
    let entries: Vec<_> = entries
        .map(|(name, value)| format!("{} = {value:?}", quoted(name)))
        .collect();
    format!("{{ {} }}", entries.join(", "))
}

/// A text as TOML writes it, in one line.
pub fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        let _ = match c {
            '"' | '\\' => write!(quoted, "\\{c}"),
            c if c.is_control() => write!(quoted, "\\u{:04X}", u32::from(c)),
            c => write!(quoted, "{c}"),
        };
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Seen to fail with quotes that are not escaped.
    #[test]
    fn a_table_is_read_as_it_was_written() {
        let row = |weight: f64| {
            let names = ["a \"b\" \\ c\n\u{7f}d", "12.1"];
            let row = names.map(|name| (name.to_owned(), weight));
            Some(BTreeMap::from(row))
        };
        let table = ContactTable {
            name: "p\t\"1\"".to_owned(),
            t1: row(1.0 / 3.0),
            t2: None,
            n: row(-1e-300),
            k_n: Some(0.1 + 0.2),
            k_t1: Some(1e25),
            k_t2: None,
            mu: 0.1,
            n_0: None,
            gap: Some(f64::MIN_POSITIVE),
            interface: 3,
        };
        for si in [true, false] {
            let text = table.text(si).replace("model.contact", "contact");
            let read: BTreeMap<String, Vec<ContactTable>> = toml::from_str(&text).unwrap();
            assert_eq!(read["contact"].first(), Some(&table), "{text}");
        }
    }
}
