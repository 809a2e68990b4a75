//! One Gauss–Seidel sweep over blocks of C, the preconditioner of large systems.
//!
//! A sweep reads all of C from memory, so it works in single precision: half of the memory is half of the time. What that
//! leaves of a residual is found in double precision by its caller. Columns of matrices end with zeros that fill the last
//! vector register; where a column is added to one slot, these zeros reach into the next.

use super::capacitance::Capacitance;
use crate::linalg::single::{LANES, SingleLu, add_product, filled, round, vectors, vectors_mut};
use faer::prelude::*;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Largest blocks of the sweep. Of 90, 130, 200 and 260 unknowns 130 made peaks of the two-blade rig cheapest (5 and 21
/// harmonics), by a twentieth.
const BLOCK_UNKNOWNS: usize = 130;

/// Slots that a block may have whatever their unknowns: neighbours apart make the iterations grow with the harmonics. Of 1, 2,
/// 3, 4, 6, 8 and 15 slots (all) 6 made peaks of the two-blade rig with 28 to 80 harmonics cheapest.
const BLOCK_SLOTS: usize = 6;

/// C = I + e G' in single precision, with the factors of its diagonal blocks.
#[derive(Debug)]
pub(super) struct GaussSeidel {
    /// Coefficients of a slot.
    m: usize,
    /// Relative displacements of one coefficient, filled up.
    n: usize,
    slots: Vec<SingleSlot>,
    /// Real and imaginary part of G' of the 0th and the dynamic harmonics, by columns.
    compliance: Vec<[Vec<f32>; 2]>,
    blocks: Vec<Block>,
}

/// One force component of one pair.
#[derive(Debug)]
struct SingleSlot {
    /// Position among the relative displacements of one coefficient.
    row: usize,
    /// Displacements that the force depends on, each with its block of e by columns.
    reads: Vec<(usize, Vec<f32>)>,
}

/// Neighbouring slots of one force component.
#[derive(Debug)]
struct Block {
    slots: Range<usize>,
    /// Of their diagonal block of C.
    factors: SingleLu,
}

impl GaussSeidel {
    pub(super) fn new(exact: &Capacitance) -> Self {
        let m = exact.layout.n_coefficients;
        let slots = exact.slots.iter().map(|slot| SingleSlot {
            row: slot.row,
            reads: (slot.reads.iter())
                .map(|(row, columns)| (*row, filled(m, columns.chunks_exact(m))))
                .collect(),
        });
        let columns = |matrix: &Mat<f64>| {
            let column = |j| matrix.col_as_slice(j);
            filled(matrix.nrows(), (0..matrix.ncols()).map(column))
        };
        let compliance = (exact.compliance.iter()).map(|h| [&h.real, &h.imaginary].map(columns));
        Self {
            m,
            n: exact.layout.n_relative().next_multiple_of(LANES),
            slots: slots.collect(),
            compliance: compliance.collect(),
            blocks: blocks(exact),
        }
    }

    /// (z, C z) with z from one sweep for C z = v.
    pub(super) fn apply(&self, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        Arch::new().dispatch(Application { sweep: self, v })
    }

    /// See [`Self::apply`].
    #[inline(always)]
    fn applied<S: Simd>(&self, simd: S, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut z = vec![0.0; v.len().next_multiple_of(LANES) + LANES];
        round(v, &mut z);
        let mut x = vec![0.0; self.m * self.n];
        for block in &self.blocks {
            let range = block.slots.start * self.m..block.slots.end * self.m;
            self.add_forces(simd, block.slots.clone(), -1.0, &x, &mut z);
            let z = &mut z[range];
            block.factors.solve_in_place(simd, z);
            self.add_motion(simd, block.slots.clone(), z, &mut x);
        }
        let mut product = z.clone();
        self.add_forces(simd, 0..self.slots.len(), 1.0, &x, &mut product);
        let double = |y: Vec<f32>| y[..v.len()].iter().map(|y| f64::from(*y)).collect();
        (double(z), double(product))
    }

    /// y += factor e x in a range of slots.
    #[inline(always)]
    fn add_forces<S: Simd>(
        &self,
        simd: S,
        range: Range<usize>,
        factor: f32,
        x: &[f32],
        y: &mut [f32],
    ) {
        let stride = self.m.next_multiple_of(LANES);
        for (slot, first) in self.slots[range.clone()].iter().zip(range) {
            let y = &mut y[first * self.m..][..stride];
            for (row, columns) in &slot.reads {
                let x = x[*row..].iter().step_by(self.n);
                add_product(simd, factor, columns, x, y);
            }
        }
    }

    /// x += G' y for the forces y of a range of slots.
    #[inline(always)]
    fn add_motion<S: Simd>(&self, simd: S, range: Range<usize>, y: &[f32], x: &mut [f32]) {
        let (m, n) = (self.m, self.n);
        let slots = &self.slots[range];
        let (x_rest, x_moving) = x.split_at_mut(n);
        for (slot, y) in slots.iter().zip(y.chunks_exact(m)) {
            let column = &self.compliance[0][0][slot.row * n..][..n];
            add_product(simd, 1.0, column, [y[0]].iter(), x_rest);
        }
        let moving = self.compliance[1..].iter().enumerate();
        for ((k, [real, imaginary]), x) in moving.zip(x_moving.chunks_exact_mut(2 * n)) {
            let (cosine, sine) = x.split_at_mut(n);
            let (cosine, sine) = (vectors_mut::<S>(cosine), vectors_mut::<S>(sine));
            for (v, (c, s)) in cosine.iter_mut().zip(sine).enumerate() {
                let (mut sum_c, mut sum_s) = (*c, *s);
                for (slot, y) in slots.iter().zip(y.chunks_exact(m)) {
                    let column = slot.row * n..(slot.row + 1) * n;
                    let re = vectors::<S>(&real[column.clone()])[v];
                    let im = vectors::<S>(&imaginary[column])[v];
                    let (y_c, y_s) = (y[1 + 2 * k], y[2 + 2 * k]);
                    let [y_c, minus_y_c, y_s] = [y_c, -y_c, y_s].map(|y| simd.splat_f32s(y));
                    sum_c = simd.mul_add_f32s(re, y_c, simd.mul_add_f32s(im, y_s, sum_c));
                    sum_s = simd.mul_add_f32s(re, y_s, simd.mul_add_f32s(im, minus_y_c, sum_s));
                }
                (*c, *s) = (sum_c, sum_s);
            }
        }
    }
}

/// Blocks of neighbouring slots of one force component.
fn blocks(exact: &Capacitance) -> Vec<Block> {
    let most = (BLOCK_UNKNOWNS / exact.layout.n_coefficients).max(BLOCK_SLOTS);
    let mut blocks = Vec::new();
    let mut start = 0;
    for same in (exact.slots).chunk_by(|a, b| a.component == b.component) {
        let parts = same.len().div_ceil(most);
        for part in 0..parts {
            let at = |part: usize| start + part * same.len() / parts;
            let slots = at(part)..at(part + 1);
            let matrix = exact.matrix(slots.clone());
            let factors = SingleLu::new(&matrix);
            blocks.push(Block { slots, factors });
        }
        start += same.len();
    }
    blocks
}

/// The arguments of [`GaussSeidel::apply`], for the instruction set that is found at run time.
struct Application<'a> {
    sweep: &'a GaussSeidel,
    v: &'a [f64],
}

impl WithSimd for Application<'_> {
    type Output = (Vec<f64>, Vec<f64>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.sweep.applied(simd, self.v)
    }
}
