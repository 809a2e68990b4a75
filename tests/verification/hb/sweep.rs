//! Slow sweeps against the continuous curve, where several solutions exist.

use super::invariants::with_plane;
use super::polyline::{distance, half_width, points};
use crate::response::over_band;
use microslip::contact::Events;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::response::forced_response::{self, CurveSettings, Largest, PLOT_ERROR};
use microslip::hb::response::values::{SlowSweep, at_frequencies};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{HbSettings, LinearModel, Problem, Solution, Status};
use microslip::study::Study;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::path::Path;

fn band(low: f64, high: f64) -> Band {
    Band {
        low: low * TAU,
        high: high * TAU,
    }
}

/// The reference problem of two blades and a strip, both blades excited in phase.
fn with_in_phase(visit: impl FnOnce(&Problem<'_>, &HbSettings)) {
    let file = Path::new("tests/reference/blades-strip-oop/study.toml");
    let study = Study::read(file).expect("a study");
    let built = study.build_model().expect("a model");
    let mut model = built.reduced;
    model.cosine_force.iter_mut().for_each(|f| *f = f.abs());
    let linear = LinearModel::new(&model).expect("definite");
    let anchor = study.solver.anchor;
    let problem = Problem::new(&linear, built.contacts, 1.0, anchor).expect("held");
    visit(&problem, &study.solver);
}

/// Amplitudes at `omega` along the curve, each with whether the frequency rises there.
fn crossings(curve: &[Solution], omega: f64) -> Vec<(f64, bool)> {
    (curve.windows(2))
        .filter(|w| (w[0].omega - omega) * (w[1].omega - omega) <= 0.0)
        .map(|w| {
            let share = (omega - w[0].omega) / (w[1].omega - w[0].omega);
            let [a, b] = [w[0].amplitude(0), w[1].amplitude(0)];
            (a + share * (b - a), w[1].omega > w[0].omega)
        })
        .collect()
}

/// What a sweep meets at `omega`: the first crossing along the curve. Legs between folds alternate between
/// stable and unstable ones, and it is a leg on which the frequency moves as in the sweep.
fn met(curve: &[Solution], omega: f64, direction: SweepDirection) -> f64 {
    let along = crossings(curve, omega);
    let (amplitude, rises) = match direction {
        SweepDirection::Upward => along.first(),
        SweepDirection::Downward => along.last(),
    }
    .expect("on the curve");
    assert!(*rises, "a leg on which the frequency rises");
    *amplitude
}

/// The curve of the reference problem in phase folds over at 0.2 N. At 288.6496 Hz it has three solutions (given with the
/// problem); a frequency alone, with one neighbour, with three and with fifty has one answer to the last digit, on the leg
/// of the curve that a sweep reaches. Seen to fail with sweeps that begin near the first frequency listed: downward
/// 5.52e-5 m alone and with one neighbour, 2.34e-4 m with three.
#[test]
fn what_is_listed_does_not_change_what_a_sweep_meets() {
    let (band, level) = (band(284.0, 292.0), 0.2);
    with_in_phase(|problem, settings| {
        let curve = over_band(problem, settings, level, band);
        let at = 288.6496 * TAU;
        let all: Vec<f64> = crossings(&curve, at).iter().map(|c| c.0).collect();
        println!("{} points, at 288.6496 Hz {all:?}", curve.len());
        assert_eq!(all.len(), 3, "three solutions");
        // the upper fold is near, and its place depends on the discretisation
        for (found, known) in all.iter().zip([5.52e-5, 2.22e-4, 2.349e-4]) {
            assert!((found / known - 1.0).abs() < 4e-2, "{found} {known}");
        }
        let fifty: Vec<f64> = (1..50).map(|i| 284.0 + 8.0 * f64::from(i) / 50.0).collect();
        for direction in [SweepDirection::Upward, SweepDirection::Downward] {
            let answer = |hertz: &[f64]| {
                let mut omega: Vec<f64> = hertz.iter().map(|f| f * TAU).collect();
                omega.push(at);
                omega.sort_by(f64::total_cmp);
                let sweep = SlowSweep {
                    band,
                    direction,
                    omega: &omega,
                };
                let response = at_frequencies(problem, settings, level, sweep, |_| ());
                assert_eq!(response.gap, None, "the whole band");
                for solution in &response.solutions {
                    let (found, expected) = (
                        solution.amplitude(0),
                        met(&curve, solution.omega, direction),
                    );
                    let hertz = solution.omega / TAU;
                    println!("{direction:?} {hertz:.4} Hz: {found:.5e}, curve {expected:.5e}");
                    assert_eq!(solution.status, Status::Converged, "{hertz} Hz");
                    assert!((found / expected - 1.0).abs() < 1e-3, "{hertz} Hz");
                }
                let here = omega.iter().position(|omega| *omega == at).expect("listed");
                response.solutions[here].responses.clone()
            };
            let alone = answer(&[]);
            assert_eq!(alone, answer(&[289.0]), "{direction:?}, one neighbour");
            assert_eq!(alone, answer(&[287.0, 288.0, 290.0]), "three");
            assert_eq!(alone, answer(&fifty), "fifty");
        }
    });
}

/// Straight lines between the solutions of a curve miss a dense curve by no more than promised, with a third of its
/// solutions (two fifths where events are located), and its largest amplitude is the top. Seen to fail at 1 N, where the pairs begin to slip: without added
/// solutions by 2.2e-2, and by 1.07e-2 with half of a step's length given to its second half, which a corner makes longer;
/// and at 2 N by 0.48 with steps that may lead far from their prediction: one jumped over the resonance.
#[test]
fn curves_are_as_close_together_as_a_picture_needs() {
    with_plane(|problem, mut settings| {
        for events in [Events::Interpolated, Events::Located] {
            settings.aft.events = events;
            for level in [1.0, 2.0, 20.0, 40.0] {
                let band = band(320.0, 450.0);
                let picture = CurveSettings::for_plot(band);
                let thin = forced_response::over_band(problem, &settings, level, picture, |_| ());
                let dense = over_band(problem, &settings, level, band);
                let solved = thin.solutions.iter().all(|s| s.status.has_solution());
                assert!(solved && thin.gap.is_none(), "{level} N");
                let (peak, what) = thin.largest(band).expect("solved");
                assert_eq!(what, Largest::Maximum, "{level} N");
                let top = peak.amplitude(0);
                let scale = [half_width(&dense, top), top];
                let missed = distance(&points(&dense, scale), &points(&thin.solutions, scale));
                let [n, many] = [thin.solutions.len(), dense.len()];
                println!("{events:?}, {level} N: {n} of {many} points, {missed:.1e} away");
                assert!(missed < PLOT_ERROR, "{level} N: {missed:e}");
                let share = n as f64 / many as f64;
                let is_ragged = events != Events::Located;
                assert!(share < if is_ragged { 1.0 / 3.0 } else { 0.4 }, "{share}");
                let highest = dense.iter().map(|s| s.amplitude(0)).fold(0.0, f64::max);
                // the amplitude is ragged unless events are located
                let below = if events == Events::Located {
                    1e-9
                } else {
                    1e-3
                };
                let over = top / highest - 1.0;
                assert!((-below..1e-4).contains(&over), "{level} N: {over:e}");
            }
        }
    });
}

/// With a budget of 70 Newton iterations no sweep gets through: the response says from where to where nothing is known, and no
/// amplitude of it passes for a peak. A value that the opposite sweep answers leaves nothing open.
#[test]
fn a_response_with_a_gap_says_so() {
    with_plane(|problem, mut settings| {
        settings.newton.budget = 70;
        let band = band(330.0, 430.0);
        let picture = CurveSettings::for_plot(band);
        let curve = forced_response::over_band(problem, &settings, 40.0, picture, |_| ());
        let omega: Vec<f64> = (0..9)
            .map(|i| (335.0 + 10.0 * f64::from(i)) * TAU)
            .collect();
        let sweep = SlowSweep {
            band,
            direction: SweepDirection::Downward,
            omega: &omega,
        };
        let values = at_frequencies(problem, &settings, 40.0, sweep, |_| ());
        for response in [&curve, &values] {
            let gap = response.gap.expect("a gap");
            println!("{:?}", gap);
            assert_eq!(gap.below.status, Status::BudgetSpent);
            assert_eq!(gap.above.status, Status::BudgetSpent);
            assert!(band.low < gap.below.omega && gap.below.omega < gap.above.omega);
            assert!(gap.above.omega <= band.high);
            let (_, what) = response.largest(band).expect("both ends are solved");
            assert_eq!(what, Largest::OfPart);
        }
        // the sweep up had passed the fold at 360.3 Hz when it stopped at 356.3 Hz; a sweep stops where it was furthest
        let [by_curve, gap] = [&curve, &values].map(|response| response.gap.expect("a gap"));
        let way_up = (curve.solutions.iter()).take_while(|s| s.status.has_solution());
        let furthest = way_up.map(|s| s.omega).fold(0.0, f64::max);
        assert!(furthest > by_curve.below.omega, "{furthest}");
        assert!((gap.below.omega / furthest - 1.0).abs() < 1e-3);
        for solution in &curve.solutions {
            let inside = furthest < solution.omega && solution.omega < by_curve.above.omega;
            assert!(!inside || !solution.status.has_solution(), "in the gap");
        }
        for solution in &values.solutions {
            let inside = gap.below.omega < solution.omega && solution.omega < gap.above.omega;
            assert!(!inside || !solution.status.has_solution(), "in the gap");
        }
        let near = [0.5 * (band.low + gap.below.omega)];
        let sweep = SlowSweep {
            omega: &near,
            ..sweep
        };
        let answered = at_frequencies(problem, &settings, 40.0, sweep, |_| ());
        let gap = answered.gap.expect("the sweep did not get there");
        assert!(gap.is_answered(), "{gap:?}");
        assert_eq!(gap.below.status, Status::Converged);
        assert_eq!(answered.solutions[0].status, Status::Converged);
        let (_, what) = answered.largest(band).expect("solved");
        assert_eq!(what, Largest::AtEdge, "the only value");
        let [first, last] = [0, curve.solutions.len() - 1].map(|i| &curve.solutions[i]);
        assert_eq!([first.omega, last.omega], [band.low, band.high]);
        assert!(first.status.has_solution(), "{:?}", first.status);
    });
}

/// A band below the resonance ends on the flank.
#[test]
fn the_edge_of_a_band_is_no_peak() {
    with_plane(|problem, settings| {
        for (low, high, expected) in [
            (330.0, 380.0, Largest::AtEdge),
            (330.0, 440.0, Largest::Maximum),
        ] {
            let band = band(low, high);
            let picture = CurveSettings::for_plot(band);
            let curve = forced_response::over_band(problem, &settings, 1.0, picture, |_| ());
            let (largest, what) = curve.largest(band).expect("solved");
            println!("{:.3} Hz {what:?}", largest.omega / TAU);
            assert_eq!((what, curve.gap), (expected, None));
            if what == Largest::AtEdge {
                assert_eq!(largest.omega, band.high);
            }
        }
    });
}

/// The reference problem with small friction coefficients at 0.5 N, where almost all of its 16 pairs slip and events at samples leave
/// the branch ragged: every frequency of the list is solved. Seen to fail at 315 Hz (step-too-small) where a frequency between
/// two solutions of the sweep was left alone once it could not be located on the way from one to the other, on a processor without
/// AVX-512 from 314.5 to 317.5 Hz where a solution had to be nearer to the ends of the step than the step is long along its tangent, and
/// at 307 Hz with the second coefficient where a solution to which both ends lead did not count.
#[test]
fn every_frequency_of_a_ragged_branch_is_solved() {
    for (friction, frequencies) in [(1e-2, 278.0..=325.0), (9e-3, 306.0..=308.0)] {
        solve_every_frequency(friction, frequencies);
    }
}

/// All of the 95 frequencies that lie in the range are solved.
fn solve_every_frequency(friction: f64, frequencies: RangeInclusive<f64>) {
    let file = Path::new("tests/reference/blades-strip-oop/study.toml");
    let study = Study::read(file).expect("a study");
    let mut built = study.build_model().expect("a model");
    for pair in &mut built.contacts {
        pair.mu = friction;
    }
    let linear = LinearModel::new(&built.reduced).expect("definite");
    let problem = Problem::new(&linear, built.contacts, 1.0, study.solver.anchor).expect("held");
    let omega: Vec<f64> = (0..95)
        .map(|i| 278.0 + 0.5 * f64::from(i))
        .filter(|frequency| frequencies.contains(frequency))
        .map(|frequency| frequency * TAU)
        .collect();
    let sweep = SlowSweep {
        band: band(278.0, 325.0),
        direction: SweepDirection::Upward,
        omega: &omega,
    };
    let response = at_frequencies(&problem, &study.solver, 0.5, sweep, |_| ());
    let failed = response.solutions.iter();
    let failed = failed.filter(|solution| !solution.status.has_solution());
    let failed: Vec<_> = failed.map(|s| (s.omega / TAU, s.status)).collect();
    assert!(failed.is_empty(), "mu {friction}: {failed:?}");
}
