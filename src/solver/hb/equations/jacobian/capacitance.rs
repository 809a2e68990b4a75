//! J x = b reduced to the force components that deviate from the stuck contact.
//!
//! Such a component of one pair is called a slot here: dg has rows for slots only. A pair that slips in one direction has one
//! slot, a pair that opens has three. Vectors are slot-major, `[slot][coefficient]`.
//!
//! The derivative of a slot's force by its own displacement at one harmonic is split: dg = D + e. D is a complex spring, the
//! contact linearised harmonic by harmonic; its real part is negative where the contact is softer than the stuck one. e
//! couples harmonics and components. The structure with the springs D has the compliance G' = (I + G D)⁻¹ G, and
//!
//! ```text
//! (I + G dg) x = b   becomes   x + G' e x = b',   b' = b − G' D b
//! y = e x obeys      C y = e b',   C = I + e G'       (capacitance matrix of Woodbury's identity)
//! and then           x = b' − G' y
//! ```
//!
//! C is better conditioned than I + dg G, which is nearly singular for a stiff contact that is open for a part of the period.

use super::PairTangent;
use crate::hb::equations::layout::Layout;
use crate::hb::structure::compliance::Compliance;
use crate::hb::structure::springs::ContactCompliance;
use crate::linalg::vector::{axpy, axpy_complex};
use faer::prelude::*;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Force components in the order of the slots: tangential forces depend on the normal displacement, the normal force does not
/// depend on tangential ones.
const ORDER: [usize; 3] = [2, 0, 1];

/// C = I + e G' at one point.
#[derive(Debug)]
pub(super) struct Capacitance {
    pub(super) layout: Layout,
    /// G' (m/N) of harmonic 0 and of those above, in the order of the set.
    pub(super) compliance: Vec<ContactCompliance>,
    pub(super) slots: Vec<Slot>,
}

/// One force component of one pair.
#[derive(Debug)]
pub(super) struct Slot {
    pub(super) component: usize,
    /// Index of its displacement among those of one coefficient.
    pub(super) row: usize,
    /// D (N/m) at harmonic 0 and at those above.
    springs: Vec<c64>,
    /// Displacements that the force depends on, each with its block of e by columns. Shape: `[column m][row m]`.
    pub(super) reads: Vec<(usize, Vec<f64>)>,
}

impl Capacitance {
    /// Collects the slots of the active pairs.
    pub(super) fn new(
        layout: &Layout,
        static_compliance: &Mat<f64>,
        compliance: &Compliance<'_>,
        active: &[PairTangent],
    ) -> Self {
        let slots: Vec<Slot> = (ORDER.iter())
            .flat_map(|&component| {
                active
                    .iter()
                    .filter_map(move |t| Slot::new(layout, component, t))
            })
            .collect();
        let n = layout.n_relative();
        let rest = ContactCompliance {
            real: static_compliance.clone(),
            imaginary: Mat::zeros(n, n),
            symmetric: true,
        };
        let moving = compliance.harmonics.iter().map(|h| ContactCompliance {
            real: h.real.clone(),
            imaginary: h.imaginary.clone(),
            symmetric: h.part.is_real(),
        });
        let with_springs = |(order, stuck): (usize, ContactCompliance)| {
            let mut springs = vec![c64::new(0.0, 0.0); n];
            for slot in &slots {
                springs[slot.row] = slot.springs[order];
            }
            stuck.with_springs(&springs)
        };
        Self {
            layout: *layout,
            compliance: (std::iter::once(rest).chain(moving).enumerate())
                .map(with_springs)
                .collect(),
            slots,
        }
    }

    /// Number of unknowns.
    pub(super) fn size(&self) -> usize {
        self.slots.len() * self.layout.n_coefficients
    }

    /// dg x. Shape: as the unknowns.
    pub(super) fn deviation(&self, x: &[f64]) -> Vec<f64> {
        let layout = &self.layout;
        let mut forces = self.spring_forces(x);
        self.add_forces(x, &mut forces);
        let mut out = vec![0.0; layout.n_unknowns()];
        let forces = forces.chunks_exact(layout.n_coefficients);
        for (slot, y) in self.slots.iter().zip(forces) {
            for (coefficient, y) in out.chunks_exact_mut(layout.n_relative()).zip(y) {
                coefficient[slot.row] = *y;
            }
        }
        out
    }

