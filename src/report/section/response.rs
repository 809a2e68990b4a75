//! Forced response: nominal curves, the cloud of peaks, and the band of the curves level by level.

use super::super::assessment::CONTENT;
use super::super::axis::Axis;
use super::super::block::{Block, Figure, Key, Mark, Section};
use super::super::display::percent;
use super::super::figure::{Panel, Size};
use super::super::record::Bands;
use super::super::summary::{CONFIDENCE, PROBABILITIES};
use super::super::usable_peak;
use super::super::view::{Shown, View, thinned};
use crate::ensemble::outcome::{LevelOutcome, SampleOutcome};
use crate::statistics::{
    Band, BandPoint, Curve, CurveSet, Envelope, EnvelopePoint, EnvelopeRefusal, Interval, Limit,
    MissingPoints, Sorted, depth_band, pointwise_band, quantile, simultaneous_band,
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
    let band = Key::new(Mark::Band, "", "5 %, 50 % and 95 % at each frequency");
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
                [band, whole]
                    .into_iter()
                    .chain(line)
                    .chain(linear())
                    .collect(),
            ),
            Block::triples(bands(view)),
            Block::Hint(meaning(view.input.record.bands)),
        ],
    }
}

/// What the bands are, in words.
fn meaning(bands: Bands) -> String {
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
    format!(
        "{abscissa}The filled band is pointwise: at each frequency 90 % of the curves lie inside, but fewer curves stay \
         inside everywhere. The dashed band {shape} and calibrated on the other half of the samples to hold the stated \
         share of whole curves. Both are drawn where at least half of the curves exist. For the peak itself use the \
         envelopes."
    )
}

