//! `report.html`: one file for people, no network, no script.
//!
//! All that knows HTML or SVG: sections say what is shown, blocks (figures, tables, sentences) are what they are made of,
//! `look` is how it looks. Shows numbers and computes none that a program could want. Start reading in `document`, then
//! `section`, which lists the sections in the order of the page; a figure is a `figure::Panel`, a table a `block::Table`.

pub(super) mod axis;
pub(super) mod block;
pub(super) mod confidence_band;
pub(super) mod document;
pub(super) mod figure;
mod level_mark;
mod section;
pub(super) mod statistic_cell;
pub(super) mod view;
