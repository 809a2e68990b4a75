//! Disturbances of a travelling wave: the sectors of a disk one after the other against the whole ring, an ordinary model whose
//! disturbances are marched over a whole period, and against the march of the full equations of the ring.

use super::super::disk::{expanded, sharp};
use super::super::lumped_disk::{contacts, disk, ring, uncoupled};
use super::super::mistuned::{bladed, deviations, mistuned_ring};
use super::disturbed::compare as against_the_march;
use super::raised;
use crate::response::at_frequencies;
use faer::prelude::c64;
use microslip::contact::FrictionLaw;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::newton::{Condition, solve};
use microslip::hb::stability::assessment::{STEPS, Stability, assess, assess_with, by_leading};
use microslip::hb::stability::period_map::{PeriodMap, PeriodicMotion};
use microslip::hb::stability::ring_map::RingMap;
use microslip::hb::structure::mistuned::MistunedRing;
use microslip::hb::{Balance, LinearModel, Problem, SliderAnchor, Solution, Status};
use microslip::model::disk::Disk;
use std::f64::consts::TAU;

/// Steps per period, which 4, 5 and 6 sectors divide.
const EVEN: usize = 240;
/// The same, so short that damping may act in the steps (of sectors) or between them (of the ring): both err by the square of the step.
const SHORT: usize = 4 * EVEN;
/// Excitation levels (N): contacts stick at the lowest and separate at the highest.
const LEVELS: [f64; 4] = [0.5, 30.0, 100.0, 600.0];

fn problem(linear: &LinearModel) -> Problem<'_> {
    let contacts = contacts(linear.n_contacts());
    Problem::new(linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held")
}

fn motion<'a>(of: &'a Solution, relative: &'a [f64]) -> PeriodicMotion<'a> {
    PeriodicMotion {
        harmonics: &of.harmonics,
        relative,
        omega: of.omega,
        law: FrictionLaw::Box,
    }
}

/// Solutions of a sector at some frequencies and all levels.
fn solutions(problem: &Problem<'_>) -> Vec<Solution> {
    let omega = [280.0, 318.0, 330.0, 345.0, 390.0].map(|hertz| TAU * hertz);
    let upward = SweepDirection::Upward;
    let at_level = |level| at_frequencies(problem, &sharp(3), level, &omega, upward);
    let found = LEVELS.into_iter().flat_map(at_level);
    found.filter(|found| found.status.has_solution()).collect()
}

fn map(problem: &Problem<'_>, of: &Solution, n_steps: usize) -> RingMap {
    let ring = problem.model.ring.as_ref().expect("a disk");
    RingMap::new(problem, ring, &motion(of, &of.relative), n_steps).expect("a map")
}

/// Largest distance of one of `these` that is above a half in modulus from the nearest of `those`, over the largest modulus, if that is
/// above 1: rounding of a matrix is a share of its largest entries.
fn distance(these: &[c64], those: &[c64]) -> f64 {
    let largest = these.iter().map(|m| m.norm()).fold(1.0, f64::max);
    let nearest = |m: &c64| {
        let distances = those.iter().map(|other| (other - m).norm());
        distances.fold(f64::INFINITY, f64::min) / largest
    };
    let above = these.iter().filter(|m| m.norm() > 0.5);
    above.map(nearest).fold(0.0, f64::max)
}

/// States seen.
#[derive(Debug, Default)]
struct Seen {
    stuck: usize,
    slip: usize,
    lift: usize,
    unstable: usize,
    /// Distances of all multipliers above a half.
    errors: Vec<f64>,
}

