//! Scatter of the response curves, level by level: pointwise quantiles and bands of whole curves.
//!
//! Where the resonances of a level scatter over many widths of a peak, quantiles at a frequency say nothing of the curves;
//! the curves then stand over the frequency divided by that of their own peak.

use super::response_frame::{
    FREQUENCY, add_linear_curves, amplitude_axis, largest_linear_amplitude, unstable, window,
};
use crate::ensemble::outcome::{LevelOutcome, SampleOutcome};
use crate::page::axis::Axis;
use crate::page::block::Figure;
use crate::page::display::{count, percent, significant};
use crate::page::figure::{Panel, Size};
use crate::report::asked::bands::Bands;
use crate::report::convention::{CONTENT, PROBABILITIES};
use crate::report::numbers::outer_points::outer_groups;
use crate::report::numbers::peaks::usable_peak;
use crate::report::numbers::population::Populations;
use crate::report::page::view::{Shown, View};
use crate::report::run::record::RunRecord;
use crate::statistics::{
    Band, Curve, CurveSet, Envelope, EnvelopeRefusal, MissingPoints, Sorted, depth_band, hull,
    pointwise_band, quantile, simultaneous_band,
};

/// Grid points of a band.
const GRID: usize = 401;
/// Places of the pointer in a panel.
const PLACES: usize = 40;
/// A band is drawn where at least this share of the curves exists.
const PRESENT: f64 = 0.5;
/// Resonances that scatter over more than this many half-power widths of a peak are no band over the frequency.
const MOST_WIDTHS: f64 = 3.0;
/// Half-power widths that an aligned panel shows on either side of the peak.
const SHOWN_WIDTHS: f64 = 6.0;

/// What the bands of a level stand over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Abscissa {
    /// Frequency (Hz).
    Frequency,
    /// Frequency over that of the curve's own peak.
    OverResonance,
}

/// Abscissas of a panel.
#[derive(Debug, Clone, Copy)]
struct Window {
    abscissa: Abscissa,
    low: f64,
    high: f64,
}

impl Window {
    /// Of level `i`: as the study asks, but over each curve's own resonance where the resonances scatter too far.
    fn of(view: &View, i: usize) -> Self {
        let width = half_power_width(view, i);
        let (low, high) = window(view);
        let far = Populations::of(view.input, i, |p| p.frequency_hz)
            .scatter([0.05, 0.95])
            .zip(width)
            .is_some_and(|([low, _, high], width)| high - low > MOST_WIDTHS * width);
        let asked = view.input.record.bands == Bands::PeakAligned;
        if !(asked || far) {
            return Self {
                abscissa: Abscissa::Frequency,
                low,
                high,
            };
        }
        let whole = 0.5 * (high - low) / (high + low);
        let half = width.map_or(whole, |w| {
            whole.min(SHOWN_WIDTHS * w / (0.5 * (high + low)))
        });
        Self {
            abscissa: Abscissa::OverResonance,
            low: 1.0 - half,
            high: 1.0 + half,
        }
    }

    /// What the frequencies of a curve with the given resonance (Hz) are divided by.
    fn unit(self, resonance_hz: f64) -> f64 {
        match self.abscissa {
            Abscissa::Frequency => 1.0,
            Abscissa::OverResonance => resonance_hz,
        }
    }

    fn label(self) -> &'static str {
        match self.abscissa {
            Abscissa::Frequency => FREQUENCY,
            Abscissa::OverResonance => "Frequency over resonance frequency",
        }
    }

    fn grid(self) -> Vec<f64> {
        let step = (self.high - self.low) / (GRID - 1) as f64;
        (0..GRID).map(|k| self.low + step * k as f64).collect()
    }
}

/// Median width (Hz) of the curves of level `i` where the power is half of that of the peak; `None` without curves.
fn half_power_width(view: &View, i: usize) -> Option<f64> {
    let outcomes = view.input.outcomes.iter();
    let curves = outcomes.map(|o| view.curve(o.levels[i].around.curve(), o.levels[i].level));
    let widths = curves.filter_map(|points| width_of(&points));
    quantile(&Sorted::finite(widths), 0.5)
}

/// Distance of the points around the highest one where the amplitude is 1/√2 of it, by linear interpolation.
fn width_of(points: &[(f64, f64)]) -> Option<f64> {
    let top = (0..points.len()).max_by(|&a, &b| points[a].1.total_cmp(&points[b].1))?;
    let half = points[top].1 * std::f64::consts::FRAC_1_SQRT_2;
    let crossing = |a: (f64, f64), b: (f64, f64)| a.0 + (half - a.1) / (b.1 - a.1) * (b.0 - a.0);
    let falls = |pair: &&[(f64, f64)]| (pair[0].1 < half) != (pair[1].1 < half);
    let left = points[..=top].windows(2).rev().find(falls)?;
    let right = points[top..].windows(2).find(falls)?;
    Some(crossing(right[0], right[1]) - crossing(left[0], left[1]))
}

