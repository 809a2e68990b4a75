//! What every section of the page needs: the samples, their statistics, and the units in which they are shown.

use crate::ensemble::outcome::{CurvePoint, PeakRecord, SampleOutcome};
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key};
use crate::page::display::{LengthUnit, hertz, level_name, per_level, significant};
use crate::page::figure::Panel;
use crate::page::style::figure_style;
use crate::report::assessment::Assessment;
use crate::report::numbers::epistemic::PointStatistics;
use crate::report::numbers::peaks::usable_peak;
use crate::report::numbers::summary::Summary;
use crate::report::run::input::ReportInput;

/// The samples of a study as the page shows them.
pub(super) struct View<'a> {
    /// Samples and record.
    pub(super) input: &'a ReportInput<'a>,
    /// Their statistics.
    pub(super) summary: &'a Summary,
    /// What they say about the requirements.
    pub(super) assessment: &'a Assessment,
    /// Unit of all displacements.
    pub(super) unit: LengthUnit,
    /// Style sheet of the figures, with the colours of the levels.
    pub(super) style: String,
}

/// What an outer and an inner band show of the outer points.
pub(super) const RANGES: [&str; 2] = [
    "from the lowest 5 % to the highest 95 % quantile of the outer points",
    "from their lowest to their highest median",
];

/// What a panel shows of a peak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    /// Resonance frequency (Hz).
    Frequency,
    /// Amplitude over excitation level, in the view's unit.
    AmplitudePerLevel,
}

impl Shown {
    /// Both.
    pub(super) const ALL: [Self; 2] = [Self::Frequency, Self::AmplitudePerLevel];

    /// In sentences and titles.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Frequency => "frequency",
            Self::AmplitudePerLevel => "amplitude",
        }
    }

    /// A value as tables and the words under the pointer show it.
    pub(super) fn in_words(self, value: f64) -> String {
        match self {
            Self::Frequency => hertz(value),
            Self::AmplitudePerLevel => significant(value),
        }
    }
}

/// The unit that suits the largest amplitude per unit level of some runs.
pub(in crate::report) fn length_unit(runs: &[ReportInput]) -> LengthUnit {
    let levels = (runs.iter()).flat_map(|run| run.outcomes.iter().flat_map(|o| &o.levels));
    let sampled = levels.filter_map(|l| Some(usable_peak(l)?.amplitude_m / l.level));
    let linear = runs
        .iter()
        .flat_map(|run| run.record.free.curve.iter().map(|p| p.amplitude_m));
    LengthUnit::for_largest(sampled.chain(linear).fold(0.0, f64::max))
}

impl<'a> View<'a> {
    /// A view in the unit that suits the amplitudes.
    pub(super) fn new(
        input: &'a ReportInput<'a>,
        summary: &'a Summary,
        assessment: &'a Assessment,
    ) -> Self {
        Self {
            input,
            summary,
            assessment,
            unit: length_unit(&[*input]),
            style: figure_style(summary.levels.len()),
        }
    }

    /// Number of excitation levels.
    pub(super) fn n_levels(&self) -> usize {
        self.input.record.levels.len()
    }

    /// `10 N`; `level 10` where the unit is a sentence.
    pub(super) fn level_name(&self, i: usize) -> String {
        let record = self.input.record;
        level_name(record.levels[i], &record.level_unit)
    }

    /// First cell of a row of level `i`.
    pub(super) fn level_cell(&self, i: usize) -> Cell {
        let level = self.input.record.levels[i];
        Cell::number(self.level_name(i), Some(level)).with_chip(i)
    }

    /// The same in a table of margins, beside which it stands how often there are several answers.
    pub(super) fn level_cell_of_margin(&self, i: usize) -> Cell {
        self.level_cell(i)
            .with_small(self.summary.levels[i].several_answers.in_words())
    }

    /// A limit of the amplitude (m), in the unit of the page; in m in the download.
    pub(super) fn limit_cell(&self, limit_m: f64) -> Cell {
        Cell::number(self.amplitude(limit_m), Some(limit_m))
    }

    /// A length (m) in the unit of the page, without its symbol.
    pub(super) fn length(&self, m: f64) -> String {
        significant(m * self.unit.per_metre)
    }

    /// An amplitude (m) in the unit of the page, with its symbol.
    pub(super) fn amplitude(&self, m: f64) -> String {
        format!("{} {}", self.length(m), self.unit.symbol)
    }

    /// One key per level.
    pub(super) fn level_keys(&self) -> Vec<Key> {
        let key = |i: usize| Key::level(i, self.level_name(i));
        (0..self.n_levels()).map(key).collect()
    }

