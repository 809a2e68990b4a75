//! The compliance of the stuck structure against the structure itself.

use super::lumped_disk::{contacts as disk_contacts, disk};
use super::models::short;
use crate::two_blade::folded;
use faer::prelude::c64;
use microslip::contact::ContactParameters;
use microslip::hb::LinearModel;
use microslip::hb::structure::compliance::{Compliance, HarmonicCompliance};
use microslip::study::Study;
use std::path::Path;

fn size(x: &[c64]) -> f64 {
    x.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt()
}

fn distance(a: &[c64], b: &[c64]) -> f64 {
    let difference: Vec<c64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    size(&difference) / size(a)
}

/// For unit forces at all contacts: what the motion leaves of the load, and the error of G against the motion.
fn errors(h: &HarmonicCompliance<'_>, k: &[f64], omega: f64) -> [f64; 2] {
    let structure = &h.part.structure;
    let frequency = h.order as f64 * omega;
    let mut worst = [0.0_f64; 2];
    for j in 0..k.len() {
        let mut force = vec![c64::new(0.0, 0.0); k.len()];
        force[j].re = 1.0;
        let load = h.part.contact_load(&force);
        let eta = h.solve(&load);
        let relative = h.part.relative(&eta);
        let springs: Vec<c64> = relative.iter().zip(k).map(|(r, k)| r * *k).collect();
        let damped = structure.damp(&eta);
        let balanced: Vec<c64> = (eta.iter().zip(damped).zip(&structure.lambda))
            .map(|((x, damped), l)| {
                x * (l - frequency * frequency) + damped * c64::new(0.0, frequency)
            })
            .zip(h.part.contact_load(&springs))
            .map(|(free, spring)| free + spring)
            .collect();
        let column: Vec<c64> = (h
            .real
            .col_as_slice(j)
            .iter()
            .zip(h.imaginary.col_as_slice(j)))
        .map(|(&re, &im)| c64::new(re, im))
        .collect();
        worst[0] = worst[0].max(distance(&load, &balanced));
        worst[1] = worst[1].max(distance(&relative, &column));
    }
    worst
}

/// Every free resonance up to the seventh harmonic, hit exactly: contacts from open to rigid.
fn compliance_is_that_of_the_stuck_structure(
    linear: &LinearModel,
    pairs: &[ContactParameters<f64>],
) {
    for scale in [0.0, 1e-3, 0.1, 1.0, 10.0, 1e3] {
        let k: Vec<f64> = (pairs.iter().map(|c| c.k_t[0]))
            .chain(pairs.iter().map(|c| c.k_t[1]))
            .chain(pairs.iter().map(|c| c.k_n))
            .map(|k| scale * k)
            .collect();
        let mut worst = [0.0_f64; 2];
        for part in &linear.parts {
            let elastic = part.structure.lambda.iter().filter(|l| **l > 1e4);
            for omega in elastic.take(9).map(|l| l.sqrt()) {
                for h in &Compliance::new(linear, &k, &[0, 1, 2, 3, 7], omega).harmonics {
                    let errors = errors(h, &k, omega);
                    (worst.iter_mut().zip(errors)).for_each(|(w, e)| *w = w.max(e));
                }
            }
        }
        println!(
            "contacts {scale}: load, compliance off by {}",
            short(&worst)
        );
        assert!(worst.iter().all(|e| *e < 1e-9), "{worst:?}");
    }
}

/// Where all modes are condensed to the contacts 7e-6 of the load is left.
#[test]
fn compliance_at_free_resonances() {
    let (linear, contacts) = folded(1.0, 0.6);
    compliance_is_that_of_the_stuck_structure(&linear, &contacts);
}

/// The waves of a disk with damping that couples modes: compliances that are not symmetric. Seen to fail with the loose modes moved as
/// by a symmetric one.
#[test]
fn compliance_of_travelling_waves() {
    let linear = LinearModel::travelling_wave(&disk(6), 1).expect("definite");
    let waves = linear.parts.iter().filter(|part| !part.is_real()).count();
    assert_eq!((linear.parts.len(), waves), (6, 4), "parts of the waves");
    assert!(
        !linear.part(1).structure.coupling.modes.is_empty(),
        "damping is classical"
    );
    let at = Compliance::new(&linear, &[1e5; 6], &[0, 1], 2000.0);
    let g = &at.harmonics[0].real;
    let largest = g.norm_max();
    let symmetric = (0..6).all(|i| (0..i).all(|j| (g[(i, j)] - g[(j, i)]).abs() < 1e-3 * largest));
    assert!(!symmetric, "the compliance of this wave is symmetric");
    compliance_is_that_of_the_stuck_structure(&linear, &disk_contacts(2));
}

/// Blades whose damping couples 32 of 92 modes. Seen to fail without the coupling in the loose modes.
#[test]
fn compliance_with_damping_that_couples_modes() {
    let path = Path::new("tests/reference/blades-strip-oop/study.toml");
    let model = Study::read(path).and_then(|study| study.build_model());
    let model = model.expect("the reference model");
    let linear = LinearModel::new(&model.reduced).expect("definite");
    println!(
        "{} modes are coupled",
        linear.part(1).structure.coupling.modes.len()
    );
    assert!(
        !linear.part(1).structure.coupling.modes.is_empty(),
        "damping is classical"
    );
    compliance_is_that_of_the_stuck_structure(&linear, &model.contacts);
}
