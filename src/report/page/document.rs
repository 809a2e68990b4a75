//! The pages of this module: what they are about, and that of a study.

use super::section::sections;
use super::view::View;
use crate::page::block::Section;
use crate::page::document::Document;
use crate::report::assessment::Assessment;
use crate::report::error::ReportError;
use crate::report::numbers::summary::Summary;
use crate::report::run::input::ReportInput;

/// Renders the page of a study.
pub(in crate::report) fn study_page(
    input: &ReportInput,
    summary: &Summary,
    assessment: &Assessment,
) -> Result<String, ReportError> {
    let view = View::new(input, summary, assessment);
    let title = &summary.provenance.study;
    page(title, view.n_levels(), &sections(&view))
}

/// A page of the given title and sections, for so many excitation levels.
pub(in crate::report) fn page(
    title: &str,
    n_levels: usize,
    sections: &[Section],
) -> Result<String, ReportError> {
    let document = Document {
        subject: "Forced response under uncertainty",
        title,
        n_levels,
        sections,
    };
    Ok(document.html()?)
}
