//! Performance curves of the designs beside each other, on common axes: a damper in phase and out of phase, or two strips.

use super::comparison::DesignComparison;
use crate::page::block::{Block, Section};
use crate::report::numbers::outer_points::nested;
use crate::report::numbers::performance::Measure;
use crate::report::page::performance_figure::{HINT, Performance, file, keys, title};
use crate::report::page::view::length_unit;
use crate::report::run::input::ReportInput;
use crate::report::run::stored_run::StoredRun;

/// Absent with fewer than two levels.
pub(super) fn section(comparison: &DesignComparison, runs: &[StoredRun]) -> Option<Section> {
    if comparison.levels.len() < 2 {
        return None;
    }
    let inputs: Vec<ReportInput> = runs.iter().map(StoredRun::input).collect();
    let performance = Performance {
        runs: &inputs,
        unit: length_unit(&inputs),
    };
    let nominal = inputs.iter().any(|run| run.record.nominal.is_some());
    let legend = Block::Legend(keys(nested(inputs[0].outcomes), nominal));
    let figures = Measure::ALL.map(|measure| {
        let label = |k: usize| &comparison.designs[k].label;
        let figures = performance.figures(
            measure,
            |k| format!("{}, design {}", title(measure), label(k)),
            |k| format!("performance-{}-{k}", file(measure)),
        );
        match figures.len() {
            3 => Block::triples(figures),
            _ => Block::pairs(figures),
        }
    });
    let blocks = [legend].into_iter().chain(figures);
    Some(Section {
        id: "performance",
        title: "Performance over the excitation".to_owned(),
        blocks: blocks.chain([Block::Hint(HINT.to_owned())]).collect(),
    })
}
