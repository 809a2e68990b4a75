//! What the samples say, level by level.

use std::io::Write;
use std::path::Path;

use super::log::{Event, Messages};
use super::terminal::print;
use microslip::Error;
use microslip::report::Summary;
use microslip::report::numbers::EpistemicSummary;
use microslip::study::{Profile, RunResult};
use microslip::units::count;
use serde_json::{Map, Value, json};

/// What the intervals of a design without independent samples are.
pub(super) const INDICATIONS: &str = "no independent samples: intervals are indications";

/// ` at outer point 3`, where there are such.
pub(super) fn at_point(outer: Option<u64>) -> String {
    outer.map_or_else(String::new, |outer| format!(" at outer point {outer}"))
}

/// Warnings and the end; unless quiet, what the samples say, and where the files are.
pub(super) fn show_result(
    result: &RunResult,
    folder: &Path,
    messages: &Messages,
) -> Result<(), Error> {
    let log = messages.log;
    log.warn(&result.notes);
    log.warn(&result.summary.backend.messages());
    log.warn(&unsolved(&result.summary));
    log.write(&Event::Finished(in_json(result, folder)));
    if messages.quiet {
        return Ok(());
    }
    print(|out| {
        show_levels(out, &result.summary)?;
        if result.taken_over > 0 {
            let were = if result.taken_over == 1 {
                "was"
            } else {
                "were"
            };
            let samples = count(result.taken_over, "sample");
            writeln!(out, "{samples} {were} solved before and taken over")?;
        }
        if let Some(reason) = &result.unfolded {
            writeln!(out, "{reason}")?;
        }
        if let Some(stopping) = &result.stored.record.stopping {
            writeln!(out, "{}", stopping.in_words())?;
        }
        writeln!(
            out,
            "samples.parquet, curves.parquet, run.json, summary.json, report.json and report.html are in {}",
            folder.display()
        )
    })
}

/// Levels at which no sample has a solution.
fn unsolved(summary: &Summary) -> Vec<String> {
    let without = |failed: usize| summary.samples > 0 && failed == summary.samples;
    let levels = summary.levels.iter().filter(|level| without(level.failed));
    let words = levels.map(|level| format!("level {}: no sample has a solution", level.level));
    words.collect()
}

/// What a program should know of a result: where it is, how many samples failed at each level, and where the time went.
fn in_json(result: &RunResult, folder: &Path) -> Value {
    let summary = &result.summary;
    let levels = summary.levels.iter();
    let levels = levels.map(|level| json!({ "level": level.level, "failed": level.failed }));
    let stages = result.profile.stages.iter();
    let stages = stages.map(|(stage, time)| (stage.name().to_owned(), time.as_secs_f64().into()));
    let times = result.profile.samples;
    json!({
        "folder": folder.display().to_string(),
        "samples": summary.samples,
        "taken_over": result.taken_over,
        "levels": levels.collect::<Value>(),
        "seconds_of_stages": stages.collect::<Map<_, _>>(),
        "thread_seconds_of_samples": {
            "peaks": times.peaks.as_secs_f64(),
            "larger harmonic sets": times.larger_sets.as_secs_f64(),
            "stability": times.stability.as_secs_f64(),
            "curves": times.curves.as_secs_f64(),
        },
        "newton_iterations": times.newton_iterations,
    })
}

/// Where the time went, stage by stage.
pub(super) fn show_profile(out: &mut dyn Write, profile: &Profile) -> std::io::Result<()> {
    writeln!(out, "wall time of this process by stage:")?;
    for (stage, time) in &profile.stages {
        writeln!(out, "  {:24} {:9.2} s", stage.name(), time.as_secs_f64())?;
    }
    let times = profile.samples;
    writeln!(out, "time of the samples, summed over the threads:")?;
    for (name, time) in [
        ("peaks", times.peaks),
        ("larger harmonic sets", times.larger_sets),
        ("stability", times.stability),
        ("curves", times.curves),
    ] {
        writeln!(out, "  {name:24} {:9.2} s", time.as_secs_f64())?;
    }
    writeln!(out, "Newton iterations: {}", times.newton_iterations)
}