fn compare(disk: &Disk, engine_order: usize, seen: &mut Seen) {
    let sector = LinearModel::travelling_wave(disk, engine_order).expect("definite");
    let whole = LinearModel::new(&ring(disk, engine_order)).expect("definite");
    let (of_sector, of_ring) = (problem(&sector), problem(&whole));
    for found in solutions(&of_sector) {
        let everywhere = expanded(&found, disk.n_sectors, engine_order).r;
        let maps = PeriodMap::all(&of_ring, &motion(&found, &everywhere), SHORT).expect("maps");
        let expected = maps[0].multipliers().expect("eigenvalues");
        let ours = map(&of_sector, &found, SHORT)
            .multipliers()
            .expect("eigenvalues");
        let error = distance(&ours, &expected).max(distance(&expected, &ours));
        let one = motion(&found, &found.relative);
        let stability = assess_with(&of_sector, &one, SHORT).expect("assessed");
        println!(
            "{} sectors, order {engine_order}, {} N at {:.0} Hz: {error:.1e}, {} ({} unstable), {:?}",
            disk.n_sectors,
            found.level,
            found.omega / TAU,
            stability.multiplier,
            stability.n_unstable,
            found.contact,
        );
        seen.errors.push(error);
        seen.stuck += usize::from(found.contact.stick == 1.0);
        seen.slip += usize::from(found.contact.slip > 0.05);
        seen.lift += usize::from(found.contact.separated > 0.05);
        seen.unstable += usize::from(!stability.is_stable());
    }
}

/// Stuck, slipping and lifting: all multipliers above a half, also where several sectors do the same at the same time. One state may have
/// multipliers so close to each other that rounding moves them by more than 1e-6.
///
/// Seen to fail with sectors that do not become others after a lap, with no lag between sectors, with the contact rows of the other
/// direction for waves that go backward, without the memory of sliders that stick, and with sectors left where laps have taken them.
#[test]
fn sectors_have_the_multipliers_of_the_ring() {
    let mut seen = Seen::default();
    for (n_sectors, engine_order) in [
        (2, 1),
        (4, 1),
        (4, 2),
        (4, 4),
        (4, 7),
        (5, 2),
        (6, 1),
        (6, 2),
        (6, 3),
        (6, 4),
    ] {
        compare(&disk(n_sectors), engine_order, &mut seen);
    }
    for engine_order in [1, 3] {
        compare(&uncoupled(6), engine_order, &mut seen);
    }
    let least = [seen.stuck, seen.slip, seen.lift, seen.unstable]
        .into_iter()
        .min();
    let worst = seen.errors.iter().copied().fold(0.0, f64::max);
    let beyond = seen.errors.iter().filter(|error| **error >= 1e-6).count();
    println!(
        "{} stuck, {} slip, {} lift, {} unstable of {}; largest distance {worst:.1e}, {beyond} of 1e-6 or more",
        seen.stuck,
        seen.slip,
        seen.lift,
        seen.unstable,
        seen.errors.len()
    );
    assert!(least >= Some(20), "{least:?}");
    assert!(worst < 2e-5 && beyond <= 1, "{worst:e} {beyond}");
}

/// A mistuned disk has the multipliers of the whole ring with the same stiffness of each blade: stuck, slipping and lifting. Seen to fail with
/// the deviations in the opposite order.
#[test]
fn a_mistuned_disk_has_the_multipliers_of_the_ring() {
    let (mut compared, mut slip, mut lift, mut unstable) = (0, 0, 0, 0);
    for (n_sectors, engine_order, coupled) in [(4, 1, true), (5, 2, false)] {
        let disk = bladed(n_sectors, coupled);
        let deviations = deviations(n_sectors as u64, n_sectors, 0.02);
        let of_disk = MistunedRing::new(&disk, engine_order, 1e6).expect("definite");
        let model = of_disk.linear(&deviations).expect("finite");
        let whole = mistuned_ring(&disk, engine_order, &deviations);
        let whole = LinearModel::new(&whole).expect("definite");
        let problems = [&model, &whole].map(problem);
        for found in solutions(&problems[0]) {
            let one = motion(&found, &found.relative);
            let [ours, expected] = problems.each_ref().map(|problem| {
                let maps = PeriodMap::all(problem, &one, EVEN / 2).expect("maps");
                maps[0].multipliers().expect("eigenvalues")
            });
            let error = distance(&ours, &expected).max(distance(&expected, &ours));
            println!(
                "{n_sectors} sectors, {} N at {:.0} Hz: {error:.1e}, {:?}",
                found.level,
                found.omega / TAU,
                found.contact
            );
            assert!(error < 1e-5, "{error:e}");
            compared += 1;
            slip += usize::from(found.contact.slip > 0.05);
            lift += usize::from(found.contact.separated > 0.05);
            unstable += usize::from(expected.iter().any(|m| m.norm() > 1.01));
        }
    }
    println!("{compared} compared: {slip} slip, {lift} lift, {unstable} unstable");
    assert!([slip, lift, unstable].into_iter().min() >= Some(10));
}

