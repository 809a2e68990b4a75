//! Resonance peaks per second, and what they are worth: `cargo bench --bench peaks -- [section ...]`.
//!
//! Sections: `parts` (one Newton iteration), `study` (random samples over the box of the default study, levels up to
//! 100 N), `sweep` (this program's own continuation, 60 points around the peak), `slow-path` (the same peaks found by
//! each sample alone), `strip` (a structure with a strip of its own), `harmonics` (rate on more harmonics), `pairs` (rate
//! with more contact pairs), `certified` (rate at a truncation threshold of 1e-3, against 31 harmonics), `memory` (results
//! of 100 000 samples), `peers` (the reference problem blades-strip-oop). Rates are per second of processor time of all
//! threads; without arguments all sections run.

#![expect(clippy::expect_used, reason = "a benchmark without its state fails")]

use microslip::aft::{Accuracy, AftSettings, Laps, Want};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::ensemble::atlas::{Anchor, Atlas, AtlasPrediction, ModePeaks};
use microslip::ensemble::backend::BackendReport;
use microslip::ensemble::outcome::{LevelOutcome, SampleOutcome};
use microslip::ensemble::store::{Provenance, write_samples};
use microslip::ensemble::{Ensemble, SampleSolver, Solved, Strips};
use microslip::harmonics::HarmonicSet;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::equations::balance::balance_on;
use microslip::hb::newton::Iterate;
use microslip::hb::peak::maxima::PeakChoice;
use microslip::hb::peak::predicted::maximum_near;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::response::values::{SlowSweep, at_frequencies};
use microslip::hb::structure::resonance::{Band, linear_resonance};
use microslip::hb::{
    AlertSettings, Balance, HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor,
    Solution, Status,
};
use microslip::model::interface::InterfaceSettings;
use microslip::model::two_blade::{TwoBladeSettings, build};
use microslip::report::asked::Bands;
use microslip::report::asked::Requirements;
use microslip::report::run::{DesignRecord, FileRecord, InputRecord, LinearRecord};
use microslip::report::{self, ReportInput, RunRecord};
use microslip::sampling::{Design, DesignKind, Distribution, Growth, Input, Shape};
use microslip::study::Study;
use microslip::units::{hz_to_rad_s, rad_s_to_hz};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

const LEVELS: [f64; 7] = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0];

fn main() {
    let asked: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let sections: [(&str, fn()); 10] = [
        ("parts", parts),
        ("strip", strip),
        ("study", study),
        ("sweep", sweep),
        ("slow-path", slow_path),
        ("harmonics", harmonics),
        ("pairs", pairs),
        ("certified", certified),
        ("memory", memory),
        ("peers", peers),
    ];
    for (name, section) in sections {
        if asked.is_empty() || asked.iter().any(|a| a == name) {
            println!("== {name}");
            section();
        }
    }
}

/// Seconds of processor time of `f`, all threads, and its value.
fn processor_time<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let (clock, before) = (Instant::now(), processor_seconds());
    let value = f();
    let spent = match (before, processor_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => clock.elapsed().as_secs_f64(),
    };
    (spent, value)
}

/// Of this process so far, where the system tells (Linux; ticks of 10 ms).
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks: f64 = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

fn milliseconds(n: u32, mut f: impl FnMut()) -> f64 {
    let one = |f: &mut dyn FnMut()| {
        let clock = Instant::now();
        (0..n).for_each(|_| f());
        clock.elapsed().as_secs_f64() * 1e3 / f64::from(n)
    };
    (0..5).map(|_| one(&mut f)).fold(f64::INFINITY, f64::min)
}

/// The default rig on half of its contacts.
struct Rig {
    linear: LinearModel,
    contacts: Vec<ContactParameters<f64>>,
}

impl Rig {
    fn new(contact_nodes: [usize; 2]) -> Self {
        let settings = TwoBladeSettings {
            contact_nodes,
            ..TwoBladeSettings::default()
        };
        let model = build(&settings).expect("valid").reduced;
        let each = 0.5 * model.n_contacts() as f64;
        let contact = ContactParameters {
            k_n: 1e9 / each,
            k_t: [2.33e8 / each; 2],
            mu: 0.6,
            n_0: 0.0,
            anchor: [0.0; 2],
        };
        let contacts = vec![contact; model.n_contacts()];
        let linear = LinearModel::folded(&model, &contacts)
            .expect("definite")
            .expect("a mirror");
        let contacts = contacts[..linear.n_contacts()].to_vec();
        Self { linear, contacts }
    }

