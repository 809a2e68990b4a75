//! The error alert: what it states against solves with more harmonics.

use super::invariants::settings;
use super::models::{Case, plane};
use crate::response::at_frequencies;
use microslip::contact::{Events, FrictionLaw};
use microslip::ensemble::outcome::LevelOutcome;
use microslip::harmonics::HarmonicSet;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::equations::balance::balance_on;
use microslip::hb::newton::{Condition, Iterate, solve};
use microslip::hb::peak::alert::{AlertSets, step_on};
use microslip::hb::{AlertSettings, LinearModel, Problem, Status};
use microslip::study::Study;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::path::Path;

/// Random states with lift-off.
const STATES: usize = 200;
/// Of them, those that may have a true error above the stated one.
const TOO_LOW: usize = STATES / 100;

const ALERT: AlertSettings = AlertSettings {
    threshold: 0.01,
    highest_harmonic: 10,
    compared_with: 20,
};

/// Stated and true error of one solution.
struct Stated {
    status: Status,
    /// By the alert; infinite where it states none.
    error: f64,
    /// Twice the change by one Newton step onto twice the harmonics.
    by_step: f64,
    /// Change by a solve with twice the harmonics.
    truth: f64,
}

/// The solution at a random point with as many harmonics as the alert asks for, if contacts separate in it and one with
/// twice the harmonics is found next to it.
fn stated(rng: &mut ChaCha8Rng) -> Option<Stated> {
    let scale = 10f64.powf(rng.random_range(-0.7..0.7));
    let mu = rng.random_range(0.1..0.8);
    let phase = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let Case { model, contacts } = plane(phase).with_contacts(scale, mu);
    let mut settings = settings(5, FrictionLaw::Box);
    settings.alert = Some(ALERT);
    settings.aft.events = Events::Located;
    let level = 10f64.powf(rng.random_range(0.7..2.0));
    let omega = [rng.random_range(310.0..430.0) * TAU];

    let linear = LinearModel::new(&model).expect("definite");
    let problem = Problem::new(&linear, contacts, 1.0, settings.anchor).expect("held");
    let upward = SweepDirection::Upward;
    let found = at_frequencies(&problem, &settings, level, &omega, upward).pop()?;
    if !found.status.has_solution() || found.contact.separated == 0.0 {
        return None;
    }
    let few = balance_on(&problem, found.harmonics.clone(), &settings);
    let twice = HarmonicSet::up_to(2 * found.harmonics.highest());
    let twice = balance_on(&problem, twice, &settings);
    let fixed = Condition::FixedFrequency;
    let iterate = Iterate::new(&few, found.point());
    let (step, _) = step_on(&few, &iterate, &twice, fixed);
    let start = found.point().padded(&few, &twice);
    let best = solve(&twice, start, fixed, settings.newton).ok()?;
    Some(Stated {
        status: found.status,
        error: found.truncation_error.unwrap_or(f64::INFINITY),
        by_step: 2.0 * step.abs(),
        truth: (best.response(&twice).norm() / found.amplitude(0) - 1.0).abs(),
    })
}

/// From any first set on, the sets that a solution may come to have one with exactly twice their harmonics. Seen to fail
/// where a solution may have the harmonics of a check: 4 of 200 errors of solutions with 4, 6 and 8 harmonics were too low.
#[test]
fn every_set_has_one_with_twice_its_harmonics() {
    let Case { model, contacts } = plane(1.0);
    let linear = LinearModel::new(&model).expect("definite");
    for first in 1..=9 {
        let mut settings = settings(first, FrictionLaw::Box);
        settings.alert = Some(ALERT);
        let problem = Problem::new(&linear, contacts.clone(), 1.0, settings.anchor).expect("held");
        let sets = AlertSets::new(&problem, &settings.harmonics, &settings).expect("an alert");
        let highest = |i: usize| sets.balance(i).harmonics.highest();
        let mut at = 0;
        loop {
            assert_eq!(highest(sets.twice(at)), 2 * highest(at), "from {first}");
            match sets.above(at, f64::INFINITY).last() {
                Some(&next) => at = next,
                None => break,
            }
        }
        assert_eq!(highest(at), ALERT.highest_harmonic, "from {first}");
    }
}

/// Where the error of the amplitude is the inverse of the harmonics every other set, smaller or larger, tells it exactly. Seen
/// to fail with the share of the other set in place of that of the set itself.
#[test]
fn any_other_set_tells_an_error_that_falls_as_the_inverse_of_the_harmonics() {
    let Case { model, contacts } = plane(1.0);
    let linear = LinearModel::new(&model).expect("definite");
    let mut settings = settings(5, FrictionLaw::Box);
    settings.alert = Some(ALERT);
    let problem = Problem::new(&linear, contacts, 1.0, settings.anchor).expect("held");
    let sets = AlertSets::new(&problem, &settings.harmonics, &settings).expect("an alert");
    let inverse = |i: usize| 1.0 / sets.balance(i).harmonics.highest() as f64;
    for (at, other) in [(0, 1), (1, 0), (1, 2), (2, 0)] {
        let [here, there] = [at, other].map(|i| 1.0 + inverse(i));
        let error = sets.error_by(at, other, there / here - 1.0);
        println!("{at} by {other}: {error}");
        assert!((error / (inverse(at) / here) - 1.0).abs() < 1e-12);
    }
}

