//! What each approximation can change; the ignorance of the inputs is not among them.

use super::distribution::Distribution;
use super::peak_error::{half_power_ratio, harmonics_shift, place_error};
use super::peaks::usable_peak;
use super::summary::{LevelSummary, Summary};
use super::surrogate::{LevelSurrogates, SurrogateResult};
use crate::contact::{Events, FrictionLaw};
use crate::ensemble::store::Provenance;
use crate::page::display::{level_name, signed, significant};
use crate::report::run::input::ReportInput;
use crate::report::run::record::{FinerGridRecord, RunRecord};
use crate::statistics::{Sorted, quantile};
use serde::Serialize;

/// One source of error, at its worst over levels and outer points; a number that nobody estimated is absent, never 0.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct ErrorLine {
    /// What is approximated.
    pub source: &'static str,
    /// Change of the resonance frequency (Hz); absent = not estimated.
    pub frequency_hz: Option<f64>,
    /// Change of the amplitude, relative; absent = not estimated.
    pub amplitude_relative: Option<f64>,
    /// How it is known.
    pub basis: String,
}

const SAMPLING: &str = "Number of samples";
const HARMONICS: &str = "Harmonics left out";
const PLACE: &str = "Place of the peak";
const PRECISION: &str = "Precision of the numbers";
const SURROGATE: &str = "Surrogate";
/// Amplitude: at its worst level in the budget, and level by level in verdicts.
pub(in crate::report) const CONTACT_GRID: &str = "Contact grid";

/// Lines that are no error of a solved sample: verdicts know the number of samples by their confidence, and use no surrogate.
pub(in crate::report) const NO_NUMERICAL_ERROR: [&str; 2] = [SAMPLING, SURROGATE];
/// Lines that verdicts take from each peak instead of at their worst.
pub(in crate::report) const OF_EACH_PEAK: [&str; 3] = [HARMONICS, PLACE, PRECISION];

/// The lines of the budget; the surrogates are those of the levels, empty where the study wants none.
pub(in crate::report) fn error_budget(
    input: &ReportInput,
    summary: &Summary,
    surrogates: &[&LevelSurrogates],
) -> Vec<ErrorLine> {
    let record = input.record;
    vec![
        sampling(summary),
        harmonics(input, summary),
        time_points(record),
        place_of_peak(record, summary),
        precision(record, summary),
        reduction(record),
        contact_grid(record, summary),
        surrogate(summary, surrogates),
    ]
}

fn surrogate(summary: &Summary, wanted: &[&LevelSurrogates]) -> ErrorLine {
    let source = SURROGATE;
    if wanted.is_empty() {
        return ErrorLine {
            source,
            frequency_hz: Some(0.0),
            amplitude_relative: Some(0.0),
            basis: "none is used: the balance equations are solved for every sample".to_owned(),
        };
    }
    // one level without is unknown
    let rms = |result: &SurrogateResult| Some(result.surrogate()?.held_out.rms);
    let worst = |errors: Vec<Option<f64>>| {
        let errors: Option<Vec<f64>> = errors.into_iter().collect();
        errors?.into_iter().reduce(f64::max)
    };
    let frequency_hz = worst(wanted.iter().map(|s| rms(&s.frequency)).collect());
    let relative = |(s, level): (&&LevelSurrogates, &LevelSummary)| {
        Some(rms(&s.amplitude)? / level.amplitude_m.moments?.mean)
    };
    let amplitudes = wanted.iter().zip(&summary.levels).map(relative);
    let amplitude_relative = worst(amplitudes.collect());
    ErrorLine {
        source,
        frequency_hz,
        amplitude_relative,
        basis: match frequency_hz.is_some() && amplitude_relative.is_some() {
            true => {
                "root mean square difference from the solver at samples that were held out, of the mean amplitude; in \
                 numbers labelled surrogate alone"
            }
            false => "not available at every level: the section on the surrogate says why",
        }
        .to_owned(),
    }
}

/// The largest number there is; absent if there is none.
fn largest(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values = values.flatten().filter(|v| v.is_finite());
    values.reduce(f64::max)
}