/// A wave of order 2 on 6 sectors is one of order 1 on 3 sectors, twice around. What disturbs 3 sectors disturbs 6, whose multipliers are
/// those and more: there are vibrations that 3 sectors keep and 6 do not (3 of these states). Seen to fail with sectors that lag by
/// their number in place of its product with the engine order.
#[test]
fn more_sectors_have_more_disturbances() {
    let mut only_on_more = 0;
    for (n_sectors, engine_order, times) in [(3, 1, 2), (2, 1, 2), (2, 1, 3), (2, 2, 2)] {
        let few = LinearModel::travelling_wave(&disk(n_sectors), engine_order).expect("definite");
        let more = disk(times * n_sectors);
        let more = LinearModel::travelling_wave(&more, times * engine_order).expect("definite");
        let problems = [problem(&few), problem(&more)];
        for found in solutions(&problems[0]) {
            let maps = problems
                .each_ref()
                .map(|problem| map(problem, &found, EVEN));
            let [some, all] = maps.map(|map| map.multipliers().expect("eigenvalues"));
            let missing = distance(&some, &all);
            assert!(missing < 1e-6, "{missing:e}");
            let one = motion(&found, &found.relative);
            let [few, more] = problems
                .each_ref()
                .map(|problem| assess_with(problem, &one, EVEN).expect("assessed"));
            if few.is_stable() && !more.is_stable() {
                only_on_more += 1;
                println!(
                    "{n_sectors} × {times} sectors, {} N at {:.0} Hz: {} and {}",
                    found.level,
                    found.omega / TAU,
                    few.multiplier,
                    more.multiplier
                );
            }
        }
    }
    println!("{only_on_more} states are unstable on more sectors alone");
    assert!(only_on_more > 0);
}

/// The largest multiplier by what becomes of a few disturbances against all by a dense matrix: a verdict for each of 80 states, right, and the
/// multipliers of unstable ones to 4e-7. Seen to fail without the root of unity of engine orders that divide the sectors.
#[test]
fn a_few_disturbances_have_the_largest_multiplier() {
    let (mut known, mut unknown, mut unstable, mut worst) = (0, 0, 0, 0.0_f64);
    for (disk, engine_order) in [
        (disk(12), 1),
        (disk(12), 4),
        (uncoupled(12), 5),
        (uncoupled(15), 3),
    ] {
        let sector = LinearModel::travelling_wave(&disk, engine_order).expect("definite");
        let problem = problem(&sector);
        for found in solutions(&problem) {
            let map = map(&problem, &found, 120);
            let all = map.multipliers().expect("eigenvalues");
            let neutral = |m: &&c64| (**m - 1.0).norm() > 1e-6;
            let expected = all
                .iter()
                .filter(neutral)
                .map(|m| m.norm())
                .fold(0.0, f64::max);
            let found_here: Option<Stability> = by_leading(&map);
            println!(
                "{} sectors, order {engine_order}, {} N at {:.0} Hz, {} unknowns: {expected} {found_here:?}",
                disk.n_sectors,
                found.level,
                found.omega / TAU,
                map.size()
            );
            let Some(stability) = found_here else {
                unknown += 1;
                continue;
            };
            known += 1;
            unstable += usize::from(!stability.is_stable());
            if expected > 1.01 {
                worst = worst.max((stability.multiplier.norm() - expected).abs() / expected);
                worst = worst.max(distance(&[stability.multiplier], &all));
            }
            assert_eq!(
                stability.is_stable(),
                expected <= 1.01,
                "{expected} {stability:?}"
            );
        }
    }
    println!(
        "{known} known, {unstable} of them unstable, {unknown} unknown, largest error {worst:.1e}"
    );
    assert!(worst < 1e-5, "{worst:e}");
    assert!(unstable >= 20 && unknown == 0, "{unstable} {unknown}");
}

