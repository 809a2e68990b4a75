//! The engine orders of a tuned disk on one page: `disk.json` and `disk.html`.
//!
//! Each order excites a nodal diameter of its own and has a run of its own. Knows stored runs alone: nothing is solved. Start
//! reading in [`mod@summary`].

mod folders;
mod page;
pub mod summary;
mod write;

pub use folders::order_faults;
pub use summary::{DiskSummary, OrderLevel, OrderSummary};
pub use write::{DISK_NUMBERS, write};
