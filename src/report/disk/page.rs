//! `disk.html`: the engine orders of a disk over speed and nodal diameter.

use super::summary::{DiskSummary, OrderLevel, OrderSummary};
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table, Verdict};
use crate::page::display::{DASH, LengthUnit, hertz, level_name, percent, significant};
use crate::page::figure::{Panel, Size};
use crate::page::style::figure_style;
use crate::report::error::ReportError;
use crate::report::page::document::page;
use crate::report::page::view::length_unit;
use crate::report::run::input::ReportInput;
use crate::report::run::record::NodalRecord;
use crate::report::run::stored_run::StoredRun;
use crate::report::verdict::criterion_result::CriterionResult;
use crate::report::verdict::sentence::word;
use crate::statistics::{Judgement, hull};

/// Space between the bars of two levels at one nodal diameter.
const BESIDE: f64 = 0.12;
/// Half the gap between two bands of the Campbell diagram, as a share of its width.
const GAP: f64 = 0.003;

/// Linear frequencies (Hz) of a nodal diameter, of one kind.
type FrequenciesOf = fn(&NodalRecord) -> &Vec<f64>;

/// A disk as the page shows it.
struct View<'a> {
    disk: &'a DiskSummary,
    /// Unit of the amplitudes.
    unit: LengthUnit,
    style: String,
    /// Frequencies that matter (Hz): all scatter bars with space around.
    window: [f64; 2],
}

/// Renders the page.
pub(super) fn render(disk: &DiskSummary, runs: &[StoredRun]) -> Result<String, ReportError> {
    let inputs: Vec<ReportInput> = runs.iter().map(StoredRun::input).collect();
    let bars = disk.orders.iter().flat_map(|order| &order.levels);
    let ends = bars.filter_map(|level| level.frequency_hz);
    let [low, high] = hull(ends.flat_map(|[low, _, high]| [low, high])).unwrap_or([0.0, 1.0]);
    let space = (high - low).max(2e-3 * high);
    let view = View {
        disk,
        unit: length_unit(&inputs),
        style: figure_style(disk.levels.len()),
        window: [low - space, high + space],
    };
    let title = match disk.orders.first() {
        Some(order) => format!("Disk of {} sectors: {}", disk.sectors, order.study),
        None => format!("Disk of {} sectors", disk.sectors),
    };
    let sections = [
        Some(verdicts(&view)),
        Some(diagrams(&view)),
        Some(numbers(&view)),
    ];
    let sections: Vec<Section> = sections.into_iter().flatten().collect();
    page(&title, disk.levels.len(), &sections)
}

impl View<'_> {
    fn level_name(&self, i: usize) -> String {
        level_name(self.disk.levels[i], &self.disk.level_unit)
    }

    fn figure(&self, panel: &Panel, file: &str, caption: &str) -> Figure {
        Figure::new(
            panel,
            &self.style,
            format!("{file}.svg"),
            caption.to_owned(),
        )
    }

    /// Every order at every level that has a solution.
    fn bars(&self) -> impl Iterator<Item = (&OrderSummary, usize, &OrderLevel)> {
        let orders = self.disk.orders.iter();
        orders.flat_map(|order| (order.levels.iter().enumerate()).map(move |(i, l)| (order, i, l)))
    }

    /// Place of the bar of level i at a nodal diameter: levels stand beside each other.
    fn beside(&self, nodal_diameter: usize, i: usize) -> f64 {
        let middle = 0.5 * (self.disk.levels.len() as f64 - 1.0);
        nodal_diameter as f64 + BESIDE * (i as f64 - middle)
    }

    fn nodal_axis(&self) -> Axis {
        let most = self
            .disk
            .orders
            .iter()
            .map(|order| order.nodal_diameter)
            .max();
        let most = most.unwrap_or(0).min(self.disk.sectors / 2);
        Axis::linear("Nodal diameter", -0.5, most as f64 + 1.5)
    }
}

