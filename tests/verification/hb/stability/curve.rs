//! The stability of the points of a drawn curve against that of a densely followed branch.

use super::{blades, branch, settings};
use microslip::hb::response::curve::{CurvePoint, response_curve};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{Balance, Problem, SliderAnchor, Solution};
use std::f64::consts::TAU;

/// Band (Hz) of the blades against each other.
const BAND: [f64; 2] = [330.0, 400.0];
/// Levels (N): the contacts stick in part of the band, or open.
const LEVELS: [f64; 5] = [10.0, 20.0, 40.0, 60.0, 80.0];

/// The solution of the branch next to a point, over the width and the amplitude of the peak.
fn nearest<'a>(dense: &'a [Solution], point: &CurvePoint, [width, top]: [f64; 2]) -> &'a Solution {
    let distance = |s: &Solution| {
        let [x, y] = [s.omega - point.omega, s.amplitude(0) - point.amplitude];
        (x / width).hypot(y / top)
    };
    let near = |a: &&Solution, b: &&Solution| distance(a).total_cmp(&distance(b));
    dense.iter().min_by(near).expect("solutions")
}

/// Whether the assessed points of the curve at `level` are unstable, and whether the branch is so next to them.
fn judged(problem: &Problem<'_>, level: f64) -> Vec<[bool; 2]> {
    let settings = settings(5);
    let [low, high] = BAND.map(|end| end * TAU);
    let band = Band { low, high };
    let dense = branch(problem, level, BAND).into_iter();
    let dense: Vec<Solution> = (dense.map(|s| s.with_stability(problem, &settings))).collect();
    let higher = |a: &&Solution, b: &&Solution| a.amplitude(0).total_cmp(&b.amplitude(0));
    let peak = dense.iter().max_by(higher).expect("solutions");
    let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
    let curve = response_curve(&balance, &peak.point(), band, &settings).points;
    let scales = [0.1 * band.width(), peak.amplitude(0)];
    let of_point = |point: &CurvePoint| {
        let stability = nearest(&dense, point, scales).stability?;
        Some([point.unstable?, !stability.is_stable()])
    };
    curve.iter().filter_map(of_point).collect()
}

/// Solutions of a curve lie between those of the branch, and may differ from the nearest one beside a change of stability. Seen to fail
/// with the verdict of the solution before, and without any.
#[test]
fn solutions_of_a_curve_are_as_stable_as_the_branch() {
    let (linear, contacts) = blades(-1.0, 300.0);
    let problem = Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held");
    let judged: Vec<[bool; 2]> = LEVELS
        .iter()
        .flat_map(|&level| judged(&problem, level))
        .collect();
    let count = |wanted: fn(&[bool; 2]) -> bool| judged.iter().filter(|j| wanted(j)).count();
    let [all, unstable, agree] = [judged.len(), count(|j| j[0]), count(|j| j[0] == j[1])];
    println!("{all} solutions assessed, {unstable} unstable, {agree} as the branch");
    assert!(unstable > 0 && unstable < all);
    assert!(agree as f64 > 0.9 * all as f64);
}
