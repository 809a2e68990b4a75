//! Error budget: what each approximation can change, in one table, so that none hides behind another.

use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{percent, significant};
use crate::report::page::view::View;

pub(super) fn section(view: &View) -> Section {
    let mut table = Table::of(
        "Largest error of any level",
        "error-budget",
        &[
            ("Source of error", &["source"]),
            ("Frequency (Hz)", &["frequency_hz"]),
            ("Amplitude", &["amplitude_relative"]),
            ("How it is known", &["basis"]),
        ],
    );
    for line in &view.assessment.error_budget {
        let unknown = || "not estimated".to_owned();
        let frequency = line.frequency_hz.map_or_else(unknown, significant);
        let amplitude = line.amplitude_relative.map_or_else(unknown, percent);
        table.row(vec![
            Cell::text(line.source).with_class("text strong"),
            Cell::number(frequency, line.frequency_hz),
            Cell::number(amplitude, line.amplitude_relative),
            Cell::text(&line.basis).with_class("text wide"),
        ]);
    }
    Section {
        id: "error-budget",
        title: "Error budget".to_owned(),
        blocks: vec![
            table.block(),
            Block::Hint(
                "The ignorance of the inputs is no error and stands in no line: it is the width of the distributions \
                 themselves and does not shrink with more samples."
                    .to_owned(),
            ),
        ],
    }
}
