//! From solved samples to parts: a thread that writes while others solve.

use super::super::runner::{SolvedSample, Watch};
use super::super::table::TableError;
use super::folder::PartFolder;
use super::part::PartHead;
use crate::ensemble::stop::Stop;
use crate::ensemble::times::SampleTimes;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

/// What is solved is on the disk after this time at the latest, unless another one is asked for.
pub const FLUSH_EVERY: Duration = Duration::from_secs(10);
/// Samples of a part at most.
const FLUSH_SAMPLES: usize = 4096;
/// How often the writing thread looks at the clock and at the stop.
const TICK: Duration = Duration::from_millis(100);

/// Takes solved samples from any thread.
#[derive(Debug)]
pub struct Collector<'s, F> {
    samples: SyncSender<SolvedSample>,
    stop: &'s Stop,
    done: F,
}

impl<F: Fn(SampleTimes) + Sync> Watch for Collector<'_, F> {
    fn solved(&self, sample: SolvedSample, times: SampleTimes) {
        // without a reader the writing thread has failed, and its error ends the run
        let _ = self.samples.send(sample);
        (self.done)(times);
    }

    fn stops(&self) -> bool {
        self.stop.asked()
    }
}

/// The thread that writes parts.
#[derive(Debug)]
pub struct PartWriter<'scope>(ScopedJoinHandle<'scope, Result<(), TableError>>);

impl<'scope> PartWriter<'scope> {
    /// Starts the thread, which writes a part `every` so often, and at once when asked to stop. It ends when the collector is
    /// dropped and everything is written. If a part cannot be written, it stops the run.
    pub fn start<'s: 'scope, F>(
        scope: &'scope Scope<'scope, '_>,
        folder: &'s PartFolder,
        head: &'s PartHead,
        stop: &'s Stop,
        every: Duration,
        done: F,
    ) -> (Self, Collector<'s, F>) {
        // a disk that is slower than the solver holds the solver up, before the memory is full
        let (samples, receiver) = sync_channel(FLUSH_SAMPLES);
        let thread = scope.spawn(move || {
            let written = write_all(&receiver, folder, head, stop, every);
            if written.is_err() {
                stop.ask();
            }
            written
        });
        let collector = Collector {
            samples,
            stop,
            done,
        };
        (Self(thread), collector)
    }

    /// Waits until everything is written; the collector must be dropped before.
    ///
    /// # Errors
    /// [`TableError`] of the part that could not be written.
    pub fn finish(self) -> Result<(), TableError> {
        match self.0.join() {
            Ok(written) => written,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

fn write_all(
    receiver: &Receiver<SolvedSample>,
    folder: &PartFolder,
    head: &PartHead,
    stop: &Stop,
    every: Duration,
) -> Result<(), TableError> {
    let mut waiting: Vec<SolvedSample> = Vec::new();
    let mut written = Instant::now();
    loop {
        let ended = match receiver.recv_timeout(TICK) {
            Ok(sample) => {
                waiting.push(sample);
                false
            }
            Err(RecvTimeoutError::Timeout) => false,
            Err(RecvTimeoutError::Disconnected) => true,
        };
        let due = written.elapsed() >= every || waiting.len() >= FLUSH_SAMPLES;
        if ended || due || stop.asked() {
            folder.write(head, std::mem::take(&mut waiting))?;
            written = Instant::now();
        }
        if ended {
            return Ok(());
        }
    }
}
