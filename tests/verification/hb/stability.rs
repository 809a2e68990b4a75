//! Floquet multipliers against time integration of the full nonlinear equations from a disturbed periodic state.

use super::models::plane;
use super::time_integration::March;
use crate::response::over_band;
use faer::prelude::*;
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::newton::{Condition, Iterate, Point, solve};
use microslip::hb::stability::assessment::assess_with;
use microslip::hb::stability::period_map::{PeriodMap, PeriodicMotion};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    Balance, HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, Solution,
};
use std::f64::consts::TAU;

fn settings(highest: usize, n_time: usize) -> HbSettings {
    HbSettings {
        harmonics: HarmonicSet::up_to(highest),
        aft: AftSettings {
            n_time,
            law: FrictionLaw::Box,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        anchor: SliderAnchor::Unloaded,
        newton: NewtonSettings {
            tolerance: 1e-9,
            ..NewtonSettings::default()
        },
        alert: None,
    }
}

/// The two lumped blades, the strip with the damping `strip` (1/s).
fn blades(phase: f64, strip: f64) -> (LinearModel, Vec<microslip::contact::ContactParameters<f64>>) {
    let mut case = plane(phase);
    for (dof, mass) in [(2, 1.58e-3), (3, 1.58e-3), (4, 1.58e-3 * 1e-4 / 12.0)] {
        case.model.damping[(dof, dof)] = strip * mass;
    }
    (LinearModel::new(&case.model).expect("definite"), case.contacts)
}

fn raised<'p>(problem: &'p Problem<'p>, start: &Solution, highest: &[usize]) -> Option<(Balance<'p>, Iterate<'p>)> {
    let settings = settings(start.harmonics.highest(), 1024);
    let mut balance = Balance::new(problem, start.harmonics.clone(), settings.aft);
    let mut iterate = solve(&balance, start.point(), Condition::FixedFrequency, settings.newton).ok()?;
    for &h in highest {
        let larger = Balance::new(problem, HarmonicSet::up_to(h), settings.aft);
        let padded = iterate.point.padded(&balance, &larger);
        iterate = solve(&larger, padded, Condition::FixedFrequency, settings.newton).ok()?;
        balance = larger;
    }
    Some((balance, iterate))
}

/// Largest multiplier and its eigenvector by the map, and the errors of what the march makes of that disturbance after each period.
fn compare(problem: &Problem<'_>, balance: &Balance<'_>, iterate: &Iterate<'_>, settle: usize) {
    let motion = PeriodicMotion {
        harmonics: &balance.harmonics,
        relative: &iterate.point.r,
        omega: iterate.point.omega,
        law: FrictionLaw::Box,
    };
    let clock = std::time::Instant::now();
    let map = PeriodMap::all(problem, &motion, 512).expect("a map").remove(0);
    let time = clock.elapsed();
    let eigen = map.matrix.eigen().expect("eigen");
    let values: Vec<c64> = (0..map.matrix.nrows()).map(|i| eigen.S()[i]).collect();
    let mut order: Vec<usize> = (0..values.len()).filter(|&i| (values[i] - 1.0).norm() > 1e-6).collect();
    order.sort_by(|&a, &b| values[b].norm().total_cmp(&values[a].norm()));
    let top = order[0];
    let coarse: Vec<String> = [128, 256, 1024, 2048].iter().map(|&n| {
        let s = assess_with(problem, &motion, n).expect("assessed");
        format!("{:.5}", s.multiplier.norm())
    }).collect();
    println!("  {} Hz {} N: mult {:?} |{:.5}| next {:.4} steps {coarse:?} sep {:.3} ({time:?})", iterate.point.omega / TAU, iterate.point.level, values[top], values[top].norm(), values[order[order.len().min(3) - 1]].norm(),
       iterate.contact.samples.iter().map(|s| f64::from(s[2])).sum::<f64>() / iterate.contact.samples.iter().flatten().map(|&s| f64::from(s)).sum::<f64>());
    let n = map.n_modes;
    let vector: Vec<c64> = (0..values.len()).map(|i| eigen.U()[(i, top)]).collect();
    let size = vector[..n].iter().map(|z| z.norm()).fold(0.0, f64::max);
    let amplitude = iterate.response(balance).norm();
    let eps = 1e-6 * amplitude / size;
    let part = |range: std::ops::Range<usize>| -> Vec<f64> { vector[range].iter().map(|z| eps * z.re).collect() };
    let steps = 16000;
    let mut base = March::new(problem, iterate, steps);
    let mut other = March::new(problem, iterate, steps);
    for _ in 0..settle { base.period(); other.period(); }
    let sliders: Vec<([usize; 2], f64)> = map.sliders.iter().copied().zip(part(2 * n..values.len())).collect();
    other.disturb(&part(0..n), &part(n..2 * n), &sliders);
    let mut power = c64::new(eps, 0.0);
    let mut text = String::new();
    for _ in 0..4 {
        base.period();
        other.period();
        power *= values[top];
        let (a, b) = (base.state(), other.state());
        let expected: Vec<f64> = vector[..2 * n].iter().map(|z| (power * z).re).collect();
        let norm = |f: &dyn Fn(usize) -> f64| -> f64 { (0..2 * n).map(|i| { let x = f(i) * if i < n { iterate.point.omega } else { 1.0 }; x * x }).sum::<f64>().sqrt() };
        let error = norm(&|i| b[i] - a[i] - expected[i]) / norm(&|i| expected[i]);
        let ratio = norm(&|i| b[i] - a[i]) / norm(&|i| expected[i]);
        text += &format!(" {error:.1e} ({ratio:.4})");
    }
    println!("    march:{text}");
}

#[test]
fn explore() {
    for (phase, strip, level, low, high) in [(-1.0, 2000.0, 10.0, 380.0, 440.0), (-1.0, 2000.0, 40.0, 320.0, 420.0), (1.0, 0.0, 10.0, 310.0, 360.0), (1.0, 0.0, 40.0, 310.0, 350.0), (1.0, 2000.0, 40.0, 310.0, 350.0), (-1.0, 0.0, 40.0, 320.0, 420.0)] {
        println!("phase {phase} strip {strip} level {level}");
        let (linear, contacts) = blades(phase, strip);
        let problem = Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held");
        let settings = settings(5, 256);
        let band = Band { low: low * TAU, high: high * TAU };
        let curve = over_band(&problem, &settings, level, band);
        let solved: Vec<&Solution> = curve.iter().filter(|s| s.status.has_solution()).collect();
        println!(" {} points", solved.len());
        for i in 0..12 {
            let start = solved[i * (solved.len() - 1) / 11];
            match raised(&problem, start, &[9, 15, 24]) {
                Some((balance, iterate)) => compare(&problem, &balance, &iterate, 0),
                None => println!("  {} not raised", start.omega / TAU),
            }
        }
    }
}
