//! The figures of a report.

use super::axis::Axis;
use super::display::{LengthUnit, percent, short};
use super::figure::{Panel, Size};
use super::summary::{CONFIDENCE, PROBABILITIES, Summary};
use super::{ReportInput, usable_peak};
use crate::ensemble::outcome::{CurvePoint, LevelOutcome, PeakRecord, SampleOutcome};
use crate::statistics::{
    Band, Curve, CurveSet, Sorted, empirical_cdf, histogram, pointwise_band, quantile,
    rank_correlation,
};

/// Grid points of a band.
const GRID: usize = 401;
/// A band is drawn where at least this share of the curves exists.
const PRESENT: f64 = 0.5;
/// Dots per level and panel; more are thinned evenly.
const MAX_DOTS: usize = 1500;
/// Inputs that get a scatter panel, those with the strongest rank correlations.
const MAX_INPUTS: usize = 6;

/// A panel with a sentence below it.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct Captioned {
    /// SVG.
    pub(super) svg: String,
    /// What the reader must know; may be empty.
    pub(super) caption: String,
}

/// Draws the figures of one report.
pub(super) struct Figures<'a> {
    input: &'a ReportInput<'a>,
    summary: &'a Summary,
    /// Unit of all displacements.
    pub(super) unit: LengthUnit,
}

/// What a panel shows of a peak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Frequency,
    AmplitudePerLevel,
}

impl<'a> Figures<'a> {
    /// Figures in the unit that suits the largest amplitude per unit level.
    pub(super) fn new(input: &'a ReportInput<'a>, summary: &'a Summary) -> Self {
        let sampled = summary.levels.iter().filter_map(|level| {
            let moments = level.amplitude_per_unit_level_m.moments?;
            Some(moments.maximum)
        });
        let linear = input.free_curve.iter().map(|p| p.amplitude_m);
        let largest = sampled.chain(linear).fold(0.0, f64::max);
        Self {
            input,
            summary,
            unit: LengthUnit::for_largest(largest),
        }
    }

    /// `10 N`.
    pub(super) fn level_name(&self, i: usize) -> String {
        format!("{} {}", short(self.input.levels[i]), self.input.level_unit)
    }

    /// `µm/N`.
    pub(super) fn amplitude_unit(&self) -> String {
        format!("{}/{}", self.unit.symbol, self.input.level_unit)
    }

    fn label(&self, quantity: Quantity) -> String {
        match quantity {
            Quantity::Frequency => "Resonance frequency (Hz)".to_owned(),
            Quantity::AmplitudePerLevel => {
                format!("Amplitude ({})", self.amplitude_unit())
            }
        }
    }

    fn value(&self, quantity: Quantity, level: f64, peak: &PeakRecord) -> f64 {
        match quantity {
            Quantity::Frequency => peak.frequency_hz,
            Quantity::AmplitudePerLevel => peak.amplitude_m / level * self.unit.per_metre,
        }
    }

    /// Samples with a solution at level `i`.
    fn peaks(&self, i: usize) -> impl Iterator<Item = (&'a SampleOutcome, PeakRecord)> {
        let outcomes = self.input.outcomes.iter();
        outcomes.filter_map(move |o| Some((o, usable_peak(&o.levels[i])?)))
    }

    fn values(&self, quantity: Quantity, i: usize) -> impl Iterator<Item = f64> {
        let level = self.input.levels[i];
        self.peaks(i)
            .map(move |(_, p)| self.value(quantity, level, &p))
    }

    fn all_values(&self, quantity: Quantity) -> impl Iterator<Item = f64> {
        (0..self.input.levels.len()).flat_map(move |i| self.values(quantity, i))
    }

    fn nominal(&self, quantity: Quantity, i: usize) -> Option<f64> {
        let peak = self.summary.levels[i].nominal?;
        Some(self.value(quantity, self.input.levels[i], &peak))
    }

    fn curve(&self, points: &[CurvePoint], level: f64) -> Vec<(f64, f64)> {
        let scale = self.unit.per_metre / level;
        let point = |p: &CurvePoint| (p.frequency_hz, p.amplitude_m * scale);
        points.iter().map(point).collect()
    }