    /// b' and e b' of the right-hand side `b` of J x = b.
    pub(super) fn eliminated(&self, b: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut x = b.to_vec();
        self.take_motion(&self.spring_forces(b), &mut x);
        let mut y = vec![0.0; self.size()];
        self.add_forces(&x, &mut y);
        (x, y)
    }

    /// x = b' − G' y, from b' in `x` and y = C⁻¹ e b'.
    pub(super) fn substitute(&self, y: &[f64], x: &mut [f64]) {
        self.take_motion(y, x);
    }

    /// `b` − C y.
    pub(super) fn residual(&self, b: &[f64], y: &[f64]) -> Vec<f64> {
        let mut motion = vec![0.0; self.layout.n_unknowns()];
        self.take_motion(y, &mut motion);
        let mut left: Vec<f64> = b.iter().zip(y).map(|(b, y)| b - y).collect();
        self.add_forces(&motion, &mut left);
        left
    }

    /// D x. Shape: `[slot][coefficient]`.
    fn spring_forces(&self, x: &[f64]) -> Vec<f64> {
        let n = self.layout.n_relative();
        let mut forces = Vec::with_capacity(self.size());
        for slot in &self.slots {
            forces.push(slot.springs[0].re * x[slot.row]);
            for (spring, x) in slot.springs[1..].iter().zip(x[n..].chunks_exact(2 * n)) {
                let f = spring * c64::new(x[slot.row], -x[n + slot.row]);
                forces.extend([f.re, -f.im]);
            }
        }
        forces
    }

    /// x −= G' y.
    fn take_motion(&self, y: &[f64], x: &mut [f64]) {
        let capacitance = self;
        Arch::new().dispatch(TakeMotion { capacitance, y, x });
    }

    /// y += e x.
    fn add_forces(&self, x: &[f64], y: &mut [f64]) {
        let capacitance = self;
        Arch::new().dispatch(AddForces { capacitance, x, y });
    }

    /// The diagonal block of C of a range of slots.
    pub(super) fn matrix(&self, slots: Range<usize>) -> Mat<f64> {
        Arch::new().dispatch(Assembly {
            capacitance: self,
            slots,
        })
    }

    /// See [`Self::matrix`].
    #[inline(always)]
    fn assembled(&self, slots: Range<usize>) -> Mat<f64> {
        let m = self.layout.n_coefficients;
        let size = slots.len() * m;
        let mut matrix = Mat::<f64>::identity(size, size);
        for (j, column_slot) in self.slots[slots.clone()].iter().enumerate() {
            for coefficient in 0..m {
                let target = matrix.col_as_slice_mut(j * m + coefficient);
                for (slot, target) in
                    (self.slots[slots.clone()].iter()).zip(target.chunks_exact_mut(m))
                {
                    for (row, columns) in &slot.reads {
                        for (k, g) in self.compliance_entries(*row, column_slot.row, coefficient) {
                            axpy(g, &columns[k * m..(k + 1) * m], target);
                        }
                    }
                }
            }
        }
        matrix
    }

    /// Displacement coefficients in `row` per unit of one coefficient of the force in `column`.
    #[inline(always)]
    fn compliance_entries(
        &self,
        row: usize,
        column: usize,
        coefficient: usize,
    ) -> [(usize, f64); 2] {
        let h = &self.compliance[coefficient.div_ceil(2)];
        let (re, im) = (h.real[(row, column)], h.imaginary[(row, column)]);
        match coefficient {
            0 => [(0, re), (0, 0.0)],
            cosine if cosine % 2 == 1 => [(cosine, re), (cosine + 1, -im)],
            sine => [(sine - 1, im), (sine, re)],
        }
    }
}

/// The arguments of [`Capacitance::take_motion`], for the instruction set that is found at run time.
struct TakeMotion<'a> {
    capacitance: &'a Capacitance,
    y: &'a [f64],
    x: &'a mut [f64],
}