/// What the probabilities depend on: once where it is the same for all orders.
fn conditions(orders: &[OrderSummary]) -> String {
    let of_all = orders.first().map(|order| &order.condition);
    if orders.iter().all(|order| Some(&order.condition) == of_all) {
        return of_all.cloned().unwrap_or_default();
    }
    let of_order = |order: &OrderSummary| format!("EO {}: {}", order.engine_order, order.condition);
    let each: Vec<String> = orders.iter().map(of_order).collect();
    each.join(" ")
}

fn verdicts(view: &View) -> Section {
    let orders = &view.disk.orders;
    let mut blocks = Vec::new();
    match orders.iter().any(|order| !order.criteria.is_empty()) {
        true => blocks.extend([criteria(orders), Block::Verdicts(sentences(orders))]),
        false => blocks.push(Block::Sentence("The studies state no criteria.".to_owned())),
    }
    let hint = format!(
        "Engine order r excites the nodal diameter that r leaves modulo {0} sectors, or {0} minus it. All sectors are equal: \
         what scatters is common to the whole disk. {1}",
        view.disk.sectors,
        conditions(orders)
    );
    blocks.push(Block::Hint(hint));
    Section {
        id: "verdict",
        title: "Verdict by engine order".to_owned(),
        blocks,
    }
}

/// The word of a judgement and the class of its badge.
fn badge(result: &CriterionResult) -> (&'static str, &'static str) {
    let class = match result.judgement {
        Judgement::Pass => "pass",
        Judgement::Fail => "fail",
        Judgement::Undecided => "undecided",
    };
    (word(result.judgement), class)
}

/// The judgements of all orders at a glance; narrow, so that a phone shows all of it. The sentences are in the download.
fn criteria(orders: &[OrderSummary]) -> Block {
    let mut table = Table::of(
        "Criteria by engine order",
        "disk-criteria",
        &[
            ("Order", &["engine_order", "nodal_diameter"]),
            ("Criterion", &["criterion"]),
            ("Verdict", &["verdict", "sentence"]),
        ],
    );
    for order in orders {
        for result in &order.criteria {
            let (word, class) = badge(result);
            let nodal_diameter = Some(order.nodal_diameter as f64);
            table.row(vec![
                whole(order.engine_order as usize)
                    .with_raw([nodal_diameter])
                    .with_small(format!("nodal diameter {}", order.nodal_diameter))
                    .with_class("text brief"),
                Cell::text(&result.criterion.name).with_class("text brief"),
                Cell::text(word)
                    .with_badge(class)
                    .with_raw_text(&result.sentence)
                    .with_class("text"),
            ]);
        }
    }
    table.block()
}

/// What each judgement says, order by order.
fn sentences(orders: &[OrderSummary]) -> Vec<Verdict> {
    let of_order = |order: &OrderSummary| -> Vec<Verdict> {
        let verdict = |result: &CriterionResult| {
            let (word, class) = badge(result);
            Verdict {
                word: word.to_owned(),
                class,
                name: format!(
                    "Engine order {}: {}",
                    order.engine_order, result.criterion.name
                ),
                sentence: result.sentence.clone(),
            }
        };
        order.criteria.iter().map(verdict).collect()
    };
    orders.iter().flat_map(of_order).collect()
}

fn whole(number: usize) -> Cell {
    Cell::number(number.to_string(), Some(number as f64))
}

