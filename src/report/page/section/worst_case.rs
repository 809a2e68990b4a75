//! The number that a criterion judges along each epistemic input, at the points where it is known.

use super::decision::{label, level_of};
use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark};
use crate::page::display::short;
use crate::page::figure::{Panel, Size};
use crate::report::page::view::View;
use crate::report::verdict::criterion_result::{CriterionResult, LevelResult};
use crate::report::verdict::over_box::{OverBox, PointJudgement};
use crate::report::verdict::sentence::{shown, word};

/// Legend and figures, one per criterion and epistemic input; nothing without criteria.
pub(super) fn blocks(view: &View) -> Vec<Block> {
    let results = view.assessment.criteria.iter().enumerate();
    let figures: Vec<Figure> = results
        .filter_map(|(k, result)| {
            let level = result.deciding()?;
            Some((k, result, level, level.over_box.as_ref()?))
        })
        .flat_map(|(k, result, level, over)| {
            let figure = move |j| figure(view, k, result, level, over, j);
            (0..over.inputs.len()).map(figure)
        })
        .collect();
    if figures.is_empty() {
        return Vec::new();
    }
    let mut keys = vec![Key::new(
        Mark::Ring,
        "solved",
        "outer point that the study asks for",
    )];
    if view.input.record.design.further_points > 0 {
        let met = "point that the search for the worst case has met";
        keys.push(Key::new(Mark::Cross, "solved", met));
    }
    keys.push(Key::new(Mark::Line, "rule limit", "limit"));
    let hint = "What each criterion judges (the quantile that its share leaves out, or the probability), over each epistemic \
                input, at the level that decides. The filled mark is the worst point. Nothing is known between the points.";
    vec![
        Block::Hint(hint.to_owned()),
        Block::Legend(keys),
        Block::pairs(figures),
    ]
}

/// The figure of criterion `k` over epistemic input `j`, at the level that decides.
fn figure(
    view: &View,
    k: usize,
    result: &CriterionResult,
    level: &LevelResult,
    over: &OverBox,
    j: usize,
) -> Figure {
    let criterion = &result.criterion;
    let known = || {
        let points = over.points.iter();
        points.filter_map(|p| Some((p, (p.values[j], p.estimate?))))
    };
    let x = Axis::around(
        over.inputs[j].clone(),
        over.points.iter().map(|p| p.values[j]),
    );
    let estimates = known().map(|(_, place)| place.1);
    let y = Axis::around(
        label(criterion.quantity),
        estimates.chain([criterion.limit]),
    );
    let (i, name) = level_of(view, level);
    let title = format!("{}, {name}", criterion.name);
    let mut panel = Panel::new(Size::Large, title, x, y);
    panel.level_rule("limit", criterion.limit);
    let asked_for = |point: &PointJudgement| {
        let grid = view.input.record.design.outer_points;
        point.outer.is_none_or(|outer| outer < grid)
    };
    let class = format!("l{i}");
    let met = known().filter(|(point, _)| !asked_for(point));
    panel.crosses(&class, met.map(|(_, place)| place));
    for (_, place) in known().filter(|(point, _)| asked_for(point)) {
        panel.ring(&class, place);
    }
    for (point, place) in known() {
        if point.outer == level.outer {
            panel.mark(i, place);
        }
        let outer = point.outer.map_or_else(String::new, |n| n.to_string());
        let words = [
            format!("point {outer}: {}", word(point.judgement)),
            format!("{} {}", over.inputs[j], short(place.0)),
            shown(criterion)(place.1),
        ];
        panel.readout_mark(place, &words);
    }
    if known().next().is_none() {
        panel.note("too few samples, or too many failed");
    }
    view.figure(&panel, format!("worst-case-{k}-{j}"), "")
}