    fn problem(&self, scale: f64, mu: f64) -> Problem<'_> {
        let scaled = |c: &ContactParameters<f64>| ContactParameters {
            k_n: c.k_n * scale,
            k_t: c.k_t.map(|k| k * scale),
            mu,
            ..*c
        };
        let contacts = self.contacts.iter().map(scaled).collect();
        Problem::new(&self.linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held")
    }

    fn ensemble<'a>(
        &'a self,
        design: &'a Design,
        levels: &'a [f64],
        settings: &'a HbSettings,
    ) -> Ensemble<'a> {
        Ensemble {
            linear: &self.linear,
            strips: None,
            contacts: &self.contacts,
            interfaces: &[],
            loads: &[],
            design,
            levels,
            settings,
            peak: search(),
            choice: PeakChoice::Highest,
            curve_samples: 0,
            gpu: None,
            solver: SampleSolver::HarmonicBalance,
        }
    }
}

fn search() -> PeakSettings {
    PeakSettings {
        band: Band {
            low: hz_to_rad_s(2605.0),
            high: hz_to_rad_s(2635.0),
        },
        frequency_tolerance: 1e-9,
    }
}

fn settings(highest: usize, alert: Option<AlertSettings>) -> HbSettings {
    HbSettings {
        harmonics: HarmonicSet::up_to(highest),
        aft: AftSettings {
            n_time: (12 * highest).next_power_of_two().max(128),
            law: FrictionLaw::Box,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        anchor: SliderAnchor::Unloaded,
        newton: NewtonSettings::default(),
        alert,
    }
}

/// The box of the default study.
fn design(seed: u64) -> Design {
    let new = |shape| Distribution::new(shape, None).expect("valid");
    let log_uniform = Shape::LogUniform {
        low: 0.1,
        high: 10.0,
    };
    let uniform = Shape::Uniform {
        low: 0.1,
        high: 0.8,
    };
    let inputs = vec![
        (Input::StiffnessScale, new(log_uniform)),
        (Input::FrictionCoefficient, new(uniform)),
    ];
    Design::new(seed, inputs).expect("valid")
}

fn rank(sorted: &[usize], share: f64) -> usize {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

/// One line on the work and the fate of the peaks.
fn describe(name: &str, peaks: &[&LevelOutcome]) {
    let mut factors: Vec<usize> = peaks.iter().map(|p| p.factorizations).collect();
    factors.sort_unstable();
    let failed = peaks.iter().filter(|p| !p.status.has_solution()).count();
    println!(
        "{name}: factorisations mean {:.2}, median {}, 95 % {}, most {}; {failed} of {} not solved",
        factors.iter().sum::<usize>() as f64 / factors.len() as f64,
        rank(&factors, 0.5),
        rank(&factors, 0.95),
        rank(&factors, 1.0),
        peaks.len()
    );
}

/// Runs the first samples, prints their rate, work and fate, and returns them with the rate.
fn measured(name: &str, ensemble: &Ensemble<'_>, samples: u64) -> (f64, Vec<SampleOutcome>) {
    let (seconds, outcomes) = processor_time(|| ensemble.run(samples, || {}));
    let peaks: Vec<&LevelOutcome> = outcomes.iter().flat_map(|o| &o.levels).collect();
    let rate = peaks.len() as f64 / seconds;
    println!(
        "{name}, {samples} samples x {} levels: {rate:.2} peaks per processor second",
        ensemble.levels.len()
    );
    describe("all", &peaks);
    (rate, outcomes)
}

fn parts() {
    println!("pairs  H    compliance  contact  motion  Jacobian and two solves (ms, fastest of 5)");
    for (grid, highest) in [
        ([5, 3], 3),
        ([5, 3], 5),
        ([5, 3], 9),
        ([5, 3], 21),
        ([4, 7], 5),
        ([5, 9], 5),
    ] {
        let rig = Rig::new(grid);
        let problem = rig.problem(1.0, 0.4);
        let settings = settings(highest, None);
        let start = track_peaks(&problem, &settings, search(), &[20.0]).expect("modes");
        let Some(solution) = &start[0].solution else {
            println!("{:5} {highest:2}  no peak", 2 * grid[0] * grid[1]);
            continue;
        };
        let balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
        print_iteration(&balance, solution);
    }
}

/// The parts of a Newton iteration at a solution.
fn print_iteration(balance: &Balance<'_>, solution: &Solution) {
    let at = Iterate::new(balance, solution.point());
    let (r, omega, force) = (&at.point.r, at.point.omega, &at.contact.force);
    let times = [
        milliseconds(5, || drop(balance.compliance(omega))),
        milliseconds(5, || {
            drop(balance.contact(r, Want::ForcesAndTangents, Accuracy::Full))
        }),
        milliseconds(5, || {
            drop(balance.motion(&at.compliance, solution.level, r, force));
        }),
        milliseconds(2, || {
            let jacobian = at.jacobian(balance);
            drop(jacobian.solve(&at.residual));
            drop(at.frequency_rate(balance, &jacobian));
        }),
    ];
    let [compliance, contact, motion, jacobian] = times;
    println!(
        "{:5} {:2}  {compliance:10.3} {contact:8.3} {motion:7.3} {jacobian:9.3}",
        balance.layout.n_pairs,
        balance.harmonics.highest()
    );
}

fn strip() {
    let rig = build(&TwoBladeSettings::default()).expect("valid");
    let contacts = InterfaceSettings::default().parameters(&rig.reduced.contacts);
    let nominal = LinearModel::of(&rig.reduced, &contacts, true).expect("definite");
    let reduced = milliseconds(10, || drop(rig.with_strip(0.5)));
    let strips = Strips {
        rig,
        contacts,
        mirror: true,
    };
    let folded = milliseconds(10, || drop(strips.linear(0.5, &nominal)));
    println!(
        "{reduced:.1} ms to reduce a strip, {folded:.1} ms with folding and modes (fastest of 5)"
    );
}

fn study() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(2026), settings(5, None));
    let ensemble = rig.ensemble(&design, &LEVELS, &settings);
    for samples in [64, 256, 1024] {
        let (_, outcomes) = measured("H = 5", &ensemble, samples);
        if samples == 1024 {
            for (i, level) in LEVELS.iter().enumerate() {
                let peaks: Vec<_> = outcomes.iter().map(|o| &o.levels[i]).collect();
                describe(&format!("{level} N"), &peaks);
            }
        }
    }
}

