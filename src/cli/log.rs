//! What a command says of its work on standard error: lines for people, or JSON lines for programs.

use std::io::Write;
use std::time::SystemTime;

use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

/// How much a command says, and how.
#[derive(Clone, Copy, Args)]
pub(super) struct Messages {
    /// No progress and no summary. Warnings stay, and so does all that `inspect` shows.
    #[arg(long)]
    pub quiet: bool,
    /// Warnings, progress and the end on standard error: lines for people, or a JSON object per line.
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t)]
    pub log: Log,
}

/// Form of the lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Log {
    #[default]
    Text,
    Json,
}

/// Something that happened.
pub(super) enum Event<'a> {
    /// A command began its work; with what it says of itself.
    Started(Value),
    /// Something that a user should know.
    Warning(&'a str),
    /// So many parts of the work are done.
    Progress {
        done: u64,
        total: u64,
        /// Parts per second, where known.
        per_second: Option<f64>,
        /// Newton iterations of the parts that this process has done.
        newton_iterations: u64,
        /// The rest in words.
        words: &'a str,
    },
    /// A stage of the work begins.
    Stage {
        words: &'a str,
        /// The same for programs.
        fields: Value,
    },
    /// The command has its results; with what it says of them.
    Finished(Value),
    /// The command ends before its results, as was asked for.
    Stopped(&'a str),
    /// The command fails.
    Error(&'a str),
}

impl Log {
    /// Writes a line. One that cannot be written is no reason to stop.
    pub(super) fn write(self, event: &Event) {
        let line = match self {
            Self::Text => event.text(),
            Self::Json => Some(event.json(SystemTime::now())),
        };
        if let Some(line) = line {
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }

    pub(super) fn warn(self, messages: &[String]) {
        for message in messages {
            self.write(&Event::Warning(message));
        }
    }
}

impl Event<'_> {
    /// For people; nothing where the summary on standard output says it.
    fn text(&self) -> Option<String> {
        match self {
            Self::Started(_) | Self::Finished(_) => None,
            Self::Warning(message) => Some(format!("warning: {message}")),
            Self::Progress {
                done,
                total,
                words: "",
                ..
            } => Some(format!("{done}/{total}")),
            Self::Progress {
                done, total, words, ..
            } => Some(format!("{done}/{total}, {words}")),
            Self::Stage { words, .. } => Some((*words).to_owned()),
            Self::Stopped(message) => Some((*message).to_owned()),
            Self::Error(message) => Some(format!("error: {message}")),
        }
    }

    fn json(&self, now: SystemTime) -> String {
        let (name, fields) = match self {
            Self::Started(fields) => ("started", fields.clone()),
            Self::Warning(message) => ("warning", json!({ "message": message })),
            Self::Progress {
                done,
                total,
                per_second,
                newton_iterations,
                ..
            } => {
                let left = per_second.map(|rate| total.saturating_sub(*done) as f64 / rate);
                let progress = json!({
                    "done": done, "total": total, "per_second": per_second, "seconds_left": left,
                    "newton_iterations": newton_iterations,
                });
                ("progress", progress)
            }
            Self::Stage { fields, .. } => ("stage", fields.clone()),
            Self::Finished(fields) => ("finished", fields.clone()),
            Self::Stopped(message) => ("stopped", json!({ "message": message })),
            Self::Error(message) => ("error", json!({ "message": message })),
        };
        let time = humantime::format_rfc3339_millis(now).to_string();
        let mut line = Map::new();
        line.insert("time".to_owned(), Value::from(time));
        line.insert("event".to_owned(), Value::from(name));
        line.extend(fields.as_object().cloned().unwrap_or_default());
        Value::Object(line).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with the seconds left of all parts, and with a comma after the numbers where no pace is known.
    #[test]
    fn a_line_is_one_object() {
        let event = Event::Progress {
            done: 30,
            total: 100,
            per_second: Some(2.0),
            newton_iterations: 70,
            words: "about 35s left",
        };
        let line: Value = serde_json::from_str(&event.json(SystemTime::UNIX_EPOCH)).unwrap();
        let expected = json!({
            "time": "1970-01-01T00:00:00.000Z", "event": "progress",
            "done": 30, "total": 100, "per_second": 2.0, "seconds_left": 35.0, "newton_iterations": 70,
        });
        assert_eq!(line, expected);
        assert_eq!(event.text().unwrap(), "30/100, about 35s left");
        let first = Event::Progress {
            done: 0,
            total: 100,
            per_second: None,
            newton_iterations: 0,
            words: "",
        };
        assert_eq!(first.text().unwrap(), "0/100");
        let two_lines = Event::Error("a\nb").json(SystemTime::UNIX_EPOCH);
        assert!(!two_lines.contains('\n'), "{two_lines}");
    }
}
