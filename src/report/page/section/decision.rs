//! The figure that decides a criterion: what was found at every level, beside the limit.

use crate::page::axis::Axis;
use crate::page::block::Figure;
use crate::page::figure::{Panel, Size};
use crate::report::asked::requirement::{Criterion, RequiredQuantity};
use crate::report::page::statistic_cell::limits;
use crate::report::page::view::View;
use crate::report::verdict::criterion_result::{CriterionResult, LevelResult};
use crate::report::verdict::sentence::shown;

/// One figure per criterion that is judged at some level.
pub(super) fn figures(view: &View) -> Vec<Figure> {
    let results = view.assessment.criteria.iter().enumerate();
    results
        .filter(|(_, result)| !result.levels.is_empty())
        .map(|(k, result)| figure(view, k, result))
        .collect()
}

fn figure(view: &View, k: usize, result: &CriterionResult) -> Figure {
    let Criterion {
        name,
        quantity,
        limit,
        ..
    } = &result.criterion;
    let known = |level: &LevelResult| {
        let sides = [level.interval.lower, level.interval.upper].map(|side| side.value());
        [sides[0], level.estimate, sides[1]]
    };
    let values = result.levels.iter().flat_map(known).flatten();
    let x = Axis::around(label(*quantity), values.chain([*limit]));
    let ends = x.range();
    let names = result.levels.iter().map(|level| level_of(view, level).1);
    let names = Axis::of_names(names.collect());
    let mut panel = Panel::new(Size::Rows(result.levels.len()), name.clone(), x, names);
    panel.rule("limit", *limit);
    for (row, level) in result.levels.iter().enumerate() {
        let [lower, Some(estimate), upper] = known(level) else {
            continue;
        };
        let y = -(row as f64);
        let (i, name) = level_of(view, level);
        // A side that no sample bounds goes on to the end of the axis.
        let interval = [lower.unwrap_or(ends[0]), upper.unwrap_or(ends[1])];
        panel.level_whisker(&format!("l{i}"), y, interval);
        panel.mark(i, (estimate, y));
        let show = shown(&result.criterion);
        let words = [
            format!("{name}: {}", show(estimate)),
            limits(level.interval, &show),
        ];
        panel.readout_level(y, ends, &words);
    }
    let side = match quantity.at_least() {
        true => "right",
        false => "left",
    };
    let caption = format!(
        "Found at each level, with the interval that is judged; required: to the {side} of the red line."
    );
    view.figure(&panel, format!("criterion-{k}"), caption)
}

/// Place and name of the level of a result.
pub(super) fn level_of(view: &View, result: &LevelResult) -> (usize, String) {
    let mut levels = view.input.record.levels.iter();
    let i = levels.position(|l| *l == result.level).unwrap_or(0);
    (i, view.level_name(i))
}

/// Axis label of what a criterion judges.
pub(super) fn label(quantity: RequiredQuantity) -> &'static str {
    match quantity {
        RequiredQuantity::FrequencyMarginPercent => "Frequency margin (%)",
        RequiredQuantity::AmplitudeUm => "Amplitude (µm)",
        RequiredQuantity::ReserveFactor => "Reserve factor",
        RequiredQuantity::ProbabilityOfExceedance => "Probability of a reserve factor below 1",
    }
}