/// Frequencies that hold nearly all resonances, the free and the stuck one included, with room for the flanks.
fn window(view: &View) -> (f64, f64) {
    let record = view.input.record;
    let sorted = Sorted::finite(view.all_values(Shown::Frequency));
    let nominal = (0..view.n_levels()).filter_map(|i| view.nominal(Shown::Frequency, i));
    let linear = [record.free.frequency_hz, record.stuck.frequency_hz];
    let shown: Vec<f64> = [quantile(&sorted, 0.02), quantile(&sorted, 0.98)]
        .into_iter()
        .flatten()
        .chain(linear)
        .chain(nominal)
        .collect();
    let low = shown.iter().copied().fold(f64::INFINITY, f64::min);
    let high = shown.iter().copied().fold(f64::NEG_INFINITY, f64::max);
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

/// Bands of one level.
struct LevelBands {
    pointwise: Band,
    whole: Result<Envelope, EnvelopeRefusal>,
    /// Samples with a curve.
    curves: usize,
}

/// One panel per level: 5 %, 50 % and 95 % of the response at each frequency, the band of whole curves, and the nominal
/// response.
fn bands(view: &View) -> Vec<Figure> {
    let (low, high) = band_window(view);
    let grid: Vec<f64> = (0..GRID)
        .map(|i| low + (high - low) * i as f64 / (GRID - 1) as f64)
        .collect();
    let whole_band = match view.input.record.bands {
        Bands::Simultaneous | Bands::PeakAligned => simultaneous_band,
        Bands::Depth => depth_band,
    };
    let bands: Vec<LevelBands> = (0..view.n_levels())
        .map(|i| {
            let set = CurveSet::of(&curves(view, i), &grid);
            LevelBands {
                pointwise: pointwise_band(&set, &PROBABILITIES, CONFIDENCE),
                whole: whole_band(&set, CONTENT, CONFIDENCE, MissingPoints::NotJudged),
                curves: set.total() - set.failed(),
            }
        })
        .collect();
    let quantiles = bands.iter().flat_map(|band| &band.pointwise.points);
    let highest = quantiles.filter_map(|p| p.quantiles.as_ref()?.last().copied());
    let top = highest.fold(largest_linear_amplitude(view), f64::max);
    let panels = bands.iter().enumerate();
    panels
        .map(|(i, bands)| band_panel(view, i, bands, top))
        .collect()
}

/// Curve of each sample that was to have one, over the abscissa of the bands; absent without a solution.
fn curves(view: &View, i: usize) -> Vec<Option<Curve>> {
    let solved = |o: &SampleOutcome| {
        let record: &LevelOutcome = &o.levels[i];
        let resonance_hz = usable_peak(record)?.frequency_hz;
        let curve = Curve::through(view.curve(&record.curve, record.level))?;
        curve.aligned(band_unit(view, resonance_hz))
    };
    let asked = |o: &&SampleOutcome| o.index < view.input.record.curve_samples;
    view.input
        .outcomes
        .iter()
        .filter(asked)
        .map(solved)
        .collect()
}

fn band_panel(view: &View, i: usize, bands: &LevelBands, top: f64) -> Figure {
    let (low, high) = band_window(view);
    let label = match view.input.record.bands {
        Bands::Simultaneous | Bands::Depth => FREQUENCY,
        Bands::PeakAligned => "Frequency over resonance frequency",
    };
    let (x, y) = (Axis::linear(label, low, high), amplitude_axis(view, top));
    let mut panel = Panel::new(Size::Small, view.level_name(i), x, y);
    add_linear_curves(view, &mut panel, |resonance| band_unit(view, resonance));
    let drawn = draw_pointwise(&mut panel, i, bands);
    draw_whole(&mut panel, i, bands);
    let nominal = view.input.record.nominal.as_ref();
    if let (Some(nominal), Some(resonance)) = (nominal, view.nominal(Shown::Frequency, i)) {
        let record = &nominal.levels[i];
        let curve = view.curve(&record.curve, record.level).into_iter();
        let unit = band_unit(view, resonance);
        panel.line("nominal", curve.map(|(f, a)| (f / unit, a)));
    }
    let inside = bands.pointwise.whole_curves_inside.and_then(|s| s.known);
    let pointwise = match inside {
        None => "No sample has a response curve.".to_owned(),
        Some(_) if drawn == 0 => "No frequency is reached by half of the curves.".to_owned(),
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
    view.figure(&panel, format!("band-{i}"), pointwise + &whole)
}

/// Draws the pointwise band where enough curves exist; number of grid points drawn.
fn draw_pointwise(panel: &mut Panel, i: usize, bands: &LevelBands) -> usize {
    let least = PRESENT * bands.curves as f64;
    let enough = |present: usize| present > 0 && present as f64 >= least;
    let mut drawn = 0;
    for run in bands
        .pointwise
        .points
        .chunk_by(|a, b| enough(a.present) == enough(b.present))
    {
        let shown = run.iter().filter(|p| enough(p.present));
        let quantiles: Vec<(f64, &[f64])> = shown
            .filter_map(|p| Some((p.x, p.quantiles.as_deref()?)))
            .collect();
        drawn += quantiles.len();
        let outer: Vec<_> = quantiles.iter().map(|(x, q)| (*x, q[0], q[2])).collect();
        panel.band(&format!("l{i}"), &outer);
        let median = quantiles.iter().map(|(x, q)| (*x, q[1]));
        panel.line(&format!("median l{i}"), median);
    }
    drawn
}

/// Draws the band of whole curves, where it exists and where enough curves do.
fn draw_whole(panel: &mut Panel, i: usize, bands: &LevelBands) {
    let Ok(whole) = &bands.whole else { return };
    let least = PRESENT * bands.curves as f64;
    let edge = |side: fn(&EnvelopePoint) -> f64| {
        let points = whole.points.iter().zip(&bands.pointwise.points);
        let of = move |(point, band): (&Option<EnvelopePoint>, &BandPoint)| {
            let present = band.present as f64 >= least;
            let value = point.as_ref().filter(|_| present).map(side);
            (band.x, value.unwrap_or(f64::NAN))
        };
        points.map(of)
    };
    let class = format!("wide l{i}");
    panel.line(&class, edge(|p| p.lower.max(0.0)));
    panel.line(&class, edge(|p| p.upper));
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
        true => "",
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