    /// Frequencies that hold nearly all resonances, the free and the stuck one included, with room for the flanks.
    fn window(&self) -> (f64, f64) {
        let sorted = Sorted::finite(self.all_values(Quantity::Frequency));
        let nominal =
            (0..self.input.levels.len()).filter_map(|i| self.nominal(Quantity::Frequency, i));
        let linear = [self.input.free_frequency_hz, self.input.stuck_frequency_hz];
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

    fn response_axes(&self, top: f64) -> (Axis, Axis) {
        let (low, high) = self.window();
        let frequency = Axis::linear("Excitation frequency (Hz)", low, high);
        let label = self.label(Quantity::AmplitudePerLevel);
        (frequency, Axis::linear(label, 0.0, 1.06 * top))
    }

    fn add_linear_curves(&self, panel: &mut Panel) {
        panel.line("free", self.curve(self.input.free_curve, 1.0).into_iter());
        panel.line("stuck", self.curve(self.input.stuck_curve, 1.0).into_iter());
    }

    fn largest_linear_amplitude(&self) -> f64 {
        let points = self.input.free_curve.iter().chain(self.input.stuck_curve);
        points
            .map(|p| p.amplitude_m * self.unit.per_metre)
            .fold(0.0, f64::max)
    }

    /// Response at the nominal inputs, all levels in one panel.
    pub(super) fn nominal_responses(&self) -> Option<String> {
        let nominal = self.input.nominal?;
        let amplitudes =
            (0..nominal.levels.len()).filter_map(|i| self.nominal(Quantity::AmplitudePerLevel, i));
        let top = amplitudes.fold(self.largest_linear_amplitude(), f64::max);
        let (x, y) = self.response_axes(top);
        let mut panel = Panel::new(Size::Large, "Nominal forced response", x, y);
        self.add_linear_curves(&mut panel);
        for (i, record) in nominal.levels.iter().enumerate() {
            let curve = self.curve(&record.curve, record.level);
            panel.line(&format!("level l{i}"), curve.into_iter());
        }
        Some(panel.svg())
    }

    /// One panel per level: 5 %, 50 % and 95 % of the response at each frequency, with the nominal response.
    pub(super) fn bands(&self) -> Vec<Captioned> {
        let (low, high) = self.window();
        let grid: Vec<f64> = (0..GRID)
            .map(|i| low + (high - low) * i as f64 / (GRID - 1) as f64)
            .collect();
        let levels = 0..self.input.levels.len();
        let bands: Vec<(Band, usize)> = levels
            .map(|i| {
                let curves = self.curves(i);
                let set = CurveSet::of(&curves, &grid);
                let drawn = set.total() - set.failed();
                (pointwise_band(&set, &PROBABILITIES, CONFIDENCE), drawn)
            })
            .collect();
        let quantiles = bands.iter().flat_map(|(band, _)| &band.points);
        let highest = quantiles.filter_map(|p| p.quantiles.as_ref()?.last().copied());
        let top = highest.fold(self.largest_linear_amplitude(), f64::max);
        let panels = bands.iter().enumerate();
        panels
            .map(|(i, (band, n))| self.band_panel(i, band, *n, top))
            .collect()
    }

    /// Curve of each sample; absent without a solution.
    fn curves(&self, i: usize) -> Vec<Option<Curve>> {
        let solved = |o: &'a SampleOutcome| {
            let record: &LevelOutcome = &o.levels[i];
            usable_peak(record)?;
            Curve::through(self.curve(&record.curve, record.level))
        };
        self.input.outcomes.iter().map(solved).collect()
    }

