//! What a study takes before it is run: sizes, memory, time.
//!
//! Start reading at [`inspect::inspect`].

pub mod inspect;
pub(super) mod pilot;
mod processor_time;
mod size;
