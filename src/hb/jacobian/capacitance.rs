//! The equations that are left of J x = b once everything linear is eliminated.
//!
//! y = dg x obeys C y = dg b with C = I + dg G, and x = b − G y (C is the capacitance matrix of Woodbury's identity).
//! dg has rows only for the force components that deviate from the stuck contact: the "slots". A pair that slips in one
//! direction has one slot, a pair that opens three. Vectors are slot-major, `[slot][coefficient]`.

use super::PairTangent;
use crate::hb::balance::Layout;
use crate::hb::compliance::Compliance;
use crate::linalg::vector::axpy;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Force components in the order of elimination: the normal force drives the tangential ones, not the other way round.
const ORDER: [usize; 3] = [2, 0, 1];

/// Largest blocks of the Gauss–Seidel sweep. Of 70, 130, 200, 300 and 500 unknowns 200 made setup and two solves cheapest
/// on peaks of the two-blade rig (3 to 21 harmonics, soft and stiff contacts); 130 and 300 cost up to 1.5 times as much.
const BLOCK_UNKNOWNS: usize = 200;

/// C = I + dg G at one iterate.
#[derive(Debug)]
pub(super) struct Capacitance<'a> {
    layout: Layout,
    static_compliance: &'a Mat<f64>,
    compliance: &'a Compliance<'a>,
    slots: Vec<Slot>,
}

/// One force component of one pair.
#[derive(Debug)]
struct Slot {
    component: usize,
    /// Position among the relative displacements of one coefficient.
    row: usize,
    /// Displacements that the force depends on, each with its block of dg by columns. Shape: `[column m][row m]`.
    reads: Vec<(usize, Vec<f64>)>,
}

/// Neighbouring slots with the factors of their diagonal block of C, in single precision: a preconditioner need not be
/// exact, and half of the memory is half of the time.
#[derive(Debug)]
pub(super) struct Block {
    slots: Range<usize>,
    factors: PartialPivLu<f32>,
}

impl<'a> Capacitance<'a> {
    /// Collects the slots of the active pairs.
    pub(super) fn new(
        layout: &Layout,
        static_compliance: &'a Mat<f64>,
        compliance: &'a Compliance<'a>,
        active: &[PairTangent],
    ) -> Self {
        let slots = (ORDER.iter())
            .flat_map(|&component| {
                active
                    .iter()
                    .filter_map(move |t| Slot::new(layout, component, t))
            })
            .collect();
        Self {
            layout: *layout,
            static_compliance,
            compliance,
            slots,
        }
    }

    /// Number of unknowns.
    pub(super) fn size(&self) -> usize {
        self.slots.len() * self.layout.n_coefficients
    }

