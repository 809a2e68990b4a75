//! Campbell and SAFE diagram, and the amplitude over the nodal diameter.

use super::{DiskView, excitation_hz};
use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark, Section};
use crate::page::display::{hertz, significant};
use crate::page::figure::{Panel, Size};
use crate::report::disk::summary::OrderSummary;
use crate::report::run::record::NodalRecord;
use crate::statistics::hull;

/// Half the gap between two bands of the Campbell diagram, as a share of its width.
const GAP: f64 = 0.003;

/// Of a nodal diameter, the number of rigid-body modes and the flexible linear frequencies (Hz), of one kind.
type FrequenciesOf = fn(&NodalRecord) -> (usize, &Vec<f64>);

pub(super) fn section(view: &DiskView) -> Section {
    let mut keys: Vec<Key> = (0..view.disk.levels.len())
        .map(|i| Key::level(i, view.level_name(i)))
        .collect();
    keys.extend([
        Key::new(Mark::Line, "line free", "free, nominal"),
        Key::new(Mark::Line, "line stuck", "stuck, nominal"),
        Key::new(Mark::Line, "line order", "engine order, or speed"),
        Key::new(Mark::Band, "speeds", "range of speeds"),
    ]);
    if !view.disk.dwell_rpm.is_empty() {
        keys.push(Key::new(Mark::Line, "rule limit", "speed that is held"));
    }
    let figures = vec![campbell(view), safe(view), amplitudes(view)];
    let hint = "Bars: 1 %, 50 % and 99 % of the samples, by level; with epistemic inputs the lowest, middle and highest of the \
                outer points. The SAFE diagram shows which nodal diameter resonates at which frequency; the lines are the \
                excitation at the ends of the range of speeds, which meets a nodal diameter by the engine order of the same \
                number or one that folds onto it. The frequencies are the same at all speeds: centrifugal stiffening enters by the \
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

fn campbell(view: &DiskView) -> Figure {
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
        if let Some([lower, upper]) = family_range(view, order.nodal_diameter) {
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
    let caption = "A band spans the scatter of one nodal diameter over all levels and all engine orders that excite it. The bands lie on \
                   each other, so each is drawn at the speeds nearest to those where its engine orders cross; bars stand where they cross \
                   their middle.";
    view.figure(&panel, "campbell", caption)
}

/// Lowest and highest frequency (Hz) of the bars of all orders that excite a nodal diameter.
fn family_range(view: &DiskView, nodal_diameter: usize) -> Option<[f64; 2]> {
    let of_family = |order: &&OrderSummary| order.nodal_diameter == nodal_diameter;
    let orders = view.disk.orders.iter().filter(of_family);
    hull(orders.filter_map(order_range).flatten())
}

/// Lowest and highest frequency (Hz) of the bars of an order.
fn order_range(order: &OrderSummary) -> Option<[f64; 2]> {
    let bars = order.levels.iter().filter_map(|level| level.frequency_hz);
    hull(bars.flat_map(|[lower, _, upper]| [lower, upper]))
}

/// The speeds (1/min) at which the band of each order is drawn: up to halfway to the crossings of its neighbours, with a gap
/// between them, and within `ends`.
fn stretches(view: &DiskView, [slow, fast]: [f64; 2]) -> Vec<[f64; 2]> {
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

fn safe(view: &DiskView) -> Figure {
    let [low, high] = view.window;
    let y = Axis::linear("Frequency (Hz)", low, high);
    let mut panel = Panel::new(Size::Large, "SAFE diagram", view.nodal_axis(), y);
    families(view, &mut panel);
    for speed in view.disk.speed_rpm {
        for ends in folded_orders(view) {
            let ends = ends.map(|(order, diameter)| (diameter, excitation_hz(order, speed)));
            panel.line("order", ends.into_iter());
        }
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

/// Ranges of engine orders, as (order, nodal diameter) at both ends, in which the nodal diameter goes through all its values once: up for
/// orders from 0 to N/2, down to N, up again. As many as the orders of the runs need, and two at least.
fn folded_orders(view: &DiskView) -> Vec<[(f64, f64); 2]> {
    let half = view.disk.sectors as f64 / 2.0;
    let orders = view.disk.orders.iter().map(|o| f64::from(o.engine_order));
    let highest = orders.fold(2.0 * half, f64::max);
    let folds = (highest / half).ceil() as usize;
    let range = |fold: usize| {
        let from = fold as f64 * half;
        let diameters = match fold % 2 {
            0 => [0.0, half],
            _ => [half, 0.0],
        };
        [(from, diameters[0]), (from + half, diameters[1])]
    };
    (0..folds).map(range).collect()
}

/// The linear frequencies in sight over the nodal diameter: free and stuck. Families are counted from the lowest mode, so that the
/// rigid-body modes of one nodal diameter alone shift none. A family has gaps where the list of a nodal diameter does not reach it.
fn families(view: &DiskView, panel: &mut Panel) {
    let diameters = &view.disk.nodal_diameters;
    let [low, high] = view.window;
    let shown: [(&str, FrequenciesOf); 2] = [
        ("free", |diameter| (diameter.rigid_modes, &diameter.free_hz)),
        ("stuck", |diameter| (0, &diameter.stuck_hz)),
    ];
    for (class, frequencies) in shown {
        let count = |d: &NodalRecord| {
            let (rigid, flexible) = frequencies(d);
            rigid + flexible.len()
        };
        for family in 0..diameters.iter().map(count).max().unwrap_or(0) {
            let point = |d: &NodalRecord| {
                let (rigid, flexible) = frequencies(d);
                let place = family.checked_sub(rigid);
                let frequency = place.and_then(|k| flexible.get(k)).copied();
                (d.nodal_diameter as f64, frequency.unwrap_or(f64::NAN))
            };
            let points: Vec<(f64, f64)> = diameters.iter().map(point).collect();
            let [lowest, highest] = hull(points.iter().map(|point| point.1)).unwrap_or([high; 2]);
            if lowest < high && highest > low {
                panel.line(class, points.into_iter());
            }
        }
    }
}

fn amplitudes(view: &DiskView) -> Figure {
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
