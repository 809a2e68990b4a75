//! `report.html` of an identification: what it shows, in the blocks of the module `page`.
//!
//! A function of [`Identified`](super::Identified) alone. Start reading in `document`, which lists the sections in the order of
//! the page; `view` holds what they share, `parameter` the words for the contact parameters.

mod answer;
mod cycles;
mod document;
mod joint;
mod loops;
mod parameter;
mod provenance;
mod test_table;
mod view;

pub use document::html;