/// Frequency (Hz) and amplitude (m) of every population: the samples of a level, or of each outer point there.
fn populations(summary: &Summary) -> Vec<[&Distribution; 2]> {
    let levels = summary.levels.iter();
    match &summary.epistemic {
        None => levels.map(|l| [&l.frequency_hz, &l.amplitude_m]).collect(),
        Some(epistemic) => {
            let points = epistemic.levels.iter().flat_map(|l| &l.points);
            points.map(|p| [&p.frequency_hz, &p.amplitude_m]).collect()
        }
    }
}

/// Half the confidence interval of the 95 % quantile; absent where a side is open.
fn half_width(distribution: &Distribution) -> Option<f64> {
    let interval = distribution.quantiles.last()?.interval;
    Some(0.5 * (interval.upper.value()? - interval.lower.value()?))
}

fn sampling(summary: &Summary) -> ErrorLine {
    let relative = |amplitude: &Distribution| {
        Some(half_width(amplitude)? / amplitude.quantiles.last()?.estimate)
    };
    let populations = populations(summary);
    let frequency_hz = largest(
        populations
            .iter()
            .map(|[frequency, _]| half_width(frequency)),
    );
    let amplitude_relative = largest(populations.iter().map(|[_, amplitude]| relative(amplitude)));
    let half = "half the 95 % confidence interval of the 95 % quantile; shrinks with the root of the number of samples";
    ErrorLine {
        source: SAMPLING,
        frequency_hz,
        amplitude_relative,
        basis: match frequency_hz.is_some() && amplitude_relative.is_some() {
            true => half,
            false => "too few samples bound the 95 % quantile on both sides",
        }
        .to_owned(),
    }
}

fn harmonics(input: &ReportInput, summary: &Summary) -> ErrorLine {
    let q95 = |l: &LevelSummary| Some(l.truncation_error.quantiles.last()?.estimate);
    let damping_ratio = half_power_ratio(&input.record.free);
    let shift = |i: usize| {
        let peaks = (input.outcomes.iter()).filter_map(|o| usable_peak(&o.levels[i]));
        let hz = peaks.filter_map(|p| Some(p.frequency_hz * harmonics_shift(damping_ratio, &p)?));
        quantile(&Sorted::finite(hz), 0.95)
    };
    ErrorLine {
        source: HARMONICS,
        frequency_hz: largest((0..summary.levels.len()).map(shift)),
        amplitude_relative: largest(summary.levels.iter().map(q95)),
        basis: match &input.record.provenance {
            of if of.truncation_threshold.is_some() => format!(
                "95 % quantile of the error that the alert states: {}; frequency: the same share of the half-power half-width",
                stated_truncation_error(of)
            ),
            _ => "the error alert is off".to_owned(),
        },
    }
}

/// What the alert states as the error by the harmonics left out.
pub(in crate::report) fn stated_truncation_error(of: &Provenance) -> String {
    let twice = "twice the change of the amplitude with twice the harmonics".to_owned();
    match of.compared_with {
        Some(fewest) => format!("{twice}, or more by the change with {fewest}"),
        None => twice,
    }
}

fn time_points(record: &RunRecord) -> ErrorLine {
    let provenance = &record.provenance;
    let exact = provenance.events == Events::Located && provenance.law == FrictionLaw::Box;
    let zero = exact.then_some(0.0);
    ErrorLine {
        source: "Time points per period",
        frequency_hz: zero,
        amplitude_relative: zero,
        basis: match exact {
            true => "events are located to rounding and the forces between them integrated in closed form",
            false => "not located to rounding or not integrated in closed form; compare a run with more time_points",
        }
        .to_owned(),
    }
}

fn place_of_peak(record: &RunRecord, summary: &Summary) -> ErrorLine {
    let highest = |[frequency, _]: [&Distribution; 2]| Some(frequency.moments?.maximum);
    let frequency = largest(populations(summary).into_iter().map(highest));
    ErrorLine {
        source: PLACE,
        frequency_hz: frequency.map(|f| f * place_error(record)),
        amplitude_relative: Some(0.0),
        basis: "as far apart as searches from other starts stop; the amplitude is stationary there"
            .to_owned(),
    }
}

