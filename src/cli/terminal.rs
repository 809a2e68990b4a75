//! The terminal: standard output, warnings, progress.

use std::io::Write;

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

/// Warnings go to standard error; one that cannot be shown is no reason to stop.
pub(super) fn show_warnings(messages: &[String]) {
    for message in messages {
        let _ = writeln!(std::io::stderr(), "warning: {message}");
    }
}

/// Progress on standard error: a bar on a terminal, else one line per twentieth.
pub(super) struct Bar {
    bar: indicatif::ProgressBar,
    quiet: bool,
}

impl Bar {
    pub(super) fn new(quiet: bool) -> Self {
        let bar = if quiet {
            indicatif::ProgressBar::hidden()
        } else {
            indicatif::ProgressBar::new(0)
        };
        Self { bar, quiet }
    }

    /// Makes room for the summary.
    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }

    pub(super) fn show(&self, Progress { done, total }: Progress) {
        let before = self.bar.position();
        self.bar.set_length(total);
        self.bar.set_position(done);
        let twentieth = |n: u64| 20 * n / total.max(1);
        let step = twentieth(done) > twentieth(before);
        if !self.quiet && self.bar.is_hidden() && step {
            let eta = self.bar.eta().as_secs();
            // Progress that cannot be shown is no reason to stop.
            let _ = writeln!(std::io::stderr(), "{done}/{total}, about {eta} s left");
        }
    }
}
