//! The file of a page: no network, no script.

use super::block::Section;
use super::style::{dark_style, figure_style};
use minijinja::value::Serde;
use minijinja::{Environment, context};

/// A page before it is written as HTML.
#[derive(Debug, Clone, Copy)]
pub struct Document<'a> {
    /// What pages of this kind are about.
    pub subject: &'a str,
    /// What this one is about.
    pub title: &'a str,
    /// Number of excitation levels, or of what else has a colour and a shape of its own.
    pub n_levels: usize,
    /// Content, from top to bottom.
    pub sections: &'a [Section],
}

impl Document<'_> {
    /// The page as HTML.
    ///
    /// # Errors
    /// [`minijinja::Error`] if the template is broken.
    pub fn html(&self) -> Result<String, minijinja::Error> {
        let mut environment = Environment::new();
        // The names end in .html, which switches escaping on.
        environment.add_template("page.html", include_str!("look/page.html.j2"))?;
        environment.add_template("block.html", include_str!("look/block.html.j2"))?;
        environment.get_template("page.html")?.render(context! {
            page_style => include_str!("look/page.css"),
            figure_style => figure_style(self.n_levels),
            dark_style => dark_style(self.n_levels),
            subject => self.subject,
            title => self.title,
            sections => Serde(self.sections),
        })
    }
}
