//! Why a report could not be written.

use crate::file::FileError;

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file cannot be read back or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The numbers cannot be written as JSON.
    #[error("report: {0}")]
    Json(#[from] serde_json::Error),
    /// The page template is broken.
    #[error("report page: {0}")]
    Page(#[from] minijinja::Error),
}
