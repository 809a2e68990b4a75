//! Solves that cannot succeed end with a status.

use super::invariants::with_plane;
use super::models::plane;
use crate::response::{at_frequencies, dense_curve};
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::newton::{Condition, Point, solve};
use microslip::hb::peak::search::{PeakSettings, find_peak};
use microslip::hb::peak::track::track_peaks;
use microslip::hb::response::values::{self, SlowSweep};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{Balance, LinearModel, Problem, ProblemError, SliderAnchor, Status};
use std::f64::consts::TAU;

fn band(low: f64, high: f64) -> Band {
    Band {
        low: low * TAU,
        high: high * TAU,
    }
}

fn peak(band: Band) -> PeakSettings {
    PeakSettings {
        band,
        frequency_tolerance: 1e-7,
    }
}

/// One iteration is not enough where contacts slip, and enough where they stick.
/// Seen to fail with: 40 times the iterations allowed.
#[test]
fn too_few_iterations_are_a_status() {
    with_plane(|problem, mut settings| {
        settings.newton.max_iterations = 1;
        let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
        let one = |level: f64| {
            let start = Point::stuck(&balance, 400.0 * TAU, level);
            solve(&balance, start, Condition::FixedFrequency, settings.newton)
        };
        let slipping = one(20.0).expect_err("one iteration from the stuck solution");
        let iterations = problem.effort.count().iterations;
        assert_eq!((slipping, iterations), (Status::MaxIterations, 1));
        assert!(one(0.1).is_ok(), "nothing slips");
    });
}

/// One iteration per step: a curve gives up early, and a sweep finds a solution or gives up. Seen to fail without the
/// pace of a sweep: 8623 points on the curve.
#[test]
fn hopeless_walks_end_early() {
    with_plane(|problem, mut settings| {
        settings.newton.max_iterations = 1;
        let response = dense_curve(problem, &settings, 40.0, band(330.0, 430.0));
        let curve = response.solutions;
        let ends = (curve.iter().filter(|s| !s.status.has_solution())).map(|s| s.status);
        let ends: Vec<Status> = ends.collect();
        let most = response.work.iter().map(|work| work.iterations).max();
        println!("{} points, {ends:?}, {most:?}", curve.len());
        assert_eq!((ends[0], ends.len()), (Status::StepTooSmall, 2));
        assert!(curve.len() <= 400, "{} points", curve.len());
        assert!(most <= Some(1000), "{most:?} iterations");
        let sweep = SlowSweep {
            band: band(335.0, 400.0),
            direction: SweepDirection::Upward,
            omega: &[335.0 * TAU, 400.0 * TAU],
        };
        let found = values::at_frequencies(problem, &settings, 40.0, sweep, |_| ());
        for (found, work) in found.solutions.iter().zip(&found.work) {
            let iterations = work.iterations;
            println!("{:?}, {iterations} iterations", found.status);
            assert!(iterations <= 2000, "{iterations} iterations");
        }
    });
}

/// Each level has a budget of its own, and what is found within it stays.
/// Seen to fail without a check of the budget in `newton`: the slipping level is found with 43 iterations.
#[test]
fn a_spent_budget_is_a_status() {
    with_plane(|problem, mut settings| {
        settings.newton.budget = 20;
        let levels = [0.1, 40.0, 0.2];
        let peaks = track_peaks(problem, &settings, peak(band(300.0, 450.0)), &levels);
        let ends = peaks.expect("modes").into_iter();
        let ends: Vec<_> = ends.map(|p| (p.status, p.count.iterations)).collect();
        println!("{ends:?}");
        assert_eq!(ends[0].0, Status::Converged);
        assert_eq!(ends[1].0, Status::BudgetSpent);
        assert!((20..25).contains(&ends[1].1), "{ends:?}");
    });
}

/// In frequency, level or start. Seen to hang without the check of the levels in `track`, and to
/// fail without the check of the residual in `newton`.
#[test]
fn numbers_that_are_none_are_a_status() {
    with_plane(|problem, settings| {
        let nan = f64::NAN;
        for (level, omega) in [
            (nan, 400.0 * TAU),
            (20.0, nan),
            (f64::INFINITY, 400.0 * TAU),
        ] {
            let found =
                &at_frequencies(problem, &settings, level, &[omega], SweepDirection::Upward)[0];
            assert_eq!(found.status, Status::NonFinite, "{level} {omega}");
        }
        let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
        let start = Point::stuck(&balance, 400.0 * TAU, 20.0);
        for i in [0, balance.layout.n_relative(), start.r.len() - 1] {
            let mut spoiled = start.clone();
            spoiled.r[i] = nan;
            let end = solve(
                &balance,
                spoiled,
                Condition::FixedFrequency,
                settings.newton,
            );
            assert_eq!(end.expect_err("no number"), Status::NonFinite, "entry {i}");
        }
        let levels = [nan, -1.0, 0.0, f64::INFINITY, 10.0];
        let peaks = track_peaks(problem, &settings, peak(band(300.0, 450.0)), &levels);
        let statuses: Vec<Status> = peaks.expect("modes").iter().map(|p| p.status).collect();
        assert_eq!(statuses[..4], [Status::NonFinite; 4]);
        assert_eq!(
            statuses[4],
            Status::Converged,
            "the bad levels spoil nothing"
        );
    });
}

/// Not a number and infinity in every parameter of one pair. Seen to fail without the check: a friction coefficient
/// that is not a number sticks.
#[test]
fn contacts_that_are_no_numbers_are_refused() {
    let case = plane(-1.0);
    let linear = LinearModel::new(&case.model).expect("definite");
    for bad in [f64::NAN, f64::INFINITY] {
        for parameter in 0..5 {
            let mut contacts = case.contacts.clone();
            let c = &mut contacts[1];
            let [a, b] = &mut c.k_t;
            *[&mut c.k_n, a, b, &mut c.mu, &mut c.n_0][parameter] = bad;
            let refused = Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded);
            let expected = ProblemError::NotFinite { pair: 1 };
            assert_eq!(refused.err(), Some(expected), "{parameter} {bad}");
        }
    }
}

/// No natural frequency of the stuck structure in the band, and a peak that leaves the band.
/// Seen to fail with: the band not checked in the search.
#[test]
fn bands_without_peak_are_a_status() {
    with_plane(|problem, settings| {
        let empty = peak(band(500.0, 600.0));
        for found in track_peaks(problem, &settings, empty, &[1.0, 20.0]).expect("modes") {
            assert_eq!(found.status, Status::NoPeakInBand);
            assert!(found.solution.is_none(), "no solution");
        }
        let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
        let start = Point::stuck(&balance, 390.0 * TAU, 1.0);
        let fixed = Condition::FixedFrequency;
        let iterate = solve(&balance, start, fixed, settings.newton).expect("stuck");
        let narrow = peak(band(385.0, 395.0));
        let end = find_peak(&balance, iterate, narrow, settings.newton);
        assert_eq!(end.err(), Some(Status::NoPeakInBand));
    });
}
