//! Why a command cannot go on. A sample that does not converge is a [`crate::hb::Status`], not an error.

use std::path::PathBuf;

/// Everything that ends a command with exit code 2.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
}
