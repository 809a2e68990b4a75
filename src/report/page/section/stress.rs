//! Alternating stress against the allowable one: Haigh diagram and reserve factors.

use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use crate::page::display::{percent, significant, with_digits};
use crate::page::figure::{Panel, Size};
use crate::report::asked::requirement::Stress;
use crate::report::numbers::allowable::{allowable_mpa, factor};
use crate::report::numbers::margins::Reserve;
use crate::report::numbers::population::{Exceeded, Populations};
use crate::report::page::statistic_cell::{
    BOUND_FIELDS, bound_cell, interval_fields, quantile_cell, range_cell, share_cell,
};
use crate::report::page::view::View;
use crate::units::m_to_um;

/// Absent without `[stress]`.
pub(super) fn section(view: &View) -> Option<Section> {
    let stress = view.input.record.requirements.stress.as_ref()?;
    let keys = [
        Key::new(
            Mark::Line,
            "line allowable",
            "Goodman’s allowable alternating stress",
        ),
        Key::new(
            Mark::Cross,
            "",
            "bound for 95 % of the assumed prior with 95 % confidence",
        ),
    ];
    let hint = format!(
        "Goodman: allowable = endurance limit × (1 − mean/ultimate) = {} × (1 − {}/{}) MPa. Stress = amplitude × {} \
         MPa/µm at the mean stress of the study. The line’s limits of use are the user’s to know. {}",
        with_digits(stress.endurance_limit_mpa, 4),
        with_digits(stress.mean_stress_mpa, 4),
        with_digits(stress.ultimate_strength_mpa, 4),
        with_digits(stress.modal_stress_mpa_per_um, 4),
        view.assessment.condition
    );
    Some(Section {
        id: "stress",
        title: "Stress and reserve factor".to_owned(),
        blocks: vec![
            view.level_legend(keys),
            Block::pairs(vec![haigh(view, stress), reserves(view, stress)]),
            table(view),
            Block::Hint(hint),
        ],
    })
}

/// 5 %, 50 %, 95 % of a number of the amplitude (m) at level `i`.
fn scatter(view: &View, i: usize, of: impl Fn(f64) -> f64) -> Option<[f64; 3]> {
    Populations::of(view.input, i, |peak| of(peak.amplitude_m)).scatter([0.05, 0.95])
}

/// Alternating over mean stress, with the scatter of each level at the mean stress.
fn haigh(view: &View, stress: &Stress) -> Figure {
    let applied = |amplitude_m: f64| m_to_um(amplitude_m) * stress.modal_stress_mpa_per_um;
    let bound = |i: usize| view.assessment.levels[i].amplitude_bound_m.value();
    let levels = 0..view.n_levels();
    let bounds = levels.clone().filter_map(bound).map(applied);
    let tops = levels.filter_map(|i| Some(scatter(view, i, applied)?[2]));
    let top = bounds
        .chain(tops)
        .fold(stress.endurance_limit_mpa, f64::max);
    let ultimate = stress.ultimate_strength_mpa;
    let x = Axis::linear("Mean stress (MPa)", 0.0, 1.04 * ultimate);
    let y = Axis::linear("Alternating stress (MPa)", 0.0, 1.06 * top);
    let mut panel = Panel::new(Size::Large, "Haigh diagram", x, y);
    let line = [(0.0, stress.endurance_limit_mpa), (ultimate, 0.0)];
    panel.line("allowable", line.into_iter());
    let mean = stress.mean_stress_mpa;
    let mut labels = Vec::new();
    for i in 0..view.n_levels() {
        let bound = bound(i).map(applied);
        panel.crosses(&format!("l{i}"), bound.map(|b| (mean, b)).into_iter());
        let Some([low, middle, high]) = scatter(view, i, applied) else {
            continue;
        };
        panel.whisker(&format!("l{i}"), mean, [low, high]);
        panel.mark(i, (mean, middle));
        labels.push(((mean, middle), view.level_name(i)));
        let numbers = [low, middle, high].map(significant).join(", ");
        let bound = bound.map_or_else(
            || "no bound".to_owned(),
            |bound| format!("bound {} MPa", significant(bound)),
        );
        let words = [format!("{}: {numbers} MPa", view.level_name(i)), bound];
        panel.readout_upright(mean, [low, high], &words);
    }
    let allowable = allowable_mpa(stress);
    labels.push((
        (mean, allowable),
        format!("allowable {} MPa", significant(allowable)),
    ));
    panel.labels(&labels);
    view.note_if_empty(&mut panel);
    let caption = format!(
        "Bars: {}, all at the mean stress of the study.",
        view.scatter_in_words("5 %", "95 %")
    );
    view.figure(&panel, "haigh", caption)
}

