//! The nominal forced response of one level in words.

use std::io::Write;

use microslip::hb::forced_response::{Gap, Largest, Stop};
use microslip::hb::{Solution, Status};
use microslip::study::{FrequencyUnit, LevelCurve};

/// Number of points, where the response could not be followed, and the largest amplitude of the first response.
pub(super) fn show(
    out: &mut dyn Write,
    curve: &LevelCurve,
    unit: FrequencyUnit,
) -> std::io::Result<()> {
    let hertz = |omega: f64| format!("{:.6} {}", unit.of_rad_s(omega), unit.name());
    let solutions = &curve.response.solutions;
    let n_solved = (solutions.iter())
        .filter(|s| s.status.has_solution())
        .count();
    write!(
        out,
        "level {}: {n_solved} of {} points solved",
        curve.level,
        solutions.len()
    )?;
    if let Some(Gap { below, above }) = curve.response.gap {
        let stop = |stop: Stop| match stop.status {
            Status::Converged => hertz(stop.omega),
            status => format!(
                "{} ({}: {})",
                hertz(stop.omega),
                status.name(),
                status.explanation()
            ),
        };
        write!(
            out,
            ", STOPPED: from below at {}, from above at {}; nothing is known between",
            stop(below),
            stop(above)
        )?;
    }
    if let Some((solution, largest)) = curve.largest() {
        let place = hertz(solution.omega);
        write!(out, "{}", in_words(solution, largest, &place))?;
    }
    writeln!(out)
}

fn in_words(solution: &Solution, largest: Largest, place: &str) -> String {
    let amplitude = format!("{:.6e}", solution.amplitude(0));
    match largest {
        Largest::Maximum => format!(", peak {amplitude} at {place}"),
        Largest::OfValues => format!(", largest amplitude {amplitude} at {place}"),
        Largest::AtEdge => format!(
            ", no peak: the amplitude is largest, {amplitude}, at the edge, {place}; the band ends before the resonance"
        ),
        Largest::OfPart => format!(
            ", largest amplitude found {amplitude} at {place}: no peak, it may be larger where nothing is known"
        ),
    }
}
