//! State of one lap of the slider of the circle law with located events. A lap is one pass over the excitation period.

use super::course::Course;
use super::kink::Kink;
use super::sensitivity::{Base, Blocks, Row, Rows};
use super::slip::HalfAngle;
use crate::aft::vector::dot;
use crate::contact::Real;

/// What a closed contact does.
#[derive(Debug, Clone, Copy)]
pub(super) enum ClosedMotion<T> {
    /// Stick: the slider k_t w (N) rests.
    Stick([T; 2]),
    /// Slip, and the direction of the traction.
    Slip(HalfAngle<T>),
}

/// What is known at the end of a lap, and what the lap needs on the way.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Lap<T> {
    /// Tractions at the samples (N), times the weights of the samples. Shape: `[time]`.
    pub tractions: Vec<[T; 2]>,
    /// Tractions at the nodes between samples (N), times the weights of these nodes.
    pub(super) between: Vec<[T; 2]>,
    /// First phase and length of the present cell, if an interval between samples has several.
    pub(super) cell: Option<[T; 2]>,
    pub(super) kinks: Vec<Kink<T>>,
    /// Number of samples that slip.
    pub slip: u32,
    /// Whether anything moved the slider.
    pub moved: bool,
    /// Longest slip of the slider (N); infinite if the contact opens.
    pub longest_slip: T,
    /// Derivatives of the present state; at the end of the lap those of the slider.
    pub rows: Rows<T>,
    /// Basis rows at the last event and at the next one, which is searched for.
    pub(super) row: Vec<T>,
    pub(super) next_row: Vec<T>,
    /// Scratch row of the size of a jump along the traction: of λ, of e·s'' − L'', of L' or of L''.
    pub(super) sliding: Row<T>,
    /// The slider (N) where the present slip began.
    pub(super) slip_from: [T; 2],
    /// First sample of the present stick.
    pub(super) stick_from: Option<usize>,
}

/// A lap in progress; `target` takes the derivatives of the forces, where they are wanted.
pub(in crate::aft) struct LapMarch<'a, S, T> {
    pub simd: S,
    pub course: Course<'a, T>,
    pub lap: &'a mut Lap<T>,
    pub target: Option<&'a mut Blocks<T>>,
}

impl<T: Real> Lap<T> {
    /// Adds what the kinks and the nodes between samples contribute to the traction coefficients. Shape: `force` `[2][m]`.
    pub(in crate::aft) fn complete(&mut self, course: Course<T>, force: &mut [T]) {
        let plan = course.plan;
        for kink in &self.kinks {
            kink.add_force(plan, [&mut self.row, &mut self.next_row], force);
        }
        let Some(between) = course.between else {
            return;
        };
        for (k, traction) in self.between.iter().enumerate() {
            let terms = between.row(k).iter().zip(&plan.weight);
            for (force, &traction) in force.chunks_exact_mut(plan.m).zip(traction) {
                for (force, (&b, &w)) in force.iter_mut().zip(terms.clone()) {
                    *force += w * b * traction;
                }
            }
        }
    }

    /// The slider, which slipped, has come to `slider`.
    pub(super) fn note_slip(&mut self, slider: [T; 2]) {
        let from = self.slip_from;
        let slip = [slider[0] - from[0], slider[1] - from[1]];
        self.longest_slip = self.longest_slip.or_larger(dot(slip, slip).sqrt());
    }
}

impl<'a, S, T: Real> LapMarch<'a, S, T> {
    /// What the rows depend on.
    #[inline(always)]
    pub(super) fn base(&self) -> Base<'a, T> {
        Base {
            plan: self.course.plan,
            p: self.course.p,
        }
    }
}
