//! A TOML text that knows the line of every key, so that every message can name it.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::Error;
use crate::file::FileError;
use crate::setting::BadSetting;

/// A parsed TOML file whose sections are taken out one by one.
pub struct Document<'t> {
    path: PathBuf,
    text: &'t str,
    root: DeTable<'t>,
    places: Vec<Place>,
    /// Keys of sections that are taken out by themselves, as `section.key`: they are known where a message lists those that are.
    taken: Vec<String>,
}

/// Where a key and its value stand in the text, in bytes.
struct Place {
    key: String,
    line_of: usize,
    value: Range<usize>,
}

impl<'t> Document<'t> {
    /// Parses `text`, the content of `path`.
    ///
    /// # Errors
    /// [`Error::Study`] on the first syntax error.
    pub fn parse(path: &Path, text: &'t str) -> Result<Self, Error> {
        let root = DeTable::parse(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            Error::Study {
                path: path.to_owned(),
                line: line_at(text, at),
                message: format!("not valid TOML: {}", one_line(error.message())),
            }
        })?;
        let mut places = Vec::new();
        collect_places("", root.get_ref(), &mut places);
        Ok(Self {
            path: path.to_owned(),
            text,
            root: root.into_inner(),
            places,
            taken: Vec::new(),
        })
    }

    /// Takes a top-level value out; `None` if it is absent.
    ///
    /// # Errors
    /// [`Error::Study`] if it does not have the shape of `T`.
    pub fn take<T: DeserializeOwned>(&mut self, key: &str) -> Result<Option<T>, Error> {
        match self.root.remove(key) {
            None => Ok(None),
            Some(value) => self.deserialize(value).map(Some),
        }
    }

    /// Takes a top-level value that must be given.
    ///
    /// # Errors
    /// [`Error::Study`] if it is absent or does not have the shape of `T`.
    pub fn required<T: DeserializeOwned>(&mut self, key: &str) -> Result<T, Error> {
        match self.take(key)? {
            Some(value) => Ok(value),
            None => Err(self.at_key(key, "must be given".to_owned())),
        }
    }

    /// Whether a top-level value is a table.
    pub fn is_table(&self, key: &str) -> bool {
        let value = self.root.get(key).map(Spanned::get_ref);
        matches!(value, Some(DeValue::Table(_)))
    }

    /// Takes a string out of a section, such as the `kind` that decides how the rest is read.
    ///
    /// # Errors
    /// [`Error::Study`] if the section is no table, or the key is absent or no string.
    pub(crate) fn take_string(&mut self, section: &str, key: &str) -> Result<String, Error> {
        if !self.root.contains_key(section) {
            return Err(self.at_key(section, format!("must be given, with a {key}")));
        }
        if !self.is_table(section) {
            return Err(self.at_key(section, "must be a table".to_owned()));
        }
        let taken = self.take_below(section, key)?;
        taken.ok_or_else(|| self.at_key(&format!("{section}.{key}"), "must be given".to_owned()))
    }

    /// Takes a value out of a section that is read by other rules; `None` if one of them is absent.
    ///
    /// # Errors
    /// [`Error::Study`] if it does not have the shape of `T`.
    pub fn take_below<T: DeserializeOwned>(
        &mut self,
        section: &str,
        key: &str,
    ) -> Result<Option<T>, Error> {
        self.taken.push(format!("{section}.{key}"));
        let removed = match self.root.get_mut(section).map(Spanned::get_mut) {
            Some(DeValue::Table(table)) => table.remove(key),
            _ => None,
        };
        removed.map(|value| self.deserialize(value)).transpose()
    }

    /// The text with what stands at the dotted `key` replaced by `value`, written as TOML; a top-level one in a line of its own where
    /// the key is absent.
    #[must_use]
    pub fn with_value(&self, key: &str, value: &str) -> String {
        match self.places.iter().find(|place| place.key == key) {
            None => format!("{key} = {value}\n{}", self.text),
            Some(place) => {
                let Range { start, end } = place.value;
                format!("{}{value}{}", &self.text[..start], &self.text[end..])
            }
        }
    }

    /// Refuses whatever was not taken.
    ///
    /// # Errors
    /// [`Error::Study`] on the first key that is left, naming the `known` ones.
    pub fn finish(&self, known: &[&str]) -> Result<(), Error> {
        let left = self
            .root
            .keys()
            .min_by_key(|key| key.span().start)
            .map(|key| key.get_ref().to_string());
        match left {
            None => Ok(()),
            Some(key) => {
                Err(self.at_key(&key, format!("unknown key; known are {}", known.join(", "))))
            }
        }
    }

    /// The error of a setting, at the line of its key, or of the section that lacks it.
    #[must_use]
    pub fn bad_setting(&self, bad: &BadSetting) -> Error {
        Error::Study {
            path: self.path.clone(),
            line: self.line_of(&bad.key),
            message: bad.to_string(),
        }
    }

    /// The value, or the error of the setting at the line of its key.
    ///
    /// # Errors
    /// [`Error::Study`] if the setting is bad.
    pub fn checked<T>(&self, result: Result<T, BadSetting>) -> Result<T, Error> {
        result.map_err(|bad| self.bad_setting(&bad))
    }

    /// The error of a file that is not there, at the line of the key that names it, relative to the folder of the text; that of a file
    /// which is not what its key asks for, with the keys that name it; other errors as they are.
    #[must_use]
    pub fn bad_file(&self, error: FileError) -> Error {
        match error {
            FileError::System { ref path, .. } if error.is_absence() => {
                let Some(place) = self.places_naming(path).next() else {
                    return error.into();
                };
                let rule = format!("must name a file: there is no {}", path.display());
                let value = &self.text[place.value.clone()];
                self.bad_setting(&BadSetting::new(&place.key, value, rule))
            }
            FileError::Content {
                path,
                line: None,
                rule,
            } => {
                let places = self.places_naming(&path);
                let keys: Vec<String> = places
                    .map(|place| format!("{} (line {})", place.key, self.line_of(&place.key)))
                    .collect();
                let named = match keys.is_empty() {
                    true => String::new(),
                    false => format!("; {} names it: {}", self.path.display(), keys.join(", ")),
                };
                FileError::content(&path, None, rule + &named).into()
            }
            error => error.into(),
        }
    }

    /// Where the text names the file `path`, relative to its own folder.
    fn places_naming<'p>(&'p self, path: &'p Path) -> impl Iterator<Item = &'p Place> {
        let folder = before_name(&self.path);
        let name = |place: &Place| -> Option<String> {
            let value = ValueDeserializer::parse(&self.text[place.value.clone()]).ok()?;
            String::deserialize(value).ok()
        };
        let names_it = move |place: &&Place| name(place).is_some_and(|n| folder.join(n) == *path);
        self.places.iter().filter(names_it)
    }

    /// An error at the line of `key`.
    #[must_use]
    pub fn at_key(&self, key: &str, rule: String) -> Error {
        Error::Study {
            path: self.path.clone(),
            line: self.line_of(key),
            message: format!("{key}: {rule}"),
        }
    }

    fn deserialize<T: DeserializeOwned>(&self, value: Spanned<DeValue<'t>>) -> Result<T, Error> {
        let whole = value.span();
        T::deserialize(ValueDeserializer::from(value)).map_err(|error| {
            let span = error.span().unwrap_or(whole);
            let key = self.key_around(&span).unwrap_or_default();
            let mut message = in_words(&one_line(error.message()));
            if message.contains("unknown field") {
                message.extend(self.known_beside(&key));
            }
            Error::Study {
                path: self.path.clone(),
                line: line_at(self.text, span.start),
                message: format!("{key}: {message}"),
            }
        })
    }

    /// The keys of the section of `key` that are known though its type does not have them, as the end of a list.
    fn known_beside(&self, key: &str) -> Vec<String> {
        let section = key.rsplit_once('.').map_or("", |(section, _)| section);
        let taken = self.taken.iter().filter_map(|taken| {
            let (of, name) = taken.rsplit_once('.')?;
            (of == section).then_some(name)
        });
        let names: BTreeSet<&str> = taken.collect();
        names.iter().map(|name| format!(", `{name}`")).collect()
    }

    /// Dotted key whose value is the smallest that holds `span`.
    fn key_around(&self, span: &Range<usize>) -> Option<String> {
        let around = |place: &&Place| {
            place.value.start <= span.start && span.end <= place.value.end
                || place.line_of == span.start
        };
        self.places
            .iter()
            .filter(around)
            .min_by_key(|place| place.value.len())
            .map(|place| place.key.clone())
    }

    /// Line of the key itself, or of the longest section name that starts it; 1 if there is none.
    fn line_of(&self, key: &str) -> usize {
        let starts = |place: &&Place| {
            key.strip_prefix(place.key.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        self.places
            .iter()
            .filter(starts)
            .max_by_key(|place| place.key.len())
            .map_or(1, |place| line_at(self.text, place.line_of))
    }
}

/// What stands before the name of a file: nothing before a bare name, so that paths beside it are as short.
pub(super) fn before_name(path: &Path) -> &Path {
    path.parent().unwrap_or_else(|| Path::new(""))
}

/// Every key below `table`, as `a.b.c`; elements of arrays as `a[0]`.
fn collect_places(prefix: &str, table: &DeTable<'_>, places: &mut Vec<Place>) {
    for (key, value) in table {
        let dotted = if prefix.is_empty() {
            key.get_ref().to_string()
        } else {
            format!("{prefix}.{}", key.get_ref())
        };
        add_place(dotted, key.span().start, value, places);
    }
}

fn add_place(key: String, line_of: usize, value: &Spanned<DeValue<'_>>, places: &mut Vec<Place>) {
    match value.get_ref() {
        DeValue::Table(table) => collect_places(&key, table, places),
        DeValue::Array(array) => {
            for (i, element) in array.iter().enumerate() {
                add_place(format!("{key}[{i}]"), element.span().start, element, places);
            }
        }
        _ => {}
    }
    places.push(Place {
        key,
        line_of,
        value: value.span(),
    });
}

/// 1-based line of a byte.
fn line_at(text: &str, byte: usize) -> usize {
    let before = &text.as_bytes()[..byte.min(text.len())];
    1 + before.iter().filter(|b| **b == b'\n').count()
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What serde expects, and what a reader of the file calls it.
const EXPECTED: [(&str, &str); 12] = [
    ("expected u64", "expected a whole number >= 0"),
    ("expected u32", "expected a whole number >= 0"),
    ("expected usize", "expected a whole number >= 0"),
    ("expected f64", "expected a number"),
    ("expected a boolean", "expected true or false"),
    ("expected a string", "expected a text in quotes"),
    ("expected path string", "expected a file name in quotes"),
    ("expected a sequence", "expected a list in brackets"),
    ("expected a map", "expected a table"),
    // of a key that takes one of a few names
    (
        "wanted string or table",
        "expected one of its names, a text in quotes",
    ),
    ("invalid type: map", "invalid type: table"),
    ("invalid type: sequence", "invalid type: list"),
];

/// A message of serde in the words of TOML.
fn in_words(message: &str) -> String {
    let plain = EXPECTED
        .iter()
        .fold(message.to_owned(), |text, (name, words)| {
            text.replace(name, words)
        });
    match plain.split_once("expected struct ") {
        // the name of the type says nothing to the reader
        Some((before, _)) => format!("{before}expected a table"),
        None => plain,
    }
}
