//! What every section of the page needs: the tests, which of them are drawn, and the units in which they are shown.

use crate::identify::found::identified::Identified;
use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::pooled_result::PooledParameter;
use crate::identify::found::result::{TestEstimate, TestResult};
use crate::page::block::{Cell, Figure};
use crate::page::display::LengthUnit;
use crate::page::figure::Panel;
use crate::page::style::figure_style;

/// Tests whose loops are drawn at most, so that a page of hundreds of tests can still be read.
const MOST_DRAWN: usize = 6;
/// Letters of a test's name in a title or beside a figure.
const SHORT_NAME: usize = 20;

/// An identification as the page shows it.
pub(super) struct View<'a> {
    /// What was found.
    pub(super) found: &'a Identified,
    /// Tests whose loops are drawn, by their place in the table; each has its own colour and shape.
    pub(super) drawn: Vec<usize>,
    /// Unit of all displacements.
    pub(super) unit: LengthUnit,
    style: String,
}

impl<'a> View<'a> {
    /// A view that draws the tests with the greatest misfit: where these are good, all are.
    pub(super) fn new(found: &'a Identified) -> Self {
        let misfit = |i: &usize| Some(found.tests[*i].estimate.as_ref()?.misfit.relative_rms);
        let figure = |i: &usize| found.tests[*i].figure.is_some();
        let mut drawn: Vec<usize> = (0..found.tests.len()).filter(figure).collect();
        let order = |i: &usize| misfit(i).unwrap_or(0.0);
        drawn.sort_by(|a, b| order(b).total_cmp(&order(a)));
        drawn.truncate(MOST_DRAWN);
        drawn.sort_unstable();
        let estimates = found.tests.iter().filter_map(|t| t.estimate.as_ref());
        let largest = estimates
            .map(|e| e.displacement_amplitude_m)
            .fold(0.0, f64::max);
        Self {
            found,
            unit: LengthUnit::for_largest(largest),
            style: figure_style(drawn.len()),
            drawn,
        }
    }

    /// Tests with an estimate, with their place in the table.
    pub(super) fn estimates(
        &self,
    ) -> impl Iterator<Item = (usize, &'a TestResult, &'a TestEstimate)> {
        let tests = self.found.tests.iter().enumerate();
        tests.filter_map(|(i, test)| Some((i, test, test.estimate.as_ref()?)))
    }

    /// Tests that are drawn: their place among these, and the test.
    pub(super) fn drawn(&self) -> impl Iterator<Item = (usize, &'a TestResult)> {
        let tests = &self.found.tests;
        self.drawn.iter().map(|&i| &tests[i]).enumerate()
    }

    /// Colour and shape of test `i`; none where its loops are not drawn.
    pub(super) fn level(&self, i: usize) -> Option<usize> {
        self.drawn.iter().position(|&drawn| drawn == i)
    }

    /// First cell of a row of test `i`, with its mark.
    pub(super) fn test_cell(&self, i: usize) -> Cell {
        let cell = Cell::text(&self.found.tests[i].name).with_class("text prose");
        match self.level(i) {
            Some(level) => cell.with_chip(level),
            None => cell,
        }
    }

    /// What all tests together say of a parameter.
    pub(super) fn pooled(&self, parameter: ContactParameter) -> Option<&'a PooledParameter> {
        let pooled = self.found.pooled.as_ref()?;
        pooled.parameters.iter().find(|p| p.parameter == parameter)
    }

    /// Confidence of the intervals of this page.
    pub(super) fn confidence(&self) -> f64 {
        self.found.settings.unwrap_or_default().confidence
    }

    /// Says which tests are drawn; empty where all are.
    pub(super) fn not_drawn(&self) -> String {
        let known = self
            .found
            .tests
            .iter()
            .filter(|t| t.figure.is_some())
            .count();
        match known - self.drawn.len() {
            0 => String::new(),
            others => format!(
                "Drawn are the {} tests whose loops differ most from that of an elastic-Coulomb contact; {others} others are \
                 in the table alone.",
                self.drawn.len()
            ),
        }
    }

    /// A panel with its download.
    pub(super) fn figure(&self, panel: &Panel, file: String, caption: impl Into<String>) -> Figure {
        Figure::new(panel, &self.style, file, caption.into())
    }
}

/// A name that fits beside a figure.
pub(super) fn short_name(name: &str) -> String {
    match name.chars().count() <= SHORT_NAME {
        true => name.to_owned(),
        false => name.chars().take(SHORT_NAME - 1).chain(['…']).collect(),
    }
}
