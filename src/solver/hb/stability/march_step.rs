//! What the contacts do in one step of the march beside sticking.

use super::contact_steps::PairStep;
use super::structure::Disturbed;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;

/// Derivatives of all contacts in one step, in the coordinates of the structure.
#[derive(Debug)]
pub(super) struct MarchStep {
    /// `factor` Bᵀ of the forces g: first those of contacts that do not stick, then those of sliders alone. Shape: n × forces.
    pub(super) load: Mat<f64>,
    /// Δ B of the first. Shape: first × n.
    pub(super) released: Mat<f64>,
    /// 1 − Δ X of the first, factorised.
    pub(super) coupled: PartialPivLu<c64>,
    /// Δ X of the first by the others, real above imaginary parts. Shape: 2 · first × others.
    pub(super) by_others: Mat<f64>,
    /// Entries of E: force, slider, derivative (N/m).
    pub(super) memory: Vec<(usize, usize, f64)>,
    /// Sliders that move.
    pub(super) slides: Slides,
}

/// Sliders that move in a step.
#[derive(Debug)]
pub(super) struct Slides {
    pub(super) moved: Vec<MovedSlider>,
    /// Where they go by the coordinates at the start of the step, and by those at its end. Shape: moved sliders × n.
    pub(super) by_start: Mat<f64>,
    pub(super) by_end: Mat<f64>,
}

/// A slider that moves in a step.
#[derive(Debug)]
pub(super) struct MovedSlider {
    /// Its row, `[direction][pair]`.
    pub(super) row: usize,
    /// Rows of the sliders of the pair, and what is kept of each.
    pub(super) kept: [(usize, f64); 2],
}

/// A force of a contact that is not that of stick.
struct Force {
    pair: usize,
    /// Its row of B.
    row: usize,
    /// Δ by the displacements of the pair (N/m).
    released: [f64; 3],
    /// E by the sliders of the pair (N/m).
    memory: [f64; 2],
}

/// The forces of a step, and how many of them are of contacts that do not stick; these are the first.
fn forces(structure: &Disturbed, at: &[&PairStep]) -> (Vec<Force>, usize) {
    let (mut free, mut held) = (Vec::new(), Vec::new());
    for (pair, of) in at.iter().enumerate() {
        for component in 0..3 {
            let row = component * at.len() + pair;
            let mut released = of.stiffness[component].map(|d| -d);
            released[component] += structure.stuck[row];
            let memory = of.memory.get(component).copied().unwrap_or_default();
            let force = Force {
                pair,
                row,
                released,
                memory,
            };
            if released != [0.0; 3] {
                free.push(force);
            } else if memory != [0.0; 2] {
                held.push(force);
            }
        }
    }
    let first = free.len();
    free.extend(held);
    (free, first)
}

impl MarchStep {
    /// The step in which the pairs of `structure` have the derivatives `at`; X is the `compliance` of the stuck structure.
    pub(super) fn new(
        structure: &Disturbed,
        at: &[&PairStep],
        compliance: MatRef<'_, c64>,
    ) -> Self {
        let (n, n_pairs) = (structure.lambda.len(), at.len());
        let b = &structure.contact;
        let (forces, first) = forces(structure, at);
        // Σ Δ x(row) over the displacements of the pair
        let through = |force: &Force, x: &dyn Fn(usize) -> c64| -> c64 {
            let of = force.released.iter().enumerate();
            of.map(|(c, delta)| x(c * n_pairs + force.pair) * *delta)
                .sum()
        };
        let moving = |i: usize, j: usize| {
            let by: &Force = &forces[j];
            through(&forces[i], &|row| compliance[(row, by.row)])
        };
        let coupled = Mat::from_fn(first, first, |i, j| {
            c64::new(f64::from(u8::from(i == j)), 0.0) - moving(i, j)
        });
        let by_others = Mat::from_fn(2 * first, forces.len() - first, |i, j| match i < first {
            true => moving(i, first + j).re,
            false => moving(i - first, first + j).im,
        });
        let entries = |(i, force): (usize, &Force)| {
            let sliders = [0, 1].map(|d| (i, d * n_pairs + force.pair, force.memory[d]));
            sliders.into_iter().filter(|(_, _, e)| *e != 0.0)
        };
        Self {
            load: Mat::from_fn(n, forces.len(), |i, j| {
                structure.factor * b[(forces[j].row, i)]
            }),
            released: Mat::from_fn(first, n, |i, j| {
                through(&forces[i], &|row| c64::new(b[(row, j)], 0.0)).re
            }),
            memory: forces.iter().enumerate().flat_map(entries).collect(),
            by_others,
            coupled: coupled.partial_piv_lu(),
            slides: Slides::new(structure, at),
        }
    }
}

impl Slides {
    fn new(structure: &Disturbed, at: &[&PairStep]) -> Self {
        let (n, n_pairs) = (structure.lambda.len(), at.len());
        let moved: Vec<[usize; 2]> = (0..n_pairs)
            .flat_map(|pair| [[pair, 0], [pair, 1]])
            .filter(|&[pair, d]| at[pair].moves(d))
            .collect();
        let by = |of: &dyn Fn(usize, usize) -> [f64; 3]| {
            Mat::from_fn(moved.len(), n, |i, j| {
                let [pair, d] = moved[i];
                let by_component = of(pair, d);
                (0..3)
                    .map(|c| by_component[c] * structure.contact[(c * n_pairs + pair, j)])
                    .sum()
            })
        };
        Self {
            by_start: by(&|pair, d| at[pair].by_start[d]),
            by_end: by(&|pair, d| at[pair].by_end[d]),
            moved: (moved.iter())
                .map(|&[pair, d]| MovedSlider {
                    row: d * n_pairs + pair,
                    kept: [0, 1].map(|c| (c * n_pairs + pair, at[pair].kept[d][c])),
                })
                .collect(),
        }
    }
}
