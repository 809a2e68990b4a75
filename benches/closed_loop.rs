//! What an identification finds in virtual tests whose truth is known:
//! `cargo bench --bench closed_loop [-- map coverage resolution varying map-given untold frequencies] [--seeds 3]`.
//!
//! `map`: friction coefficient and stiffness over their range, under the instruments of the published rig and without their
//! errors. `coverage`: how often the interval of a test holds the truth, 500 tests. `resolution`: how fine the displacement must
//! be for the stiffness. `varying`: coverage where the gap of the air, and so the pressure map, is another one in every ten tests.
//! `map-given`: coverage with the instruments of `coverage`, where the pressure map of the contact is given; `untold`: where nothing is told of it. `frequencies`: errors
//! and coverage with the map given from 5 to 600 Hz. `--seeds N` takes N times as many tests in `coverage`, `varying`, `map-given`
//! and `frequencies`, of N seeds. 100 cycles at 100 Hz, 20 for the coverage, 5 without errors. The amplitude is what a careful operator takes: four times the travel to gross slip, from 1 to 20 µm. All parts take some fifteen minutes of processor time; [`REPEATED`] and
//! [`COVERAGE_TESTS`] scale it.

#![expect(clippy::expect_used, reason = "a benchmark without its rig fails")]

use microslip::identify::{
    IdentifySettings, KnownPressure, TestResult, identify_pressed_test, identify_test,
};
use microslip::rig::{Rig, Slip, VirtualTest};
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;

const FRICTION: [f64; 5] = [0.1, 0.3, 0.6, 0.9, 1.2];
const SCALE: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];
/// Nominal tangential stiffness (N/µm).
const NOMINAL: f64 = 233.0;
/// Stiffness behind the contact: strip and box (N/µm).
const BEHIND: f64 = 136.0;
/// Least and greatest amplitude of the platform.
const AMPLITUDES_UM: [f64; 2] = [1.0, 20.0];
/// Tests of a cell of the map: median errors.
const REPEATED: u64 = 10;
const COVERAGE_TESTS: u64 = 500;
/// First seed of the coverage.
const COVERAGE_SEED: u64 = 2;
const USUAL_HZ: f64 = 100.0;
/// Frequencies of the published rig.
const FREQUENCIES_HZ: [f64; 6] = [5.0, 50.0, 100.0, 200.0, 400.0, 600.0];
/// Friction coefficients and scales of the stiffness of the coverage.
const CELLS: [(f64, f64); 7] = [
    (0.6, 1.0),
    (0.3, 0.3),
    (0.9, 3.0),
    (1.2, 0.1),
    (0.6, 10.0),
    (0.1, 1.0),
    (0.1, 3.0),
];
/// Gaps of the rig whose pressure map varies (mm), and its tests with each.
const GAPS_MM: [f64; 2] = [0.08, 0.12];
const TESTS_OF_A_GAP: u64 = 10;
/// Published accuracies of friction coefficient and stiffness.
const PUBLISHED: [f64; 2] = [0.01, 0.05];

/// Instruments without errors.
const EXACT: &str = "[support]\nk12_n_per_um = 0\ndecoupling = [1, 1]\n\
    [force_cells]\nerror_percent = 0\nnoise_n = 0\ndrift_n_per_s = 0\n\
    [vibrometer]\nresolution_um = 0\nnoise_um = 0\ndrift_um_per_s = 0\n";

/// What decides a case.
#[derive(Clone, Copy)]
struct Case<'a> {
    mu: f64,
    scale: f64,
    loading: &'a str,
    /// Gap between nozzle and strip (mm), if it is not that of the rig.
    gap_mm: Option<f64>,
    instruments: &'a str,
    tests: u64,
    cycles: usize,
    frequency_hz: f64,
    seed: u64,
    pressure: Pressure,
}

/// What the identification is told of the pressure.
#[derive(Clone, Copy)]
enum Pressure {
    /// The record states the share of its area within a tenth of the mean.
    EvenArea,
    /// Nothing.
    Untold,
    /// The map is given.
    Map,
}