/// Where a disturbance grows the steps are shortened: the growth differs from that with eight times as many steps by less than 5 %. Seen to fail with
/// [`STEPS`] alone, by 28 % in one of these states.
#[test]
fn growth_is_that_of_short_steps() {
    let sector = LinearModel::travelling_wave(&uncoupled(6), 1).expect("definite");
    let problem = problem(&sector);
    let (mut unstable, mut worst) = (0, 0.0_f64);
    for found in solutions(&problem) {
        let one = motion(&found, &found.relative);
        let stability = assess(&problem, &one).expect("assessed");
        if stability.is_stable() {
            continue;
        }
        let finer = assess_with(&problem, &one, 8 * STEPS).expect("assessed");
        let apart = stability.growth() / finer.growth() - 1.0;
        println!(
            "{} N at {:.0} Hz: {:.5} and {:.5}",
            found.level,
            found.omega / TAU,
            stability.growth(),
            finer.growth()
        );
        worst = worst.max(apart.abs());
        unstable += 1;
    }
    assert!(unstable >= 8 && worst < 0.05, "{unstable} {worst:e}");
}

/// The march of the full equations of the ring, stuck, slipping and lifting, one of them unstable. Seen to fail with allowed differences of
/// a tenth of these.
#[test]
fn disturbances_of_the_ring_grow_by_the_multipliers() {
    let (n_sectors, engine_order) = (4, 1);
    let disk = disk(n_sectors);
    let sector = LinearModel::travelling_wave(&disk, engine_order).expect("definite");
    let whole = LinearModel::new(&ring(&disk, engine_order)).expect("definite");
    let (of_sector, of_ring) = (problem(&sector), problem(&whole));
    for (level, hertz, periods, allowed) in STATES {
        let omega = [TAU * hertz];
        let start = at_frequencies(&of_sector, &sharp(5), level, &omega, SweepDirection::Upward);
        let (of_one, iterate) = raised(&of_sector, &start[0], hertz, FrictionLaw::Box);
        let solution = Solution::new(&of_one, &iterate, Status::Converged);
        let start = expanded(&solution, n_sectors, engine_order);
        let aft = sharp(5).aft;
        let balance = Balance::new(&of_ring, solution.harmonics.clone(), aft);
        let held = Condition::FixedFrequency;
        let iterate = solve(&balance, start, held, sharp(5).newton).expect("a solution");
        let one = motion(&solution, &solution.relative);
        let with = |n_steps| assess_with(&of_sector, &one, n_steps).expect("assessed");
        let (ours, finer) = (with(STEPS), with(4 * STEPS));
        let found = against_the_march(&balance, &iterate, periods, ours.multiplier);
        let apart = (found.computed.norm() - ours.multiplier.norm()).abs();
        println!(
            "{level} N at {hertz} Hz: {} of sectors, {} of the ring, {} by the march ({:.1e}), {:.5} with four times the steps, {:?}",
            ours.multiplier,
            found.computed,
            found.marched,
            found.error(),
            finer.multiplier,
            solution.contact
        );
        assert!(apart < 1e-5 * found.computed.norm(), "{apart:e}");
        assert!(found.error() < allowed, "{:e}", found.error());
        let modulus = finer.multiplier.norm() / found.marched.norm() - 1.0;
        assert!(modulus.abs() < 0.05, "{modulus:e}");
    }
}

/// Level (N), frequency (Hz), periods to settle and periods compared, allowed difference: stuck, slipping and, last, lifting. At 30 N and 318
/// Hz the steps turn a high mode by 0.06 per period, and with four times as many the difference is 1.4e-3; the modulus is right with both. At 600 N
/// the modulus is 0.5 % off, the angle 0.08.
const STATES: [(f64, f64, [usize; 2], f64); 7] = [
    (30.0, 330.0, [0, 4], 2e-3),
    (100.0, 345.0, [0, 4], 2e-3),
    (100.0, 330.0, [0, 4], 1e-2),
    (100.0, 390.0, [0, 4], 2e-2),
    (100.0, 318.0, [0, 4], 3e-2),
    (30.0, 318.0, [0, 4], 8e-2),
    (600.0, 280.0, [0, 2], 0.1),
];