fn sweep() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(2026), settings(5, None));
    let (mut points, mut seconds, mut peaks) = (0, 0.0, 0);
    for index in 0..4 {
        let [scale, mu] = design.sample(index)[..] else {
            continue;
        };
        let problem = rig.problem(scale, mu);
        let found = track_peaks(&problem, &settings, search(), &LEVELS).expect("modes");
        let stuck = linear_resonance(&rig.linear, &problem.stuck_stiffness, search().band)
            .expect("modes")
            .expect("a resonance");
        for solution in found.iter().filter_map(|p| p.solution.as_ref()) {
            let reach = 4.0 * stuck.half_bandwidth;
            let omega: Vec<f64> = (0..60)
                .map(|i| solution.omega + reach * (f64::from(i) / 29.5 - 1.0))
                .collect();
            let (spent, _) = processor_time(|| {
                let sweep = SlowSweep {
                    band: Band {
                        low: omega[0],
                        high: omega[omega.len() - 1],
                    },
                    direction: SweepDirection::Upward,
                    omega: &omega,
                };
                at_frequencies(&problem, &settings, solution.level, sweep, |_| ())
            });
            points += omega.len();
            peaks += 1;
            seconds += spent;
        }
    }
    println!(
        "{peaks} sweeps of {} points: {:.2} sweeps per processor second",
        points / peaks.max(1),
        f64::from(peaks as u32) / seconds
    );
}

