//! The page of an identification.

use super::view::View;
use super::{answer, cycles, joint, loops, provenance, test_table};
use crate::identify::found::identified::Identified;
use crate::page::document::Document;

/// The page of an identification as HTML: one file, no network, no script.
///
/// # Errors
/// [`minijinja::Error`] if the template is broken.
pub fn html(found: &Identified) -> Result<String, minijinja::Error> {
    let view = View::new(found);
    let sections = [
        Some(answer::section(&view)),
        Some(test_table::section(&view)),
        loops::section(&view),
        cycles::section(&view),
        joint::section(&view),
        Some(provenance::section(&view)),
    ];
    let sections: Vec<_> = sections.into_iter().flatten().collect();
    let document = Document {
        subject: "Friction contact from measured loops",
        title: "Contact parameters",
        n_levels: view.drawn.len(),
        sections: &sections,
    };
    document.html()
}
