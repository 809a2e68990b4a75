//! Who solves what, among processes that share a folder. Hints, not facts: a sample that two processes solve has the same bits.
//!
//! A claim is a file that can be made only once. While its process lives it refreshes the file's time. A claim whose time stands
//! still is void; only one's own clock decides that, so that clocks need not agree.

use super::super::program::this_process;
use super::folder::PartFolder;
use crate::file::FileError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant, SystemTime};

/// How often a claim is refreshed.
const BEAT: Duration = Duration::from_secs(2);
/// A claim whose time stands still for so long is void.
const VOID_AFTER: Duration = Duration::from_secs(10);

/// The claims on the samples of a run.
#[derive(Debug)]
pub struct Claims {
    folder: PathBuf,
    /// Time of each file of others, and when it was first seen.
    seen: BTreeMap<String, (SystemTime, Instant)>,
}

impl Claims {
    /// The claims beside the parts of a run.
    ///
    /// # Errors
    /// [`FileError`] if their folder cannot be made.
    pub fn of(parts: &PartFolder) -> Result<Self, FileError> {
        let folder = parts.path().join("claims");
        let made = std::fs::create_dir_all(&folder);
        made.map_err(|source| FileError::system(&folder, source))?;
        Ok(Self {
            folder,
            seen: BTreeMap::new(),
        })
    }

    /// Claims what bears this `name`: nothing if another process has it.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be made.
    pub fn take(&mut self, name: &str) -> Result<Option<Claim>, FileError> {
        let path = self.folder.join(name);
        let system = |source| FileError::system(&path, source);
        let made = match File::create_new(&path) {
            // somebody deletes the folder of a run: what is solved from now on is worth keeping
            Err(source) if source.kind() == ErrorKind::NotFound => {
                std::fs::create_dir_all(&self.folder).map_err(system)?;
                File::create_new(&path)
            }
            made => made,
        };
        match made {
            Ok(mut file) => {
                let now = humantime::format_rfc3339_seconds(SystemTime::now());
                writeln!(file, "{} at {now}", this_process()).map_err(system)?;
                Ok(Some(Claim { path }))
            }
            Err(source) if source.kind() == ErrorKind::AlreadyExists => {
                if self.stands_still(name, &path) {
                    // two may do this at once, and then both solve the same
                    let _ = std::fs::remove_file(&path);
                }
                Ok(None)
            }
            Err(source) => Err(system(source)),
        }
    }

    fn stands_still(&mut self, name: &str, path: &Path) -> bool {
        let Ok(time) = std::fs::metadata(path).and_then(|m| m.modified()) else {
            return false;
        };
        let now = (time, Instant::now());
        let seen = self.seen.entry(name.to_owned()).or_insert(now);
        if seen.0 != time {
            *seen = now;
        }
        seen.1.elapsed() >= VOID_AFTER
    }
}

/// A claim of this process; void when it is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
}

impl Claim {
    /// Refreshes the claim until `work` has ended, and returns what it gives.
    pub fn hold<T>(&self, work: impl FnOnce() -> T) -> T {
        let ended = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let beat = scope.spawn(|| {
                while !ended.load(Ordering::Relaxed) {
                    std::thread::park_timeout(BEAT);
                    let file = File::options().write(true).open(&self.path);
                    let _ = file.and_then(|file| file.set_modified(SystemTime::now()));
                }
            });
            let _end = EndOfWork {
                ended: &ended,
                beat: beat.thread(),
            };
            work()
        })
    }
}

/// Ends the refreshing when it is dropped, after a panic too: a claim must not outlive its work.
struct EndOfWork<'a> {
    ended: &'a AtomicBool,
    beat: &'a Thread,
}

impl Drop for EndOfWork<'_> {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        self.beat.unpark();
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}