fn slow_path() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(7), settings(5, None));
    let ensemble = rig.ensemble(&design, &LEVELS, &settings);
    let (_, fast) = measured("from the atlas", &ensemble, 300);
    let alone = |outcome: &SampleOutcome| {
        let problem = rig.problem(outcome.inputs[0], outcome.inputs[1]);
        track_peaks(&problem, &settings, search(), &LEVELS).expect("modes")
    };
    let (seconds, slow) = processor_time(|| fast.par_iter().map(alone).collect::<Vec<_>>());
    println!("each alone: {seconds:.1} processor seconds");
    let mut differences = [Vec::new(), Vec::new()];
    for (fast, slow) in fast.iter().zip(&slow) {
        for (fast_peak, slow_peak) in fast.levels.iter().zip(slow) {
            let (Some(a), Some(b)) = (&fast_peak.peak, &slow_peak.solution) else {
                println!(
                    "{:?} {} N: {:?} from the atlas, {:?} alone",
                    fast.inputs, fast_peak.level, fast_peak.status, slow_peak.status
                );
                continue;
            };
            let errors = [
                (a.amplitude_m / b.amplitude(0) - 1.0).abs(),
                (a.frequency_hz / rad_s_to_hz(b.omega) - 1.0).abs(),
            ];
            if errors[0] > 1e-5 || errors[1] > 1e-7 {
                println!(
                    "{:?} {} N: differs by {errors:?}",
                    fast.inputs, fast_peak.level
                );
            }
            (differences.iter_mut().zip(errors)).for_each(|(all, error)| all.push(error));
        }
    }
    for (name, all) in ["amplitude", "frequency"].iter().zip(&mut differences) {
        all.sort_by(f64::total_cmp);
        let at = |share: f64| all[((all.len() - 1) as f64 * share) as usize];
        println!(
            "{} peaks, {name}: median {:.1e}, 99 % {:.1e}, most {:.1e}",
            all.len(),
            at(0.5),
            at(0.99),
            at(1.0)
        );
    }
}

fn harmonics() {
    let rig = Rig::new([5, 3]);
    let design = design(11);
    let levels = [1.0, 5.0, 20.0, 100.0];
    for samples in [32, 64, 256] {
        let times = [5, 9, 13, 21].map(|highest| {
            let settings = settings(highest, None);
            let ensemble = rig.ensemble(&design, &levels, &settings);
            let (rate, _) = measured(&format!("H = {highest}"), &ensemble, samples);
            (highest as f64, 1.0 / rate)
        });
        print_growth("H", times);
    }
}

/// The default structure with finer and finer contact grids, and how the time per peak grows with their pairs.
fn pairs() {
    let (design, settings) = (design(2026), settings(5, None));
    let levels = [1.0, 20.0, 100.0];
    let times = [[2, 3], [5, 3], [4, 7], [6, 8]].map(|grid| {
        let rig = Rig::new(grid);
        let ensemble = rig.ensemble(&design, &levels, &settings);
        let pairs = (2 * grid[0] * grid[1]) as f64;
        let (rate, _) = measured(&format!("{pairs} pairs"), &ensemble, 64);
        (pairs, 1.0 / rate)
    });
    print_growth("pairs", times);
}

/// How the time per peak grows with a number, from its first to its last value.
fn print_growth(name: &str, times: [(f64, f64); 4]) {
    let [(few, short), .., (many, long)] = times;
    let growth = (long / short).ln() / (many / few).ln();
    println!("from {few} to {many} the time per peak grows as {name}^{growth:.2}");
}

const CERTIFIED: AlertSettings = AlertSettings {
    threshold: 1e-3,
    highest_harmonic: 21,
};

/// Samples solved, and those of them that are compared with 31 harmonics.
const CERTIFIED_SAMPLES: u64 = 256;
const COMPARED: usize = 50;