fn diagrams(view: &View) -> Section {
    let mut keys: Vec<Key> = (0..view.disk.levels.len())
        .map(|i| Key::level(i, view.level_name(i)))
        .collect();
    keys.extend([
        Key::new(Mark::Line, "line free", "free, nominal"),
        Key::new(Mark::Line, "line stuck", "stuck, nominal"),
        Key::new(Mark::Line, "line order", "engine order, or speed"),
        Key::new(Mark::Band, "speeds", "range of speeds"),
    ]);
    let figures = vec![campbell(view), safe(view), amplitudes(view)];
    let hint = "Bars: 1 %, 50 % and 99 % of the samples, by level; with epistemic inputs the lowest, middle and highest of the \
                outer points. The SAFE diagram shows which nodal diameter resonates at which frequency; the lines are the \
                excitation at the ends of the range of speeds, which meets a nodal diameter by the engine order of the same \
                number (or the folded one). The frequencies are the same at all speeds: centrifugal stiffening enters by the \
                study's model only.";
    Section {
        id: "diagrams",
        title: "Campbell and SAFE diagram".to_owned(),
        blocks: vec![
            Block::Legend(keys),
            Block::pairs(figures),
            Block::Hint(hint.to_owned()),
        ],
    }
}

/// Frequency (Hz) of an engine order at a speed (1/min).
fn excitation_hz(order: f64, speed_rpm: f64) -> f64 {
    order / 60.0 * speed_rpm
}

fn campbell(view: &View) -> Figure {
    let [low, high] = view.window;
    let crossings = view.bars().filter_map(|(order, _, level)| {
        let [_, middle, _] = level.frequency_hz?;
        Some(middle / excitation_hz(f64::from(order.engine_order), 1.0))
    });
    let seen = crossings.chain(view.disk.speed_rpm);
    let [slow, fast] = hull(seen).unwrap_or([0.0, 1.0]);
    let space = 0.08 * (fast - slow).max(0.1 * fast);
    let [slow, fast] = [(slow - space).max(0.0), fast + space];
    let x = Axis::linear("Speed (1/min)", slow, fast);
    let y = Axis::linear("Frequency (Hz)", low, high);
    let mut panel = Panel::new(Size::Large, "Campbell diagram", x, y);
    let range = view.disk.speed_rpm.map(|speed| (speed, low, high));
    panel.band("speeds", &range);
    for speed in &view.disk.dwell_rpm {
        panel.rule("limit", *speed);
    }
    let mut names = Vec::new();
    for (order, [from, to]) in view.disk.orders.iter().zip(stretches(view, [slow, fast])) {
        // one band per family, over all levels
        if let Some([lower, upper]) = order_range(order) {
            panel.band("range", &[(from, lower, upper), (to, lower, upper)]);
        }
        let slope = excitation_hz(f64::from(order.engine_order), 1.0);
        let [enters, leaves] = [slow.max(low / slope), fast.min(high / slope)];
        if enters < leaves {
            let ends = [enters, leaves].map(|speed| (speed, slope * speed));
            panel.line("order", ends.into_iter());
            names.push((leaves, format!("EO {}", order.engine_order)));
        }
    }
    for (order, i, level) in view.bars() {
        let Some([lower, middle, upper]) = level.frequency_hz else {
            continue;
        };
        let speed = middle / excitation_hz(f64::from(order.engine_order), 1.0);
        panel.whisker(&format!("l{i}"), speed, [lower, upper]);
        panel.mark(i, (speed, middle));
        let words = [
            format!(
                "{}, EO {} at {speed:.0}/min",
                view.level_name(i),
                order.engine_order
            ),
            [lower, middle, upper].map(hertz).join(", ") + " Hz",
        ];
        panel.readout_upright(speed, [lower, upper], &words);
    }
    panel.names_above(&names);
    let caption = "A band spans the scatter of one nodal diameter over all levels. The bands lie on each other, so each is drawn \
                   at the speeds nearest to those where its engine order crosses; bars stand where it crosses their middle.";
    view.figure(&panel, "campbell", caption)
}

/// Lowest and highest frequency (Hz) of the bars of an order.
fn order_range(order: &OrderSummary) -> Option<[f64; 2]> {
    let bars = order.levels.iter().filter_map(|level| level.frequency_hz);
    hull(bars.flat_map(|[lower, _, upper]| [lower, upper]))
}

