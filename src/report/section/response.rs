//! Forced response: nominal curves, the cloud of peaks, and the band of the curves level by level.

use super::super::assessment::CONTENT;
use super::super::axis::Axis;
use super::super::block::{Block, Figure, Key, Mark, Section};
use super::super::display::percent;
use super::super::epistemic::outer_groups;
use super::super::figure::{Panel, Size};
use super::super::population::hull;
use super::super::record::Bands;
use super::super::summary::{CONFIDENCE, PROBABILITIES};
use super::super::view::{RANGES, Shown, View, thinned};
use super::super::{ReportInput, usable_peak};
use crate::ensemble::outcome::{LevelOutcome, SampleOutcome};
use crate::statistics::{
    Band, Curve, CurveSet, Envelope, EnvelopeRefusal, Interval, Limit, MissingPoints, Sorted,
    depth_band, pointwise_band, quantile, simultaneous_band,
};

/// Label of the abscissa.
const FREQUENCY: &str = "Excitation frequency (Hz)";
/// Grid points of a band.
const GRID: usize = 401;
/// A band is drawn where at least this share of the curves exists.
const PRESENT: f64 = 0.5;

pub(super) fn section(view: &View) -> Section {
    let linear = || {
        [
            Key::new(Mark::Line, "line free", "without contact"),
            Key::new(Mark::Line, "line stuck", "fully stuck"),
        ]
    };
    let nominal = view.input.record.nominal.is_some();
    let ring = nominal.then(|| Key::new(Mark::Ring, "", "nominal peak"));
    let line = nominal.then(|| Key::new(Mark::Line, "line nominal", "nominal"));
    let band_keys: Vec<Key> = match view.nested() {
        false => vec![Key::new(
            Mark::Band,
            "",
            "5 %, 50 % and 95 % at each frequency",
        )],
        true => {
            let [outer, inner] = RANGES;
            vec![
                Key::new(Mark::Band, "outer", outer),
                Key::new(Mark::Band, "", inner),
            ]
        }
    };
    let whole = Key::new(Mark::Line, "line wide grey", "95 % of whole curves");
    let mut first: Vec<Figure> = nominal_responses(view).into_iter().collect();
    first.push(cloud(view));
    Section {
        id: "response",
        title: "Forced response".to_owned(),
        blocks: vec![
            view.level_legend(linear().into_iter().chain(ring)),
            Block::pairs(first),
            Block::Heading("Scatter of the response, level by level".to_owned()),
            Block::Legend(
                band_keys
                    .into_iter()
                    .chain([whole])
                    .chain(line)
                    .chain(linear())
                    .collect(),
            ),
            Block::triples(bands(view)),
            Block::Hint(meaning(view.input.record.bands, view.nested())),
        ],
    }
}

/// What the bands are, in words.
fn meaning(bands: Bands, nested: bool) -> String {
    let (abscissa, shape) = match bands {
        Bands::Simultaneous => ("", "is stretched from the pointwise one"),
        Bands::Depth => (
            "",
            "is spanned by the deepest curves of one half of the samples",
        ),
        Bands::PeakAligned => (
            "Each curve stands over its frequency divided by that of its own peak: what scatters is its shape, not its \
             place. ",
            "is stretched from the pointwise one",
        ),
    };
    if nested {
        return format!(
            "{abscissa}Quantiles and medians at each frequency are those of each outer point, and the filled bands run from \
             the lowest to the highest of them. The dashed band holds the band of whole curves of each outer point, which \
             {shape} and calibrated on the other half of its samples. All are drawn where at least half of the curves of \
             every outer point exist. Whichever outer point is true, its own bands lie inside. For the peak itself use the \
             ranges."
        );
    }
    format!(
        "{abscissa}The filled band is pointwise: at each frequency 90 % of the curves lie inside, but fewer curves stay \
         inside everywhere. The dashed band {shape} and calibrated on the other half of the samples to hold the stated \
         share of whole curves. Both are drawn where at least half of the curves exist. For the peak itself use the \
         envelopes."
    )
}

/// Frequencies that hold nearly all resonances of every population, the free and the stuck one included, with room for the
/// flanks.
fn window(view: &View) -> (f64, f64) {
    let ReportInput {
        record, outcomes, ..
    } = *view.input;
    let most = |(_, members): (_, Vec<usize>)| {
        let levels = members.iter().flat_map(|&sample| &outcomes[sample].levels);
        let sorted = Sorted::finite(levels.filter_map(|l| Some(usable_peak(l)?.frequency_hz)));
        [quantile(&sorted, 0.02), quantile(&sorted, 0.98)]
    };
    let most = outer_groups(outcomes).into_iter().flat_map(most).flatten();
    let nominal = (0..view.n_levels()).filter_map(|i| view.nominal(Shown::Frequency, i));
    let linear = [record.free.frequency_hz, record.stuck.frequency_hz];
    let [low, high] = hull(most.chain(linear).chain(nominal)).unwrap_or(linear);
    let room = (0.15 * (high - low)).max(4e-4 * high);
    (low - room, high + room)
}

