//! Amplification factors of a mistuned disk.

use super::envelope::quantile_cells;
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use crate::page::display::with_digits;
use crate::page::distribution::cumulative_steps;
use crate::page::figure::{Panel, Size};
use crate::report::numbers::amplification::{AmplificationSummary, FactorSummary};
use crate::report::numbers::peaks::usable_peak;
use crate::report::numbers::population::Bound;
use crate::report::page::statistic_cell::{BOUND_FIELDS, bound_cell};
use crate::report::page::view::View;
use crate::statistics::Sorted;

/// An amplification factor and its names.
struct Factor {
    /// The disks that it compares.
    against: &'static str,
    /// Its name in the download.
    file: &'static str,
    /// Its numbers at a level.
    of: fn(&AmplificationSummary) -> &FactorSummary,
}

const FACTORS: [Factor; 3] = [
    Factor {
        against: "same friction",
        file: "amplification",
        of: |a| &a.amplification,
    },
    Factor {
        against: "stuck, tuned",
        file: "over-linear",
        of: |a| &a.over_linear,
    },
    Factor {
        against: "both stuck",
        file: "linear",
        of: |a| &a.linear,
    },
];

/// Absent without a disk whose blades differ, and with epistemic inputs.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.nested()
        || view
            .summary
            .levels
            .iter()
            .all(|l| l.amplification.is_none())
    {
        return None;
    }
    let hint = "Largest amplitude of all blades and frequencies over the peak of the tuned disk with the same inputs: against the tuned \
                disk with the same friction, against the tuned disk with all contacts stuck, and both disks with all contacts stuck. \
                Small figures: 95 % confidence interval. The bound holds for 95 % of all disks.";
    let stuck = Key::new(Mark::Line, "stuck", "both stuck");
    Some(Section {
        id: "amplification",
        title: "Amplification by mistuning".to_owned(),
        blocks: std::iter::once(Block::Hint(hint.to_owned()))
            .chain(FACTORS.map(|factor| table(view, &factor)))
            .chain([view.level_legend([stuck]), Block::pairs(vec![figure(view)])])
            .collect(),
    })
}

fn table(view: &View, factor: &Factor) -> Block {
    let mut table = Table::of(
        format!("Amplification factor: {}", factor.against),
        &format!("amplification-{}", factor.file),
        &[
            ("Level", &["level"]),
            ("5 %", &["q05", "q05_lower", "q05_upper"]),
            ("50 %", &["q50", "q50_lower", "q50_upper"]),
            ("95 %", &["q95", "q95_lower", "q95_upper"]),
            ("Bound of 95 %", BOUND_FIELDS[0]),
        ],
    );
    let show = |factor: f64| with_digits(factor, 4);
    for (i, level) in view.summary.levels.iter().enumerate() {
        let Some(of_level) = level.amplification.as_ref().map(factor.of) else {
            continue;
        };
        let distribution = &of_level.distribution;
        let failed = view.input.outcomes.len() - distribution.valid;
        let mut cells: Vec<Cell> = vec![view.level_cell(i)];
        cells.extend(quantile_cells(distribution, failed, &show));
        cells.push(bound_cell(&Bound::One(of_level.upper_bound), &show));
        table.row(cells);
    }
    table.block()
}

/// Distribution functions of the factor with the same friction, level by level, and of the disks with stuck contacts.
fn figure(view: &View) -> Figure {
    let records = |i: usize| {
        let levels = view.input.outcomes.iter().map(move |o| &o.levels[i]);
        let usable = levels.filter(|level| usable_peak(level).is_some());
        usable.filter_map(|level| level.around.mistuned())
    };
    let with_friction = |i: usize| records(i).filter_map(|m| m.amplification.get());
    let linear = || records(0).filter_map(|m| m.linear_amplification.get());
    let all = (0..view.n_levels()).flat_map(with_friction).chain(linear());
    let x = Axis::around("Amplification factor".to_owned(), all);
    let y = Axis::linear("Share of disks below", 0.0, 1.0);
    let mut panel = Panel::new(
        Size::Large,
        "Distribution of the amplification factor",
        x,
        y,
    );
    panel.steps("stuck", &cumulative_steps(&Sorted::finite(linear())), 0.0);
    for i in 0..view.n_levels() {
        let corners = cumulative_steps(&Sorted::finite(with_friction(i)));
        panel.steps(&format!("level l{i}"), &corners, 0.0);
        panel.marks_along(i, &corners);
    }
    let caption = "Against the tuned disk with the same friction; dashed with all contacts stuck.";
    view.figure(&panel, "amplification", caption)
}