    fn band_panel(&self, i: usize, band: &Band, n_curves: usize, top: f64) -> Captioned {
        let (x, y) = self.response_axes(top);
        let mut panel = Panel::new(Size::Small, self.level_name(i), x, y);
        self.add_linear_curves(&mut panel);
        let enough = |present: usize| present > 0 && present as f64 >= PRESENT * n_curves as f64;
        let mut drawn = 0;
        for run in band
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
            panel.line(
                &format!("median l{i}"),
                quantiles.iter().map(|(x, q)| (*x, q[1])),
            );
        }
        if let Some(nominal) = self.input.nominal {
            let record = &nominal.levels[i];
            panel.line(
                "nominal",
                self.curve(&record.curve, record.level).into_iter(),
            );
        }
        let inside = band.whole_curves_inside.and_then(|share| share.known);
        let caption = match inside {
            None => "No sample has a response curve.".to_owned(),
            Some(_) if drawn == 0 => "No frequency is reached by half of the curves.".to_owned(),
            Some(inside) => format!(
                "{n_curves} curves, {} of them wholly inside.",
                percent(inside.estimate)
            ),
        };
        Captioned {
            svg: panel.svg(),
            caption,
        }
    }

    /// All peaks: amplitude per force over frequency, coloured by level.
    pub(super) fn cloud(&self) -> String {
        let (frequency, amplitude) = (Quantity::Frequency, Quantity::AmplitudePerLevel);
        let x = Axis::around(self.label(frequency), self.all_values(frequency));
        let y = Axis::around(self.label(amplitude), self.all_values(amplitude)).starting_at_zero();
        let mut panel = Panel::new(Size::Large, "Resonance peaks of all samples", x, y);
        for i in 0..self.input.levels.len() {
            let points = self.values(frequency, i).zip(self.values(amplitude, i));
            panel.dots(&format!("l{i}"), thinned(points.collect()).into_iter());
        }
        for i in 0..self.input.levels.len() {
            if let (Some(x), Some(y)) = (self.nominal(frequency, i), self.nominal(amplitude, i)) {
                panel.ring(&format!("l{i}"), (x, y));
            }
        }
        self.note_if_empty(&mut panel);
        panel.svg()
    }

    fn note_if_empty(&self, panel: &mut Panel) {
        if self
            .summary
            .levels
            .iter()
            .all(|level| level.frequency_hz.valid == 0)
        {
            panel.note("no sample has a solution");
        }
    }

    /// One histogram per level: of the frequency, then of the amplitude.
    pub(super) fn histograms(&self) -> [Vec<String>; 2] {
        [Quantity::Frequency, Quantity::AmplitudePerLevel].map(|quantity| {
            let levels = 0..self.input.levels.len();
            levels.map(|i| self.histogram(quantity, i)).collect()
        })
    }

    fn histogram(&self, quantity: Quantity, i: usize) -> String {
        let sorted = Sorted::finite(self.values(quantity, i));
        let bins = histogram(&sorted, 30);
        let nominal = self.nominal(quantity, i);
        let edges = bins.iter().flat_map(|b| [b.lower, b.upper]);
        let (low, high) = edges
            .chain(nominal)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
        let highest = bins.iter().map(|b| b.count).max().unwrap_or(1);
        let x = if low <= high {
            let room = 0.04 * (high - low);
            Axis::linear(self.label(quantity), low - room, high + room)
        } else {
            Axis::linear(self.label(quantity), 0.0, 1.0)
        };
        let y = Axis::linear("Samples", 0.0, 1.08 * highest as f64);
        let mut panel = Panel::new(Size::Small, self.level_name(i), x, y);
        let bars = bins.iter().map(|b| (b.lower, b.upper, b.count as f64));
        panel.bars(&format!("l{i}"), bars);
        for p in PROBABILITIES
            .into_iter()
            .filter_map(|p| quantile(&sorted, p))
        {
            panel.rule("quantile", p);
        }
        if let Some(nominal) = nominal {
            panel.rule("nominal", nominal);
        }
        if bins.is_empty() {
            panel.note("no sample has a solution");
        }
        panel.svg()
    }

    /// Empirical distribution functions of frequency and amplitude, all levels in one panel each.
    pub(super) fn distributions(&self) -> Vec<String> {
        let both = [Quantity::Frequency, Quantity::AmplitudePerLevel];
        both.map(|quantity| {
            let x = Axis::around(self.label(quantity), self.all_values(quantity));
            let y = Axis::linear("Share of samples below", 0.0, 1.0);
            let title = match quantity {
                Quantity::Frequency => "Distribution of the resonance frequency",
                Quantity::AmplitudePerLevel => "Distribution of the amplitude",
            };
            let mut panel = Panel::new(Size::Large, title, x, y);
            for i in 0..self.input.levels.len() {
                let corners = empirical_cdf(&Sorted::finite(self.values(quantity, i)));
                // From the last corner back, so that thinned steps still end at 1.
                let kept = corners.into_iter().rev().collect();
                let corners: Vec<_> = thinned(kept).into_iter().rev().collect();
                panel.steps(&format!("level l{i}"), &corners, 0.0);
            }
            self.note_if_empty(&mut panel);
            panel.svg()
        })
        .to_vec()
    }

    /// Frequency and amplitude over each input; the inputs with the strongest rank correlations first.
    pub(super) fn input_scatter(&self) -> Vec<String> {
        let strength = |j: usize| {
            let levels = self.summary.levels.iter();
            let of_input = levels.filter_map(|l| l.rank_correlations.get(j));
            of_input
                .flat_map(|c| [c.frequency, c.amplitude])
                .flatten()
                .fold(0.0, |a: f64, b| a.max(b.abs()))
        };
        let mut order: Vec<usize> = (0..self.input.input_names.len()).collect();
        if order.len() > MAX_INPUTS {
            order.sort_by(|&a, &b| strength(b).total_cmp(&strength(a)));
            order.truncate(MAX_INPUTS);
        }
        let both = [Quantity::Frequency, Quantity::AmplitudePerLevel];
        order
            .into_iter()
            .flat_map(|j| both.map(|quantity| self.scatter(j, quantity)))
            .collect()
    }

    fn scatter(&self, j: usize, quantity: Quantity) -> String {
        let name = &self.input.input_names[j];
        let y = Axis::around(self.label(quantity), self.all_values(quantity));
        let title = match quantity {
            Quantity::Frequency => format!("Frequency over {name}"),
            Quantity::AmplitudePerLevel => format!("Amplitude over {name}"),
        };
        let mut panel = Panel::new(Size::Large, title, self.input_axis(j), y);
        for i in 0..self.input.levels.len() {
            let inputs = self.peaks(i).map(|(o, _)| o.inputs[j]);
            let points = inputs.zip(self.values(quantity, i)).collect();
            panel.dots(&format!("l{i}"), thinned(points).into_iter());
        }
        self.note_if_empty(&mut panel);
        panel.svg()
    }

    fn input_axis(&self, j: usize) -> Axis {
        let values = self.input.outcomes.iter().map(|o| o.inputs[j]);
        Axis::around(self.input.input_names[j].clone(), values)
    }

    /// Where failed samples lie, over the two inputs that separate them best; absent without failures or inputs.
    pub(super) fn failures(&self) -> Option<String> {
        let failed = |o: &SampleOutcome| o.levels.iter().any(|l| usable_peak(l).is_none());
        if !self.input.outcomes.iter().any(failed) {
            return None;
        }
        let separation = |j: usize| {
            let pairs = self.input.outcomes.iter();
            let indicator = |o: &SampleOutcome| (o.inputs[j], f64::from(u8::from(failed(o))));
            rank_correlation(&pairs.map(indicator).collect::<Vec<_>>()).map_or(0.0, f64::abs)
        };
        let mut order: Vec<usize> = (0..self.input.input_names.len()).collect();
        order.sort_by(|&a, &b| separation(b).total_cmp(&separation(a)));
        let j = *order.first()?;
        let second = order.get(1).copied();
        let y = match second {
            Some(k) => self.input_axis(k),
            None => Axis::around("Sample", self.input.outcomes.iter().map(|o| o.index as f64)),
        };
        let place =
            |o: &SampleOutcome| (o.inputs[j], second.map_or(o.index as f64, |k| o.inputs[k]));
        let mut panel = Panel::new(Size::Large, "Where samples failed", self.input_axis(j), y);
        let solved = self.input.outcomes.iter().filter(|o| !failed(o)).map(place);
        panel.dots("solved", thinned(solved.collect()).into_iter());
        for i in 0..self.input.levels.len() {
            let outcomes = self.input.outcomes.iter();
            let lost = outcomes.filter(|o| usable_peak(&o.levels[i]).is_none());
            panel.crosses(&format!("l{i}"), lost.map(place));
        }
        Some(panel.svg())
    }

    /// Histogram of the truncation errors of all solutions; absent where none was estimated.
    pub(super) fn truncation(&self) -> Option<String> {
        let levels = 0..self.input.levels.len();
        let errors = levels
            .flat_map(|i| self.peaks(i))
            .filter_map(|(_, p)| p.truncation_error);
        // Errors of 0 have no logarithm; they cannot be a cause for worry.
        let sorted = Sorted::finite(errors.map(f64::log10));
        let bins = histogram(&sorted, 40);
        let highest = bins.iter().map(|b| b.count).max()?;
        let threshold = self.input.provenance.truncation_threshold;
        let edges = bins
            .iter()
            .flat_map(|b| [b.lower, b.upper])
            .map(|e| 10f64.powf(e));
        let x = Axis::around(
            "Estimated relative truncation error",
            edges.chain(threshold),
        );
        let y = Axis::linear("Solutions, all levels", 0.0, 1.08 * highest as f64);
        let mut panel = Panel::new(Size::Large, "Harmonics left out", x, y);
        let bars = bins
            .iter()
            .map(|b| (10f64.powf(b.lower), 10f64.powf(b.upper), b.count as f64));
        panel.bars("neutral", bars);
        if let Some(threshold) = threshold {
            panel.rule("limit", threshold);
        }
        Some(panel.svg())
    }
}

fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let stride = points.len().div_ceil(MAX_DOTS).max(1);
    points.into_iter().step_by(stride).collect()
}
