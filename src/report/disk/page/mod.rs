//! `disk.html`: the engine orders of a disk over speed and nodal diameter. One file per section.

mod diagrams;
mod numbers;
mod solutions;
mod verdicts;

use super::summary::{DiskSummary, OrderLevel, OrderSummary};
use crate::page::axis::Axis;
use crate::page::block::Figure;
use crate::page::display::{LengthUnit, level_name};
use crate::page::figure::Panel;
use crate::page::style::figure_style;
use crate::report::error::ReportError;
use crate::report::page::document::page;
use crate::report::page::view::length_unit;
use crate::report::run::input::ReportInput;
use crate::report::run::stored_run::StoredRun;
use crate::statistics::hull;

/// Space between the bars of two levels at one nodal diameter.
const BESIDE: f64 = 0.12;
/// A disk as the page shows it.
struct DiskView<'a> {
    disk: &'a DiskSummary,
    /// Unit of the amplitudes.
    unit: LengthUnit,
    style: String,
    /// Frequencies that matter (Hz): all scatter bars with space around.
    window: [f64; 2],
}

/// Renders the page.
pub(super) fn render(disk: &DiskSummary, runs: &[StoredRun]) -> Result<String, ReportError> {
    let inputs: Vec<ReportInput> = runs.iter().map(StoredRun::input).collect();
    let bars = disk.orders.iter().flat_map(|order| &order.levels);
    let ends = bars.filter_map(|level| level.frequency_hz);
    let [low, high] = hull(ends.flat_map(|[low, _, high]| [low, high])).unwrap_or([0.0, 1.0]);
    let space = (high - low).max(2e-3 * high);
    let view = DiskView {
        disk,
        unit: length_unit(&inputs),
        style: figure_style(disk.levels.len()),
        window: [low - space, high + space],
    };
    let title = match disk.orders.first() {
        Some(order) => format!("Disk of {} sectors: {}", disk.sectors, order.study),
        None => format!("Disk of {} sectors", disk.sectors),
    };
    let sections = [
        verdicts::section(&view),
        diagrams::section(&view),
        numbers::section(&view),
        solutions::section(&view),
    ];
    page(&title, disk.levels.len(), &sections)
}

impl DiskView<'_> {
    fn level_name(&self, i: usize) -> String {
        level_name(self.disk.levels[i], &self.disk.level_unit)
    }

    fn figure(&self, panel: &Panel, file: &str, caption: &str) -> Figure {
        Figure::new(
            panel,
            &self.style,
            format!("{file}.svg"),
            caption.to_owned(),
        )
    }

    /// Every order at every level that has a solution.
    fn bars(&self) -> impl Iterator<Item = (&OrderSummary, usize, &OrderLevel)> {
        let orders = self.disk.orders.iter();
        orders.flat_map(|order| (order.levels.iter().enumerate()).map(move |(i, l)| (order, i, l)))
    }

    /// Place of the bar of level i at a nodal diameter: levels stand beside each other.
    fn beside(&self, nodal_diameter: usize, i: usize) -> f64 {
        let middle = 0.5 * (self.disk.levels.len() as f64 - 1.0);
        nodal_diameter as f64 + BESIDE * (i as f64 - middle)
    }

    fn nodal_axis(&self) -> Axis {
        let most = self
            .disk
            .orders
            .iter()
            .map(|order| order.nodal_diameter)
            .max();
        let most = most.unwrap_or(0).min(self.disk.sectors / 2);
        Axis::linear("Nodal diameter", -0.5, most as f64 + 1.5)
    }
}

/// Frequency (Hz) of an engine order at a speed (1/min).
fn excitation_hz(order: f64, speed_rpm: f64) -> f64 {
    order / 60.0 * speed_rpm
}