/// Peaks whose truncation error is below 1e-3 by the alert, the first of them against the same peaks on 31 harmonics.
fn certified() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(17), settings(5, Some(CERTIFIED)));
    let levels = [1.0, 5.0, 20.0, 100.0];
    let ensemble = rig.ensemble(&design, &levels, &settings);
    let (seconds, solved) =
        processor_time(|| ensemble.extend(Solved::default(), CERTIFIED_SAMPLES, || {}));
    let n_peaks = solved.outcomes.len() * levels.len();
    println!("{:.2} peaks per processor second", n_peaks as f64 / seconds);
    for (i, level) in levels.iter().enumerate() {
        let peaks: Vec<&LevelOutcome> = solved.outcomes.iter().map(|o| &o.levels[i]).collect();
        describe(&format!("{level} N"), &peaks);
        let mut fates: BTreeMap<(&str, usize), usize> = BTreeMap::new();
        for peak in &peaks {
            let highest = peak.peak.map_or(0, |p| p.highest_harmonic);
            *fates.entry((peak.status.name(), highest)).or_default() += 1;
        }
        println!("  {fates:?}");
    }
    let compared = solved.outcomes.par_iter().zip(&solved.anchors);
    let mut errors: Vec<f64> = compared
        .take(COMPARED)
        .flat_map_iter(|(outcome, anchor)| on_31_harmonics(&rig, &settings, outcome, anchor))
        .collect();
    errors.sort_by(f64::total_cmp);
    let above = errors.iter().filter(|e| **e > CERTIFIED.threshold).count();
    println!(
        "{} certified peaks against 31 harmonics: median {:.1e}, most {:.1e}, {above} above {:.0e}",
        errors.len(),
        errors[errors.len() / 2],
        errors[errors.len() - 1],
        CERTIFIED.threshold
    );
}

/// Relative changes of the certified amplitudes of one sample on 31 harmonics.
fn on_31_harmonics(
    rig: &Rig,
    settings: &HbSettings,
    outcome: &SampleOutcome,
    anchor: &Anchor,
) -> Vec<f64> {
    let problem = rig.problem(outcome.inputs[0], outcome.inputs[1]);
    let balance = balance_on(&problem, HarmonicSet::up_to(31), settings);
    let change = |(level, peaks): (&LevelOutcome, &ModePeaks)| {
        let mut peaks = peaks.iter();
        let peak = peaks.next().filter(|_| level.status == Status::Converged)?;
        let AtlasPrediction {
            harmonics,
            mut peak,
            amplitude,
        } = peak.as_prediction();
        let n_relative = balance.layout.n_relative();
        peak.point.r = harmonics.convert(&peak.point.r, n_relative, &balance.harmonics);
        match maximum_near(&balance, peak, search(), settings.newton) {
            Ok(best) => Some((best.iterate.response(&balance).norm() / amplitude - 1.0).abs()),
            Err(status) => {
                println!("{} N: {status:?} on 31 harmonics", level.level);
                None
            }
        }
    };
    let peaks = outcome.levels.iter().zip(&anchor.peaks);
    peaks.filter_map(change).collect()
}

/// Peak of the memory with the results of 100 000 samples, the largest atlas and what writes them.
fn memory() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(17), settings(5, Some(CERTIFIED)));
    let ensemble = rig.ensemble(&design, &LEVELS, &settings);
    let few: Vec<_> = (0..4)
        .map(|index| ensemble.sample(index, &Atlas::default()))
        .collect();
    let mut atlas = Atlas::default();
    atlas.extend((0..1024).map(|i| few[i % 4].1.clone()));
    let outcomes: Vec<(SampleOutcome, Option<Anchor>)> = (0..100_000)
        .map(|index| {
            let mut outcome = few[index as usize % 4].0.clone();
            outcome.index = index;
            (outcome, None)
        })
        .collect();
    let (outcomes, _): (Vec<SampleOutcome>, Vec<Option<Anchor>>) = outcomes.into_iter().unzip();
    let folder = tempfile::tempdir().expect("a folder");
    let provenance = provenance(&settings);
    let names = ["stiffness-scale", "friction-coefficient"].map(str::to_owned);
    write_samples(
        &folder.path().join("samples.parquet"),
        &provenance,
        &names,
        &outcomes,
    )
    .expect("written");
    let record = record(provenance, &names);
    let input = ReportInput {
        record: &record,
        outcomes: &outcomes,
        mixed: &[],
        changed: &[],
    };
    report::write(folder.path(), &input).expect("written");
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find(|line| line.starts_with("VmHWM"));
    println!(
        "{} samples x {} levels: {}",
        outcomes.len(),
        LEVELS.len(),
        peak.unwrap_or("the system does not tell")
    );
    drop(atlas);
}

