//! `report.html` and `comparison.html`: what they show of a run, in the blocks of [`crate::page`].
//!
//! Shows numbers and computes none that a program could want. Start reading in `document`, then `section`, which lists the
//! sections in the order of the page.

pub(super) mod document;
mod section;
pub(super) mod statistic_cell;
mod view;
