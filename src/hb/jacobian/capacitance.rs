//! The equations that are left of J x = b once everything linear is eliminated.
//!
//! dg has rows only for the force components that deviate from the stuck contact: the "slots". A pair that slips in one
//! direction has one slot, a pair that opens three. Vectors are slot-major, `[slot][coefficient]`.
//!
//! What a slot does to its own displacement at one harmonic is, apart from the coupling of harmonics, a complex spring D
//! (the contact, linearised harmonic by harmonic); softer than the stuck contact it takes away. With dg = D + e and the
//! compliance G' = (I + G D)⁻¹ G with these springs, J x = b becomes x + G' e x = b' with b' = b − G' D b, so that y = e x
//! obeys C y = e b' with C = I + e G' (the capacitance matrix of Woodbury's identity), and x = b' − G' y. C is closer to I
//! than I + dg G: where contacts are stiff and open, that is nearly singular, pair by pair.

use super::PairTangent;
use crate::hb::balance::Layout;
use crate::hb::compliance::Compliance;
use crate::hb::springs::Symmetric;
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

/// So many unknowns and more are worth springs. At 495 (45 slots, 5 harmonics) attaching them costs as much as the sweeps
/// they save, at 1935 (21 harmonics) it halves the sweeps of stiff contacts and is a tenth of the time.
const SPRINGS_FROM: usize = 1000;

/// C = I + e G' at one iterate.
#[derive(Debug)]
pub(super) struct Capacitance {
    layout: Layout,
    /// G' of the 0th and of the dynamic harmonics.
    compliance: Vec<Symmetric>,
    slots: Vec<Slot>,
}

/// One force component of one pair.
#[derive(Debug)]
struct Slot {
    component: usize,
    /// Position among the relative displacements of one coefficient.
    row: usize,
    /// D (N/m) at the 0th and the dynamic harmonics; zero where springs are not worth their cost.
    springs: Vec<c64>,
    /// Displacements that the force depends on, each with its block of e by columns. Shape: `[column m][row m]`.
    reads: Vec<(usize, Vec<f64>)>,
}

/// Neighbouring slots with the factors of their diagonal block of C, in single precision: a preconditioner need not be
/// exact, and half of the memory is half of the time.
#[derive(Debug)]
pub(super) struct Block {
    slots: Range<usize>,
    factors: PartialPivLu<f32>,
}

impl Capacitance {
    /// Collects the slots of the active pairs.
    pub(super) fn new(
        layout: &Layout,
        static_compliance: &Mat<f64>,
        compliance: &Compliance<'_>,
        active: &[PairTangent],
    ) -> Self {
        let mut slots: Vec<Slot> = (ORDER.iter())
            .flat_map(|&component| {
                active
                    .iter()
                    .filter_map(move |t| Slot::new(layout, component, t))
            })
            .collect();
        if slots.len() * layout.n_coefficients >= SPRINGS_FROM {
            (slots.iter_mut()).for_each(|slot| slot.take_springs(layout.n_coefficients));
        }
        let n = layout.n_relative();
        let rest = Symmetric {
            real: static_compliance.clone(),
            imaginary: Mat::zeros(n, n),
        };
        let moving = compliance.harmonics.iter().map(|h| Symmetric {
            real: h.real.clone(),
            imaginary: h.imaginary.clone(),
        });
        let with_springs = |(order, stuck): (usize, Symmetric)| {
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
        let n = self.layout.n_relative();
        let mut out = vec![0.0; self.layout.n_unknowns()];
        let forces = self.slots.iter().zip(self.spring_forces(x));
        for (slot, mut y) in forces {
            slot.add_deviation(&self.layout, 1.0, x, &mut y);
            for (coefficient, y) in out.chunks_exact_mut(n).zip(y) {
                coefficient[slot.row] = y;
            }
        }
        out
    }

    /// x = J⁻¹ b, where `solve` is y ← C⁻¹ y. Shape: as the unknowns.
    pub(super) fn solve(&self, b: &[f64], solve: impl FnOnce(&mut [f64])) -> Vec<f64> {
        let negated = |y: &[f64]| -> Vec<f64> { y.iter().map(|y| -y).collect() };
        let all = 0..self.slots.len();
        let m = self.layout.n_coefficients;
        let mut x = b.to_vec();
        let pull: Vec<f64> = self.spring_forces(b).flatten().collect();
        self.add_compliance(all.clone(), &negated(&pull), &mut x);
        let mut y = vec![0.0; self.size()];
        for (slot, y) in self.slots.iter().zip(y.chunks_exact_mut(m)) {
            slot.add_deviation(&self.layout, 1.0, &x, y);
        }
        solve(&mut y);
        self.add_compliance(all, &negated(&y), &mut x);
        x
    }

    /// D x, slot by slot.
    fn spring_forces(&self, x: &[f64]) -> impl Iterator<Item = Vec<f64>> {
        let n = self.layout.n_relative();
        self.slots.iter().map(move |slot| {
            let x: Vec<f64> = x[slot.row..].iter().step_by(n).copied().collect();
            let mut force = vec![slot.springs[0].re * x[0]];
            for (spring, x) in slot.springs[1..].iter().zip(x[1..].chunks_exact(2)) {
                let f = spring * c64::new(x[0], -x[1]);
                force.extend([f.re, -f.im]);
            }
            force
        })
    }

    /// x += G' y for the forces y of a range of slots.
    #[inline(always)]
    fn add_compliance(&self, slots: Range<usize>, y: &[f64], x: &mut [f64]) {
        let n = self.layout.n_relative();
        let m = self.layout.n_coefficients;
        let (x_rest, x_moving) = x.split_at_mut(n);
        for (slot, y) in self.slots[slots].iter().zip(y.chunks_exact(m)) {
            axpy(y[0], self.compliance[0].real.col_as_slice(slot.row), x_rest);
            for ((h, y), x) in (self.compliance[1..].iter())
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
        let h = &self.compliance[coefficient.div_ceil(2)];
        let (re, im) = (h.real[(row, column)], h.imaginary[(row, column)]);
        match coefficient {
            0 => [(0, re), (0, 0.0)],
            cosine if cosine % 2 == 1 => [(cosine, re), (cosine + 1, -im)],
            sine => [(sine - 1, im), (sine, re)],
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

/// The arguments of [`Capacitance::sweep`], for the instruction set that is found at run time.
struct Sweep<'a> {
    capacitance: &'a Capacitance,
    blocks: &'a [Block],
    v: &'a [f64],
}

impl WithSimd for Sweep<'_> {
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
            springs: vec![c64::new(0.0, 0.0); m.div_ceil(2)],
            reads,
        })
    }

    /// Parts dg into D and e.
    fn take_springs(&mut self, m: usize) {
        let row = self.row;
        if let Some((_, own)) = self.reads.iter_mut().find(|(column, _)| *column == row) {
            self.springs = take_springs(own, m);
        }
    }

    /// y += factor e x in this slot.
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

/// Takes out of a block, by columns, what multiplies each harmonic by a complex number: x̂ = x_c − i x_s.
fn take_springs(columns: &mut [f64], m: usize) -> Vec<c64> {
    let mut springs = vec![c64::new(columns[0], 0.0)];
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

/// x ← A⁻¹ x.
pub(super) fn solve_in_place(factors: &PartialPivLu<f64>, x: &mut [f64]) {
    factors.solve_in_place(ColMut::from_slice_mut(x));
}
