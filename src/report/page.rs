//! The page: one file, no network, no script.

use super::assessment::Assessment;
use super::section::sections;
use super::summary::Summary;
use super::view::View;
use super::{ReportError, ReportInput};
use minijinja::value::Serde;
use minijinja::{Environment, context};

/// Renders the page.
pub(super) fn render(
    input: &ReportInput,
    summary: &Summary,
    assessment: &Assessment,
) -> Result<String, ReportError> {
    let view = View::new(input, summary, assessment);
    let mut environment = Environment::new();
    // The names end in .html, which switches escaping on.
    environment.add_template("report.html", include_str!("look/report.html.j2"))?;
    environment.add_template("block.html", include_str!("look/block.html.j2"))?;
    let page = environment.get_template("report.html")?.render(context! {
        page_style => include_str!("look/page.css"),
        figure_style => &view.style,
        study => &summary.provenance.study,
        sections => Serde(sections(&view)),
    })?;
    Ok(page)
}
