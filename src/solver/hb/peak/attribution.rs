//! The mode that a maximum belongs to.
//!
//! Contact moves a mode of the structure between two shapes: the stuck one, and the free one that has the largest share in it. A maximum
//! belongs to the mode that its vibration resembles most, where the correlations with both shapes count alike. Only the part of
//! the vibration counts that is a quarter of a period behind the excitation: that of the mode that resonates. A mode beside its
//! resonance moves in phase with the force, perhaps more than a weak one at its resonance.
//!
//! The modes do not depend on the sample as long as the structure does not. The shape of the vibration decides, unless several modes are as
//! near: where contacts slip through, two modes may end in one maximum, whose shape is of both. Then the other maxima of the sample decide,
//! and at last the order of the modes, so that the name does not change with the last digits.

use crate::hb::equations::problem::Problem;
use crate::hb::solution::Solution;
use crate::hb::structure::compliance::Compliance;
use crate::hb::structure::linear::{LinearModel, ModalPart};
use crate::hb::structure::resonance::{LinearMode, excited};
use crate::linalg::LinalgError;
use faer::prelude::c64;
use std::ops::Range;

/// A mode counts as near as the nearest one if its correlation is at least this part of that one's: the shape does not tell them apart.
const AS_NEAR: f64 = 0.6;
/// Relative distance of two squared frequencies of free modes that count as one: their shapes may be mixed in any way.
const EQUAL: f64 = 2e-6;
/// A shape counts as not excited if its modal force is below this share of the whole force.
const UNEXCITED: f64 = 1e-6;

/// The modes that maxima may belong to.
#[derive(Debug, Clone)]
pub struct ModeShapes(Vec<ModeShape>);

/// A mode between stuck and free.
#[derive(Debug, Clone)]
struct ModeShape {
    /// Number of the stuck mode, as [`crate::hb::structure::resonance::Candidate::mode`].
    mode: usize,
    /// Stuck and free shape in the modes of the free structure, of unit modal mass.
    shapes: [Vec<c64>; 2],
}

/// The mode of a maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeOfMaximum {
    /// Its number.
    pub mode: usize,
    /// Its part of the correlations with all modes: 1 where no other mode comes near, one half where two are as near.
    pub share: f64,
}

impl ModeShapes {
    /// The excited modes of the structure with the springs `stuck` of stuck contacts (N/m, shape `[3·n_contacts]`).
    ///
    /// # Errors
    /// [`LinalgError`] if the eigensolver fails.
    pub fn new(model: &LinearModel, stuck: &[f64]) -> Result<Self, LinalgError> {
        let part = model.part(1);
        let modes = LinearMode::all(part, stuck)?;
        let shape = |mode: usize| {
            let stuck = modes[mode].shape.clone();
            let free = largest_free_share(&part.structure.lambda, &stuck);
            ModeShape {
                mode,
                shapes: [stuck, free],
            }
        };
        Ok(Self(excited(&modes).map(shape).collect()))
    }

    /// The modes of the maxima of `problem` at one level, in their order.
    #[must_use]
    pub fn attributed(
        &self,
        problem: &Problem<'_>,
        maxima: &[&Solution],
    ) -> Vec<Option<ModeOfMaximum>> {
        let correlations = |maximum: &&Solution| self.correlations(problem, maximum);
        let correlations: Vec<Vec<f64>> = maxima.iter().map(correlations).collect();
        let named = chosen(&correlations).into_iter().zip(&correlations);
        let mode = |(place, all): (Option<usize>, &Vec<f64>)| {
            let place = place?;
            Some(ModeOfMaximum {
                mode: self.0[place].mode,
                share: all[place] / all.iter().sum::<f64>(),
            })
        };
        named.map(mode).collect()
    }

