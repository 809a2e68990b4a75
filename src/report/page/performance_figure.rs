//! Figures of performance curves: samples as thin lines, the fan of all of them, the nominal inputs; of one run or of several
//! beside each other, on common axes.

use crate::page::axis::Axis;
use crate::page::block::{Figure, Key, Mark};
use crate::page::display::{LengthUnit, from_to, hertz, per_level, significant};
use crate::page::figure::{Panel, Size};
use crate::page::style::figure_style;
use crate::report::numbers::peak_error::half_power_ratio;
use crate::report::numbers::performance::{FanPlace, Line, Measure, fan, line, q_factor};
use crate::report::page::view::RANGES;
use crate::report::run::input::ReportInput;
use crate::report::run::record::{LinearRecord, RunRecord};

/// What every page with performance curves says of them.
pub(in crate::report) const HINT: &str = "Quantiles at each ratio of the samples with a solution there; each sample is a line, straight on logarithmic \
     axes. Damping ratio: the work that damping and friction dissipate per cycle over 4π times the kinetic energy of the first \
     harmonic; at the linear limits from the half-power width. Q = 1 / (2 · damping ratio), beside published ranges of \
     sources of damping (Gastaldi, Berruti & Gola 2018). Small excitation: contacts stick; large excitation: they slip and open.";

/// Samples shown as lines of their own: the first so many.
const THIN_LINES: usize = 30;

/// Published ranges of the Q factor by source of damping, and where the name stands. Source: Gastaldi, Berruti & Gola 2018,
/// doi 10.1007/s40799-018-0248-z, which gathers them from the literature.
const SOURCES: [(&str, [f64; 2], f64); 4] = [
    ("material 3000 to 10000", [3000.0, 10_000.0], 5500.0),
    ("shroud 180 to 2500", [180.0, 2500.0], 440.0),
    ("platform damper 15 to 250", [15.0, 250.0], 26.0),
    ("root 50 to 140", [50.0, 140.0], 84.0),
];

/// One number of one run, in the units that the page shows.
struct Drawn {
    fan: Vec<FanPlace>,
    lines: Vec<Line>,
    nominal: Line,
    /// Without contact, and fully stuck; NaN where not known.
    limits: [f64; 2],
}

/// The runs whose figures share their axes.
pub(in crate::report) struct Performance<'a> {
    /// One run, or those of a comparison.
    pub(in crate::report) runs: &'a [ReportInput<'a>],
    /// Unit of amplitudes.
    pub(in crate::report) unit: LengthUnit,
}

impl Performance<'_> {
    /// A figure of `measure` for each run; `title` names a run by its place, `file` its download.
    pub(in crate::report) fn figures(
        &self,
        measure: Measure,
        title: impl Fn(usize) -> String,
        file: impl Fn(usize) -> String,
    ) -> Vec<Figure> {
        let drawn: Vec<Drawn> = self
            .runs
            .iter()
            .map(|run| self.drawn(run, measure))
            .collect();
        let axes = self.axes(measure, &drawn);
        let style = figure_style(self.runs[0].record.levels.len());
        let figure = |(k, drawn): (usize, &Drawn)| {
            let panel = panel(title(k), &axes, measure, drawn);
            Figure::new(&panel, &style, file(k), String::new())
        };
        drawn.iter().enumerate().map(figure).collect()
    }

    fn drawn(&self, run: &ReportInput, measure: Measure) -> Drawn {
        let scale = self.scale(measure);
        let scaled =
            |line: Line| -> Line { line.into_iter().map(|(x, y)| (x, y * scale)).collect() };
        let of = |sample| scaled(line(run.record, measure, sample));
        let in_unit = |place: FanPlace| FanPlace {
            outer: place.outer.map(|v| v * scale),
            inner: place.inner.map(|v| v * scale),
            median: place.median.map(|v| v * scale),
            ..place
        };
        Drawn {
            fan: fan(run, measure).into_iter().map(in_unit).collect(),
            lines: run.outcomes.iter().take(THIN_LINES).map(of).collect(),
            nominal: run.record.nominal.as_ref().map(of).unwrap_or_default(),
            limits: limits(run.record, measure).map(|v| v * scale),
        }
    }

    /// Shown number per SI unit.
    fn scale(&self, measure: Measure) -> f64 {
        match measure {
            Measure::Frequency | Measure::QFactor => 1.0,
            Measure::AmplitudePerExcitation => self.unit.per_metre,
            Measure::DampingRatio => 100.0,
        }
    }

    /// Label of the axis of `measure`, and head of its column.
    pub(in crate::report) fn label(&self, measure: Measure) -> String {
        match measure {
            Measure::Frequency => "Resonance frequency (Hz)".to_owned(),
            Measure::AmplitudePerExcitation => {
                let unit = per_level(self.unit.symbol, &self.runs[0].record.level_unit);
                format!("Amplitude ({unit})")
            }
            Measure::QFactor => "Q factor".to_owned(),
            Measure::DampingRatio => "Damping ratio (%)".to_owned(),
        }
    }

    /// Common to all runs.
    fn axes(&self, measure: Measure, drawn: &[Drawn]) -> [Axis; 2] {
        let lines = || {
            drawn
                .iter()
                .flat_map(|d| d.lines.iter().chain([&d.nominal]))
                .flatten()
        };
        let ratios = lines().map(|point| point.0);
        let [low, high] = ends(ratios);
        let label = ratio_label(self.runs[0].record);
        let x = match low > 0.0 && high > low {
            true => Axis::log(label, low / SPACE, high * SPACE),
            false => Axis::around(label, [low, high].into_iter()),
        };
        let fans = drawn
            .iter()
            .flat_map(|d| d.fan.iter().flat_map(|place| place.outer));
        let limits = drawn.iter().flat_map(|d| d.limits);
        let values = lines().map(|point| point.1).chain(fans).chain(limits);
        let y = match measure {
            Measure::QFactor => {
                let sources = SOURCES.iter().flat_map(|source| source.1);
                Axis::around(self.label(measure), values.chain(sources))
            }
            _ => Axis::around(self.label(measure), values),
        };
        [x, y]
    }
}

