//! How often each interval of the program holds the truth: `cargo bench --bench coverage [-- PART OF A NAME]`.
//!
//! 1000 repetitions of every case of `cases`, each on fresh samples of a function with a known answer. The standard
//! error of a measured 95 % is 0.7 points. README.md has the lowest and the highest row of each interval.

mod cases;
mod functions;

use rayon::prelude::*;

const REPETITIONS: u64 = 1000;

fn main() {
    // cargo itself passes --bench
    let wanted = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    println!("| interval | samples | stated | covers |\n|-|-|-|-|");
    for case in cases::all() {
        let name = |s: &cases::Statement| format!("{}, {}", s.interval, s.samples);
        let is_wanted = |s: &cases::Statement| {
            wanted
                .as_ref()
                .is_none_or(|part| name(s).contains(part.as_str()))
        };
        if !case.statements.iter().any(is_wanted) {
            continue;
        }
        let seeds = (0..REPETITIONS).into_par_iter();
        let found: Vec<Vec<bool>> = seeds.map(|seed| case.covers(seed)).collect();
        for (place, statement) in case.statements.iter().enumerate() {
            let hits = found.iter().filter(|holds| holds[place]).count();
            let covers = 100.0 * hits as f64 / REPETITIONS as f64;
            let cases::Statement {
                interval,
                samples,
                stated,
            } = statement;
            println!(
                "| {interval} | {samples} | {:.1} | {covers:.1} |",
                100.0 * stated
            );
        }
    }
}
