//! Peaks, folds and the error alert.

use super::invariants::{Draw, settings, solved};
use super::models::{plane, short, with_problem};
use crate::response::{at_frequencies, over_band};
use faer::prelude::c64;
use microslip::contact::{Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::newton::{Condition, Iterate, Point, solve};
use microslip::hb::peak::alert::{AlertSets, step_on};
use microslip::hb::peak::more_harmonics::highest_on_both_sides;
use microslip::hb::peak::predicted::{PeakPrediction, correct, phase_locked};
use microslip::hb::peak::refine::{RefinementTarget, refined};
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{AlertSettings, Balance, HbSettings, Status};
use std::f64::consts::TAU;

/// Tracked peaks against the top of a finely followed curve in a narrow band around them.
/// Seen to fail with: the maximum of ω|ŷ| in place of |ŷ|.
#[test]
fn tracked_peaks_are_the_tops_of_the_curves() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let mut settings = settings(3, FrictionLaw::Box);
        settings.aft.n_time = 4096;
        let peak = PeakSettings {
            band: Band {
                low: 300.0 * TAU,
                high: 450.0 * TAU,
            },
            frequency_tolerance: 1e-8,
        };
        let levels = [1.0, 10.0, 20.0];
        for found in track_peaks(problem, &settings, peak, &levels).expect("modes") {
            let solution = found.solution.expect("a peak");
            let around = |share: f64| Band {
                low: solution.omega * (1.0 - share),
                high: solution.omega * (1.0 + share),
            };
            let curve: Vec<(f64, f64)> = over_band(problem, &settings, found.level, around(2e-3))
                .iter()
                .map(|s| (s.omega, s.amplitude(0)))
                .collect();
            let highest = curve.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
            let (omega, amplitude) = highest.expect("points");
            let errors = [
                solution.omega / omega - 1.0,
                solution.amplitude(0) / amplitude - 1.0,
            ];
            println!(
                "{} N: {:.4} Hz {:.6e} m, {} points, errors {}",
                found.level,
                solution.omega / TAU,
                solution.amplitude(0),
                curve.len(),
                short(&errors)
            );
            let small = errors[0].abs() < 1e-4 && errors[1].abs() < 1e-6;
            assert!(small, "{errors:?}");
            // The amplitude has a kink where a sample changes its state; so its top is compared point by point.
            for step in [-1e-5, -3e-6, -1e-6, 1e-6, 3e-6, 1e-5] {
                let omega = [solution.omega, solution.omega * (1.0 + step)];
                let near = at_frequencies(
                    problem,
                    &settings,
                    found.level,
                    &omega,
                    SweepDirection::Upward,
                );
                let change = near[1].amplitude(0) / solution.amplitude(0) - 1.0;
                println!("  {step:e}: {change:.1e}");
                assert!(
                    near[1].status == Status::Converged && change < 1e-13,
                    "{change:e}"
                );
            }
        }
    });
}

/// Out of phase at 40 N the blades' curve folds over: the continuation turns back twice and passes the upper branch.
/// Seen to fail with: tangents that always point to higher frequencies.
#[test]
fn the_walk_passes_folds() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let settings = settings(3, FrictionLaw::Box);
        let band = Band {
            low: 320.0 * TAU,
            high: 450.0 * TAU,
        };
        let curve = over_band(problem, &settings, 40.0, band);
        let turns = curve
            .windows(3)
            .filter(|w| (w[1].omega - w[0].omega) * (w[2].omega - w[1].omega) < 0.0)
            .count();
        let last = curve.last().expect("points");
        let worst = curve.iter().fold(0.0, |a: f64, s| a.max(s.residual));
        let crossings: Vec<f64> = curve
            .windows(2)
            .filter(|w| (w[0].omega - 353.0 * TAU) * (w[1].omega - 353.0 * TAU) <= 0.0)
            .map(|w| w[0].amplitude(0))
            .collect();
        println!(
            "{} points, {turns} turns, residual {worst:.1e}, at 353 Hz {crossings:?}",
            curve.len()
        );
        assert!(
            curve.iter().all(|s| s.status == Status::Converged),
            "{:?}",
            last.status
        );
        assert!(last.omega >= band.high, "ended at {} Hz", last.omega / TAU);
        assert!(turns >= 2 && crossings.len() >= 3, "{turns} {crossings:?}");
    });
}

