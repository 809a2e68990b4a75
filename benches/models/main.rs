//! Small random models, parameters over six decades: how many peaks are found, by which route, how the others end, and whether those
//! structures vibrate with the period of the excitation at all, by time integration.
//!
//! `cargo bench --bench models [-- seeds [first seed [harmonics [budget [time points]]]] [control] [search] [curves] [sweep]]`; with
//! `control` those with a peak are integrated, too, with `search` none; with `curves` each peak is compared with the maximum of the response
//! curve; with `sweep` nothing is searched: each model is integrated at many frequencies (`-- 1 405 sweep`).

#![allow(clippy::expect_used, reason = "a benchmark that cannot be set up ends")]

mod march;
mod random;

use microslip::hb::response::forced_response::{CurveSettings, Largest, over_band};
use microslip::hb::{NewtonSettings, PeakRoute, Status};
use random::RandomModel;
use rayon::prelude::*;

/// Which models are integrated in time.
#[derive(Clone, Copy)]
enum Integrated {
    All,
    WithoutPeak,
    None,
}

/// Relative difference of a maximum and that of a curve, which is exact to 3e-3, from which they are two.
const OTHER: f64 = 3e-3;

/// How the search for the peak of one model ended.
struct Outcome {
    status: Status,
    route: Option<PeakRoute>,
    iterations: usize,
    /// Where the structure was integrated: whether it vibrates with the period of the excitation.
    periodic: Option<bool>,
    /// Amplitude of the peak (m).
    amplitude: Option<f64>,
    /// Where the response curve was computed and has a maximum: that of the curve over the peak.
    curve: Option<f64>,
}

fn main() {
    let numbers = std::env::args().filter_map(|a| a.parse::<u64>().ok());
    let numbers: Vec<u64> = numbers.collect();
    let or = |at: usize, default: u64| numbers.get(at).copied().unwrap_or(default);
    let (seeds, first, harmonics) = (or(0, 200), or(1, 0), or(2, 5));
    let budget = or(3, NewtonSettings::default().budget as u64);
    let points = or(4, random::TIME_POINTS as u64) as usize;
    let named = |name: &str| std::env::args().any(|a| a == name);
    let integrated = match (named("control"), named("search")) {
        (true, _) => Integrated::All,
        (false, true) => Integrated::None,
        (false, false) => Integrated::WithoutPeak,
    };
    if named("sweep") {
        return (first..first + seeds).for_each(print_sweep);
    }
    let outcome = |seed: u64| {
        let model = RandomModel {
            n_time: points,
            ..RandomModel::of_seed(seed)
        };
        let outcome = outcome_of(&model, harmonics as usize, budget as usize, integrated);
        match named("curves") {
            true => compared(&model, harmonics as usize, budget as usize, outcome),
            false => outcome,
        }
    };
    let seeds: Vec<u64> = (first..first + seeds).collect();
    // one at a time, so that no thread waits with models behind another's slow one
    let seeds = seeds.into_par_iter().with_max_len(1);
    let outcomes: Vec<Outcome> = seeds.map(outcome).collect();
    print_ends(&outcomes);
    print_iterations(&outcomes);
    print_periodicity(&outcomes);
    print_curves(&outcomes);
}

/// Searches for the peak of one model. Those to be `integrated` and those without a peak are printed. Where one without a peak vibrates
/// with the period at all frequencies tried, many more are looked at, and the highest vibration decides.
fn outcome_of(
    model: &RandomModel,
    harmonics: usize,
    budget: usize,
    integrated: Integrated,
) -> Outcome {
    let found = model.peak(harmonics, budget);
    let (status, iterations) = (found.status, found.count.iterations);
    let route = found.solution.as_ref().and_then(|peak| peak.route);
    let wanted = match integrated {
        Integrated::All => true,
        Integrated::WithoutPeak => !status.has_solution(),
        Integrated::None => false,
    };
    let at_highest = || match status.has_solution() {
        true => None,
        false => march::not_periodic_at_its_highest(model),
    };
    let vibration = wanted.then(|| march::not_periodic(model).or_else(at_highest));
    if wanted || !status.has_solution() {
        let vibration = match vibration {
            Some(Some((omega, change))) => {
                format!("not periodic at {omega:.3} rad/s, change {change:.1e}")
            }
            Some(None) => "periodic".to_owned(),
            None => "not integrated".to_owned(),
        };
        let status = status.name();
        println!(
            "{status}, {iterations} iterations, {vibration}: {}",
            model.text
        );
    }
    Outcome {
        status,
        route,
        iterations,
        periodic: vibration.map(|found| found.is_none()),
        amplitude: found.solution.map(|peak| peak.amplitude(0)),
        curve: None,
    }
}