fn record(provenance: Provenance, names: &[String]) -> RunRecord {
    let linear = |frequency_hz: f64| LinearRecord {
        frequency_hz,
        curve: Vec::new(),
    };
    let input = |name: &String| InputRecord {
        name: name.clone(),
        prior: String::new(),
        distribution: None,
    };
    RunRecord {
        provenance,
        backend: BackendReport::default(),
        inputs: names.iter().map(input).collect(),
        design: DesignRecord {
            kind: DesignKind::MonteCarlo,
            description: "monte-carlo".to_owned(),
            independent: true,
            growth: Growth::Any,
            outer_points: 1,
            further_points: 0,
            mixed_inputs: Vec::new(),
        },
        frequency_tolerance: 3e-7,
        levels: LEVELS.to_vec(),
        curve_samples: 0,
        bands: Bands::default(),
        level_unit: "N".to_owned(),
        free: linear(2600.0),
        stuck: linear(2620.0),
        nominal: None,
        one_at_a_time: None,
        components: Vec::new(),
        contact_grid: None,
        requirements: Requirements::default(),
        stopping: None,
        surrogate: None,
        study_file: FileRecord::of("study.toml", b""),
        tables: Vec::new(),
        wall_time_s: 0.0,
    }
}

fn provenance(settings: &HbSettings) -> Provenance {
    Provenance {
        study: "memory".to_owned(),
        seed: 17,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: None,
        model: "two blades with a strip damper".to_owned(),
        law: settings.aft.law,
        events: settings.aft.events,
        anchor: settings.anchor,
        harmonics: settings.harmonics.orders().to_vec(),
        time_points: settings.aft.n_time,
        folded: true,
        truncation_threshold: settings.alert.map(|alert| alert.threshold),
        highest_harmonic: settings.alert.map(|alert| alert.highest_harmonic),
    }
}

fn peers() {
    let path = Path::new("tests/reference/blades-strip-oop/study.toml");
    let study = Study::read(path).expect("the reference study");
    let model = study.build_model().expect("the reference model");
    let linear = LinearModel::new(&model.reduced).expect("definite");
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(5),
        aft: AftSettings {
            n_time: 256,
            law: FrictionLaw::Circle,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        alert: None,
        ..study.solver.clone()
    };
    let new = |shape| Distribution::new(shape, None).expect("valid");
    let factor = || Shape::LogUniform {
        low: 0.1,
        high: 10.0,
    };
    let mu = Shape::Uniform {
        low: 0.1,
        high: 0.9,
    };
    let inputs = vec![
        (Input::NormalStiffnessScale, new(factor())),
        (Input::TangentialStiffnessScale, new(factor())),
        (Input::FrictionCoefficient, new(mu)),
    ];
    let design = Design::new(3, inputs).expect("valid");
    // that of the reference ends at 325 Hz; stiff contacts with much friction peak at up to 331 Hz
    let [low, high] = [270.0, 340.0].map(hz_to_rad_s);
    let ensemble = Ensemble {
        linear: &linear,
        strips: None,
        contacts: &model.contacts,
        interfaces: &[],
        loads: &[],
        design: &design,
        levels: &[0.5],
        settings: &settings,
        peak: PeakSettings {
            band: Band { low, high },
            frequency_tolerance: 1e-6,
        },
        choice: PeakChoice::Highest,
        curve_samples: 0,
        gpu: None,
        solver: SampleSolver::HarmonicBalance,
    };
    println!("pairs  H    compliance  contact  motion  Jacobian and two solves (ms, fastest of 5)");
    for mu in [0.2, 0.5, 0.8] {
        let mut contacts = model.contacts.clone();
        contacts.iter_mut().for_each(|c| c.mu = mu);
        let problem = Problem::new(&linear, contacts, 1.0, settings.anchor).expect("held");
        let peak = track_peaks(&problem, &settings, ensemble.peak, &[0.5]).expect("modes");
        let balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
        print_iteration(&balance, peak[0].solution.as_ref().expect("a peak"));
    }
    for samples in [256, 1024, 4096] {
        measured("blades-strip-oop", &ensemble, samples);
    }
}