    /// Whether a maximum may be that of the mode with this number: no other mode is clearly nearer.
    #[must_use]
    pub fn resembles(&self, problem: &Problem<'_>, maximum: &Solution, mode: usize) -> bool {
        let correlations = self.correlations(problem, maximum);
        let largest = correlations.iter().copied().fold(0.0, f64::max);
        let of_mode = self.0.iter().position(|shape| shape.mode == mode);
        let own = of_mode.map_or(0.0, |place| correlations[place]);
        own > 0.0 && own >= AS_NEAR * largest
    }

    /// Correlation of the first harmonic of a maximum with every mode.
    fn correlations(&self, problem: &Problem<'_>, maximum: &Solution) -> Vec<f64> {
        let part = problem.model.part(1);
        let eta = first_harmonic(problem, maximum);
        let correlation = |of: &ModeShape| {
            let both = of.shapes.iter();
            both.map(|shape| quadrature(part, shape, &eta).powi(2))
                .sum()
        };
        self.0.iter().map(correlation).collect()
    }
}

/// The places of the modes of all maxima of one level. A maximum has its nearest mode. If several modes are about as near, it has the
/// lowest of them that no other maximum has. Of several such maxima the one with the clearest shape chooses first, and takes its nearest
/// mode. Shape: `correlations[maxima][modes]`.
fn chosen(correlations: &[Vec<f64>]) -> Vec<Option<usize>> {
    let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    let near = |all: &Vec<f64>| -> Vec<usize> {
        let least = AS_NEAR * largest(all);
        let is_near = |&mode: &usize| all[mode] >= least && all[mode] > 0.0;
        (0..all.len()).filter(is_near).collect()
    };
    let near: Vec<Vec<usize>> = correlations.iter().map(near).collect();
    let only = |near: &Vec<usize>| match near[..] {
        [mode] => Some(mode),
        _ => None,
    };
    let mut names: Vec<Option<usize>> = near.iter().map(only).collect();
    let mut unclear: Vec<usize> = (0..near.len()).filter(|&i| near[i].len() > 1).collect();
    let clearness = |i: usize| largest(&correlations[i]) / correlations[i].iter().sum::<f64>();
    unclear.sort_by(|&a, &b| clearness(b).total_cmp(&clearness(a)));
    for (order, &i) in unclear.iter().enumerate() {
        let is_free = |mode: &usize| !names.contains(&Some(*mode));
        let nearest = near[i].iter().copied().reduce(|best, mode| {
            match correlations[i][mode] > correlations[i][best] {
                true => mode,
                false => best,
            }
        });
        let rivals = &unclear[order + 1..];
        let has_rival = rivals
            .iter()
            .any(|&j| near[j].iter().any(|m| near[i].contains(m)));
        let lowest = near[i].iter().copied().find(is_free);
        names[i] = match has_rival {
            true => nearest.filter(is_free).or(lowest),
            false => lowest,
        }
        .or(nearest);
    }
    names
}

/// The part of a stuck `shape` in the free modes of one frequency that have the largest share in it, of unit modal mass. `lambda`:
/// squared frequencies, ascending.
fn largest_free_share(lambda: &[f64], shape: &[c64]) -> Vec<c64> {
    let n = lambda.len();
    let round_off = 10.0 * f64::EPSILON * n as f64 * lambda.last().copied().unwrap_or_default();
    let is_next = |a: f64, b: f64| b - a <= EQUAL * b.abs() + round_off;
    let mut groups: Vec<Range<usize>> = Vec::new();
    for next in 0..n {
        let joins = next > 0 && is_next(lambda[next - 1], lambda[next]);
        match groups.last_mut() {
            Some(group) if joins => group.end = next + 1,
            _ => groups.push(next..next + 1),
        }
    }
    let share =
        |group: &Range<usize>| -> f64 { shape[group.clone()].iter().map(|x| x.norm_sqr()).sum() };
    let largest = groups
        .into_iter()
        .map(|group| (share(&group), group))
        .reduce(|most, next| if next.0 > most.0 { next } else { most });
    let mut free = vec![c64::ZERO; n];
    if let Some((share, group)) = largest {
        for i in group {
            free[i] = shape[i] / share.sqrt();
        }
    }
    free
}

