//! Other routes to the same peaks: the continuation around a peak, and each sample alone.

use crate::clock::processor_time;
use crate::rates::measured;
use crate::rig::{LEVELS, Rig, design, search, settings};
use microslip::ensemble::outcome::SampleOutcome;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::response::values::{SlowSweep, at_frequencies};
use microslip::hb::structure::resonance::{Band, linear_resonance};
use microslip::units::rad_s_to_hz;
use rayon::prelude::*;

pub(crate) fn sweep() {
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

pub(crate) fn slow_path() {
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
