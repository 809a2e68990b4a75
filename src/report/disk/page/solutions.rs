//! Whether the structure stays in the vibrations of each engine order, and whether there are others: stability and several answers.

use super::DiskView;
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, significant};

pub(super) fn section(view: &DiskView) -> Section {
    let mut table = Table::of(
        "Stability and several answers",
        "disk-solutions",
        &[
            ("Order", &["engine_order"]),
            ("Level", &["level"]),
            ("Peaks", &["peaks"]),
            ("Assessed", &["assessed"]),
            ("Unstable", &["unstable"]),
            ("Largest multiplier", &["largest_multiplier"]),
            ("Curves", &["curves"]),
            ("Several answers", &["several"]),
        ],
    );
    for (order, i, level) in view.bars() {
        let largest = level.stability.largest_multiplier;
        table.row(vec![
            Cell::whole(u64::from(order.engine_order)),
            Cell::number(view.level_name(i), Some(level.level)).with_chip(i),
            Cell::whole(level.stability.peaks as u64),
            Cell::whole(level.stability.assessed as u64),
            Cell::whole(level.stability.unstable as u64),
            Cell::number(
                largest.map_or_else(|| DASH.to_owned(), significant),
                largest,
            ),
            Cell::whole(level.several_answers.curves as u64),
            Cell::whole(level.several_answers.several as u64),
        ]);
    }
    let hint = "Assessed: peaks whose Floquet multipliers were computed; the others may be stable or not. An unstable vibration does not \
                last, and verdicts count its sample as unknown. Several answers are looked for on curves through the band alone: where a \
                curve folds over, a sweep upwards meets another vibration than one downwards.";
    Section {
        id: "solutions",
        title: "Stability and several answers".to_owned(),
        blocks: vec![table.block(), Block::Hint(hint.to_owned())],
    }
}