/// η̂₁ of a solution: the structure with stuck contacts under the excitation and what the contact forces deviate from stuck ones.
fn first_harmonic(problem: &Problem<'_>, solution: &Solution) -> Vec<c64> {
    let springs = &problem.stuck_stiffness;
    let at = Compliance::new(problem.model, springs, &[0, 1], solution.omega);
    let (first, n) = (&at.harmonics[0], springs.len());
    let complex = |x: &[f64], i: usize| c64::new(x[n + i], -x[2 * n + i]);
    let deviation =
        |i: usize| complex(&solution.force, i) - complex(&solution.relative, i) * springs[i];
    let deviation: Vec<c64> = (0..n).map(deviation).collect();
    let mut load = first.part.contact_load(&deviation);
    for (load, force) in load.iter_mut().zip(&first.part.force) {
        *load = force * solution.level - *load;
    }
    first.solve(&load)
}

/// Component of η along a shape, a quarter of a period behind the force on this shape.
fn quadrature(part: &ModalPart, shape: &[c64], eta: &[c64]) -> f64 {
    let along = |x: &[c64]| -> c64 { shape.iter().zip(x).map(|(s, x)| s.conj() * x).sum() };
    let force = along(&part.force);
    let whole = part.force.iter().map(|f| f.norm_sqr()).sum::<f64>().sqrt();
    match force.norm() > UNEXCITED * whole {
        true => -(along(eta) * force.conj()).im / force.norm(),
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clear shapes have their mode; one maximum of two modes has the lower one, or the one that is left; two of them share the modes, the
    /// clearer one first. Seen to fail with the nearest mode alone, and with the lowest of near modes whatever the others have.
    #[test]
    fn maxima_between_modes_take_what_is_left() {
        let of = |rows: &[[f64; 3]]| {
            let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.to_vec()).collect();
            let places = chosen(&rows).into_iter();
            places
                .map(|place| place.map_or(9, |p| p))
                .collect::<Vec<_>>()
        };
        assert_eq!(of(&[[0.1, 0.9, 0.0], [0.8, 0.2, 0.0]]), [1, 0]);
        assert_eq!(of(&[[0.48, 0.52, 0.0]]), [0]);
        assert_eq!(of(&[[0.52, 0.48, 0.0]]), [0]);
        assert_eq!(of(&[[0.52, 0.48, 0.0], [0.9, 0.1, 0.0]]), [1, 0]);
        assert_eq!(of(&[[0.45, 0.55, 0.0], [0.54, 0.46, 0.0]]), [1, 0]);
        assert_eq!(of(&[[0.54, 0.46, 0.0], [0.55, 0.45, 0.0]]), [1, 0]);
        assert_eq!(of(&[[0.9, 0.0, 0.1], [0.8, 0.0, 0.2]]), [0, 0]);
        assert_eq!(of(&[[0.0, 0.0, 0.0]]), [9]);
    }

    /// The free side of a shape does not depend on how free modes of one frequency are mixed, and is the one with the largest share.
    /// Seen to fail with a group for each free mode.
    #[test]
    fn the_free_side_of_a_mode_is_a_group_of_equal_frequencies() {
        let real = |x: &[f64]| x.iter().map(|x| c64::from(*x)).collect::<Vec<_>>();
        let lambda = [1.0, 4.0, 4.0, 9.0];
        let shape = real(&[0.6, 0.48, 0.48, 0.4257]);
        let free = largest_free_share(&lambda, &shape);
        let half = 0.5f64.sqrt();
        for (found, expected) in free.iter().zip([0.0, half, half, 0.0]) {
            assert!((found - c64::from(expected)).norm() < 1e-12, "{free:?}");
        }
        let lowest = largest_free_share(&lambda, &real(&[0.9, 0.3, 0.3, 0.1]));
        assert_eq!(lowest, real(&[1.0, 0.0, 0.0, 0.0]));
    }
}