/// What the bands are, in words; `whole`: a panel has one of whole curves.
fn meaning(view: &View, whole: bool) -> String {
    let shape = match view.input.record.bands {
        Bands::Simultaneous | Bands::PeakAligned => "is stretched from the pointwise one",
        Bands::Depth => "is spanned by the deepest curves of one half of the samples",
    };
    let aligned = (0..view.n_levels())
        .filter(|&i| Window::of(view, i).abscissa == Abscissa::OverResonance)
        .map(|i| view.level_name(i))
        .collect::<Vec<_>>()
        .join(", ");
    let abscissa = match aligned.is_empty() {
        true => String::new(),
        false => format!(
            "At {aligned} each curve stands over its frequency divided by that of its own peak: what scatters there is its \
             shape, not its place. "
        ),
    };
    if view.nested() {
        let dashed = match whole {
            true => format!(
                " The dashed band holds the band of whole curves of each outer point, which {shape} and calibrated on the other \
                 half of its samples."
            ),
            false => String::new(),
        };
        return format!(
            "{abscissa}Quantiles and medians at each frequency are those of each outer point, and the filled bands run from \
             the lowest to the highest of them.{dashed} All are drawn where at least half of the curves of \
             every outer point exist. Whichever outer point is true, its own bands lie inside. For the peak itself use the \
             ranges."
        );
    }
    let dashed = match whole {
        true => format!(
            " The dashed band {shape} and calibrated on the other half of the samples to hold the stated share of whole curves. \
             Both are drawn where at least half of the curves exist."
        ),
        false => " It is drawn where at least half of the curves exist.".to_owned(),
    };
    format!(
        "{abscissa}The filled band is pointwise: at each frequency 90 % of the curves lie inside, but fewer curves stay \
         inside everywhere.{dashed} For the peak itself use the envelopes."
    )
}