/// Reserve factor of each level.
fn reserves(view: &View, stress: &Stress) -> Figure {
    let n = view.n_levels();
    let scatters: Vec<Option<[f64; 3]>> = (0..n)
        .map(|i| scatter(view, i, |a| factor(a, stress)))
        .collect();
    let bounds: Vec<Option<f64>> = view
        .assessment
        .levels
        .iter()
        .map(|l| l.reserve.as_ref()?.factor_bound.value())
        .collect();
    let shown = scatters.iter().flatten().flatten();
    let shown = shown.chain(bounds.iter().flatten()).copied().chain([1.0]);
    let x = Axis::around("Reserve factor", shown);
    let names = (0..n).map(|i| view.level_name(i)).collect();
    let mut panel = Panel::new(
        Size::Rows(n),
        "Reserve factor by level",
        x,
        Axis::of_names(names),
    );
    panel.rule("limit", 1.0);
    for (i, (scatter, bound)) in scatters.into_iter().zip(bounds).enumerate() {
        let y = -(i as f64);
        if let Some([low, middle, high]) = scatter {
            panel.level_whisker(&format!("l{i}"), y, [low, high]);
            panel.mark(i, (middle, y));
            let words = [
                view.level_name(i),
                [low, middle, high].map(significant).join(", "),
            ];
            panel.readout_level(y, [low, high], &words);
        }
        panel.crosses(&format!("l{i}"), bound.map(|b| (b, y)).into_iter());
    }
    view.note_if_empty(&mut panel);
    let words = view.scatter_in_words("5 %", "95 %");
    let caption = format!("Bars: {words}; red: allowable stress reached.");
    view.figure(&panel, "reserve-factor", caption)
}

fn table(view: &View) -> Block {
    let mut table = Table::of(
        "Reserve factor, allowable over actual stress",
        "reserve",
        &[
            ("Level", &["level"]),
            ("Allowable amplitude", &["allowable_amplitude_m"]),
            ("Reserve, 5 %", view.fields(interval_fields!("q05"))),
            ("Reserve, 50 %", view.fields(interval_fields!("q50"))),
            ("Reserve, 95 %", view.fields(interval_fields!("q95"))),
            ("Lower bound", view.fields(BOUND_FIELDS)),
            (
                "Probability below 1",
                view.fields(interval_fields!("probability")),
            ),
        ],
    );
    for (i, level) in view.assessment.levels.iter().enumerate() {
        if let Some(reserve) = &level.reserve {
            table.row(row(view, i, reserve));
        }
    }
    table.block()
}

fn row(view: &View, i: usize, reserve: &Reserve) -> Vec<Cell> {
    let quantile = |k: usize| quantile_cell(&reserve.factor, k, &significant);
    vec![
        view.level_cell_of_margin(i),
        view.limit_cell(reserve.allowable_amplitude_m),
        quantile(0),
        quantile(1),
        quantile(2),
        bound_cell(&reserve.factor_bound, &significant),
        probability_cell(reserve.exceedance.as_ref()),
    ]
}

/// Probability, or its range over the outer points.
fn probability_cell(exceeded: Option<&Exceeded>) -> Cell {
    match exceeded {
        None => share_cell(None),
        Some(Exceeded::Points(exceedance)) => range_cell(&exceedance.range, &percent),
        Some(Exceeded::One(exceedance)) => share_cell(Some(&exceedance.probability)),
    }
}