impl Case<'_> {
    /// Four times the travel of the platform from the middle of the stick branch to gross slip (µm).
    fn amplitude_um(&self) -> f64 {
        let load = if self.loading == "air" { 66.0 } else { 98.0 };
        let flexibility = 1.0 / (NOMINAL * self.scale) + 1.0 / BEHIND;
        (4.0 * self.mu * load * flexibility).clamp(AMPLITUDES_UM[0], AMPLITUDES_UM[1])
    }

    fn rig(&self) -> Rig {
        let gap = self.gap_mm.map(|gap| format!("gap_mm = {gap}\n"));
        let text = format!(
            "name = \"closed loop\"\nseed = {}\n[contact]\nfriction_coefficient = {}\ntangential_stiffness_n_per_um = {}\n\
             [loading]\nkind = \"{}\"\n{}[excitation]\namplitude_um = {}\nrepetitions = {}\ncycles = {}\nfrequencies_hz = [{}]\n{}",
            self.seed,
            self.mu,
            NOMINAL * self.scale,
            self.loading,
            gap.unwrap_or_default(),
            self.amplitude_um(),
            self.tests,
            self.cycles,
            self.frequency_hz,
            self.instruments
        );
        Rig::parse(Path::new("closed loop"), &text).expect("a rig")
    }

    fn identified(&self, settings: &IdentifySettings) -> Vec<(VirtualTest, TestResult)> {
        let rig = self.rig();
        let stand = rig.stand().expect("a contact grid");
        let map = match self.pressure {
            Pressure::EvenArea | Pressure::Untold => None,
            Pressure::Map => Some(KnownPressure::new(&stand.map.pressure_map())),
        };
        let one = |index| {
            let mut test = rig.test(&stand, index);
            if matches!(self.pressure, Pressure::Untold) {
                test.record.conditions.even_area = None;
            }
            let result = match &map {
                None => identify_test(&test.record, settings),
                Some(map) => identify_pressed_test(&test.record, settings, map),
            };
            (test, result)
        };
        (0..rig.number_of_tests())
            .into_par_iter()
            .map(one)
            .collect()
    }
}

/// What a laboratory with these cells states: 1 % that 95 % keep, as a standard uncertainty.
fn stated() -> IdentifySettings {
    IdentifySettings {
        force_error_percent: 1.0 / 1.96,
        ..IdentifySettings::default()
    }
}

/// Relative errors of friction coefficient and stiffness, where they were found.
fn errors((test, result): &(VirtualTest, TestResult)) -> [Option<f64>; 2] {
    let estimate = result.estimate.as_ref();
    let friction = estimate
        .and_then(|e| e.friction)
        .map(|f| f.coefficient.value);
    let stiffness = estimate.map(|e| e.tangential.stiffness_n_per_um.value);
    [
        friction.map(|value| value / test.truth.friction_coefficient - 1.0),
        stiffness.map(|value| value / test.truth.tangential_stiffness_n_per_um - 1.0),
    ]
}

/// Half of the interval of the stiffness over its value.
fn width((_, result): &(VirtualTest, TestResult)) -> Option<f64> {
    let k_t = result.estimate.as_ref()?.tangential.stiffness_n_per_um;
    Some(0.5 * (k_t.upper - k_t.lower) / k_t.value)
}

/// Whether a stiffness farther from the truth than the published accuracy is not said to be so little known.
fn silent(test: &(VirtualTest, TestResult)) -> bool {
    let beyond = errors(test)[1].is_some_and(|e| e.abs() > PUBLISHED[1]);
    let told = |note: &String| note.starts_with("the stiffness is only known to");
    beyond && !test.1.notes.iter().any(told)
}

/// Frequency of the resonance of the force, where it was found.
fn resonance_hz((_, result): &(VirtualTest, TestResult)) -> Option<f64> {
    Some(result.cycles?.force_resonance?.frequency_hz)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{:.2}", 100.0 * v))
}

/// Median errors (%) with their sign, the median half of an interval of the stiffness, and how many tests keep the published accuracies, of all tests that have a value.
fn row(case: &Case<'_>, settings: &IdentifySettings) {
    let found = case.identified(settings);
    let all: Vec<_> = found.iter().map(errors).collect();
    let of = |k: usize| all.iter().filter_map(|e| e[k]).collect::<Vec<f64>>();
    let within = |k: usize| of(k).iter().filter(|e| e.abs() <= PUBLISHED[k]).count();
    let gross = found.iter().filter(|(test, _)| test.slip == Slip::Gross);
    let width = percent(median(found.iter().filter_map(width).collect()));
    let reached = found
        .iter()
        .map(|(test, _)| test.motion.mobilised[0].min(test.motion.mobilised[1]));
    println!(
        "| {} | {} | {:.3} | {} | {} | {} | {} of {} | {} | {} of {} | {width} | {} |",
        case.mu,
        case.scale,
        median(reached.collect()).unwrap_or_default(),
        gross.count(),
        of(0).len(),
        percent(median(of(0))),
        within(0),
        of(0).len(),
        percent(median(of(1))),
        within(1),
        of(1).len(),
        found.iter().filter(|test| silent(test)).count()
    );
}