/// The speeds (1/min) at which the band of each order is drawn: up to halfway to the crossings of its neighbours, with a gap
/// between them, and within `ends`.
fn stretches(view: &View, [slow, fast]: [f64; 2]) -> Vec<[f64; 2]> {
    let orders = &view.disk.orders;
    let crossing = |order: &OrderSummary| {
        let [lower, upper] = order_range(order)?;
        let slope = excitation_hz(f64::from(order.engine_order), 1.0);
        Some(0.5 * (lower + upper) / slope)
    };
    let crossings: Vec<Option<f64>> = orders.iter().map(crossing).collect();
    let gap = GAP * (fast - slow);
    let of = |i: usize| {
        let Some(own) = crossings[i] else {
            return [slow, slow];
        };
        let others = || {
            (0..orders.len())
                .filter(|j| *j != i)
                .filter_map(|j| crossings[j])
        };
        let below = others()
            .filter(|speed| *speed < own)
            .fold(f64::NAN, f64::max);
        let above = others()
            .filter(|speed| *speed > own)
            .fold(f64::NAN, f64::min);
        let from = if below.is_nan() {
            slow
        } else {
            0.5 * (below + own) + gap
        };
        let to = if above.is_nan() {
            fast
        } else {
            0.5 * (above + own) - gap
        };
        [from.min(own), to.max(own)]
    };
    (0..orders.len()).map(of).collect()
}

fn safe(view: &View) -> Figure {
    let [low, high] = view.window;
    let y = Axis::linear("Frequency (Hz)", low, high);
    let mut panel = Panel::new(Size::Large, "SAFE diagram", view.nodal_axis(), y);
    families(view, &mut panel);
    let half = view.disk.sectors as f64 / 2.0;
    for speed in view.disk.speed_rpm {
        let there = [0.0, half].map(|order| (order, excitation_hz(order, speed)));
        panel.line("order", there.into_iter());
        let folded = [half, 2.0 * half];
        let back = folded.map(|order| (2.0 * half - order, excitation_hz(order, speed)));
        panel.line("order", back.into_iter());
    }
    for (order, i, level) in view.bars() {
        let Some([lower, middle, upper]) = level.frequency_hz else {
            continue;
        };
        let x = view.beside(order.nodal_diameter, i);
        panel.whisker(&format!("l{i}"), x, [lower, upper]);
        panel.mark(i, (x, middle));
        let words = [
            format!(
                "{}, nodal diameter {}, EO {}",
                view.level_name(i),
                order.nodal_diameter,
                order.engine_order
            ),
            [lower, middle, upper].map(hertz).join(", ") + " Hz",
        ];
        panel.readout_upright(x, [lower, upper], &words);
    }
    let caption = "Dashed and dotted: the linear families without contact and with stuck contacts. Solid lines: the excitation \
                   at the lowest and the highest speed.";
    view.figure(&panel, "safe", caption)
}

/// The linear frequencies in sight over the nodal diameter: free and stuck.
fn families(view: &View, panel: &mut Panel) {
    let diameters = &view.disk.nodal_diameters;
    let [low, high] = view.window;
    let shown: [(&str, FrequenciesOf); 2] = [
        ("free", |diameter| &diameter.free_hz),
        ("stuck", |diameter| &diameter.stuck_hz),
    ];
    for (class, frequencies) in shown {
        let families = diameters.iter().map(|d| frequencies(d).len()).min();
        for family in 0..families.unwrap_or(0) {
            let points =
                (diameters.iter()).map(|d| (d.nodal_diameter as f64, frequencies(d)[family]));
            let points: Vec<(f64, f64)> = points.collect();
            if points.iter().any(|(_, f)| (low..=high).contains(f)) {
                panel.line(class, points.into_iter());
            }
        }
    }
}