/// Abscissas of the bands (Hz, or over the resonance frequency).
fn band_window(view: &View) -> (f64, f64) {
    let (low, high) = window(view);
    match view.input.record.bands {
        Bands::Simultaneous | Bands::Depth => (low, high),
        Bands::PeakAligned => {
            let half = 0.5 * (high - low) / (high + low);
            (1.0 - half, 1.0 + half)
        }
    }
}

/// What the frequencies of a curve with the given resonance (Hz) are divided by in the bands.
fn band_unit(view: &View, resonance_hz: f64) -> f64 {
    match view.input.record.bands {
        Bands::Simultaneous | Bands::Depth => 1.0,
        Bands::PeakAligned => resonance_hz,
    }
}

fn amplitude_axis(view: &View, top: f64) -> Axis {
    Axis::linear(view.label(Shown::AmplitudePerLevel), 0.0, 1.06 * top)
}

/// The linear limits, the frequencies of each divided by `unit` of its resonance (Hz).
fn add_linear_curves(view: &View, panel: &mut Panel, unit: impl Fn(f64) -> f64) {
    let record = view.input.record;
    for (class, linear) in [("free", &record.free), ("stuck", &record.stuck)] {
        let points = view.curve(&linear.curve, 1.0).into_iter();
        let unit = unit(linear.frequency_hz);
        panel.line(class, points.map(|(f, a)| (f / unit, a)));
    }
}

fn largest_linear_amplitude(view: &View) -> f64 {
    let record = view.input.record;
    let limits = [&record.free, &record.stuck].map(|linear| view.largest(&linear.curve, 1.0));
    limits.into_iter().flatten().fold(0.0, f64::max)
}

/// Response at the nominal inputs, all levels in one panel.
fn nominal_responses(view: &View) -> Option<Figure> {
    let nominal = view.input.record.nominal.as_ref()?;
    let amplitudes = (0..view.n_levels()).filter_map(|i| view.nominal(Shown::AmplitudePerLevel, i));
    let top = amplitudes.fold(largest_linear_amplitude(view), f64::max);
    let (low, high) = window(view);
    let x = Axis::linear(FREQUENCY, low, high);
    let y = amplitude_axis(view, top);
    let mut panel = Panel::new(Size::Large, "Nominal forced response", x, y);
    add_linear_curves(view, &mut panel, |_| 1.0);
    for (i, record) in nominal.levels.iter().enumerate() {
        let curve = view.curve(&record.curve, record.level);
        panel.line(&format!("level l{i}"), curve.into_iter());
    }
    Some(view.figure(&panel, "nominal-response", ""))
}

/// Bands of the curves of one population at one level: of all samples, or of those of an outer point.
struct CurveBands {
    /// Number of the outer point, if it is one.
    outer: Option<u64>,
    pointwise: Band,
    whole: Result<Envelope, EnvelopeRefusal>,
    /// Samples with a curve.
    curves: usize,
}

/// What a panel shows at one abscissa, from the lowest to the highest of the populations.
struct Strip {
    x: f64,
    /// From the 5 % to the 95 % quantile.
    outer: [f64; 2],
    medians: [f64; 2],
    /// Band of whole curves; absent unless every population has one here.
    whole: Option<[f64; 2]>,
}

/// One panel per level: 5 %, 50 % and 95 % of the response at each frequency, the band of whole curves, and the nominal
/// response.
fn bands(view: &View) -> Vec<Figure> {
    let (low, high) = band_window(view);
    let grid: Vec<f64> = (0..GRID)
        .map(|i| low + (high - low) * i as f64 / (GRID - 1) as f64)
        .collect();
    let groups = outer_groups(view.input.outcomes);
    let of_level = |i: usize| -> Vec<CurveBands> {
        let bands = |(outer, members): &(Option<u64>, Vec<usize>)| {
            let set = CurveSet::of(&curves(view, i, members), &grid);
            CurveBands::of(*outer, &set, view.input.record.bands)
        };
        groups.iter().map(bands).collect()
    };
    let levels: Vec<(Vec<CurveBands>, Vec<Option<Strip>>)> = (0..view.n_levels())
        .map(of_level)
        .map(|bands| {
            let strips = (0..GRID).map(|k| Strip::of(&bands, k)).collect();
            (bands, strips)
        })
        .collect();
    let strips = levels.iter().flat_map(|(_, strips)| strips).flatten();
    let top = strips.fold(largest_linear_amplitude(view), |top, s| top.max(s.outer[1]));
    let panels = levels.iter().enumerate();
    panels
        .map(|(i, (bands, strips))| band_panel(view, i, bands, strips, top))
        .collect()
}