impl WithSimd for TakeMotion<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Capacitance {
            layout,
            compliance,
            slots,
        } = self.capacitance;
        let n = layout.n_relative();
        let (x_rest, x_moving) = self.x.split_at_mut(n);
        for (slot, y) in slots.iter().zip(self.y.chunks_exact(layout.n_coefficients)) {
            axpy(-y[0], compliance[0].real.col_as_slice(slot.row), x_rest);
            for ((h, y), x) in (compliance[1..].iter())
                .zip(y[1..].chunks_exact(2))
                .zip(x_moving.chunks_exact_mut(2 * n))
            {
                let (x_c, x_s) = x.split_at_mut(n);
                let column = [&h.real, &h.imaginary].map(|part| part.col_as_slice(slot.row));
                axpy_complex((-y[0], -y[1]), column, (x_c, x_s));
            }
        }
    }
}

/// The arguments of [`Capacitance::add_forces`], for the instruction set that is found at run time.
struct AddForces<'a> {
    capacitance: &'a Capacitance,
    x: &'a [f64],
    y: &'a mut [f64],
}

impl WithSimd for AddForces<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Capacitance { layout, slots, .. } = self.capacitance;
        let (m, n) = (layout.n_coefficients, layout.n_relative());
        for (slot, y) in slots.iter().zip(self.y.chunks_exact_mut(m)) {
            for (row, columns) in &slot.reads {
                for (x, column) in self.x.chunks_exact(n).zip(columns.chunks_exact(m)) {
                    axpy(x[*row], column, y);
                }
            }
        }
    }
}

/// The arguments of [`Capacitance::matrix`], for the instruction set that is found at run time.
struct Assembly<'a> {
    capacitance: &'a Capacitance,
    slots: Range<usize>,
}

impl WithSimd for Assembly<'_> {
    type Output = Mat<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Mat<f64> {
        self.capacitance.assembled(self.slots)
    }
}

impl Slot {
    fn new(layout: &Layout, component: usize, tangent: &PairTangent) -> Option<Self> {
        let m = layout.n_coefficients;
        let at = |component: usize| component * layout.n_pairs + tangent.pair;
        let transposed = |values: &[f64]| {
            let mut columns = vec![0.0; m * m];
            for (j, column) in columns.chunks_exact_mut(m).enumerate() {
                (column.iter_mut().zip(values[j..].iter().step_by(m))).for_each(|(c, v)| *c = *v);
            }
            columns
        };
        let mut reads: Vec<_> = (tangent.blocks.iter())
            .filter(|(row, ..)| *row == component)
            .map(|(_, column, values)| (at(*column), transposed(values)))
            .collect();
        if reads.is_empty() {
            return None;
        }
        let row = at(component);
        let own = reads.iter_mut().find(|(column, _)| *column == row);
        let springs = match own {
            Some((_, own)) => take_springs(own, m),
            None => vec![c64::new(0.0, 0.0); m.div_ceil(2)],
        };
        Some(Self {
            component,
            row,
            springs,
            reads,
        })
    }
}

/// Splits D off a block dg, stored by columns: returns for each harmonic the complex number that multiplies x̂ = x_c − i x_s,
/// and leaves e in the block.
fn take_springs(columns: &mut [f64], m: usize) -> Vec<c64> {
    let mut springs = Vec::with_capacity(m.div_ceil(2));
    springs.push(c64::new(columns[0], 0.0));
    columns[0] = 0.0;
    for (c, s) in (1..m).step_by(2).map(|c| (c, c + 1)) {
        let [cc, sc, cs, ss] = [(c, c), (c, s), (s, c), (s, s)].map(|(j, i)| j * m + i);
        let spring = c64::new(
            0.5 * (columns[cc] + columns[ss]),
            0.5 * (columns[cs] - columns[sc]),
        );
        columns[cc] -= spring.re;
        columns[ss] -= spring.re;
        columns[cs] -= spring.im;
        columns[sc] += spring.im;
        springs.push(spring);
    }
    springs
}