/// One Newton step from a solution on `highest` harmonics and true change of the amplitude on 15.
fn truncation(draw: &Draw, highest: usize) -> Option<(f64, f64, bool)> {
    with_problem(&draw.case, |problem| {
        let newton = draw.settings.newton;
        let mut aft = draw.settings.aft;
        aft.n_time = 512;
        let balance = Balance::new(problem, HarmonicSet::up_to(highest), aft);
        let larger = Balance::new(problem, HarmonicSet::up_to(15), aft);
        let fixed = Condition::FixedFrequency;
        let start = Point::stuck(&balance, draw.omega, draw.level);
        let iterate = solve(&balance, start, fixed, newton).ok()?;
        let (estimate, _) = step_on(&balance, &iterate, &larger, fixed);
        let padded = iterate.point.padded(&balance, &larger);
        let better = solve(&larger, padded, fixed, newton).ok()?;
        let ratio = better.response(&larger).norm() / iterate.response(&balance).norm();
        let separated = iterate.contact.counts.iter().any(|s| s.separated > 0);
        Some((estimate.abs(), (ratio - 1.0).abs(), separated))
    })
}

/// Slipping blades in the plane: estimated against true change of the amplitude, within a tenth.
/// Seen to fail with: half of the Newton step.
#[test]
fn a_newton_step_estimates_the_truncation_error_of_slip() {
    for (level, hertz) in [(10.0, 425.0), (10.0, 417.0), (20.0, 400.0)] {
        for highest in [1, 3] {
            let draw = Draw {
                case: plane(-1.0),
                settings: settings(highest, FrictionLaw::Box),
                level,
                omega: hertz * TAU,
            };
            let (estimate, truth, _) = truncation(&draw, highest).expect("solutions");
            println!("{level} N {hertz} Hz H {highest}: {estimate:.3e} true {truth:.3e}");
            assert!((estimate / truth - 1.0).abs() < 0.1, "{estimate} {truth}");
        }
    }
}

/// Random problems: within a factor of three where contacts slip only, and never silent (1 %) when the change is above
/// 2.5 %. Seen to fail with: half of the Newton step.
#[test]
fn a_newton_step_sees_large_truncation_errors() {
    let (mut worst, mut count, mut alarms) = (1.0f64, 0, 0);
    solved(41, 150, |draw, solution| {
        let Some((estimate, truth, separated)) = truncation(draw, solution.harmonics.highest())
        else {
            return;
        };
        if truth > 1e-4 && !separated {
            count += 1;
            worst = worst.max((estimate / truth).max(truth / estimate));
        }
        if truth > 0.025 {
            alarms += 1;
            assert!(estimate > 0.01, "{estimate} {truth}");
        }
    });
    println!("{count} slipping: worst factor {worst:.2}; {alarms} alarms");
    assert!(
        worst < 3.0 && count > 10 && alarms > 5,
        "{worst} {count} {alarms}"
    );
}

/// Solutions on the flanks are no peaks: from there the maximum is found, or nothing. Seen to fail with the first
/// solution near the predicted phase accepted.
#[test]
fn flanks_are_not_taken_for_peaks() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let mut settings = settings(3, FrictionLaw::Box);
        settings.aft.events = Events::Located;
        let peak = PeakSettings {
            band: Band {
                low: 300.0 * TAU,
                high: 450.0 * TAU,
            },
            frequency_tolerance: 1e-7,
        };
        let level = 10.0;
        let top = track_peaks(problem, &settings, peak, &[level]).expect("modes");
        let top = top[0].solution.as_ref().expect("a peak").amplitude(0);
        let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
        let omega: Vec<f64> = (0..12)
            .map(|i| (310.0 + 11.0 * f64::from(i)) * TAU)
            .collect();
        let mut lower = 0;
        for solution in at_frequencies(problem, &settings, level, &omega, SweepDirection::Upward) {
            lower += usize::from(solution.amplitude(0) < 0.9 * top);
            let prediction = PeakPrediction::of(&solution);
            if let Ok(found) = correct(&balance, prediction, peak, settings.newton) {
                let height = found.iterate.response(&balance).norm() / top;
                println!("from {} Hz: {height}", solution.omega / TAU);
                assert!((height - 1.0).abs() < 1e-6, "{height}");
            }
        }
        assert!(lower > 8, "{lower} of 12 on the flanks");
    });
}

