//! A mistuned disk: its limits, and the whole ring with the same deviations of the blades' stiffness, which is not reduced.

use super::disk::sharp;
use super::lumped_disk::{contacts, disk, ring};
use faer::prelude::*;
use microslip::contact::ContactParameters;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::peak::blades::largest_of_blades;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::compliance::Compliance;
use microslip::hb::structure::mistuned::{LinearRing, MistunedRing};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    AlertSettings, HbSettings, LinearModel, PeakRoute, Problem, SliderAnchor, Status,
};
use microslip::model::ReducedModel;
use microslip::model::disk::{CyclicMatrix, Disk};
use microslip::sampling::stream::uniform;
use std::f64::consts::TAU;
use std::time::Duration;

use crate::response::at_frequencies;

/// Degrees of freedom of a sector.
const N: usize = 7;
/// Those of the blade.
const BLADE: [usize; 3] = [0, 1, 2];

/// The lumped disk, whose blade is known.
pub(super) fn bladed(n_sectors: usize, coupled: bool) -> Disk {
    let mut disk = disk(n_sectors);
    if !coupled {
        for matrix in [&mut disk.mass, &mut disk.damping, &mut disk.stiffness] {
            if let CyclicMatrix::Neighbours { own, .. } = matrix {
                *matrix = CyclicMatrix::uncoupled(own.clone());
            }
        }
    }
    let CyclicMatrix::Neighbours { own, .. } = &disk.stiffness else {
        panic!("the lumped disk has matrices of neighbours")
    };
    let of_blade = |i: usize| BLADE.contains(&i);
    disk.blade_stiffness = Some(Mat::from_fn(N, N, |i, j| {
        match of_blade(i) && of_blade(j) {
            true => own[(i, j)],
            false => 0.0,
        }
    }));
    disk
}

/// The whole ring, as it is, with blades of other frequencies.
pub(super) fn mistuned_ring(disk: &Disk, engine_order: usize, deviations: &[f64]) -> ReducedModel {
    let mut whole = ring(disk, engine_order);
    let of_blade = disk.blade_stiffness.as_ref().expect("a blade");
    for (sector, deviation) in deviations.iter().enumerate() {
        let factor = (1.0 + deviation).powi(2) - 1.0;
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            whole.stiffness[(sector * N + i, sector * N + j)] += factor * of_blade[(i, j)];
        }
    }
    whole
}

