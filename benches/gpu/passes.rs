//! Time of the passes of an iteration of lanes.

use super::lanes::study_of_lanes;
use super::roofline::Peak;
use microslip::aft::AftPlan;
use microslip::contact::{ContactParameters, FrictionLaw};
use microslip::ensemble::Ensemble;
use microslip::gpu::{Device, GpuError};
use microslip::hb::Problem;
use microslip::hb::equations::balance::balance_on;
use microslip::hb::equations::free::{FreeBalance, StaticReference};
use microslip::hb::peak::anchored::AnchorInverse;
use microslip::hb::peak::track::track_peaks;
use microslip::lockstep::batch::LaneBatch;
use microslip::lockstep::kernels::LaneKernels;
use microslip::lockstep::system::LaneSystem;
use std::time::Instant;

/// Highest harmonics, and those on a software adapter.
const HARMONICS: [usize; 3] = [5, 8, 21];
const FEW_HARMONICS: [usize; 1] = [3];
/// Excitation (N) at which contacts stick, slip and lift off.
const LEVEL: f64 = 20.0;
/// Iterations of which the fastest counts.
const RUNS: usize = 3;

/// Times of the passes of an iteration of `lanes` lanes around one peak.
pub(super) fn passes(device: &Device, peak: &Peak, law: FrictionLaw, lanes: usize) {
    let harmonics: &[usize] = match device.adapter.is_hardware() {
        true => &HARMONICS,
        false => &FEW_HARMONICS,
    };
    for &highest in harmonics {
        let mut study = study_of_lanes(law, highest);
        study.levels = vec![LEVEL];
        let prepared = study.prepared().expect("the default model");
        println!("\npasses, {law:?} law, H = {highest}, times of one iteration");
        if let Err(error) = on_ensemble(device, peak, &prepared.ensemble(None), lanes) {
            println!("   {error}");
        }
    }
}

fn on_ensemble(
    device: &Device,
    peak: &Peak,
    ensemble: &Ensemble<'_>,
    lanes: usize,
) -> Result<(), GpuError> {
    let settings = ensemble.settings;
    let problem = |by: f64| {
        let softer = |c: &ContactParameters<f64>| ContactParameters {
            k_n: by * c.k_n,
            k_t: c.k_t.map(|k| by * k),
            ..*c
        };
        let contacts = ensemble.contacts.iter().map(softer).collect();
        Problem::new(ensemble.linear, contacts, 1.0, settings.anchor).expect("good contacts")
    };
    let nominal = problem(1.0);
    let reference = StaticReference::new(&nominal);
    let harmonics = || settings.harmonics.clone();
    let balance = balance_on(&nominal, harmonics(), settings);
    let found = track_peaks(&nominal, settings, ensemble.peak, &[LEVEL]).expect("a peak");
    let point = found[0].solution.as_ref().expect("a peak").point();
    let clock = Instant::now();
    let inverse = AnchorInverse::inverse_at(&reference, &balance, &point).expect("an inverse");
    let of_inverse = clock.elapsed().as_secs_f64();
    let free = FreeBalance::new(&balance, &reference).expect("a free form");
    let system = LaneSystem::new(&free, point.omega).expect("a first harmonic");
    let all: Vec<_> = (0..lanes)
        .map(|i| {
            let problem = problem(1.0 + 0.05 * i as f64 / lanes as f64);
            let balance = balance_on(&problem, harmonics(), settings);
            let free = FreeBalance::new(&balance, &reference).expect("a free form");
            (system.lane(&free, &point), 0)
        })
        .collect();
    let clock = Instant::now();
    let plan = AftPlan::new(&settings.harmonics, settings.aft);
    let kernels = LaneKernels::new(device, system, &plan, None)?;
    let of_compiler = clock.elapsed().as_secs_f64();
    let lanes = lanes.min(kernels.most_lanes(device) / 2);
    println!(
        "   {} unknowns; inverse {of_inverse:.2} s, kernels {of_compiler:.1} s; {lanes} lanes",
        point.r.len(),
    );
    for arrays in ["new", "used"] {
        let clock = Instant::now();
        let mut batch = kernels.begin(device, &all[..lanes], &[&inverse])?;
        let begun = clock.elapsed().as_secs_f64();
        batch.step(&vec![None; lanes])?;
        println!(
            "   upload to {arrays} arrays {begun:.4} s, first iteration until {:.4} s",
            clock.elapsed().as_secs_f64()
        );
    }
    let mut batch = kernels.begin(device, &all[..lanes], &[&inverse])?;
    times(&mut batch, peak, lanes)
}

fn times(batch: &mut LaneBatch<'_>, peak: &Peak, lanes: usize) -> Result<(), GpuError> {
    let mut fastest = f64::INFINITY;
    for _ in 0..=RUNS {
        let clock = Instant::now();
        batch.step(&vec![None; lanes])?;
        fastest = fastest.min(clock.elapsed().as_secs_f64());
    }
    let clock = Instant::now();
    batch.points()?;
    println!(
        "   iteration {:.3} ms, {:.0} thousand lanes per second; points read in {:.4} s",
        1e3 * fastest,
        1e-3 * lanes as f64 / fastest,
        clock.elapsed().as_secs_f64()
    );
    let Some(times) = batch.pass_times()? else {
        println!("   no timestamps");
        return Ok(());
    };
    let sum: f64 = times.values().map(|pass| pass.seconds).sum();
    let mut passes: Vec<_> = times.into_iter().collect();
    passes.sort_by(|(_, a), (_, b)| b.seconds.total_cmp(&a.seconds));
    for (name, pass) in passes {
        let share = 100.0 * pass.seconds / sum;
        let of_peak = 100.0 * pass.operations / pass.seconds / peak.flops;
        println!(
            "   {name:>24} {:>3} times {:>8.3} ms {share:>5.1} %; {of_peak:>5.1} % of the peak",
            pass.uses,
            1e3 * pass.seconds
        );
    }
    println!("   {:>24} {:>18.3} ms", "all", 1e3 * sum);
    Ok(())
}
