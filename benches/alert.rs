//! What the errors stated by the alert are worth, and what certified peaks cost: `cargo bench --bench alert -- [samples
//! [compared_with]]`.
//!
//! The default study's peaks at 5 to 100 N. Every solution in which contacts separate is searched again with twice its
//! harmonics, and with four times and 80 at least, by its own search of the maximum; the change of the amplitude is the true error.

#![expect(clippy::expect_used, reason = "a benchmark without its state fails")]

use microslip::contact::ContactParameters;
use microslip::ensemble::Ensemble;
use microslip::ensemble::atlas::{AnchorPeak, ModePeaks};
use microslip::ensemble::outcome::LevelOutcome;
use microslip::harmonics::HarmonicSet;
use microslip::hb::equations::balance::balance_on;
use microslip::hb::peak::predicted::maximum_near;
use microslip::hb::{Problem, Status};
use microslip::study::Study;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

const LEVELS: [f64; 4] = [5.0, 20.0, 50.0, 100.0];
/// With four levels, more than 200 solutions with separation.
const SAMPLES: u64 = 60;
/// The truths that a solution is compared with.
const TRUTHS: [&str; 2] = [
    "twice the harmonics",
    "four times the harmonics, 80 at least",
];

/// A stated error and the true ones, where they were found.
struct Compared {
    level: f64,
    certified: bool,
    stated: Option<f64>,
    truths: [Option<f64>; 2],
}

fn main() {
    let mut asked = std::env::args().skip(1).filter_map(|a| a.parse().ok());
    let samples: u64 = asked.next().unwrap_or(SAMPLES);
    let path = Path::new("studies/two-blade-strip/study.toml");
    let mut study = Study::read(path).expect("the default study");
    study.levels = LEVELS.to_vec();
    study.output.curve_samples = 0;
    let alert = study.solver.alert.as_mut().expect("an alert");
    if let Some(compared_with) = asked.next() {
        alert.compared_with = compared_with as usize;
    }
    let alert = *alert;
    let prepared = study.prepared().expect("the default rig");
    let ensemble = prepared.ensemble(None);
    println!("{alert:?}");
    let clock = Instant::now();
    let solved = ensemble.solved(samples, || {});
    println!(
        "{samples} samples x {} levels in {:.0} s",
        LEVELS.len(),
        clock.elapsed().as_secs_f64()
    );
    for (i, level) in LEVELS.iter().enumerate() {
        let mut fates: BTreeMap<(&str, u32), usize> = BTreeMap::new();
        for outcome in &solved.outcomes {
            let found = &outcome.levels[i];
            let highest = found.peak.map_or(0, |p| p.highest_harmonic);
            *fates.entry((found.status.name(), highest)).or_default() += 1;
        }
        println!("{level} N: {fates:?}");
    }
    let samples = solved.outcomes.par_iter().zip(&solved.anchors);
    let compared: Vec<Compared> = samples
        .flat_map_iter(|(outcome, anchor)| {
            let problem = problem(&ensemble, &outcome.inputs);
            let peaks = outcome.levels.iter().zip(&anchor.peaks);
            let compare = |(level, peaks): (&LevelOutcome, &ModePeaks)| {
                compared(&ensemble, &problem, level, peaks.iter().next()?)
            };
            peaks.filter_map(compare).collect::<Vec<_>>()
        })
        .collect();
    for (i, truth) in TRUTHS.iter().enumerate() {
        print_honesty(&compared, i, truth, alert.threshold);
    }
}

/// The default study's inputs: stiffness scale and friction coefficient.
fn problem<'a>(ensemble: &Ensemble<'a>, inputs: &[f64]) -> Problem<'a> {
    let sampled = |c: &ContactParameters<f64>| ContactParameters {
        k_n: c.k_n * inputs[0],
        k_t: c.k_t.map(|k| k * inputs[0]),
        mu: inputs[1],
        ..*c
    };
    let contacts = ensemble.contacts.iter().map(sampled).collect();
    Problem::new(ensemble.linear, contacts, 1.0, ensemble.settings.anchor).expect("held")
}

/// `None` for a solution without separation, or that is not to be trusted anyway.
fn compared(
    ensemble: &Ensemble<'_>,
    problem: &Problem<'_>,
    level: &LevelOutcome,
    peak: &AnchorPeak,
) -> Option<Compared> {
    let record = level.peak?;
    let trusted = level.status != Status::BouncingContact;
    let highest = record.highest_harmonic as usize;
    (trusted && record.separated_fraction > 0.0).then(|| Compared {
        level: level.level,
        certified: level.status == Status::Converged,
        stated: record.truncation_error.get(),
        truths: [2 * highest, (4 * highest).max(80)]
            .map(|truth| true_error(ensemble, problem, peak, truth)),
    })
}

/// Relative change of the amplitude at the maximum with `highest` harmonics.
fn true_error(
    ensemble: &Ensemble<'_>,
    problem: &Problem<'_>,
    peak: &AnchorPeak,
    highest: usize,
) -> Option<f64> {
    let settings = ensemble.settings;
    let balance = balance_on(problem, HarmonicSet::up_to(highest), settings);
    let start = peak.as_prediction();
    let mut prediction = start.peak;
    let n_relative = balance.layout.n_relative();
    prediction.point.r =
        (start.harmonics).convert(&prediction.point.r, n_relative, &balance.harmonics);
    let newton = settings.newton;
    let best = maximum_near(&balance, prediction, ensemble.peak, newton).ok()?;
    Some((best.iterate.response(&balance).norm() / start.amplitude - 1.0).abs())
}

fn print_honesty(all: &[Compared], i: usize, truth: &str, threshold: f64) {
    let unknown = all.iter().filter(|c| c.stated.is_none()).count();
    let missing = all.iter().filter(|c| c.truths[i].is_none()).count();
    let pairs: Vec<(f64, f64, f64)> = (all.iter())
        .filter_map(|c| Some((c.level, c.stated?, c.truths[i]?)))
        .collect();
    let low: Vec<&(f64, f64, f64)> = pairs.iter().filter(|(_, s, t)| t > s).collect();
    let mut ratios: Vec<f64> = pairs.iter().map(|(_, s, t)| t / s).collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
    let certified = all.iter().filter(|c| c.certified);
    let wrong = certified.filter(|c| c.truths[i].is_some_and(|truth| truth > threshold));
    println!(
        "against {truth}: {} certified ones are wrong by more than the threshold; {} of {} errors too low, true over stated median {median:.2}, most {:.2}; \
         {unknown} without a stated error, {missing} without a truth",
        wrong.count(),
        low.len(),
        pairs.len(),
        ratios.last().copied().unwrap_or(f64::NAN)
    );
    for (level, stated, truth) in low {
        println!("  {level} N: stated {stated:.1e}, true {truth:.1e}");
    }
}
