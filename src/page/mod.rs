//! What pages for people are made of: one HTML file each, without network and without script.
//!
//! A room that has results describes its page in [`block`]s: sentences, tables, and figures, each a [`figure::Panel`] over two
//! axes. [`mod@document`] makes the file of them; `look` holds the templates and the styles. Numbers become text in
//! [`display`]. Knows no results: what is shown, and in which order, is said by the room that has them.

pub(crate) mod axis;
pub(crate) mod block;
pub(crate) mod display;
pub(crate) mod distribution;
pub(crate) mod document;
pub(crate) mod figure;
mod level_mark;
pub(crate) mod sheet;
pub(crate) mod style;
pub(crate) mod thinning;
