//! Outcomes on disk: `samples.parquet` (one row per sample and level), `curves.parquet` (one row per point) and `atlas.parquet`
//! (the peaks that later samples start from). Files appear whole or not at all.

mod anchors;
mod curves;
mod provenance;
mod read_samples;
mod samples;
mod solved;

pub use anchors::{ATLAS_FILE, StoredStudy, read_study};
pub use curves::read_curves;
pub use provenance::{FollowedMode, Provenance};
pub use read_samples::{StoredSamples, read_indices, read_samples};
pub use samples::write_samples;
pub use solved::{SolvedCursor, SolvedFiles};

pub(super) use anchors::anchors_layout;
pub(super) use curves::curves_layout;
pub(super) use read_samples::{INDEX_COLUMNS, indices_of};
pub(super) use samples::samples_layout;
pub(super) use solved::{WRITER, parted};
