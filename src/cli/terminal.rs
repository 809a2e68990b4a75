//! The terminal: standard output, warnings, progress.

use std::io::Write;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::log::{Event, Log, Messages};
use super::pace::Pace;
use microslip::Error;
use microslip::study::Progress;

/// Writes to the standard output; a full disk behind it is an error, not a panic.
pub(super) fn print(
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    content(&mut out)
        .and_then(|()| out.flush())
        .map_err(|source| Error::file("standard output".as_ref(), source))
}

/// Progress on standard error: a bar on a terminal, else a line per twentieth, and one per ten seconds for a program.
pub(super) struct Bar {
    bar: indicatif::ProgressBar,
    began: Instant,
    pace: Mutex<Pace>,
    quiet: bool,
    log: Log,
}

impl Bar {
    pub(super) fn new(messages: &Messages) -> Self {
        let Messages { quiet, log } = *messages;
        let bar = match quiet || log == Log::Json {
            true => indicatif::ProgressBar::hidden(),
            false => indicatif::ProgressBar::new(0),
        };
        // the library's own bar stays if it does not know the words of this one
        if let Ok(style) = indicatif::ProgressStyle::with_template(BAR) {
            bar.set_style(style);
        }
        Self {
            bar,
            began: Instant::now(),
            pace: Mutex::default(),
            quiet,
            log,
        }
    }

    /// Makes room for the summary.
    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }

    pub(super) fn show(&self, progress: Progress) {
        let Progress {
            done,
            total,
            newton_iterations,
        } = progress;
        // a thread that panicked while it noted a point has spoiled nothing
        let mut pace = self.pace.lock().unwrap_or_else(PoisonError::into_inner);
        pace.note(self.began.elapsed(), done);
        let words = pace.in_words(total, newton_iterations);
        let due = self.log == Log::Json && pace.is_due();
        let before = self.bar.position();
        self.bar.set_length(total);
        self.bar.set_position(done.max(before));
        let twentieth = |n: u64| 20 * n / total.max(1);
        let step = twentieth(done) > twentieth(before);
        if !self.quiet && self.bar.is_hidden() && (step || due) {
            pace.told();
            self.log.write(&Event::Progress {
                done,
                total,
                per_second: pace.per_second(),
                newton_iterations,
                words: &words,
            });
        }
        self.bar.set_message(words);
    }
}

/// What the bar shows on a terminal.
const BAR: &str = "{wide_bar} {pos}/{len} {msg}";