/// Space at the ends of the axis of ratios, as a factor.
const SPACE: f64 = 1.2;

/// Smallest and largest finite value; NaN without any.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|v| v.is_finite());
    finite.fold([f64::NAN; 2], |[low, high], v| [low.min(v), high.max(v)])
}

/// What the axis of ratios shows.
pub(in crate::report) fn ratio_label(record: &RunRecord) -> String {
    match record.static_load {
        Some(_) => "Excitation over centrifugal load".to_owned(),
        None => format!("Excitation ({})", record.level_unit),
    }
}

/// `measure` of the linear structure at its resonance without contact, and with stuck contacts; NaN where the band holds no resonance.
fn limits(record: &RunRecord, measure: Measure) -> [f64; 2] {
    let of = |linear: &LinearRecord| {
        let Some(frequency_hz) = linear.frequency_hz else {
            return f64::NAN;
        };
        let ratio = || half_power_ratio(linear).unwrap_or(f64::NAN);
        match measure {
            Measure::Frequency => frequency_hz,
            Measure::AmplitudePerExcitation => linear
                .curve
                .iter()
                .map(|p| p.amplitude_m)
                .fold(f64::NAN, f64::max),
            Measure::QFactor => q_factor(ratio()),
            Measure::DampingRatio => ratio(),
        }
    };
    [&record.free, &record.stuck].map(of)
}

fn panel(title: String, [x, y]: &[Axis; 2], measure: Measure, drawn: &Drawn) -> Panel {
    let [low, high] = x.range();
    let mut panel = Panel::new(Size::Large, title, x.clone(), y.clone());
    if measure == Measure::QFactor {
        for (_, [least, most], _) in SOURCES {
            panel.band("source", &[(low, least, most), (high, least, most)]);
        }
    }
    for (class, limit) in ["free", "stuck"].into_iter().zip(drawn.limits) {
        panel.line(class, [(low, limit), (high, limit)].into_iter());
    }
    for line in &drawn.lines {
        panel.line("sample", line.iter().copied());
    }
    let band = |of: fn(&FanPlace) -> [f64; 2]| -> Vec<_> {
        let edges = |place: &FanPlace| (place.ratio, of(place)[0], of(place)[1]);
        drawn.fan.iter().map(edges).collect()
    };
    panel.band("range outer", &band(|place| place.outer));
    panel.band("range", &band(|place| place.inner));
    let medians = (drawn.fan.iter()).filter_map(|place| Some((place.ratio, place.median?)));
    panel.line("nominal", medians);
    for (i, point) in drawn.nominal.iter().enumerate() {
        panel.ring(&format!("l{i}"), *point);
    }
    for place in &drawn.fan {
        panel.readout_upright(place.ratio, place.outer, &words(measure, place));
    }
    if measure == Measure::QFactor {
        let names = SOURCES.map(|(name, _, place)| ((low, place), name.to_owned()));
        panel.labels(&names);
    }
    if drawn.lines.iter().flatten().all(|point| point.1.is_nan()) {
        panel.note(match measure {
            Measure::QFactor | Measure::DampingRatio => "no damping ratio in these results",
            _ => "no sample has a solution",
        });
    }
    panel
}

/// What shows under the pointer at one ratio.
fn words(measure: Measure, place: &FanPlace) -> Vec<String> {
    let number = |value: f64| match measure {
        Measure::Frequency => hertz(value),
        _ => significant(value),
    };
    let ratio = format!("at {}", significant(place.ratio));
    let median = place
        .median
        .map(|median| format!("median {}", number(median)));
    let ends = [place.outer, place.inner].map(|[low, high]| from_to([low, high], number));
    std::iter::once(ratio).chain(median).chain(ends).collect()
}

/// What the marks mean, for samples that belong to outer points or not.
pub(in crate::report) fn keys(nested: bool, nominal: bool) -> Vec<Key> {
    let [outer, inner] = match nested {
        false => ["5 % to 95 % of the samples, median", "25 % to 75 %"],
        true => RANGES,
    };
    let keys = [
        Key::new(Mark::Band, "outer", outer),
        Key::new(Mark::Band, "", inner),
        Key::new(
            Mark::Line,
            "line sample",
            format!("samples, the first {THIN_LINES}"),
        ),
        Key::new(Mark::Line, "line free", "without contact"),
        Key::new(Mark::Line, "line stuck", "fully stuck"),
    ];
    let ring = nominal.then(|| Key::new(Mark::Ring, "", "nominal"));
    keys.into_iter().chain(ring).collect()
}

/// Words for `measure` at the start of a title.
pub(in crate::report) fn title(measure: Measure) -> &'static str {
    match measure {
        Measure::Frequency => "Resonance frequency",
        Measure::AmplitudePerExcitation => "Amplitude per excitation",
        Measure::QFactor => "Q factor",
        Measure::DampingRatio => "Damping ratio",
    }
}

/// Name of `measure` in names of files.
pub(in crate::report) fn file(measure: Measure) -> &'static str {
    match measure {
        Measure::Frequency => "frequency",
        Measure::AmplitudePerExcitation => "amplitude",
        Measure::QFactor => "q-factor",
        Measure::DampingRatio => "damping-ratio",
    }
}