/// The scatter of the response as the page shows it.
pub(super) struct Scatter {
    /// One panel per level.
    pub figures: Vec<Figure>,
    /// What the bands are, in words.
    pub meaning: String,
    /// Whether a panel has a band of whole curves.
    pub whole: bool,
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

/// Everything that the panel of a level shows.
struct LevelBands {
    window: Window,
    populations: Vec<CurveBands>,
    strips: Vec<Option<Strip>>,
}

impl LevelBands {
    /// Of level `i`, with the samples of each population.
    fn of(view: &View, i: usize, groups: &[(Option<u64>, Vec<usize>)]) -> Self {
        let window = Window::of(view, i);
        let grid = window.grid();
        let bands = |(outer, members): &(Option<u64>, Vec<usize>)| {
            let set = CurveSet::of(&curves(view, i, members, window), &grid);
            CurveBands::of(*outer, &set, view.input.record)
        };
        let populations: Vec<CurveBands> = groups.iter().map(bands).collect();
        let strips = (0..GRID).map(|k| Strip::of(&populations, k)).collect();
        Self {
            window,
            populations,
            strips,
        }
    }
}

/// One panel per level: 5 %, 50 % and 95 % of the response at each frequency, the band of whole curves, and the nominal
/// response.
pub(super) fn scatter(view: &View) -> Scatter {
    let groups = outer_groups(view.input.outcomes);
    let levels = 0..view.n_levels();
    let levels: Vec<LevelBands> = levels.map(|i| LevelBands::of(view, i, &groups)).collect();
    let strips = || levels.iter().flat_map(|level| &level.strips).flatten();
    let top = strips().fold(largest_linear_amplitude(view), |top, strip| {
        let whole = strip.whole.map_or(0.0, |ends| ends[1]);
        top.max(strip.outer[1]).max(whole)
    });
    let whole = strips().any(|strip| strip.whole.is_some());
    let panels = levels.iter().enumerate();
    Scatter {
        figures: panels
            .map(|(i, level)| band_panel(view, i, level, top))
            .collect(),
        meaning: meaning(view, whole),
        whole,
    }
}

impl CurveBands {
    fn of(outer: Option<u64>, set: &CurveSet, record: &RunRecord) -> Self {
        let confidence = record.confidence();
        let whole_band = match record.bands {
            Bands::Simultaneous | Bands::PeakAligned => simultaneous_band,
            Bands::Depth => depth_band,
        };
        Self {
            outer,
            pointwise: pointwise_band(set, &PROBABILITIES, confidence),
            whole: whole_band(set, CONTENT, confidence, MissingPoints::NotJudged),
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
fn curves(view: &View, i: usize, samples: &[usize], window: Window) -> Vec<Option<Curve>> {
    let solved = |o: &SampleOutcome| {
        let record: &LevelOutcome = &o.levels[i];
        let resonance_hz = usable_peak(record)?.frequency_hz;
        let curve = Curve::through(view.curve(record.around.curve(), record.level))?;
        curve.aligned(window.unit(resonance_hz))
    };
    let asked = |o: &&SampleOutcome| o.index < view.input.record.curve_samples;
    let samples = samples.iter().map(|&s| &view.input.outcomes[s]);
    samples.filter(asked).map(solved).collect()
}

fn band_panel(view: &View, i: usize, level: &LevelBands, top: f64) -> Figure {
    let LevelBands {
        window,
        populations,
        strips,
    } = level;
    let x = Axis::linear(window.label(), window.low, window.high);
    let y = amplitude_axis(view, top);
    let mut panel = Panel::new(Size::Small, view.level_name(i), x, y);
    add_linear_curves(view, &mut panel, |resonance| match window.abscissa {
        Abscissa::Frequency => Some(1.0),
        Abscissa::OverResonance => resonance,
    });
    draw_strips(&mut panel, i, strips, view.nested());
    let nominal = view.input.record.nominal.as_ref();
    if let (Some(nominal), Some(resonance)) = (nominal, view.nominal(Shown::Frequency, i)) {
        let record = &nominal.levels[i];
        let unit = window.unit(resonance);
        let curve = view.curve(record.around.curve(), record.level).into_iter();
        panel.line("nominal", curve.map(|(f, a)| (f / unit, a)));
        panel.crosses("plain", unstable(view, i).map(|(f, a)| (f / unit, a)));
    }
    add_readouts(view, &mut panel, *window, strips);
    let drawn = strips.iter().any(Option::is_some);
    let caption = match populations.as_slice() {
        [all] if !view.nested() => caption(all, drawn),
        points => caption_of_points(points, drawn),
    };
    view.figure(&panel, format!("band-{i}"), caption)
}

/// The numbers of the bands, under the pointer.
fn add_readouts(view: &View, panel: &mut Panel, window: Window, strips: &[Option<Strip>]) {
    let stride = GRID / PLACES;
    let half_width = 0.5 * stride as f64 * (window.high - window.low) / (GRID - 1) as f64;
    for strip in strips.iter().skip(stride / 2).step_by(stride).flatten() {
        let place = match window.abscissa {
            Abscissa::Frequency => format!("{:.2} Hz", strip.x),
            Abscissa::OverResonance => format!("{:.5} × resonance", strip.x),
        };
        let [low, high] = strip.outer.map(significant);
        let words = [
            place,
            format!("{low} … {high} {}", view.amplitude_unit()),
            format!("median {}", strip.medians.map(significant)[1]),
        ];
        panel.readout_between([strip.x - half_width, strip.x + half_width], &words);
    }
}

/// How many curves of all samples there are, and what their bands hold.
fn caption(bands: &CurveBands, drawn: bool) -> String {
    let inside = bands.pointwise.whole_curves_inside.and_then(|s| s.known);
    let pointwise = match inside {
        None => "No sample has a response curve.".to_owned(),
        Some(_) if !drawn => "No frequency is reached by half of the curves.".to_owned(),
        Some(inside) if bands.curves == 1 => match inside.estimate == 1.0 {
            true => "1 curve, wholly inside the pointwise band.".to_owned(),
            false => "1 curve, not wholly inside the pointwise band.".to_owned(),
        },
        Some(inside) => format!(
            "{}, {} of them wholly inside the pointwise band.",
            count(bands.curves, "curve"),
            percent(inside.estimate)
        ),
    };
    let whole = match &bands.whole {
        Ok(band) => format!(
            " Dashed: holds {} of whole curves where they exist; {} shaped it, {} set its width.",
            percent(band.expected_coverage),
            count(band.shaped_by, "curve"),
            count(band.calibration.total(), "sample")
        ),
        Err(_) if bands.curves == 0 => String::new(),
        Err(refusal) => {
            let number = refusal.enough(CONTENT);
            let samples = number.map_or_else(String::new, |n| {
                format!(
                    " (`curve_samples = {}`, of as many `samples` or more)",
                    2 * n
                )
            });
            format!(" No band of whole curves: {}{samples}.", in_words(refusal))
        }
    };
    pointwise + &whole
}

/// Why there is no band of whole curves, and what would suffice.
fn in_words(refusal: &EnvelopeRefusal) -> String {
    let (
        Some(enough),
        EnvelopeRefusal::NotEnclosed {
            inside,
            calibrating,
            ..
        },
    ) = (refusal.enough(CONTENT), refusal)
    else {
        return refusal.to_string();
    };
    format!(
        "{inside} of {} can be enclosed, too few for {} of whole curves; {enough} suffice if all further ones can be enclosed",
        count(*calibrating, "calibrating sample"),
        percent(CONTENT)
    )
}

/// The same over outer points.
fn caption_of_points(points: &[CurveBands], drawn: bool) -> String {
    let curves: usize = points.iter().map(|p| p.curves).sum();
    if let Some(CurveBands { outer, .. }) = points.iter().find(|p| p.curves == 0) {
        let outer = outer.unwrap_or_default();
        return format!("No sample of outer point {outer} has a response curve.");
    }
    let pointwise = match drawn {
        true => format!(
            "{} of {}.",
            count(curves, "curve"),
            count(points.len(), "outer point")
        ),
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
            let reason = in_words(&refusal);
            format!(" No band of whole curves: at outer point {outer} {reason}.")
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
