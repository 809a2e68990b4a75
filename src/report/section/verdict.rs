//! The first section: what must be known before any number is used, and the numbers that matter most.

use super::super::block::{Block, Section};
use super::super::display::{duration, hertz, percent};
use super::super::summary::Summary;
use super::super::view::View;
use crate::hb::Status;

pub(super) fn section(view: &View) -> Section {
    let notices = notices(view);
    let calm = "Every sample has a solution at every level, and no error alert was raised.";
    Section {
        id: "verdict",
        title: "Verdict".to_owned(),
        blocks: vec![
            Block::Facts(facts(view.summary)),
            match notices.is_empty() {
                true => Block::Fine(calm.to_owned()),
                false => Block::Notices(notices),
            },
        ],
    }
}

fn facts(summary: &Summary) -> Vec<(String, String)> {
    let solves = summary.samples * summary.levels.len();
    let failed: usize = summary.levels.iter().map(|l| l.failed).sum();
    [
        ("samples", summary.samples.to_string()),
        ("solutions", format!("{} of {solves}", solves - failed)),
        (
            "free resonance",
            format!("{} Hz", hertz(summary.free_frequency_hz)),
        ),
        (
            "fully stuck",
            format!("{} Hz", hertz(summary.stuck_frequency_hz)),
        ),
        ("wall time", duration(summary.wall_time_s)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

/// What must be known before any number of the report is used.
fn notices(view: &View) -> Vec<String> {
    let summary = view.summary;
    let mut notices: Vec<String> = view
        .input
        .changed
        .iter()
        .map(|name| format!("{name} is not the file that the run wrote: its content has changed."))
        .collect();
    for status in Status::ALL.into_iter().filter(|&s| s != Status::Converged) {
        notices.extend(status_notice(view, status));
    }
    for (i, level) in summary.levels.iter().enumerate() {
        if level.frequency_hz.valid == 0 {
            let name = view.level_name(i);
            notices.push(format!("No sample has a solution at {name}."));
        }
    }
    notices
}

/// How many solves ended so, and where most of them; absent if none did.
fn status_notice(view: &View, status: Status) -> Option<String> {
    let summary = view.summary;
    let solves = summary.samples * summary.levels.len();
    let levels = summary.levels.iter();
    let counts: Vec<usize> = levels.map(|l| l.statuses[status.name()]).collect();
    let total: usize = counts.iter().sum();
    let numbered = counts.iter().enumerate();
    let (worst, count) = numbered.max_by_key(|(i, count)| (**count, usize::MAX - i))?;
    (total > 0).then(|| {
        let share = percent(total as f64 / solves as f64);
        format!(
            "{total} of {solves} solves ({share}) ended as {}: {}; most at {} ({count}).",
            status.name(),
            status.explanation(),
            view.level_name(worst),
        )
    })
}
