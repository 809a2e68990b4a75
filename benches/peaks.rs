//! Resonance peaks per second, and what they are worth: `cargo bench --bench peaks -- [section ...]`.
//!
//! Sections: `parts` (one Newton iteration), `study` (random samples over the box of the default study, levels up to
//! 100 N), `sweep` (this program's own continuation, 60 points around the peak), `slow-path` (the same peaks found by
//! each sample alone), `harmonics` (rate and error at a truncation threshold of 1e-3), `peers` (the reference problem
//! blades-strip-oop). Rates are per second of processor time of all threads; without arguments all sections run.

#![expect(clippy::expect_used, reason = "a benchmark without its state fails")]

use microslip::aft::{Accuracy, AftSettings, Backend, Laps, Want};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::ensemble::Ensemble;
use microslip::ensemble::outcome::{LevelOutcome, SampleOutcome};
use microslip::harmonics::HarmonicSet;
use microslip::hb::forced_response::at_frequencies;
use microslip::hb::newton::Iterate;
use microslip::hb::peak::PeakSettings;
use microslip::hb::resonance::{Band, linear_resonance};
use microslip::hb::sweep::SweepDirection;
use microslip::hb::track::track_peaks;
use microslip::hb::{
    AlertSettings, Balance, HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor,
};
use microslip::model::two_blade::{TwoBladeSettings, build};
use microslip::sampling::{Design, Distribution, Input, Shape};
use microslip::study::Study;
use microslip::units::{hz_to_rad_s, rad_s_to_hz};
use std::path::Path;
use std::time::Instant;

const LEVELS: [f64; 7] = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0];

fn main() {
    let asked: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let sections: [(&str, fn()); 6] = [
        ("parts", parts),
        ("study", study),
        ("sweep", sweep),
        ("slow-path", slow_path),
        ("harmonics", harmonics),
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
            contacts: &self.contacts,
            design,
            levels,
            settings,
            peak: search(),
            curve_samples: 0,
            backend: Backend::Cpu,
        }
    }
}

fn search() -> PeakSettings {
    PeakSettings {
        band: Band {
            low: hz_to_rad_s(2605.0),
            high: hz_to_rad_s(2635.0),
        },
        frequency_tolerance: 1e-7,
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
fn report(name: &str, peaks: &[&LevelOutcome]) {
    let mut factors: Vec<usize> = peaks.iter().map(|p| p.factorizations).collect();
    factors.sort_unstable();
    let failed = peaks.iter().filter(|p| !p.status.has_solution()).count();
    println!(
        "{name}: factorisations median {}, 95 % {}, most {}; {failed} of {} not solved",
        rank(&factors, 0.5),
        rank(&factors, 0.95),
        rank(&factors, 1.0),
        peaks.len()
    );
}

fn parts() {
    println!("pairs  H    compliance  contact  motion  Jacobian and two solves (ms, fastest of 5)");
    for (grid, highest) in [
        ([3, 5], 3),
        ([3, 5], 5),
        ([3, 5], 9),
        ([3, 5], 21),
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
        let at = Iterate::new(&balance, solution.point());
        let (r, omega, force) = (&at.point.r, at.point.omega, &at.contact.force);
        let times = [
            milliseconds(5, || drop(balance.compliance(omega))),
            milliseconds(5, || {
                drop(balance.contact(r, Want::ForcesAndTangents, Accuracy::Full))
            }),
            milliseconds(5, || drop(balance.motion(&at.compliance, 20.0, r, force))),
            milliseconds(2, || {
                let jacobian = at.jacobian(&balance);
                drop(jacobian.solve(&at.residual));
                drop(at.frequency_rate(&balance, &jacobian));
            }),
        ];
        let [compliance, contact, motion, jacobian] = times;
        println!(
            "{:5} {highest:2}  {compliance:10.3} {contact:8.3} {motion:7.3} {jacobian:9.3}",
            2 * grid[0] * grid[1]
        );
    }
}

fn study() {
    let rig = Rig::new([3, 5]);
    let (design, settings) = (design(2026), settings(5, None));
    let ensemble = rig.ensemble(&design, &LEVELS, &settings);
    for samples in [64, 256, 1024] {
        let (seconds, outcomes) = processor_time(|| ensemble.run(samples, || {}));
        let peaks: Vec<&LevelOutcome> = outcomes.iter().flat_map(|o| &o.levels).collect();
        println!(
            "{samples} samples x {} levels: {:.1} peaks per processor second",
            LEVELS.len(),
            peaks.len() as f64 / seconds
        );
        report("all", &peaks);
        if samples == 1024 {
            for (i, level) in LEVELS.iter().enumerate() {
                let peaks: Vec<_> = outcomes.iter().map(|o| &o.levels[i]).collect();
                report(&format!("{level} N"), &peaks);
            }
        }
    }
}

fn sweep() {
    let rig = Rig::new([3, 5]);
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
                at_frequencies(
                    &problem,
                    &settings,
                    solution.level,
                    &omega,
                    SweepDirection::Upward,
                )
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
    let rig = Rig::new([3, 5]);
    let (design, settings) = (design(7), settings(5, None));
    let samples = 48;
    let (fast_seconds, fast) = processor_time(|| {
        rig.ensemble(&design, &LEVELS, &settings)
            .run(samples, || {})
    });
    let alone = |outcome: &SampleOutcome| {
        let problem = rig.problem(outcome.inputs[0], outcome.inputs[1]);
        track_peaks(&problem, &settings, search(), &LEVELS).expect("modes")
    };
    let (slow_seconds, slow) = processor_time(|| fast.iter().map(alone).collect::<Vec<_>>());
    println!(
        "{samples} samples: {fast_seconds:.1} s from the atlas, {slow_seconds:.1} s each alone"
    );
    let (mut compared, mut worst) = (0, [0.0f64; 2]);
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
            compared += 1;
            worst = [worst[0].max(errors[0]), worst[1].max(errors[1])];
        }
    }
    println!(
        "{compared} peaks: amplitude {:.1e}, frequency {:.1e}",
        worst[0], worst[1]
    );
}

fn harmonics() {
    let rig = Rig::new([3, 5]);
    let design = design(11);
    let levels = [1.0, 5.0, 20.0, 100.0];
    for highest in [5, 9, 13, 21] {
        let settings = settings(highest, None);
        let ensemble = rig.ensemble(&design, &levels, &settings);
        let (seconds, outcomes) = processor_time(|| ensemble.run(32, || {}));
        let peaks: Vec<&LevelOutcome> = outcomes.iter().flat_map(|o| &o.levels).collect();
        println!(
            "H = {highest}: {:.2} peaks per processor second",
            peaks.len() as f64 / seconds
        );
        report("all", &peaks);
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
            events: Events::Interpolated,
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
    let [low, high] = study.frequency.band;
    let ensemble = Ensemble {
        linear: &linear,
        contacts: &model.contacts,
        design: &design,
        levels: &[0.5],
        settings: &settings,
        peak: PeakSettings {
            band: Band { low, high },
            frequency_tolerance: 1e-6,
        },
        curve_samples: 0,
        backend: Backend::Cpu,
    };
    let samples = 256;
    let (seconds, outcomes) = processor_time(|| ensemble.run(samples, || {}));
    let peaks: Vec<&LevelOutcome> = outcomes.iter().flat_map(|o| &o.levels).collect();
    println!(
        "{:.4} processor seconds per peak",
        seconds / peaks.len() as f64
    );
    report("all", &peaks);
}