impl CurveBands {
    fn of(outer: Option<u64>, set: &CurveSet, bands: Bands) -> Self {
        let whole_band = match bands {
            Bands::Simultaneous | Bands::PeakAligned => simultaneous_band,
            Bands::Depth => depth_band,
        };
        Self {
            outer,
            pointwise: pointwise_band(set, &PROBABILITIES, CONFIDENCE),
            whole: whole_band(set, CONTENT, CONFIDENCE, MissingPoints::NotJudged),
            curves: set.total() - set.failed(),
        }
    }

    /// Quantiles at grid point `k`; `None` where too few of the curves exist.
    fn quantiles(&self, k: usize) -> Option<&[f64]> {
        let point = &self.pointwise.points[k];
        let enough = point.present as f64 >= PRESENT * self.curves as f64;
        point.quantiles.as_deref().filter(|_| enough)
    }

    /// Edges of the band of whole curves at grid point `k`.
    fn whole(&self, k: usize) -> Option<[f64; 2]> {
        let point = self.whole.as_ref().ok()?.points[k]?;
        Some([point.lower.max(0.0), point.upper])
    }
}

impl Strip {
    /// At grid point `k`; `None` where too few of the curves of some population exist.
    fn of(populations: &[CurveBands], k: usize) -> Option<Self> {
        let hull = |ends: Option<Vec<[f64; 2]>>| hull(ends?.into_iter().flatten());
        let from_to = |low: usize, high: usize| {
            let ends = |p: &CurveBands| p.quantiles(k).map(|q| [q[low], q[high]]);
            hull(populations.iter().map(ends).collect())
        };
        Some(Self {
            x: populations.first()?.pointwise.points[k].x,
            outer: from_to(0, 2)?,
            medians: from_to(1, 1)?,
            whole: hull(populations.iter().map(|p| p.whole(k)).collect()),
        })
    }
}

/// Curves of those of the samples that were to have one, over the abscissa of the bands; absent without a solution.
fn curves(view: &View, i: usize, samples: &[usize]) -> Vec<Option<Curve>> {
    let solved = |o: &SampleOutcome| {
        let record: &LevelOutcome = &o.levels[i];
        let resonance_hz = usable_peak(record)?.frequency_hz;
        let curve = Curve::through(view.curve(&record.curve, record.level))?;
        curve.aligned(band_unit(view, resonance_hz))
    };
    let asked = |o: &&SampleOutcome| o.index < view.input.record.curve_samples;
    let samples = samples.iter().map(|&s| &view.input.outcomes[s]);
    samples.filter(asked).map(solved).collect()
}

fn band_panel(
    view: &View,
    i: usize,
    bands: &[CurveBands],
    strips: &[Option<Strip>],
    top: f64,
) -> Figure {
    let (low, high) = band_window(view);
    let label = match view.input.record.bands {
        Bands::Simultaneous | Bands::Depth => FREQUENCY,
        Bands::PeakAligned => "Frequency over resonance frequency",
    };
    let (x, y) = (Axis::linear(label, low, high), amplitude_axis(view, top));
    let mut panel = Panel::new(Size::Small, view.level_name(i), x, y);
    add_linear_curves(view, &mut panel, |resonance| band_unit(view, resonance));
    draw_strips(&mut panel, i, strips, view.nested());
    let nominal = view.input.record.nominal.as_ref();
    if let (Some(nominal), Some(resonance)) = (nominal, view.nominal(Shown::Frequency, i)) {
        let record = &nominal.levels[i];
        let curve = view.curve(&record.curve, record.level).into_iter();
        let unit = band_unit(view, resonance);
        panel.line("nominal", curve.map(|(f, a)| (f / unit, a)));
    }
    let drawn = strips.iter().any(Option::is_some);
    let caption = match bands {
        [all] if !view.nested() => caption(all, drawn),
        points => caption_of_points(points, drawn),
    };
    view.figure(&panel, format!("band-{i}"), caption)
}

/// How many curves of all samples there are, and what their bands hold.
fn caption(bands: &CurveBands, drawn: bool) -> String {
    let inside = bands.pointwise.whole_curves_inside.and_then(|s| s.known);
    let pointwise = match inside {
        None => "No sample has a response curve.".to_owned(),
        Some(_) if !drawn => "No frequency is reached by half of the curves.".to_owned(),
        Some(inside) => format!(
            "{} curves, {} of them wholly inside the pointwise band.",
            bands.curves,
            percent(inside.estimate)
        ),
    };
    let whole = match &bands.whole {
        Ok(band) => format!(
            " Dashed: holds {} of whole curves where they exist; {} curves shaped it, {} samples set its width.",
            percent(band.expected_coverage),
            band.shaped_by,
            band.calibration.total()
        ),
        Err(_) if bands.curves == 0 => String::new(),
        Err(refusal) => format!(" No band of whole curves: {refusal}."),
    };
    pointwise + &whole
}

