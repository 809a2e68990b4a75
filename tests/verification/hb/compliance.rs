//! The compliance of the stuck structure against the structure itself.

use super::models::short;
use crate::two_blade::{RIG, contacts};
use faer::prelude::c64;
use microslip::hb::LinearModel;
use microslip::hb::compliance::{Compliance, HarmonicCompliance};
use microslip::hb::linear::Structure;

fn size(x: &[c64]) -> f64 {
    x.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt()
}

fn distance(a: &[c64], b: &[c64]) -> f64 {
    let difference: Vec<c64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    size(&difference) / size(a)
}

/// For unit forces at all contacts: what the motion leaves of the load, and the error of G against the motion.
fn errors(h: &HarmonicCompliance<'_>, k: &[f64], omega: f64) -> [f64; 2] {
    let Structure::Modal { lambda, damping } = &h.part.structure else {
        unreachable!("modal coordinates")
    };
    let frequency = h.order as f64 * omega;
    let mut worst = [0.0_f64; 2];
    for j in 0..k.len() {
        let mut force = vec![c64::new(0.0, 0.0); k.len()];
        force[j].re = 1.0;
        let load = h.part.contact_load(&force);
        let eta = h.solve(&load);
        let relative = h.part.relative(&eta);
        let springs: Vec<c64> = relative.iter().zip(k).map(|(r, k)| r * *k).collect();
        let balanced: Vec<c64> = (eta.iter().zip(h.part.contact_load(&springs)).enumerate())
            .map(|(i, (x, spring))| {
                let free = c64::new(lambda[i] - frequency * frequency, frequency * damping[i]);
                x * free + spring
            })
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
///
/// Where all modes are condensed to the contacts 7e-6 of the load is left.
#[test]
fn compliance_is_that_of_the_stuck_structure_at_free_resonances() {
    let nominal = contacts(&RIG.reduced, 1.0, 0.6);
    let linear = LinearModel::folded(&RIG.reduced, &nominal)
        .expect("definite")
        .expect("a mirror");
    let pairs = &nominal[..linear.n_contacts()];
    for scale in [0.0, 1e-3, 0.1, 1.0, 10.0, 1e3] {
        let k: Vec<f64> = (pairs.iter().map(|c| c.k_t[0]))
            .chain(pairs.iter().map(|c| c.k_t[1]))
            .chain(pairs.iter().map(|c| c.k_n))
            .map(|k| scale * k)
            .collect();
        let mut worst = [0.0_f64; 2];
        for part in &linear.parts {
            let Structure::Modal { lambda, .. } = &part.structure else {
                unreachable!("modal coordinates")
            };
            for omega in lambda[3..12].iter().map(|l| l.sqrt()) {
                for h in &Compliance::new(&linear, &k, &[0, 1, 2, 3, 7], omega).harmonics {
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
