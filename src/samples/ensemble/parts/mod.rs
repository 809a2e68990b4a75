//! Parts of a run: what it has solved so far, on the disk.
//!
//! A part is up to three tables with one stem, `parts/<first>-<last>-<hash>`: `.curves.parquet` and `.atlas.parquet`, written first, and
//! `.samples.parquet`, which makes the part count. Its metadata names the run and the hashes of its companions; the hash in the
//! stem is that of its own bytes. A part is never changed. So a process that dies at any time leaves whole parts, and files that
//! belong to no part.
//!
//! ```
//! # use microslip_samples as microslip;
//! use microslip::ensemble::parts::PartFolder;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let results = tempfile::tempdir()?;
//! let parts = PartFolder::of(results.path());
//! assert!(parts.list()?.is_empty());
//! # Ok(())
//! # }
//! ```

mod claims;
mod collector;
mod folder;
mod identity;
mod merged;
mod part;

pub use claims::{Claim, Claims};
pub use collector::{Collector, FLUSH_EVERY, PartWriter};
pub use folder::PartFolder;
pub use identity::{Difference, RunIdentity, more_samples, more_samples_of_any_order};
pub use merged::{Merged, MergedSource};
pub use part::{PartHead, StoredPart};