/// The same over outer points.
fn caption_of_points(points: &[CurveBands], drawn: bool) -> String {
    let curves: usize = points.iter().map(|p| p.curves).sum();
    if let Some(CurveBands { outer, .. }) = points.iter().find(|p| p.curves == 0) {
        let outer = outer.unwrap_or_default();
        return format!("No sample of outer point {outer} has a response curve.");
    }
    let pointwise = match drawn {
        true => format!("{curves} curves of {} outer points.", points.len()),
        false => "No frequency is reached by half of the curves of every outer point.".to_owned(),
    };
    let coverage = |p: &CurveBands| match &p.whole {
        Ok(band) => Ok(band.expected_coverage),
        Err(refusal) => Err((p.outer.unwrap_or_default(), *refusal)),
    };
    let coverages: Result<Vec<f64>, _> = points.iter().map(coverage).collect();
    let whole = match coverages {
        Ok(held) => format!(
            " Dashed: around bands that hold {} or more of the whole curves of each, where they exist.",
            percent(held.into_iter().fold(1.0, f64::min))
        ),
        Err((outer, refusal)) => {
            format!(" No band of whole curves: at outer point {outer} {refusal}.")
        }
    };
    pointwise + &whole
}

/// Draws the bands where every population has enough curves.
fn draw_strips(panel: &mut Panel, i: usize, strips: &[Option<Strip>], nested: bool) {
    for run in strips.chunk_by(|a, b| a.is_some() == b.is_some()) {
        let band = |of: fn(&Strip) -> [f64; 2]| -> Vec<_> {
            let edges = |s: &Strip| (s.x, of(s)[0], of(s)[1]);
            run.iter().flatten().map(edges).collect()
        };
        let medians = band(|s| s.medians);
        match nested {
            true => {
                panel.band(&format!("outer l{i}"), &band(|s| s.outer));
                panel.band(&format!("l{i}"), &medians);
            }
            false => {
                panel.band(&format!("l{i}"), &band(|s| s.outer));
                panel.line(
                    &format!("median l{i}"),
                    medians.into_iter().map(|m| (m.0, m.1)),
                );
            }
        }
        let whole = |end: usize| {
            let of = move |s: &Strip| (s.x, s.whole.map_or(f64::NAN, |ends| ends[end]));
            run.iter().flatten().map(of)
        };
        for end in [0, 1] {
            panel.line(&format!("wide l{i}"), whole(end));
        }
    }
}

/// All peaks: amplitude per force over frequency, coloured by level.
fn cloud(view: &View) -> Figure {
    let [frequency, amplitude] = Shown::ALL;
    let x = Axis::around(view.label(frequency), view.all_values(frequency));
    let y = Axis::around(view.label(amplitude), view.all_values(amplitude)).starting_at_zero();
    let ranges = [x.range(), y.range()];
    let mut panel = Panel::new(Size::Large, "Resonance peaks of all samples", x, y);
    for i in 0..view.n_levels() {
        let points = view.values(frequency, i).zip(view.values(amplitude, i));
        panel.dots(&format!("l{i}"), thinned(points.collect()).into_iter());
    }
    for i in 0..view.n_levels() {
        if let Some(corners) = region(view, i, ranges) {
            panel.line(&format!("joint l{i}"), corners.into_iter());
        }
        if let (Some(x), Some(y)) = (view.nominal(frequency, i), view.nominal(amplitude, i)) {
            panel.ring(&format!("l{i}"), (x, y));
        }
    }
    view.note_if_empty(&mut panel);
    let caption = match view.nested() {
        true => "The samples of all outer points: how dense they lie says nothing.",
        false => {
            "Dashed: region that holds 95 % of the blades with 95 % confidence, open where too few samples bound it, \
             conditional on the assumed distributions."
        }
    };
    view.figure(&panel, "peaks", caption)
}

/// Corners of the joint region of level `i`, if there is one; open sides lie outside of the axes.
fn region(view: &View, i: usize, [x_axis, y_axis]: [[f64; 2]; 2]) -> Option<[(f64, f64); 5]> {
    let region = view.assessment.levels[i].joint_region.as_ref()?;
    let scale = view.unit.per_metre / view.input.record.levels[i];
    let sides = |interval: Interval, scale: f64, [low, high]: [f64; 2]| {
        let width = high - low;
        let side = |limit: Limit, open: f64| limit.value().map_or(open, |v| v * scale);
        let lower = side(interval.lower, low - width);
        [lower, side(interval.upper, high + width)]
    };
    let [x0, x1] = sides(region.x, 1.0, x_axis);
    let [y0, y1] = sides(region.y, scale, y_axis);
    Some([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
}
