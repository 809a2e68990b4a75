//! Resonance peaks per second, and what they are worth: `cargo bench --bench peaks -- [section ...]`.
//!
//! Sections: `parts` (one Newton iteration), `study` (random samples over the box of the default study, levels up to
//! 100 N), `sweep` (this program's own continuation, 60 points around the peak), `slow-path` (the same peaks found by
//! each sample alone), `curves` (cost of the curve of a sample beside its peak), `strip` (a structure with a strip of its own), `grids` (answer and price on contact grids), `harmonics` (rate on more harmonics), `pairs` (rate
//! with more contact pairs), `certified` (rate at a truncation threshold of 1e-3, against 31 harmonics), `memory` (results
//! of 100 000 samples), `peers` (the reference problem blades-strip-oop). Rates are per second of processor time of all
//! threads; without arguments all sections run.

#![expect(clippy::expect_used, reason = "a benchmark without its state fails")]

mod clock;
mod curves;
mod grids;
mod iteration;
mod memory;
mod peers;
mod rates;
mod rig;
mod routes;
mod truncation;

fn main() {
    let asked: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let sections: [(&str, fn()); 12] = [
        ("parts", iteration::parts),
        ("strip", iteration::strip),
        ("grids", grids::grids),
        ("study", rates::study),
        ("sweep", routes::sweep),
        ("slow-path", routes::slow_path),
        ("curves", curves::curves),
        ("harmonics", rates::harmonics),
        ("pairs", rates::pairs),
        ("certified", truncation::certified),
        ("memory", memory::memory),
        ("peers", peers::peers),
    ];
    for (name, section) in sections {
        if asked.is_empty() || asked.iter().any(|a| a == name) {
            println!("== {name}");
            section();
        }
    }
}
