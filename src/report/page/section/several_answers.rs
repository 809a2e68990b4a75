//! Where curves fold over, so that a sweep upwards and one downwards meet different vibrations: how many, and which samples.

use crate::ensemble::outcome::{Maximum, SampleOutcome, SweepRecord};
use crate::page::block::{Block, Cell, Table};
use crate::page::display::{DASH, hertz, significant};
use crate::report::page::statistic_cell::{percent_cell, percent_range};
use crate::report::page::view::View;
use crate::statistics::Proportion;

/// Samples of the table at most, those first whose sweeps are farthest apart.
const MOST_ROWS: usize = 20;

/// Counts by level, and the samples whose sweeps differ.
pub(super) fn blocks(view: &View) -> Vec<Block> {
    let mut blocks = vec![answers_table(view)];
    blocks.extend(branches(view));
    blocks
}

fn answers_table(view: &View) -> Block {
    let mut table = Table::of(
        "Several answers: curves that fold over",
        "several-answers",
        &[
            ("Level", &["level"]),
            ("Curves through the band", &["curves"]),
            ("Several solutions", &["several"]),
            ("Share", &["share", "share_lower", "share_upper"]),
            ("Widest range", &["widest_hz"]),
            ("Lower over higher sweep, least", &["lowest_ratio"]),
        ],
    );
    for (i, level) in view.summary.levels.iter().enumerate() {
        let answers = &level.several_answers;
        let width = |v: f64| format!("{} Hz", significant(v));
        let of_share = answers.share.as_ref();
        let limits = |p: &Proportion| percent_range(p.lower, p.upper);
        table.row(vec![
            view.level_cell(i),
            Cell::whole(answers.curves as u64),
            Cell::whole(answers.several as u64),
            percent_cell(of_share.map(|p| p.estimate))
                .with_raw([of_share.map(|p| p.lower), of_share.map(|p| p.upper)])
                .with_small(of_share.map_or_else(String::new, limits)),
            Cell::number(
                answers.widest_hz.map_or_else(|| DASH.to_owned(), width),
                answers.widest_hz,
            ),
            percent_cell(answers.lowest_ratio),
        ]);
    }
    table.block()
}

/// A sample at a level with several solutions.
struct Folded<'a> {
    sample: u64,
    level: usize,
    sweeps: &'a SweepRecord,
    range_hz: [f64; 2],
}

impl Folded<'_> {
    /// Difference of the largest amplitudes of both sweeps over their sum.
    fn apart(&self) -> f64 {
        let [up, down] = [self.sweeps.upward, self.sweeps.downward].map(|m| m.amplitude_m);
        (up - down).abs() / (up + down)
    }
}

/// The branches that sweeps upwards and downwards follow, sample by sample; absent where none differ.
fn branches(view: &View) -> Option<Block> {
    let mut rows: Vec<Folded> = view.input.outcomes.iter().flat_map(folded).collect();
    if rows.is_empty() {
        return None;
    }
    rows.sort_by(|a, b| b.apart().total_cmp(&a.apart()));
    let title = match rows.len() > MOST_ROWS {
        false => "Sweep branches of the samples whose curves fold over".to_owned(),
        true => format!(
            "Sweep branches of {MOST_ROWS} of the {} curves that fold over, farthest apart first",
            rows.len()
        ),
    };
    let amplitude = format!("amplitude ({})", view.unit.symbol);
    let [up, down] = ["Upwards", "Downwards"].map(|way| format!("{way}: Hz, {amplitude}"));
    let mut table = Table::of(
        &title,
        "sweep-branches",
        &[
            ("Sample", &["sample"]),
            ("Level", &["level"]),
            (&up, &["upward_hz", "upward_m"]),
            (&down, &["downward_hz", "downward_m"]),
            (
                "Several solutions (Hz)",
                &["several_from_hz", "several_to_hz"],
            ),
        ],
    );
    let largest = |of: Maximum| {
        let amplitude = view.length(of.amplitude_m);
        Cell::number(
            format!("{}, {amplitude}", hertz(of.frequency_hz)),
            Some(of.frequency_hz),
        )
        .with_raw([Some(of.amplitude_m)])
    };
    for row in rows.iter().take(MOST_ROWS) {
        let [from, to] = row.range_hz;
        table.row(vec![
            Cell::whole(row.sample),
            view.level_cell(row.level),
            largest(row.sweeps.upward),
            largest(row.sweeps.downward),
            Cell::number(format!("{} … {}", hertz(from), hertz(to)), Some(from))
                .with_raw([Some(to)]),
        ]);
    }
    Some(table.block())
}

/// The levels of a sample with several solutions at some frequency.
fn folded(outcome: &SampleOutcome) -> impl Iterator<Item = Folded<'_>> {
    let levels = outcome.levels.iter().enumerate();
    levels.filter_map(|(level, record)| {
        let sweeps = record.around.sweeps()?;
        Some(Folded {
            sample: outcome.index,
            level,
            sweeps,
            range_hz: sweeps.several_hz?,
        })
    })
}
