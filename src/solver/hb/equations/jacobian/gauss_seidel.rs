//! The preconditioner of large systems: one Gauss–Seidel sweep over blocks of C.
//!
//! The time of a sweep is that of reading C from memory. So it works in single precision, which halves the memory. The caller
//! computes the residual that this leaves in double precision. Columns of matrices are filled with zeros up to a multiple of
//! the vector register; where a column is added to one slot, its zeros are added to the first numbers of the next slot.

use super::capacitance::Capacitance;
use crate::linalg::single::{LANES, SingleLu, add_products, filled, round, vectors, vectors_mut};
use faer::prelude::*;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Most unknowns of a block. Of 90, 130, 200 and 260, peaks of the two-blade rig took the least time with 130 (5 and 21
/// harmonics), by a twentieth.
const BLOCK_UNKNOWNS: usize = 130;

/// Slots that a block may have even with more unknowns. If neighbouring slots are in different blocks, the number of
/// iterations grows with the harmonics. Of 1, 2, 3, 4, 6, 8 and 15 (all) slots, peaks of the two-blade rig with 28 to 80
/// harmonics took the least time with 6.
const BLOCK_SLOTS: usize = 6;

/// C = I + e G' in single precision, with the factors of its diagonal blocks.
#[derive(Debug)]
pub(super) struct GaussSeidel {
    /// Coefficients of a slot.
    m: usize,
    /// Relative displacements of one coefficient, with the zeros that fill the last register.
    n: usize,
    slots: Vec<SingleSlot>,
    /// Real and imaginary part of G' (m/N) of harmonic 0 and of those above, by columns.
    compliance: Vec<[Vec<f32>; 2]>,
    blocks: Vec<SlotBlock>,
}

/// One force component of one pair.
#[derive(Debug)]
struct SingleSlot {
    /// Index of its displacement among those of one coefficient.
    row: usize,
    /// Displacements that the force depends on, each with its block of e by columns.
    reads: Vec<(usize, Vec<f32>)>,
}

/// Neighbouring slots of one force component.
#[derive(Debug)]
struct SlotBlock {
    slots: Range<usize>,
    /// LU factors of the diagonal block of C of these slots.
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

    /// (z, C z) of each v, with z from one sweep for C z = v. Two at a time take little longer than one: the time is that of
    /// reading C.
    pub(super) fn apply(&self, v: &[&[f64]]) -> Vec<(Vec<f64>, Vec<f64>)> {
        let (pairs, single) = v.as_chunks::<2>();
        let pairs = pairs.iter().flat_map(|v| self.swept(*v));
        pairs
            .chain(single.iter().flat_map(|v| self.swept([*v])))
            .collect()
    }

    /// The same of one v.
    pub(super) fn apply_to(&self, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let [applied] = self.swept([v]);
        applied
    }

    /// See [`Self::apply`].
    fn swept<const K: usize>(&self, v: [&[f64]; K]) -> [(Vec<f64>, Vec<f64>); K] {
        Arch::new().dispatch(Application { sweep: self, v })
    }

    /// See [`Self::apply`].
    #[inline(always)]
    fn applied<S: Simd, const K: usize>(
        &self,
        simd: S,
        v: [&[f64]; K],
    ) -> [(Vec<f64>, Vec<f64>); K] {
        let mut z = v.map(|v| {
            let mut z = vec![0.0; v.len().next_multiple_of(LANES) + LANES];
            round(v, &mut z);
            z
        });
        let mut x: [Vec<f32>; K] = std::array::from_fn(|_| vec![0.0; self.m * self.n]);
        for block in &self.blocks {
            let range = block.slots.start * self.m..block.slots.end * self.m;
            self.add_forces(simd, block.slots.clone(), -1.0, &x, &mut z);
            let solved = z.each_mut().map(|z| &mut z[range.clone()]);
            block.factors.solve_in_place(simd, solved);
            let solved = z.each_ref().map(|z| &z[range.clone()]);
            self.add_motion(simd, block.slots.clone(), solved, &mut x);
        }
        let mut product = z.clone();
        self.add_forces(simd, 0..self.slots.len(), 1.0, &x, &mut product);
        let double = |y: &[f32]| y.iter().map(|y| f64::from(*y)).collect();
        std::array::from_fn(|k| {
            let size = v[k].len();
            (double(&z[k][..size]), double(&product[k][..size]))
        })
    }

    /// y += factor e x in a range of slots.
    #[inline(always)]
    fn add_forces<S: Simd, const K: usize>(
        &self,
        simd: S,
        range: Range<usize>,
        factor: f32,
        x: &[Vec<f32>; K],
        y: &mut [Vec<f32>; K],
    ) {
        let stride = self.m.next_multiple_of(LANES);
        for (slot, first) in self.slots[range.clone()].iter().zip(range) {
            for (row, columns) in &slot.reads {
                let x = x.each_ref().map(|x| &x[*row..]);
                let y = (y.each_mut()).map(|y| &mut y[first * self.m..][..stride]);
                add_products(simd, factor, columns, x, self.n, y);
            }
        }
    }

    /// x += G' y for the forces y of a range of slots.
    #[inline(always)]
    fn add_motion<S: Simd, const K: usize>(
        &self,
        simd: S,
        range: Range<usize>,
        y: [&[f32]; K],
        x: &mut [Vec<f32>; K],
    ) {
        let (m, n) = (self.m, self.n);
        for (i, slot) in self.slots[range.clone()].iter().enumerate() {
            let column = &self.compliance[0][0][slot.row * n..][..n];
            let y = y.map(|y| &y[i * m..]);
            let rest = x.each_mut().map(|x| &mut x[..n]);
            add_products(simd, 1.0, column, y, 1, rest);
        }
        for k in 0..self.compliance.len() - 1 {
            let coefficient = 1 + 2 * k;
            let y = y.map(|y| &y[coefficient..]);
            let x = (x.each_mut()).map(|x| &mut x[coefficient * n..(coefficient + 2) * n]);
            self.add_harmonic(simd, k + 1, &self.slots[range.clone()], y, x);
        }
    }

    /// The same for one harmonic; y begins with its coefficients in the first slot.
    #[inline(always)]
    fn add_harmonic<S: Simd, const K: usize>(
        &self,
        simd: S,
        harmonic: usize,
        slots: &[SingleSlot],
        y: [&[f32]; K],
        x: [&mut [f32]; K],
    ) {
        let (m, n) = (self.m, self.n);
        let [real, imaginary] = &self.compliance[harmonic];
        let mut x = x.map(vectors_mut::<S>);
        let n_vectors = x[0].len() / 2;
        for v in 0..n_vectors {
            let mut sums = [[simd.splat_f32s(0.0); 2]; K];
            for (sums, x) in sums.iter_mut().zip(&x) {
                *sums = [x[v], x[n_vectors + v]];
            }
            for (i, slot) in slots.iter().enumerate() {
                let column = slot.row * n..(slot.row + 1) * n;
                let re = vectors::<S>(&real[column.clone()])[v];
                let im = vectors::<S>(&imaginary[column])[v];
                for ([cosine, sine], y) in sums.iter_mut().zip(y) {
                    let (y_c, y_s) = (y[i * m], y[i * m + 1]);
                    let minus_y_c = simd.splat_f32s(-y_c);
                    let (y_c, y_s) = (simd.splat_f32s(y_c), simd.splat_f32s(y_s));
                    *cosine = simd.mul_add_f32s(re, y_c, simd.mul_add_f32s(im, y_s, *cosine));
                    *sine = simd.mul_add_f32s(re, y_s, simd.mul_add_f32s(im, minus_y_c, *sine));
                }
            }
            for (x, sums) in x.iter_mut().zip(sums) {
                [x[v], x[n_vectors + v]] = sums;
            }
        }
    }
}

/// Blocks of neighbouring slots of one force component.
fn blocks(exact: &Capacitance) -> Vec<SlotBlock> {
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
            blocks.push(SlotBlock { slots, factors });
        }
        start += same.len();
    }
    blocks
}

/// The arguments of [`GaussSeidel::apply`], for the instruction set that is found at run time.
struct Application<'a, const K: usize> {
    sweep: &'a GaussSeidel,
    v: [&'a [f64]; K],
}

impl<const K: usize> WithSimd for Application<'_, K> {
    type Output = [(Vec<f64>, Vec<f64>); K];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.sweep.applied(simd, self.v)
    }
}