/// The same beside the response curve, where there is a peak. Those of which one is another maximum are printed.
fn compared(model: &RandomModel, harmonics: usize, budget: usize, outcome: Outcome) -> Outcome {
    let Some(amplitude) = outcome.amplitude else {
        return outcome;
    };
    let maximum = curve_maximum(model, harmonics, budget);
    let curve = maximum.map(|maximum| maximum / amplitude);
    if let Some(curve) = curve
        && (curve - 1.0).abs() > OTHER
    {
        println!("the curve has {curve:.4} times the peak: {}", model.text);
    }
    Outcome { curve, ..outcome }
}

/// The largest maximum (m) of the response curve through the band of the peak; none where the branch cannot be followed through it, or is
/// largest at an end.
fn curve_maximum(model: &RandomModel, harmonics: usize, budget: usize) -> Option<f64> {
    model.solved(harmonics, budget, |problem, settings, peak| {
        let curve = CurveSettings::for_plot(peak.band);
        let response = over_band(problem, settings, model.level, curve, |_| {});
        match response.largest(peak.band) {
            Some((solution, Largest::Maximum)) => Some(solution.amplitude(0)),
            _ => None,
        }
    })
}

/// Vibrations of one model over frequency, by time integration.
fn print_sweep(seed: u64) {
    let model = RandomModel::of_seed(seed);
    println!("{}", model.text);
    let swept = march::sweep(&model);
    for (omega, v) in &swept {
        print_vibration(*omega, v);
    }
    if let Some((omega, highest)) = march::highest(swept) {
        print!("highest:");
        print_vibration(omega, &highest);
    }
}

fn print_vibration(omega: f64, vibration: &march::Vibration) {
    let (amplitude, change) = (vibration.amplitude, vibration.change);
    println!("  {omega:.5} rad/s, {amplitude:.4e} m, change {change:.1e}");
}

/// How many searches ended with each status and found the peak by each route.
fn print_ends(outcomes: &[Outcome]) {
    for status in Status::ALL {
        let ended = outcomes.iter().filter(|o| o.status == status);
        match ended.count() {
            0 => {}
            n => println!("{:<26} {n:>5}", status.name()),
        }
    }
    for route in PeakRoute::ALL {
        let by_it = outcomes.iter().filter(|o| o.route == Some(route));
        match by_it.count() {
            0 => {}
            n => println!("found: {:<19} {n:>5}", route.name()),
        }
    }
}

fn print_iterations(outcomes: &[Outcome]) {
    let mut iterations: Vec<usize> = outcomes.iter().map(|o| o.iterations).collect();
    iterations.sort_unstable();
    let quantile = |p: f64| iterations[(p * (iterations.len() - 1) as f64) as usize];
    println!(
        "Newton iterations: median {}, 99 % {}, most {}",
        quantile(0.5),
        quantile(0.99),
        quantile(1.0)
    );
}

/// How many structures vibrate with the period of the excitation, of those that were integrated.
fn print_periodicity(outcomes: &[Outcome]) {
    for (with_peak, ended) in [(true, "with"), (false, "without")] {
        let ended_so = outcomes
            .iter()
            .filter(|o| o.status.has_solution() == with_peak);
        let integrated: Vec<bool> = ended_so.filter_map(|o| o.periodic).collect();
        let periodic = integrated.iter().filter(|periodic| **periodic).count();
        println!(
            "{ended} a peak: {} integrated in time, {periodic} of them periodic",
            integrated.len()
        );
    }
}

/// How the peaks compare with the maxima of the curves.
fn print_curves(outcomes: &[Outcome]) {
    let curves: Vec<f64> = outcomes.iter().filter_map(|o| o.curve).collect();
    if curves.is_empty() {
        return;
    }
    let higher = curves.iter().filter(|curve| **curve > 1.0 + OTHER).count();
    let lower = curves.iter().filter(|curve| **curve < 1.0 - OTHER).count();
    println!(
        "curves with a maximum: {} of {} models with a peak; {higher} higher than the peak, {lower} lower",
        curves.len(),
        outcomes.iter().filter(|o| o.amplitude.is_some()).count()
    );
}
