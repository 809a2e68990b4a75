//! `solve`: the nominal forced response at every level.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use super::INCOMPLETE;
use super::log::Event;
use super::study_arguments::StudyArguments;
use super::terminal::{Bar, print};
use microslip::Error;
use microslip::hb::response::forced_response::{Gap, Largest, Stop};
use microslip::hb::{Solution, Status};
use microslip::study::{FrequencyUnit, LevelCurve, Study, solve};
use serde_json::{Value, json};

/// Its exit code says whether all curves are whole.
pub(super) fn execute(arguments: &StudyArguments) -> Result<ExitCode, Error> {
    arguments.threads.start()?;
    let study = Study::read(&arguments.study)?;
    arguments.messages.log.warn(&study.warnings);
    let folder = arguments.output_folder(&study)?;
    let bar = Bar::new(&arguments.messages);
    let curves = solve(&study, &folder, |progress| bar.show(progress))?;
    bar.clear();
    let log = arguments.messages.log;
    let gaps = stopped(&curves, study.frequency.unit);
    log.warn(&gaps);
    let code = match gaps.is_empty() {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(INCOMPLETE),
    };
    let ended = Event::Finished(in_json(&curves, folder.path()));
    log.write(&ended);
    if arguments.messages.quiet {
        return Ok(code);
    }
    print(|out| {
        for curve in &curves {
            show(out, curve, study.frequency.unit)?;
        }
        let path = folder.path().display();
        writeln!(out, "curve.csv and solution.json are in {path}")
    })?;
    Ok(code)
}

/// Levels whose curve is not known as a whole, which is no success for those who see warnings alone.
fn stopped(curves: &[LevelCurve], unit: FrequencyUnit) -> Vec<String> {
    let of_curve = |curve: &LevelCurve| {
        let gap = curve
            .response
            .gap
            .filter(|_| n_solved(curve) < curve.response.solutions.len())?;
        Some(format!(
            "level {}: the response between {} and {} is not known",
            curve.level,
            in_unit(gap.below.omega, unit),
            in_unit(gap.above.omega, unit)
        ))
    };
    curves.iter().filter_map(of_curve).collect()
}

/// What a program should know of the curves: where they are, and how many points have a solution at each level.
fn in_json(curves: &[LevelCurve], folder: &Path) -> Value {
    let level = |curve: &LevelCurve| {
        json!({
            "level": curve.level,
            "points": curve.response.solutions.len(),
            "solved": n_solved(curve),
        })
    };
    json!({
        "folder": folder.display().to_string(),
        "levels": curves.iter().map(level).collect::<Value>(),
    })
}

fn n_solved(curve: &LevelCurve) -> usize {
    let solutions = curve.response.solutions.iter();
    solutions.filter(|s| s.status.has_solution()).count()
}

fn in_unit(omega: f64, unit: FrequencyUnit) -> String {
    format!("{:.6} {}", unit.of_rad_s(omega), unit.name())
}

/// Number of points, where the response could not be followed, and the largest amplitude of the first response.
fn show(out: &mut dyn Write, curve: &LevelCurve, unit: FrequencyUnit) -> std::io::Result<()> {
    let hertz = |omega: f64| in_unit(omega, unit);
    let solutions = &curve.response.solutions;
    let n_solved = n_solved(curve);
    write!(
        out,
        "level {}: {n_solved} of {} points solved",
        curve.level,
        solutions.len()
    )?;
    if let Some(gap) = curve.response.gap {
        let answered = !curve.response.is_curve && n_solved == solutions.len();
        write!(out, "{}", where_it_ended(gap, answered, &hertz))?;
    }
    if let Some((solution, largest)) = curve.largest() {
        let place = hertz(solution.omega);
        let is_curve = curve.response.is_curve;
        write!(out, "{}", in_words(solution, largest, is_curve, &place))?;
    }
    writeln!(out)
}

fn where_it_ended(gap: Gap, answered: bool, hertz: &impl Fn(f64) -> String) -> String {
    let stop = |stop: Stop| {
        let (status, place) = (stop.status, hertz(stop.omega));
        format!("{place} ({}: {})", status.name(), status.explanation())
    };
    let Gap { below, above } = gap;
    match (below.status, above.status) {
        (_, Status::Converged) => format!(
            ", the upward sweep ended at {}; the values above are those of a downward sweep",
            stop(below)
        ),
        (Status::Converged, _) => format!(
            ", the downward sweep ended at {}; the values below are those of an upward sweep",
            stop(above)
        ),
        _ if answered => format!(
            ", no sweep passes from {} to {}; the values between are solved one by one, each from its neighbour",
            stop(below),
            stop(above)
        ),
        _ => format!(
            ", STOPPED: from below at {}, from above at {}; the branch between is not known",
            stop(below),
            stop(above)
        ),
    }
}

/// Why a solution is not to be trusted as it stands; empty if it is.
fn reservation(solution: &Solution) -> String {
    let highest = solution.harmonics.highest();
    match (solution.status, solution.truncation_error) {
        (Status::Converged, _) => String::new(),
        (Status::TruncationAboveThreshold, Some(error)) => format!(
            " (not certified: the harmonics above {highest} are estimated to change it by {:.2} %)",
            100.0 * error
        ),
        (Status::TruncationAboveThreshold, None) => {
            format!(" (not certified: what the harmonics above {highest} change is not known)")
        }
        (status, _) => format!(" ({}: {})", status.name(), status.explanation()),
    }
}

fn in_words(solution: &Solution, largest: Largest, is_curve: bool, place: &str) -> String {
    let amplitude = format!("{:.6e}", solution.amplitude(0));
    let place = &format!("{place}{}", reservation(solution));
    match largest {
        Largest::Maximum => format!(", peak {amplitude} at {place}"),
        Largest::OfValues => format!(", largest amplitude {amplitude} at {place}"),
        Largest::AtEdge if !is_curve => format!(
            ", largest amplitude {amplitude} at {place}, an end of the values: no peak, it may grow on beyond"
        ),
        Largest::AtEdge => format!(
            ", no peak: the amplitude is largest, {amplitude}, at the edge, {place}; the resonance lies outside the band"
        ),
        Largest::OfPart => format!(
            ", largest amplitude found {amplitude} at {place}: no peak, it may be larger on the part not found"
        ),
    }
}
