//! One file per format: its text or bytes become the tests that it holds.

pub(super) mod csv;
pub(super) mod matlab;
pub(super) mod tdms;
mod tdms_bytes;
mod tdms_segments;
pub(super) mod uff58;
mod uff_lines;