    /// dg x for displacements x. Shape: as the unknowns → slot-major.
    pub(super) fn deviation(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size()];
        for (slot, y) in (self.slots.iter()).zip(y.chunks_exact_mut(self.layout.n_coefficients)) {
            slot.add_deviation(&self.layout, 1.0, x, y);
        }
        y
    }

    /// Forces y in the order of the unknowns.
    pub(super) fn spread(&self, y: &[f64]) -> Vec<f64> {
        let n = self.layout.n_relative();
        let mut out = vec![0.0; self.layout.n_unknowns()];
        for (slot, y) in (self.slots.iter()).zip(y.chunks_exact(self.layout.n_coefficients)) {
            for (coefficient, y) in out.chunks_exact_mut(n).zip(y) {
                coefficient[slot.row] = *y;
            }
        }
        out
    }

    /// x += G y for the forces y of a range of slots.
    #[inline(always)]
    fn add_compliance(&self, slots: Range<usize>, y: &[f64], x: &mut [f64]) {
        let n = self.layout.n_relative();
        let m = self.layout.n_coefficients;
        let (x_rest, x_moving) = x.split_at_mut(n);
        for (slot, y) in self.slots[slots].iter().zip(y.chunks_exact(m)) {
            axpy(y[0], self.static_compliance.col_as_slice(slot.row), x_rest);
            for ((h, y), x) in (self.compliance.harmonics.iter())
                .zip(y[1..].chunks_exact(2))
                .zip(x_moving.chunks_exact_mut(2 * n))
            {
                let (x_c, x_s) = x.split_at_mut(n);
                let real = h.real.col_as_slice(slot.row);
                let imaginary = h.imaginary.col_as_slice(slot.row);
                for (((c, s), re), im) in (x_c.iter_mut().zip(x_s)).zip(real).zip(imaginary) {
                    *c += re * y[0] + im * y[1];
                    *s += re * y[1] - im * y[0];
                }
            }
        }
    }

    /// LU factors of C.
    pub(super) fn dense_factors(&self) -> PartialPivLu<f64> {
        self.matrix(0..self.slots.len()).partial_piv_lu()
    }

    /// The diagonal block of C that belongs to a range of slots.
    fn matrix(&self, slots: Range<usize>) -> Mat<f64> {
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
        let Some(moving) = coefficient.checked_sub(1) else {
            return [(0, self.static_compliance[(row, column)]), (0, 0.0)];
        };
        let h = &self.compliance.harmonics[moving / 2];
        let (re, im) = (h.real[(row, column)], h.imaginary[(row, column)]);
        if moving % 2 == 0 {
            [(coefficient, re), (coefficient + 1, -im)]
        } else {
            [(coefficient - 1, im), (coefficient, re)]
        }
    }

    /// Blocks of a Gauss–Seidel sweep: neighbouring slots of one force component.
    pub(super) fn blocks(&self) -> Vec<Block> {
        let most = (BLOCK_UNKNOWNS / self.layout.n_coefficients).max(1);
        let mut blocks = Vec::new();
        let mut start = 0;
        for same in self.slots.chunk_by(|a, b| a.component == b.component) {
            let parts = same.len().div_ceil(most);
            for part in 0..parts {
                let at = |part: usize| start + part * same.len() / parts;
                let slots = at(part)..at(part + 1);
                blocks.push(Block::new(slots.clone(), &self.matrix(slots)));
            }
            start += same.len();
        }
        blocks
    }

    /// (z, C z) with z from one Gauss–Seidel sweep for C z = v.
    pub(super) fn sweep(&self, blocks: &[Block], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        Arch::new().dispatch(Sweep {
            capacitance: self,
            blocks,
            v,
        })
    }

    /// See [`Self::sweep`].
    #[inline(always)]
    fn swept(&self, blocks: &[Block], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let m = self.layout.n_coefficients;
        let mut z = v.to_vec();
        let mut displacement = vec![0.0; self.layout.n_unknowns()];
        for block in blocks {
            let z = &mut z[block.slots.start * m..block.slots.end * m];
            for (slot, z) in (self.slots[block.slots.clone()].iter()).zip(z.chunks_exact_mut(m)) {
                slot.add_deviation(&self.layout, -1.0, &displacement, z);
            }
            block.solve_in_place(z);
            self.add_compliance(block.slots.clone(), z, &mut displacement);
        }
        let mut product = z.clone();
        for (slot, product) in self.slots.iter().zip(product.chunks_exact_mut(m)) {
            slot.add_deviation(&self.layout, 1.0, &displacement, product);
        }
        (z, product)
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a preconditioner in single precision"
)]
impl Block {
    fn new(slots: Range<usize>, matrix: &Mat<f64>) -> Self {
        let (n, m) = (matrix.nrows(), matrix.ncols());
        let single = Mat::<f32>::from_fn(n, m, |i, j| matrix[(i, j)] as f32);
        Self {
            slots,
            factors: single.partial_piv_lu(),
        }
    }

    /// x ← C⁻¹ x with this block of C.
    fn solve_in_place(&self, x: &mut [f64]) {
        let mut single: Vec<f32> = x.iter().map(|x| *x as f32).collect();
        (self.factors).solve_in_place(ColMut::from_slice_mut(&mut single));
        x.iter_mut()
            .zip(single)
            .for_each(|(x, single)| *x = f64::from(single));
    }
}

/// The arguments of [`Capacitance::matrix`], for the instruction set that is found at run time.
struct Assembly<'a, 'c> {
    capacitance: &'a Capacitance<'c>,
    slots: Range<usize>,
}

impl WithSimd for Assembly<'_, '_> {
    type Output = Mat<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Mat<f64> {
        self.capacitance.assembled(self.slots)
    }
}

/// The arguments of [`Capacitance::sweep`], for the instruction set that is found at run time.
struct Sweep<'a, 'c> {
    capacitance: &'a Capacitance<'c>,
    blocks: &'a [Block],
    v: &'a [f64],
}

impl WithSimd for Sweep<'_, '_> {
    type Output = (Vec<f64>, Vec<f64>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        self.capacitance.swept(self.blocks, self.v)
    }
}

impl Slot {
    fn new(layout: &Layout, component: usize, tangent: &PairTangent) -> Option<Self> {
        let m = layout.n_coefficients;
        let at = |component: usize| component * layout.n_pairs + tangent.pair;
        let transposed = |values: &[f64]| -> Vec<f64> {
            let column = |j: usize| values[j..].iter().step_by(m).copied();
            (0..m).flat_map(column).collect()
        };
        let reads: Vec<_> = (tangent.blocks.iter())
            .filter(|(row, ..)| *row == component)
            .map(|(_, column, values)| (at(*column), transposed(values)))
            .collect();
        (!reads.is_empty()).then(|| Self {
            component,
            row: at(component),
            reads,
        })
    }

    /// y += factor dg x in this slot.
    #[inline(always)]
    fn add_deviation(&self, layout: &Layout, factor: f64, x: &[f64], y: &mut [f64]) {
        let (m, n) = (layout.n_coefficients, layout.n_relative());
        for (row, columns) in &self.reads {
            for (x, column) in x.chunks_exact(n).zip(columns.chunks_exact(m)) {
                axpy(factor * x[*row], column, y);
            }
        }
    }
}

/// x ← A⁻¹ x.
pub(super) fn solve_in_place(factors: &PartialPivLu<f64>, x: &mut [f64]) {
    factors.solve_in_place(ColMut::from_slice_mut(x));
}
