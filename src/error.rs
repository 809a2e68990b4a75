//! Why a command cannot go on. A sample that does not converge is a [`crate::hb::Status`], not an error.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use crate::ensemble::table::TableError;
use crate::file::FileError;
use crate::identify::IdentifyError;
use crate::import::ImportError;
use crate::model::ModelError;
use crate::report::ReportError;

/// Everything that ends a command before its end: with exit code 3 if it was stopped, else with 2.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read or written, or is not what it must be.
    #[error(transparent)]
    File(#[from] FileError),
    /// A line of the study file breaks a rule.
    #[error("{}:{line}: {message}", path.display())]
    Study {
        /// The study file.
        path: PathBuf,
        /// 1-based line.
        line: usize,
        /// Key, value and rule.
        message: String,
    },
    /// Nothing can be identified from the tests.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// A model of another program cannot be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The built-in model cannot be built from its settings.
    #[error("model: {0}")]
    Model(#[from] ModelError),
    /// The threads asked for could not be started.
    #[error("threads: {0}")]
    Threads(String),
    /// Outcomes could not be stored.
    #[error(transparent)]
    Store(#[from] TableError),
    /// A part or the results of a run could not be written. What stands in parts is kept.
    #[error("{0}; what was solved before is kept: mend this, then the same command goes on")]
    Unwritten(Box<Error>),
    /// The report could not be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The run was told to stop. What it solved is kept.
    #[error("stopped: {done} of {samples} samples are solved and kept in {}; the same command goes on", folder.display())]
    Stopped {
        /// The result folder.
        folder: PathBuf,
        /// Samples solved.
        done: u64,
        /// Samples in all, at most.
        samples: u64,
    },
    /// The study lacks what the command needs, its model has no such numbers, or it no longer gives the results that there are.
    #[error("{}: {message}", study.display())]
    Unfit {
        /// The study file.
        study: PathBuf,
        /// What is missing and how to give it.
        message: String,
    },
    /// Results or parts that are of another run, damaged or incomplete, or that the command has no use for.
    #[error("{}: {message}", folder.display())]
    Results {
        /// Their folder.
        folder: PathBuf,
        /// What is wrong with them and what to do.
        message: String,
    },
    /// A value of an option breaks a rule that only shows when the command runs.
    #[error("{option}: {rule}")]
    Option {
        /// The option, such as `--shard`.
        option: &'static str,
        /// The rule.
        rule: &'static str,
    },
    /// An address is taken, or not one of this machine.
    #[error("{address}: cannot listen there: {source}; another --port or --bind")]
    Address {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
}

impl Error {
    /// `source` happened on `path`.
    #[must_use]
    pub fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File(FileError::system(path, source))
    }

    /// `message` says what is wrong with the results or parts in `folder`, and what to do.
    #[must_use]
    pub fn results(folder: &Path, message: impl Into<String>) -> Self {
        Self::Results {
            folder: folder.to_owned(),
            message: message.into(),
        }
    }

    /// `message` says what the study lacks or why it does not do, and what to do.
    #[must_use]
    pub fn unfit(study: &Path, message: impl Into<String>) -> Self {
        Self::Unfit {
            study: study.to_owned(),
            message: message.into(),
        }
    }
}