/// Band and exactness of the peaks of the plane blades.
const SEARCH: PeakSettings = PeakSettings {
    band: Band {
        low: 300.0 * TAU,
        high: 450.0 * TAU,
    },
    frequency_tolerance: 1e-7,
};

fn located(highest: usize) -> HbSettings {
    let mut settings = settings(highest, FrictionLaw::Box);
    settings.aft.events = Events::Located;
    settings
}

/// Starts around a peak lead to the same frequency, or nowhere. Seen to fail with curvatures from long secants only: a
/// flat top then passes for located where it is not.
#[test]
fn poor_starts_lead_to_the_same_top() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let settings = located(3);
        let tracked = track_peaks(problem, &settings, SEARCH, &[10.0]).expect("modes");
        let top = tracked[0].solution.as_ref().expect("a peak");
        let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
        let mut near = 0;
        for i in 0..200 {
            let (along, across) = (f64::from(i % 20) - 9.5, f64::from(i / 20) - 4.5);
            let mut prediction = PeakPrediction::of(top);
            prediction.point.omega *= 1.0 + 2e-4 * along;
            for (k, r) in prediction.point.r.iter_mut().enumerate() {
                *r *= 1.0 + 0.01 * across * (k as f64).cos();
            }
            if let Ok(found) = correct(&balance, prediction, SEARCH, settings.newton) {
                let error = found.iterate.point.omega / top.omega - 1.0;
                assert!(error.abs() < 2e-7, "start {i}: {error:e}");
                near += 1;
            }
        }
        println!("{near} of 200 starts");
        assert!(near > 150, "{near}");
    });
}

/// The sharpness of a peak is the curvature of ln|ŷ| over the phase, and a start that knows it needs fewer iterations.
/// Seen to fail with: the sign of the growth's change turned round, a step that does not use it.
#[test]
fn sharpness_is_the_curvature_of_the_top() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let settings = located(3);
        let (mut informed, mut ignorant) = (0, 0);
        for tracked in track_peaks(problem, &settings, SEARCH, &[1.0, 5.0, 10.0]).expect("modes") {
            let peak = tracked.solution.expect("a peak");
            let sharpness = peak.sharpness.expect("measured");
            let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
            let height = |phase: f64| {
                let mut beside = PeakPrediction::of(&peak);
                beside.phasor *= c64::from_polar(1.0, phase);
                let locked = phase_locked(&balance, beside, settings.newton);
                locked.expect("close by").response(&balance).norm().ln()
            };
            let step = 0.02;
            let fall = 2.0 * height(0.0) - height(step) - height(-step);
            let expected = fall / (step * step);
            println!("{} N: {sharpness} {expected}", tracked.level);
            assert!(
                (sharpness / expected - 1.0).abs() < 0.01,
                "{sharpness} {expected}"
            );
            for shift in [-2e-4, 2e-4] {
                let work = |sharpness: Option<f64>| {
                    let mut start = PeakPrediction::of(&peak);
                    start.point.omega *= 1.0 + shift;
                    start.sharpness = sharpness;
                    let before = problem.effort.count();
                    correct(&balance, start, SEARCH, settings.newton).expect("close by");
                    problem.effort.count().since(before).iterations
                };
                informed += work(peak.sharpness);
                ignorant += work(None);
            }
        }
        println!("{informed} iterations, {ignorant} without");
        assert!(informed < ignorant, "{informed} {ignorant}");
    });
}

/// A search ends with a step within the tolerance by a growth that is exact enough. Seen to fail with one more step after
/// each.
#[test]
fn exact_steps_are_the_last() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let settings = located(3);
        let tracked = track_peaks(problem, &settings, SEARCH, &[10.0]).expect("modes");
        let top = tracked[0].solution.as_ref().expect("a peak");
        let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
        let mut iterations = 0;
        for shift in [-2e-5, -1e-5, -5e-6, 5e-6, 1e-5, 2e-5] {
            let mut start = PeakPrediction::of(top);
            start.point.omega *= 1.0 + shift;
            let before = problem.effort.count();
            let found = correct(&balance, start, SEARCH, settings.newton).expect("close by");
            let count = problem.effort.count().since(before);
            let error = found.iterate.point.omega / top.omega - 1.0;
            println!("{shift:e}: {count:?} {error:e}");
            assert!(error.abs() < 2e-8, "{shift:e}: {error:e}");
            iterations += count.iterations;
        }
        assert!(iterations <= 30, "{iterations}");
    });
}