/// Samples solved, and the 5, 50 and 95 % quantiles of frequency and amplitude, one line per level; then what outer
/// points and replicates say.
pub(super) fn show_levels(out: &mut dyn Write, summary: &Summary) -> std::io::Result<()> {
    for level in &summary.levels {
        let solved = summary.samples - level.failed;
        let (value, unit) = (level.level, &summary.level_unit);
        write!(
            out,
            "level {value} {unit}: {solved} of {} solved",
            count(summary.samples, "sample")
        )?;
        let quantiles = level
            .frequency_hz
            .quantiles
            .iter()
            .zip(&level.amplitude_m.quantiles);
        for (frequency, amplitude) in quantiles {
            write!(
                out,
                "; {:.0} %: {:.3} Hz, {:.4e} m",
                100.0 * frequency.probability,
                frequency.estimate,
                amplitude.estimate
            )?;
        }
        writeln!(out)?;
    }
    if let Some(epistemic) = &summary.epistemic {
        show_ranges(out, epistemic)?;
    }
    show_replicates(out, summary)
}

/// Ranges of the quantiles over the outer points, with the point of each end.
fn show_ranges(out: &mut dyn Write, epistemic: &EpistemicSummary) -> std::io::Result<()> {
    let (inputs, n) = (epistemic.inputs.join(", "), epistemic.points.len());
    writeln!(
        out,
        "lowest and highest over {n} outer points of {inputs} (these have no probability):"
    )?;
    for level in &epistemic.levels {
        let quantities: [(_, _, &dyn Fn(f64) -> String); 2] = [
            (&level.frequency_hz, "Hz", &|v| format!("{v:.3}")),
            (&level.amplitude_m, "m", &|v| format!("{v:.4e}")),
        ];
        for (ranges, unit, show) in quantities {
            for quantile in ranges {
                let ends = [quantile.range.lowest, quantile.range.highest].map(|end| {
                    let value = end.value.in_words(show);
                    format!("{value} (point {})", end.outer)
                });
                writeln!(
                    out,
                    "level {}, {:.0} %: {} .. {} {unit}",
                    level.level,
                    100.0 * quantile.probability,
                    ends[0],
                    ends[1]
                )?;
            }
        }
        for exceedance in &level.exceedances {
            let limit = exceedance.threshold_m;
            let ends = [exceedance.range.lowest, exceedance.range.highest].map(|end| {
                let value = end.value.value().unwrap_or(f64::NAN);
                format!("{value:.3} (point {})", end.outer)
            });
            writeln!(
                out,
                "level {}, P(amplitude > {limit:.4e} m): {} .. {}",
                level.level, ends[0], ends[1]
            )?;
        }
    }
    Ok(())
}

/// Means with their intervals, where there are replicates; by outer point, where the samples belong to such.
fn show_replicates(out: &mut dyn Write, summary: &Summary) -> std::io::Result<()> {
    for (i, outer, means) in summary.replicate_means() {
        let level = summary.levels[i].level;
        let point = at_point(outer);
        let (frequency, amplitude) = (means.frequency_hz, means.amplitude_m);
        let hertz = frequency.interval.in_words(" .. ", |v| format!("{v:.4}"));
        let metres = amplitude.interval.in_words(" .. ", |v| format!("{v:.4e}"));
        writeln!(
            out,
            "level {level}{point}, mean of {} replicates and its {:.0} % interval: {:.4} Hz ({hertz}), {:.4e} m ({metres}) ({} failed samples not in it)",
            frequency.replicates,
            100.0 * summary.confidence,
            frequency.mean,
            amplitude.mean,
            amplitude.failed
        )?;
    }
    Ok(())
}