fn heading(title: &str) {
    println!("\n{title}\n");
    println!(
        "| mu | scale | traction over limit | gross slip | mu found | median error of mu % | within 1 % | median error of k_t % | within 5 % | half of its interval % | beyond 5 % untold |"
    );
    println!("|-|-|-|-|-|-|-|-|-|-|-|");
}

fn map(title: &str, base: Case<'_>, settings: &IdentifySettings) {
    heading(title);
    for scale in SCALE {
        for mu in FRICTION {
            row(&Case { mu, scale, ..base }, settings);
        }
    }
}

fn maps() {
    let published = Case {
        mu: 0.6,
        scale: 1.0,
        loading: "air",
        gap_mm: None,
        instruments: "",
        tests: REPEATED,
        cycles: 100,
        frequency_hz: USUAL_HZ,
        seed: 1,
        pressure: Pressure::EvenArea,
    };
    map(
        "Air, instruments of the published rig",
        published,
        &stated(),
    );
    let gains = Case {
        instruments: "[force_cells]\nerror_percent = 0\n[support]\ndecoupling = [1, 1]\n",
        ..published
    };
    map(
        "Air, cells without gain errors and offsets",
        gains,
        &stated(),
    );
    let exact = Case {
        instruments: EXACT,
        tests: 1,
        cycles: 5,
        ..published
    };
    let ideal = IdentifySettings::default();
    map("Air, instruments without errors", exact, &ideal);
    let punch = Case {
        loading: "punch",
        ..exact
    };
    map("Punch, instruments without errors", punch, &ideal);
}

fn coverage_heading() {
    println!(
        "\n| mu | scale | tests | interval of | has one | holds the truth % | standard error |"
    );
    println!("|-|-|-|-|-|-|-|-|");
}

/// Share of the tests whose interval holds the truth, of those that have one.
fn coverage(seeds: u64) {
    held(seeds, Pressure::EvenArea);
}

/// The same where nothing is known of the pressure.
fn untold(seeds: u64) {
    held(seeds, Pressure::Untold);
}

/// The same where the pressure map is given.
fn map_given(seeds: u64) {
    held(seeds, Pressure::Map);
}

fn held(seeds: u64, pressure: Pressure) {
    coverage_heading();
    let coarse = "[vibrometer]\nnoise_um = 0.02\n";
    let under_air = CELLS.map(|(mu, scale)| (mu, scale, "air", ""));
    let others = [
        (0.1, 1.0, "punch", ""),
        (0.1, 3.0, "punch", ""),
        (0.6, 1.0, "air", coarse),
        (0.6, 3.0, "air", coarse),
        (0.6, 10.0, "air", coarse),
    ];
    for (mu, scale, loading, instruments) in under_air.into_iter().chain(others) {
        let case = Case {
            mu,
            scale,
            loading,
            gap_mm: None,
            instruments,
            tests: COVERAGE_TESTS,
            cycles: 20,
            frequency_hz: USUAL_HZ,
            seed: COVERAGE_SEED,
            pressure,
        };
        let of_seed = |seed| Case { seed, ..case }.identified(&stated());
        let seeds = COVERAGE_SEED..COVERAGE_SEED + seeds;
        let noise = match instruments.is_empty() {
            true => "0.04 um noise",
            false => "0.02 um noise",
        };
        let told = match pressure {
            Pressure::EvenArea => "",
            Pressure::Untold => ", nothing told",
            Pressure::Map => ", map given",
        };
        let setting = format!("{mu} | {scale} | {loading}, {noise}{told}");
        shares(&setting, &seeds.flat_map(of_seed).collect::<Vec<_>>());
    }
}

/// The same with a gap between nozzle and strip that is another one in every ten tests; the record states the share of its own map.
fn varying(seeds: u64) {
    coverage_heading();
    for (mu, scale) in CELLS {
        let rigs = seeds * COVERAGE_TESTS / TESTS_OF_A_GAP;
        let of_rig = |k: u64| {
            let share = (k as f64 + 0.5) / rigs as f64;
            let gap = GAPS_MM[0] + share * (GAPS_MM[1] - GAPS_MM[0]);
            let case = Case {
                mu,
                scale,
                loading: "air",
                gap_mm: Some(gap),
                instruments: "",
                tests: TESTS_OF_A_GAP,
                cycles: 20,
                frequency_hz: USUAL_HZ,
                seed: COVERAGE_SEED + k,
                pressure: Pressure::EvenArea,
            };
            case.identified(&stated())
        };
        let found: Vec<_> = (0..rigs).flat_map(of_rig).collect();
        shares(&format!("{mu} | {scale} | air, gap varies"), &found);
    }
}