fn precision(record: &RunRecord, summary: &Summary) -> ErrorLine {
    ErrorLine {
        source: PRECISION,
        frequency_hz: None,
        amplitude_relative: largest(summary.levels.iter().map(|l| l.worst_work_balance)),
        basis: format!(
            "{}; largest |input − viscous − frictional work| over the input work",
            record.backend.description()
        ),
    }
}

fn contact_grid(record: &RunRecord, summary: &Summary) -> ErrorLine {
    // the error is a share of the shift by contacts, which is largest at the highest frequency
    let highest = |[frequency, _]: [&Distribution; 2]| Some(frequency.moments?.maximum);
    let highest = largest(populations(summary).into_iter().map(highest));
    let free = record.free.frequency_hz;
    let shift = highest.zip(free).map(|(highest, free)| highest - free);
    let shift = shift.filter(|shift| *shift > 0.0);
    let grid = record.contact_grid.as_ref();
    let of_shift = grid.zip(shift).map(|(grid, shift)| grid.relative * shift);
    let finer = record.finer_grid.as_ref();
    let of_peaks = finer.and_then(|finer| largest_change(&finer.shift_change_hz));
    let amplitude = finer.and_then(|finer| largest_change(&finer.amplitude_change));
    let linear = grid.map(|grid| {
        format!(
            "shift of neck bending by stuck contacts at nominal stiffness: {} Hz on {} x {} nodes, {} Hz extrapolated with \
             a grid twice as fine (order 1.5); this share of the largest shift of a sample",
            significant(grid.shift_hz),
            grid.contact_nodes[0],
            grid.contact_nodes[1],
            significant(grid.limit_hz),
        )
    });
    let peaks = finer.map(|finer| finer_peaks(finer, record));
    let known: Vec<String> = linear.into_iter().chain(peaks).collect();
    ErrorLine {
        source: CONTACT_GRID,
        frequency_hz: largest([of_shift, of_peaks].into_iter()),
        amplitude_relative: amplitude,
        basis: match (record.components.is_empty(), known.is_empty()) {
            (true, _) => "the contact pairs are the user's".to_owned(),
            (false, true) => "compare a run with more contact_nodes".to_owned(),
            (false, false) => known.join(". "),
        },
    }
}

/// The largest change without its sign; absent if one is.
fn largest_change(of_levels: &[Option<f64>]) -> Option<f64> {
    let known: Option<Vec<f64>> = of_levels.iter().copied().collect();
    largest(known?.into_iter().map(|change| Some(change.abs())))
}

/// What the finer contact grid changes at each level, in words.
fn finer_peaks(finer: &FinerGridRecord, record: &RunRecord) -> String {
    let peaks = finer.shift_change_hz.iter().zip(&finer.amplitude_change);
    let changes = peaks.zip(&record.levels).map(|(of, level)| {
        let level = level_name(*level, &record.level_unit);
        match of {
            (Some(shift), Some(amplitude)) => format!(
                "{} Hz and {} % at {level}",
                signed(&format!("{shift:+.2}")),
                signed(&format!("{:+.1}", 100.0 * amplitude))
            ),
            _ => format!("not known at {level}"),
        }
    });
    format!(
        "Nominal peaks on {} x {} nodes against the grid of the study, on its first harmonics: frequency over the free one and amplitude {}",
        finer.contact_nodes[0],
        finer.contact_nodes[1],
        changes.collect::<Vec<_>>().join(", ")
    )
}

fn reduction(record: &RunRecord) -> ErrorLine {
    let components = record.components.iter().map(|c| {
        let next = match c.first_left_out_hz {
            Some(f) => format!("the first one left out is at {f:.0} Hz"),
            None => "none is left out".to_owned(),
        };
        format!("{}: {} modes, {next}", c.name, c.modes)
    });
    let components: Vec<String> = components.collect();
    ErrorLine {
        source: "Reduction of the model",
        frequency_hz: None,
        amplitude_relative: None,
        basis: match components.is_empty() {
            true => "the matrices are the user's".to_owned(),
            false => format!(
                "{}; compare a run with higher cut-offs",
                components.join("; ")
            ),
        },
    }
}
