//! What pages for people are made of: one HTML file each, without network and without script.
//!
//! A module that has results describes its page in [`block`]s: sentences, tables, and figures, each a [`figure::Panel`] over two
//! axes. [`mod@document`] makes the file of them; `look` holds the templates and the styles. Numbers become text in
//! [`display`]. Knows no results: what is shown, and in which order, is said by the module that has them.

pub mod axis;
pub mod block;
pub mod display;
pub mod distribution;
pub mod document;
pub mod figure;
mod level_mark;
#[cfg(test)]
mod names_in_rows;
pub mod sheet;
pub mod style;
pub mod thinning;