fn amplitudes(view: &View) -> Figure {
    let per_metre = view.unit.per_metre;
    let ends = view.bars().filter_map(|(.., level)| level.amplitude_m);
    let largest = ends
        .map(|[.., upper]| upper * per_metre)
        .fold(0.0, f64::max);
    let label = format!("Amplitude ({})", view.unit.symbol);
    let y = Axis::linear(label, 0.0, 1.08 * largest);
    let mut panel = Panel::new(
        Size::Large,
        "Amplitude over the nodal diameter",
        view.nodal_axis(),
        y,
    );
    for i in 0..view.disk.levels.len() {
        let mut medians: Vec<(f64, f64)> = Vec::new();
        for (order, _, level) in view.bars().filter(|(_, at, _)| *at == i) {
            let Some(amplitude) = level.amplitude_m else {
                continue;
            };
            let [lower, middle, upper] = amplitude.map(|a| a * per_metre);
            let x = view.beside(order.nodal_diameter, i);
            medians.push((x, middle));
            panel.whisker(&format!("l{i}"), x, [lower, upper]);
            panel.mark(i, (x, middle));
            let words = [
                format!("{}, EO {}", view.level_name(i), order.engine_order),
                [lower, middle, upper].map(significant).join(", ") + " " + view.unit.symbol,
            ];
            panel.readout_upright(x, [lower, upper], &words);
        }
        medians.sort_by(|a, b| a.0.total_cmp(&b.0));
        panel.line(&format!("l{i} wide"), medians.into_iter());
    }
    view.figure(
        &panel,
        "amplitude-nodal-diameter",
        "First harmonic of the first response.",
    )
}

fn numbers(view: &View) -> Section {
    let unit = view.unit.symbol;
    let amplitude = format!("Amplitude ({unit})");
    let mut table = Table::of(
        "By engine order and level",
        "disk",
        &[
            ("Order", &["engine_order"]),
            ("Nodal diameter", &["nodal_diameter"]),
            ("Level", &["level"]),
            ("Samples", &["samples"]),
            ("Failed", &["failed"]),
            (
                "Frequency (Hz)",
                &["frequency_q01_hz", "frequency_q50_hz", "frequency_q99_hz"],
            ),
            (
                &amplitude,
                &["amplitude_q01_m", "amplitude_q50_m", "amplitude_q99_m"],
            ),
            ("Crossing (1/min)", &["crossing_rpm"]),
            ("Margin, lower bound", &["margin_bound"]),
        ],
    );
    for (order, i, level) in view.bars() {
        table.row(number_row(view, order, i, level));
    }
    let hint = "Frequency and amplitude: 1 %, 50 % and 99 % of the samples. The lower bound of the margin over the range of speeds \
                holds for 95 % of the assumed prior with 95 % confidence.";
    Section {
        id: "numbers",
        title: "Numbers".to_owned(),
        blocks: vec![table.block(), Block::Hint(hint.to_owned())],
    }
}

fn number_row(view: &View, order: &OrderSummary, i: usize, level: &OrderLevel) -> Vec<Cell> {
    let bar = |bar: &Option<[f64; 3]>, show: &dyn Fn(f64) -> String| match bar {
        None => Cell::number(DASH, None).with_raw([None, None]),
        Some([low, middle, high]) => {
            let words = [low, middle, high].map(|value| show(*value)).join(", ");
            Cell::number(words, Some(*low)).with_raw([Some(*middle), Some(*high)])
        }
    };
    let slope = excitation_hz(f64::from(order.engine_order), 1.0);
    let crossing = level.frequency_hz.map(|[_, middle, _]| middle / slope);
    let speed = crossing.map_or(DASH.to_owned(), |v| format!("{v:.0}"));
    let bound = level
        .margin
        .as_ref()
        .and_then(|margin| margin.range_bound.value());
    let margin = Cell::number(bound.map_or(DASH.to_owned(), percent), bound);
    vec![
        whole(order.engine_order as usize),
        whole(order.nodal_diameter),
        Cell::number(view.level_name(i), Some(level.level)).with_chip(i),
        whole(order.samples),
        whole(level.failed),
        bar(&level.frequency_hz, &hertz),
        bar(&level.amplitude_m, &|a| {
            significant(a * view.unit.per_metre)
        }),
        Cell::number(speed, crossing),
        margin,
    ]
}