/// Peaks on more harmonics than the search uses are tops of their own curve. Seen to fail with peaks left where they are
/// 0.045 rad beside the phase of the top.
#[test]
fn raised_peaks_are_tops() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let settings = located(11);
        for found in track_peaks(problem, &settings, SEARCH, &[10.0, 20.0]).expect("modes") {
            let solution = found.solution.expect("a peak");
            assert_eq!(solution.harmonics.highest(), 11);
            for step in [-1e-5, -1e-6, 1e-6, 1e-5] {
                let omega = [solution.omega, solution.omega * (1.0 + step)];
                let upward = SweepDirection::Upward;
                let near = at_frequencies(problem, &settings, found.level, &omega, upward);
                let change = near[1].amplitude(0) / solution.amplitude(0) - 1.0;
                println!("{} N {step:e}: {change:.1e}", found.level);
                assert!(
                    near[1].status == Status::Converged && change < 0.0,
                    "{change:e}"
                );
            }
        }
    });
}

/// A search from both sides of a peak on few harmonics finds the one on many. Seen to fail with the solutions aside in place of
/// the maxima next to them.
#[test]
fn peaks_on_more_harmonics_are_found_from_aside() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let [few, many] = [1, 9].map(located);
        let top = |settings: &HbSettings| {
            let found = track_peaks(problem, settings, SEARCH, &[20.0]).expect("modes");
            let solution = found.into_iter().next().and_then(|peak| peak.solution);
            solution.expect("a peak")
        };
        let (start, expected) = (top(&few), top(&many));
        let [from, to] = [&few, &many]
            .map(|settings| Balance::new(problem, settings.harmonics.clone(), settings.aft));
        let start = Iterate::new(&from, start.point());
        let before = problem.effort.count();
        let found = highest_on_both_sides(&from, &start, &to, SEARCH, few.newton);
        let count = problem.effort.count().since(before);
        let found = found.expect("a peak").iterate;
        let [frequency, amplitude] = [
            found.point.omega / expected.omega - 1.0,
            found.response(&to).norm() / expected.amplitude(0) - 1.0,
        ];
        println!("{frequency:e} {amplitude:e} {count:?}");
        assert!(frequency.abs() < 1e-7 && amplitude.abs() < 1e-10);
    });
}

/// Where the peak leaves the band with the harmonics that the alert asks for, the one on fewer is kept and says so. Seen
/// to fail with peaks on more harmonics that are not located.
#[test]
fn peaks_not_located_on_more_harmonics_stay_on_fewer() {
    let case = plane(-1.0);
    with_problem(&case, |problem| {
        let mut settings = located(1);
        settings.alert = Some(AlertSettings {
            threshold: 1e-9,
            highest_harmonic: 9,
            compared_with: 20,
        });
        let on_few = HbSettings {
            alert: None,
            ..settings.clone()
        };
        let tracked = track_peaks(problem, &on_few, SEARCH, &[10.0]).expect("modes");
        let few = tracked[0].solution.as_ref().expect("a peak");
        let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
        let refine = |band: Band| {
            let search = PeakSettings { band, ..SEARCH };
            let iterate = Iterate::new(&balance, few.point());
            let sets = AlertSets::new(problem, &settings.harmonics, &settings);
            let (sets, target) = (sets.as_ref(), RefinementTarget::Maximum(search));
            refined(&balance, iterate.into(), sets, target, settings.newton)
        };
        // on 2 harmonics the peak is 5e-7 above that on one, on 3 and more 1.1e-4 below
        for [below, above] in [[1e-7, 1e-7], [5e-5, 3e-7]] {
            let narrow = refine(Band {
                low: few.omega * (1.0 - below),
                high: few.omega * (1.0 + above),
            });
            assert_eq!(narrow.status, Status::TruncationAboveThreshold);
            assert_eq!(narrow.harmonics.highest(), 1);
        }
        let wide = refine(SEARCH.band);
        println!(
            "{} harmonics, {:e}",
            wide.harmonics.highest(),
            wide.omega / few.omega - 1.0
        );
        assert_eq!(wide.harmonics.highest(), 9);
    });
}
