//! Small random models, parameters over six decades: how many peaks are found, and how the others end.
//!
//! `cargo bench --bench models [-- seeds [first seed [harmonics [budget]]]]`

#![allow(clippy::expect_used, reason = "a benchmark that cannot be set up ends")]

mod random;

use microslip::hb::{NewtonSettings, Status};
use random::RandomModel;
use rayon::prelude::*;

/// How the search for the peak of one model ended.
struct Outcome {
    text: String,
    status: Status,
    iterations: usize,
}

fn main() {
    let arguments = std::env::args().filter_map(|a| a.parse::<u64>().ok());
    let arguments: Vec<u64> = arguments.collect();
    let or = |at: usize, default: u64| arguments.get(at).copied().unwrap_or(default);
    let (seeds, first, harmonics) = (or(0, 200), or(1, 0), or(2, 5));
    let budget = or(3, NewtonSettings::default().budget as u64);
    let outcomes: Vec<Outcome> = (first..first + seeds)
        .into_par_iter()
        .map(|seed| {
            let model = RandomModel::of_seed(seed);
            let found = model.peak(harmonics as usize, budget as usize);
            Outcome {
                text: model.text,
                status: found.status,
                iterations: found.count.iterations,
            }
        })
        .collect();
    for status in Status::ALL {
        let ended = outcomes.iter().filter(|o| o.status == status);
        match ended.count() {
            0 => {}
            n => println!("{:<26} {n:>5}", status.name()),
        }
    }
    let mut iterations: Vec<usize> = outcomes.iter().map(|o| o.iterations).collect();
    iterations.sort_unstable();
    let quantile = |p: f64| iterations[(p * (iterations.len() - 1) as f64) as usize];
    println!(
        "Newton iterations: median {}, 99 % {}, most {}",
        quantile(0.5),
        quantile(0.99),
        quantile(1.0)
    );
    for outcome in outcomes.iter().filter(|o| !o.status.has_solution()) {
        let Outcome {
            text,
            status,
            iterations,
        } = outcome;
        println!("{}, {iterations} iterations: {text}", status.name());
    }
}
