//! The page: one file, no network, no script.

use super::block::Section;
use super::level_mark::{Ground, colours};
use super::section::sections;
use super::view::{View, figure_style};
use crate::report::assessment::Assessment;
use crate::report::error::ReportError;
use crate::report::numbers::summary::Summary;
use crate::report::run::input::ReportInput;
use minijinja::value::Serde;
use minijinja::{Environment, context};

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
    let mut environment = Environment::new();
    // The names end in .html, which switches escaping on.
    environment.add_template("report.html", include_str!("look/report.html.j2"))?;
    environment.add_template("block.html", include_str!("look/block.html.j2"))?;
    let page = environment.get_template("report.html")?.render(context! {
        page_style => include_str!("look/page.css"),
        figure_style => figure_style(n_levels),
        dark_style => include_str!("look/dark.css"),
        dark_levels => colours(n_levels, Ground::Dark),
        study => title,
        sections => Serde(sections),
    })?;
    Ok(page)
}