/// The same over the frequencies of the rig, with median errors.
fn frequencies(seeds: u64) {
    let of = |(mu, scale), frequency_hz| Case {
        mu,
        scale,
        loading: "air",
        gap_mm: None,
        instruments: "",
        tests: COVERAGE_TESTS / 5,
        cycles: 20,
        frequency_hz,
        seed: COVERAGE_SEED,
        pressure: Pressure::Map,
    };
    let all = FREQUENCIES_HZ.map(|frequency_hz| {
        CELLS.map(|cell| {
            let case = of(cell, frequency_hz);
            let of_seed = |seed| Case { seed, ..case }.identified(&stated());
            let seeds = COVERAGE_SEED..COVERAGE_SEED + seeds;
            let found: Vec<_> = seeds.flat_map(of_seed).collect();
            let setting = format!("{} | {} | {frequency_hz} Hz", case.mu, case.scale);
            (setting, found)
        })
    });
    println!(
        "\n| mu | scale | frequency | median error of mu % | median error of k_t % | half of its interval % | resonance of the force found | its median Hz |"
    );
    println!("|-|-|-|-|-|-|-|-|");
    for (setting, found) in all.iter().flatten() {
        let errors: Vec<_> = found.iter().map(errors).collect();
        let middle = |k: usize| percent(median(errors.iter().filter_map(|e| e[k]).collect()));
        let resonances: Vec<f64> = found.iter().filter_map(resonance_hz).collect();
        println!(
            "| {setting} | {} | {} | {} | {} | {:.0} |",
            middle(0),
            middle(1),
            percent(median(found.iter().filter_map(width).collect())),
            resonances.len(),
            median(resonances.clone()).unwrap_or_default()
        );
    }
    coverage_heading();
    for (setting, found) in all.iter().flatten() {
        shares(setting, found);
    }
}

/// Rows of both parameters.
fn shares(setting: &str, found: &[(VirtualTest, TestResult)]) {
    let friction = found.iter().filter_map(|(test, result)| {
        let interval = result.estimate.as_ref()?.friction?.coefficient;
        let truth = test.truth.friction_coefficient;
        Some(interval.lower <= truth && truth <= interval.upper)
    });
    let stiffness = found.iter().filter_map(|(test, result)| {
        let interval = result.estimate.as_ref()?.tangential.stiffness_n_per_um;
        let truth = test.truth.tangential_stiffness_n_per_um;
        Some(interval.lower <= truth && truth <= interval.upper)
    });
    for (name, held) in [
        ("mu", friction.collect::<Vec<bool>>()),
        ("k_t", stiffness.collect()),
    ] {
        let n = held.len() as f64;
        let share = held.iter().filter(|held| **held).count() as f64 / n;
        println!(
            "| {setting} | {} | {name} | {n} | {:.1} | {:.1} |",
            found.len(),
            100.0 * share,
            100.0 * (share * (1.0 - share) / n).sqrt()
        );
    }
}

/// Error of the stiffness against the step of the vibrometer, all else as published.
fn resolution() {
    for step in ["0.08", "0.02", "0.005", "0.001"] {
        let instruments = format!("[vibrometer]\nresolution_um = {step}\nnoise_um = {step}\n");
        heading(&format!(
            "Air, vibrometer with steps and noise of {step} um"
        ));
        for scale in SCALE {
            let case = Case {
                mu: 0.6,
                scale,
                loading: "air",
                gap_mm: None,
                instruments: &instruments,
                tests: REPEATED,
                cycles: 100,
                frequency_hz: USUAL_HZ,
                seed: 3,
                pressure: Pressure::EvenArea,
            };
            row(&case, &stated());
        }
    }
}

/// A part of the benchmark, of so many seeds.
type Part = fn(u64);

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let after = asked.iter().skip_while(|a| *a != "--seeds").nth(1);
    let seeds: u64 = after.map_or(1, |n| n.parse().expect("a number of seeds"));
    let parts: [(&str, Part); 7] = [
        ("map", |_| maps()),
        ("coverage", coverage),
        ("resolution", |_| resolution()),
        ("varying", varying),
        ("map-given", map_given),
        ("untold", untold),
        ("frequencies", frequencies),
    ];
    let named = parts
        .iter()
        .any(|(name, _)| asked.iter().any(|a| a == name));
    let clock = Instant::now();
    for (name, part) in parts {
        if !named || asked.iter().any(|a| a == name) {
            part(seeds);
        }
    }
    println!("\n{:.0} s", clock.elapsed().as_secs_f64());
}
