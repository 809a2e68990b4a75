//! What pages for people are made of: one HTML file each, without network and without script.
//!
//! A module that has results describes its page in [`block`]s: sentences, tables, and figures, each a [`figure::Panel`] over two
//! axes. [`mod@document`] makes the file of them; `look` holds the templates and the styles. Numbers become text in
//! [`display`]. Knows no results: what is shown, and in which order, is said by the module that has them.
//!
//! ```
//! # use microslip_pages as microslip;
//! use microslip::page::block::{Block, Cell, Section, Table};
//! use microslip::page::document::Document;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//!
//! let mut table = Table::of("Two levels", "levels", &[("Level (N)", &["level_n"]), ("Amplitude (µm)", &["um"])]);
//! table.row(vec![Cell::text("1"), Cell::text("2.5")]);
//! table.row(vec![Cell::text("5"), Cell::text("9.1 & more")]);
//! let section = Section {
//!     id: "levels",
//!     title: "Levels".to_owned(),
//!     blocks: vec![Block::Sentence("Each level is a factor on the force.".to_owned()), table.block()],
//! };
//! let document = Document { subject: "Microslip", title: "An example", n_levels: 2, sections: &[section] };
//! assert!(document.html()?.contains("9.1 &amp; more"));
//! # Ok(())
//! # }
//! ```

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