    /// The levels, then other marks.
    pub(super) fn level_legend(&self, others: impl IntoIterator<Item = Key>) -> Block {
        Block::Legend(self.level_keys().into_iter().chain(others).collect())
    }

    /// `µm/N`; `µm per level` where the unit is a sentence.
    pub(super) fn amplitude_unit(&self) -> String {
        per_level(self.unit.symbol, &self.input.record.level_unit)
    }

    /// Axis label.
    pub(super) fn label(&self, shown: Shown) -> String {
        match shown {
            Shown::Frequency => "Resonance frequency (Hz)".to_owned(),
            Shown::AmplitudePerLevel => format!("Amplitude ({})", self.amplitude_unit()),
        }
    }

    /// A panel with its download.
    pub(super) fn figure(
        &self,
        panel: &Panel,
        file: impl Into<String>,
        caption: impl Into<String>,
    ) -> Figure {
        Figure::new(panel, &self.style, file.into(), caption.into())
    }

    /// The number of a peak that a panel shows.
    pub(super) fn value(&self, shown: Shown, level: f64, peak: &PeakRecord) -> f64 {
        match shown {
            Shown::Frequency => peak.frequency_hz,
            Shown::AmplitudePerLevel => peak.amplitude_m / level * self.unit.per_metre,
        }
    }

    /// Samples with a solution at level `i`.
    pub(super) fn peaks(&self, i: usize) -> impl Iterator<Item = (&'a SampleOutcome, PeakRecord)> {
        let outcomes = self.input.outcomes.iter();
        outcomes.filter_map(move |o| Some((o, usable_peak(&o.levels[i])?)))
    }

    /// Values of the samples with a solution at level `i`.
    pub(super) fn values(&self, shown: Shown, i: usize) -> impl Iterator<Item = f64> {
        let level = self.input.record.levels[i];
        self.peaks(i)
            .map(move |(_, p)| self.value(shown, level, &p))
    }

    /// Values of all levels.
    pub(super) fn all_values(&self, shown: Shown) -> impl Iterator<Item = f64> {
        (0..self.n_levels()).flat_map(move |i| self.values(shown, i))
    }

    /// Value at the nominal inputs.
    pub(super) fn nominal(&self, shown: Shown, i: usize) -> Option<f64> {
        let peak = self.summary.levels[i].nominal?;
        Some(self.value(shown, self.input.record.levels[i], &peak))
    }

    /// Points (Hz, amplitude per level in the view's unit).
    pub(super) fn curve(&self, points: &[CurvePoint], level: f64) -> Vec<(f64, f64)> {
        let scale = self.unit.per_metre / level;
        let point = |p: &CurvePoint| (p.frequency_hz, p.amplitude_m * scale);
        points.iter().map(point).collect()
    }

    /// Largest amplitude per level of a curve, in the view's unit; `None` without points.
    pub(super) fn largest(&self, points: &[CurvePoint], level: f64) -> Option<f64> {
        let amplitudes = self.curve(points, level).into_iter().map(|p| p.1);
        amplitudes.reduce(f64::max)
    }

    /// Axis over the values of input `j`.
    pub(super) fn input_axis(&self, j: usize) -> Axis {
        let values = self.input.outcomes.iter().map(|o| o.inputs[j]);
        Axis::around(self.input.record.inputs[j].name.clone(), values)
    }

    /// Whether the samples belong to outer points, so that all together they are no population.
    pub(super) fn nested(&self) -> bool {
        self.summary.epistemic.is_some()
    }

    /// Statistics of level `i` by outer point; empty without outer points.
    pub(super) fn points(&self, i: usize) -> &[PointStatistics] {
        let epistemic = self.summary.epistemic.as_ref();
        epistemic.map_or(&[], |e| &e.levels[i].points)
    }

    /// Of fields for all samples and fields for outer points those that the study has.
    pub(super) fn fields(&self, pair: [&'static [&'static str]; 2]) -> &'static [&'static str] {
        pair[usize::from(self.nested())]
    }

    /// What a bar from the quantile `low` to the quantile `high` shows, in words (`5 %`).
    pub(super) fn scatter_in_words(&self, low: &str, high: &str) -> String {
        match self.nested() {
            false => format!("{low} to {high} of the samples with their median"),
            true => format!(
                "from the lowest {low} to the highest {high} quantile of the outer points, with the middle of their medians"
            ),
        }
    }

    /// Whether no level has a solution.
    pub(super) fn is_empty(&self) -> bool {
        self.summary
            .levels
            .iter()
            .all(|l| l.frequency_hz.valid == 0)
    }

    /// Says in the panel that there is nothing to draw, where that is so.
    pub(super) fn note_if_empty(&self, panel: &mut Panel) {
        if self.is_empty() {
            panel.note("no sample has a solution");
        }
    }
}