/// 200 random states with lift-off: against twice the harmonics the true error is below the stated one in 99 of 100, and no
/// certified one is wrong by more than the threshold. Seen to fail (one certified solution wrong) where harmonics that were
/// seen before certify alone. Twice one Newton step, as the alert once stated where that was small,
/// is too low more often than that, which the test asks for, too.
#[test]
fn stated_errors_are_honest() {
    let mut rng = ChaCha8Rng::seed_from_u64(44);
    let states = std::iter::repeat_with(|| stated(&mut rng)).take(5 * STATES);
    let all: Vec<Stated> = states.flatten().take(STATES).collect();
    // of round-off where nothing changes
    let low = |error: fn(&Stated) -> f64| {
        let low = |s: &&Stated| s.truth > error(s) + 1e-9;
        all.iter().filter(low).count()
    };
    let unknown = all.iter().filter(|s| s.error.is_infinite()).count();
    let of = |status: Status| all.iter().filter(move |s| s.status == status);
    let certified = of(Status::Converged).count();
    let not = of(Status::TruncationAboveThreshold).count();
    let wrong = of(Status::Converged).filter(|s| s.truth > ALERT.threshold);
    let wrong = wrong.count();
    let (by_alert, by_step) = (low(|s| s.error), low(|s| s.by_step));
    println!(
        "{} states, {certified} certified, {not} not, {unknown} unknown; {by_alert} too low, {by_step} by one step; \
         {wrong} certified ones are wrong",
        all.len()
    );
    assert_eq!(all.len(), STATES, "states");
    assert!(certified > 20 && unknown <= TOO_LOW, "the case is gone");
    assert!(by_alert <= TOO_LOW, "{by_alert} too low");
    assert_eq!(wrong, 0, "certified");
    assert!(by_step > TOO_LOW, "the case is gone");
}

/// Of the first sample of the default study at 20 N the amplitude is 3.7 % off on 5 harmonics and on 10, so that twice the
/// harmonics see no error; 20 do, and where a study asks for a comparison with 10 only it is accepted on 5. Seen to fail where twice the
/// harmonics accept alone: 3.7 % off with 0.3 % stated.
#[test]
fn an_error_that_twice_the_harmonics_do_not_see_is_seen() {
    let mut study = Study::read(Path::new("studies/two-blade-strip/study.toml")).expect("a study");
    study.levels = vec![20.0];
    study.output.curve_samples = 0;
    let peak = |study: &Study| {
        let prepared = study.prepared().expect("the rig");
        let outcome = prepared.ensemble(None).run(1, || {}).remove(0);
        outcome.levels[0].peak.expect("a peak")
    };
    let certified = peak(&study);
    let alert = study.solver.alert.as_mut().expect("an alert");
    alert.compared_with = 10;
    let accepted_on_few = peak(&study);
    // the solution on 40 harmonics, raised from that on 5: tracked on 40 it takes ten times as long
    study.solver.alert = Some(AlertSettings {
        threshold: 1e-9,
        highest_harmonic: 40,
        compared_with: 40,
    });
    let on_forty = peak(&study);
    assert_eq!(on_forty.highest_harmonic, 40);
    let truth = on_forty.amplitude_m;
    study.solver.alert = None;
    let mut on = |highest: usize| {
        study.solver.harmonics = HarmonicSet::up_to(highest);
        peak(&study).amplitude_m
    };
    let off = |amplitude: f64| (amplitude / truth - 1.0).abs();
    let [five, ten, error] = [on(5), on(10), certified.amplitude_m].map(off);
    let stated = certified.truncation_error.get().expect("an error");
    let highest = certified.highest_harmonic;
    println!(
        "off by {five:.4} on 5, {ten:.4} on 10, {error:.4} of {stated:.4} stated on {highest}"
    );
    assert!(five > 0.03 && ten > 0.03, "the case is gone");
    assert!(error < stated && stated < 0.01);
    let stated_on_few = accepted_on_few.truncation_error.get().expect("an error");
    assert_eq!(accepted_on_few.highest_harmonic, 5);
    assert!(stated_on_few < 0.01 && off(accepted_on_few.amplitude_m) > 0.03);
}

/// Where the budget ends before a solution is compared with one on many harmonics, two small sets that agree do not certify it: a structure
/// with odd harmonics alone has the same amplitude on 5 and on 6. Seen to fail where any two sets tell the error: 5e-11 is stated where the
/// whole budget finds 2e-5.
#[test]
fn small_sets_that_agree_certify_nothing() {
    let mut study = Study::read(Path::new("studies/own-matrices/study.toml")).expect("a study");
    study.output.curve_samples = 0;
    study.levels = vec![1.0, 5.0, 20.0];
    study.solver.harmonics = HarmonicSet::up_to(1);
    study.solver.alert = Some(AlertSettings {
        threshold: 1e-4,
        highest_harmonic: 56,
        compared_with: 20,
    });
    let peaks = |study: &Study| {
        let prepared = study.prepared().expect("a model");
        let outcomes = prepared.ensemble(None).run(6, || {});
        let levels = outcomes.into_iter().flat_map(|outcome| outcome.levels);
        levels.collect::<Vec<_>>()
    };
    let error = |level: &LevelOutcome| level.peak.and_then(|peak| peak.truncation_error.get());
    let whole = peaks(&study);
    let mut cut = 0;
    for budget in (120..260).step_by(7) {
        study.solver.newton.budget = budget;
        for (found, truth) in peaks(&study).iter().zip(&whole) {
            cut += usize::from(found.status != truth.status);
            if found.status == Status::Converged {
                let (Some(stated), Some(full)) = (error(found), error(truth)) else {
                    panic!("{found:?}: certified without an error");
                };
                assert!(
                    stated > 1e-8 || full < 1e-6,
                    "{budget}: {stated} for {full}"
                );
            }
        }
    }
    assert!(cut > 0, "the case is gone");
}
