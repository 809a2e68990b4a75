//! The resonance of each mode, where a study follows all modes.

use super::envelope::quantile_cells;
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, hertz, percent};
use crate::report::numbers::distribution::Distribution;
use crate::report::numbers::modes::ModeSummary;
use crate::report::page::statistic_cell::share_cell;
use crate::report::page::view::View;

/// Absent where the study does not follow all modes, and with epistemic inputs.
pub(super) fn section(view: &View) -> Option<Section> {
    view.summary.levels.iter().find(|l| l.modes.is_some())?;
    let hint = "Modes bear their number among the stuck frequencies at nominal inputs, 1 for the lowest, as inspect counts them. A \
                maximum belongs to the mode whose stuck and free shapes its vibration resembles most; of several of one mode the \
                highest counts. Clearness: the part of this mode in the correlations with all modes, median and smallest; at one half \
                another mode is as near, and the name says little. Quantiles are of the samples that have the maximum; where it is \
                not known whether others have one, the second small line is their range over all values that these could have. \
                Lower maxima have no verdict, and their stability is not assessed.";
    let frequency = table(
        view,
        "Resonance frequency (Hz) by mode",
        "mode-frequency",
        |mode| &mode.frequency_hz,
        &hertz,
    );
    let title = format!("Amplitude ({}) by mode", view.unit.symbol);
    let amplitude = table(
        view,
        &title,
        "mode-amplitude",
        |mode| &mode.amplitude_m,
        &|v| view.length(v),
    );
    Some(Section {
        id: "modes",
        title: "Resonances of all modes".to_owned(),
        blocks: vec![
            Block::Hint(hint.to_owned()),
            presence(view),
            frequency,
            amplitude,
        ],
    })
}

/// The modes with their level, in the order of the tables.
fn rows<'a>(view: &'a View) -> impl Iterator<Item = (usize, &'a ModeSummary)> {
    let levels = view.summary.levels.iter().enumerate();
    levels.flat_map(|(i, level)| level.modes.iter().flatten().map(move |mode| (i, mode)))
}

/// `mode 3`, with its stuck frequency.
fn mode_cell(mode: &ModeSummary) -> Cell {
    let stuck = mode.stuck_frequency_hz;
    Cell::number(format!("mode {}", mode.mode), Some(f64::from(mode.mode)))
        .with_small(stuck.map_or_else(String::new, |hz| format!("stuck {} Hz", hertz(hz))))
}

/// How many samples have a maximum of each mode.
fn presence(view: &View) -> Block {
    let mut table = Table::of(
        "Maxima by mode",
        "mode-presence",
        &[
            ("Level", &["level"]),
            ("Mode", &["mode"]),
            ("Samples", &["present"]),
            ("Not known", &["unknown"]),
            ("Share", &["share", "share_lower", "share_upper"]),
            ("Highest", &["highest"]),
            ("Several", &["further"]),
            ("Clearness", &["clearness_median", "clearness_lowest"]),
        ],
    );
    for (i, mode) in rows(view) {
        let clearness = match mode.clearness {
            Some([median, lowest]) => Cell::number(percent(median), Some(median))
                .with_raw([Some(lowest)])
                .with_small(format!("at least {}", percent(lowest))),
            None => Cell::number(DASH, None).with_raw([None]),
        };
        table.row(vec![
            view.level_cell(i),
            mode_cell(mode),
            Cell::whole(mode.present.yes as u64),
            Cell::whole(mode.present.unknown as u64),
            share_cell(Some(&mode.present)),
            Cell::whole(mode.highest as u64),
            Cell::whole(mode.further as u64),
            clearness,
        ]);
    }
    table.block()
}

/// Quantiles of one result of each mode.
fn table(
    view: &View,
    title: &str,
    file: &str,
    of: fn(&ModeSummary) -> &Distribution,
    show: &dyn Fn(f64) -> String,
) -> Block {
    let mut table = Table::of(
        title,
        file,
        &[
            ("Level", &["level"]),
            ("Mode", &["mode"]),
            ("5 %", &["q05", "q05_lower", "q05_upper"]),
            ("50 %", &["q50", "q50_lower", "q50_upper"]),
            ("95 %", &["q95", "q95_lower", "q95_upper"]),
        ],
    );
    for (i, mode) in rows(view) {
        let mut cells = vec![view.level_cell(i), mode_cell(mode)];
        cells.extend(quantile_cells(of(mode), mode.present.unknown, show));
        table.row(cells);
    }
    table.block()
}