/// Normal deviations of a sample, by Box and Muller.
pub(super) fn deviations(sample: u64, blades: usize, scatter: f64) -> Vec<f64> {
    let normal = |blade: usize| {
        let [a, b] = [2 * blade, 2 * blade + 1].map(|j| uniform(7, sample, j as u32));
        (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
    };
    (0..blades).map(|blade| scatter * normal(blade)).collect()
}

fn stuck(contacts: &[ContactParameters<f64>]) -> Vec<f64> {
    let k = |of: fn(&ContactParameters<f64>) -> f64| contacts.iter().map(of).collect::<Vec<f64>>();
    [k(|c| c.k_t[0]), k(|c| c.k_t[1]), k(|c| c.k_n)].concat()
}

/// First responses of all blades with stuck or open contacts, per unit level (m); `rows` are their numbers.
fn blades(linear: &LinearModel, k: &[f64], hertz: f64, rows: &[usize]) -> Vec<c64> {
    let at = Compliance::new(linear, k, &[0, 1], TAU * hertz);
    let first = &at.harmonics[0];
    let all = first.part.responses(&first.solve(&first.part.force));
    rows.iter().map(|&row| all[row]).collect()
}

/// Largest difference over the largest of `exact`.
fn error(found: &[c64], exact: &[c64]) -> f64 {
    let largest = exact.iter().map(|y| y.norm()).fold(0.0, f64::max);
    let apart = found.iter().zip(exact).map(|(a, b)| (a - b).norm());
    apart.fold(0.0, f64::max) / largest
}

/// Frequencies (Hz) around the resonances of the blades.
const HERTZ: [f64; 9] = [
    250.0, 300.0, 308.0, 312.0, 316.0, 320.0, 326.0, 345.0, 390.0,
];

/// Adds to the blade's stiffness along z.
fn stiffen(disk: &mut Disk, k: f64) {
    if let CyclicMatrix::Neighbours { own, .. } = &mut disk.stiffness {
        own[(2, 2)] += k;
    }
    if let Some(of_blade) = &mut disk.blade_stiffness {
        of_blade[(2, 2)] += k;
    }
}

/// Largest error of the blades' responses, stuck and open, against the ring that is not reduced; `stiffer` is added along z (N/m).
fn linear_error(coupled: bool, highest_hz: f64, stiffer: f64) -> f64 {
    let mut worst = 0.0_f64;
    for (n_sectors, engine_order) in [(5, 1), (6, 2), (6, 3), (8, 3)] {
        let mut disk = bladed(n_sectors, coupled);
        stiffen(&mut disk, stiffer);
        let model = MistunedRing::new(&disk, engine_order, TAU * highest_hz).expect("definite");
        let deviations = deviations(n_sectors as u64, n_sectors, 0.01);
        let ours = model.linear(&deviations).expect("finite");
        let whole = mistuned_ring(&disk, engine_order, &deviations);
        let whole = LinearModel::new(&whole).expect("definite");
        let own: Vec<usize> = (0..n_sectors).collect();
        let of_ring: Vec<usize> = (0..n_sectors).map(|sector| sector * N).collect();
        let springs = stuck(&contacts(2 * n_sectors));
        for k in [springs.clone(), vec![0.0; springs.len()]] {
            for hertz in HERTZ {
                let [found, exact] = [(&ours, &own), (&whole, &of_ring)]
                    .map(|(linear, rows)| blades(linear, &k, hertz, rows));
                worst = worst.max(error(&found, &exact));
            }
        }
    }
    worst
}

/// Where all modes may combine, and where only contacts couple the sectors, nothing is left out; a subset of the nominal modes up to twice
/// the band has an error of less than 5e-3 (2.4e-3 with a scatter of 1 %, and a mode of the blade left out). Seen to fail with the deviations in the
/// opposite order, and with the factor 1 + δ.
#[test]
fn linear_responses_are_those_of_the_unreduced_ring() {
    let cases = [(true, 1e6, 0.0), (false, 400.0, 0.0), (true, 400.0, 2.7e7)];
    let errors = cases.map(|(coupled, highest, stiffer)| {
        let error = linear_error(coupled, highest, stiffer);
        println!("coupled {coupled}, modes up to 2 × {highest} Hz: {error:.1e}");
        error
    });
    assert!(errors[0] < 1e-9, "all modes: {:e}", errors[0]);
    assert!(errors[1] < 1e-9, "uncoupled: {:e}", errors[1]);
    assert!(errors[2] < 5e-3, "subset: {:e}", errors[2]);
    assert!(errors[2] > 1e-9, "the subset leaves nothing out");
}

fn search() -> PeakSettings {
    PeakSettings {
        band: Band {
            low: 290.0 * TAU,
            high: 400.0 * TAU,
        },
        frequency_tolerance: 1e-9,
    }
}

fn problem(linear: &LinearModel) -> Problem<'_> {
    let contacts = contacts(linear.n_contacts());
    Problem::new(linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held")
}

/// Without deviations every blade has the peak of the tuned disk, stuck, slipping and lifting; the sweep has one harmonic, however many the
/// study has. Seen to fail with a deviation of 1e-3 of every blade.
#[test]
fn without_deviations_it_is_the_tuned_disk() {
    for (n_sectors, engine_order, coupled) in [(4, 1, true), (5, 2, true), (4, 1, false)] {
        let disk = bladed(n_sectors, coupled);
        let sector = LinearModel::travelling_wave(&disk, engine_order).expect("definite");
        let model = MistunedRing::new(&disk, engine_order, search().band.high).expect("definite");
        let linear = model.linear(&vec![0.0; n_sectors]).expect("finite");
        let (sector, whole) = (problem(&sector), problem(&linear));
        let levels = [0.5, 30.0, 38.0];
        let tuned = track_peaks(&sector, &sharp(3), search(), &levels).expect("modes");
        let mut seen = [0.0_f64; 2];
        for tuned in &tuned {
            let tuned = tuned.solution.as_ref().expect("a peak");
            let found = largest_of_blades(&whole, &sharp(3), search(), tuned.level);
            assert_eq!(found.peak.status, Status::Converged);
            let ring = found.peak.solution.expect("a peak");
            assert_eq!(ring.route, Some(PeakRoute::SweptOnOne));
            let errors = [
                (ring.omega / tuned.omega - 1.0).abs(),
                (ring.amplitude(found.blade) / tuned.amplitude(0) - 1.0).abs(),
            ];
            println!(
                "{n_sectors} sectors, {} N: {errors:?} {:?}",
                tuned.level, ring.contact
            );
            assert!(errors[0] < 1e-7 && errors[1] < 1e-6, "{errors:?}");
            seen = [
                seen[0].max(ring.contact.stick),
                seen[1].max(ring.contact.slip),
            ];
        }
        assert!(seen[0] == 1.0 && seen[1] > 0.05, "{seen:?}");
    }
}

/// The time of the error alert of every blade counts to that of the problem. Seen to fail without: it was 0.
#[test]
fn the_alert_of_blades_takes_time() {
    let disk = bladed(4, true);
    let model = MistunedRing::new(&disk, 1, search().band.high).expect("definite");
    let linear = model.linear(&[0.0, 1e-3, -1e-3, 0.0]).expect("finite");
    let whole = problem(&linear);
    let alert = Some(AlertSettings::default());
    let settings = HbSettings { alert, ..sharp(3) };
    let found = largest_of_blades(&whole, &settings, search(), 30.0);
    assert!(found.peak.solution.is_some(), "{:?}", found.peak.status);
    assert!(whole.effort.alert_time() > Duration::ZERO);
}

/// How sectors hang together, and how contacts begin.
#[derive(Debug, Clone, Copy)]
struct Ring {
    coupled: bool,
    tractions: bool,
}

/// Compares solutions of blades that differ with those of the ring that is not reduced; gives the numbers of those that slip and lift off.
fn solutions_of_both(of: Ring) -> [usize; 2] {
    let (n_sectors, engine_order) = (4, 1);
    let disk = bladed(n_sectors, of.coupled);
    let deviations = [0.012, -0.008, 0.003, -0.015];
    // all modes may combine
    let model = MistunedRing::new(&disk, engine_order, TAU * 1e6).expect("definite");
    let ours = model.linear(&deviations).expect("finite");
    let whole = mistuned_ring(&disk, engine_order, &deviations);
    let whole = LinearModel::new(&whole).expect("definite");
    let omega = [312.0, 318.0, 324.0, 345.0].map(|hertz| TAU * hertz);
    let mut seen = [0; 2];
    for level in [0.5, 60.0, 100.0, 200.0, 600.0] {
        let [found, exact] = [&ours, &whole].map(|linear| {
            let mut problem = problem(linear);
            if of.tractions {
                let share = |pair: u64| [0, 1].map(|d| 2.0 * uniform(3, pair, d) - 1.0);
                let shares: Vec<[f64; 2]> = (0..2 * n_sectors as u64).map(share).collect();
                problem.begin_with_tractions(&shares).expect("at rest");
            }
            at_frequencies(&problem, &sharp(3), level, &omega, SweepDirection::Upward)
        });
        for (found, exact) in found.iter().zip(&exact) {
            if !(found.status.has_solution() && exact.status.has_solution()) {
                continue;
            }
            let [ours, theirs]: [Vec<c64>; 2] = [
                (0..n_sectors)
                    .map(|blade| found.first_harmonic(blade))
                    .collect(),
                (0..n_sectors)
                    .map(|blade| exact.first_harmonic(blade * N))
                    .collect(),
            ];
            let error = error(&ours, &theirs);
            println!(
                "{of:?} {level} N at {:.0} Hz: {error:.1e} {:?}",
                found.omega / TAU,
                found.contact
            );
            assert!(error < 1e-8, "{error:e}");
            seen[0] += usize::from(found.contact.slip > 0.05);
            seen[1] += usize::from(found.contact.separated > 0.05);
        }
    }
    seen
}

/// Slip and lift-off with blades that differ, against the ring that is not reduced: they are the same equations where nothing is left out, and where
/// only contacts couple the sectors; so they are with initial tractions that differ from gap to gap. Seen to fail with the deviations in the other
/// order and 1e-3 larger, and with tractions for the reduced ring alone.
#[test]
fn solutions_with_friction_are_those_of_the_unreduced_ring() {
    for (coupled, tractions) in [(false, false), (true, false), (true, true)] {
        let of = Ring { coupled, tractions };
        let [slip, lift] = solutions_of_both(of);
        println!("{of:?}: {slip} slip, {lift} lift off");
        assert!(
            slip >= 3 && lift >= 2,
            "{of:?}: {slip} slip, {lift} lift off"
        );
    }
}

/// The disk with one family of modes in the band, equally damped: what the bound is for.
fn one_family(n_sectors: usize) -> Disk {
    let mut disk = bladed(n_sectors, true);
    let CyclicMatrix::Neighbours { own, .. } = &mut disk.stiffness else {
        panic!("the lumped disk has matrices of neighbours")
    };
    own[(1, 1)] += 6e6;
    own[(2, 2)] += 6e6;
    let CyclicMatrix::Neighbours { own: mass, .. } = &disk.mass else {
        panic!("the lumped disk has matrices of neighbours")
    };
    disk.damping = CyclicMatrix::uncoupled(mass * Scale(8.0));
    disk
}

/// In a band that ends below the resonance of the tuned disk with stuck contacts the amplitude grows towards the end: it has no maximum that
/// others could be compared with.
#[test]
fn an_end_of_the_band_is_no_resonance() {
    let disk = one_family(6).with_stuck_contacts(&contacts(2));
    let largest = |band: Band| {
        let linear = LinearRing::new(&disk, 2, band).expect("definite");
        linear.largest(&[0.0; 6]).expect("finite")
    };
    let peak = largest(search().band).expect("a resonance in the band");
    let below = Band {
        high: 0.9999 * peak.omega,
        ..search().band
    };
    assert_eq!(largest(below).map(|found| found.omega), None);
}

/// The linear disk: the largest amplitude that the subset of nominal modes gives is that of the ring that is not reduced, and no disk exceeds
/// (1 + √N)/2 times the tuned one, with one family of modes that are equally damped. Seen to fail
/// with several families of modes in the band (2.0), and with 0.8 of the tuned amplitude.
/// Source: Whitehead 1966, J. Mech. Eng. Sci. 8, 15–21.
#[test]
fn amplification_without_friction_stays_below_whiteheads_bound() {
    let (n_sectors, engine_order) = (6, 2);
    let disk = one_family(n_sectors);
    let pairs = contacts(2);
    let linear = LinearRing::new(
        &disk.with_stuck_contacts(&pairs),
        engine_order,
        search().band,
    );
    let linear = linear.expect("definite");
    let largest = |deviations: &[f64]| {
        linear
            .largest(deviations)
            .expect("finite")
            .expect("modes in the band")
    };
    let tuned = largest(&[0.0; 6]).amplitude;
    let bound = 0.5 * (1.0 + (n_sectors as f64).sqrt());
    let mut factors = Vec::new();
    for sample in 0..200 {
        let scatter = [0.002, 0.005, 0.01, 0.03][sample as usize % 4];
        let deviations = deviations(sample, n_sectors, scatter);
        let found = largest(&deviations);
        factors.push(found.amplitude / tuned);
        if sample < 8 {
            let whole = mistuned_ring(&disk, engine_order, &deviations);
            let whole = LinearModel::new(&whole).expect("definite");
            let rows: Vec<usize> = (0..n_sectors).map(|sector| sector * N).collect();
            let springs = stuck(&contacts(2 * n_sectors));
            let amplitudes: Vec<f64> = blades(&whole, &springs, found.omega / TAU, &rows)
                .iter()
                .map(|y| y.norm())
                .collect();
            let highest = amplitudes.iter().fold(0.0, |a: f64, b| a.max(*b));
            let error = (found.amplitude / highest - 1.0).abs();
            println!("sample {sample}: blade {}, {error:.1e}", found.blade);
            assert!(
                error < 1e-3 && highest == amplitudes[found.blade],
                "{error:e}"
            );
        }
    }
    factors.sort_by(f64::total_cmp);
    println!("{:.3} … {:.3}, bound {bound:.3}", factors[0], factors[199]);
    assert!(factors[199] <= bound, "{} > {bound}", factors[199]);
    assert!(factors[199] > 1.2 && factors[0] > 0.5, "{factors:?}");
}
