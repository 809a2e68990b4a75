//! Products with the Jacobian of the free form in single precision, for all harmonics of several vectors at once.

use super::balance::ContactResponse;
use super::free::{FreeBalance, FreeMotion, coefficient};
use crate::linalg::single::{LANES, add_products, filled, round, rounded};
use faer::Mat;
use pulp::{Arch, Simd, WithSimd};

/// A matrix by columns, each filled up with zeros to whole vectors.
#[derive(Debug)]
struct SingleMatrix {
    columns: Vec<f32>,
    stride: usize,
}

/// L and Lᵀ of one part of the model, the latter with the mirror images.
#[derive(Debug)]
struct SinglePart {
    real: SingleShapes,
    /// The same of the imaginary part of L, where it has one.
    imaginary: Option<SingleShapes>,
}

#[derive(Debug)]
struct SingleShapes {
    shapes: SingleMatrix,
    loads: SingleMatrix,
}

/// What the Jacobians of one problem share.
#[derive(Debug)]
pub(in crate::hb) struct SingleModes {
    parts: Vec<SinglePart>,
    /// G_ref.
    compliance: SingleMatrix,
    /// K_ref and K_c. Shape: `[3·n_contacts]`.
    reference: Vec<f32>,
    stiffness: Vec<f32>,
}

/// J at one point.
#[derive(Debug)]
pub(in crate::hb) struct SingleJacobian<'a> {
    free: &'a FreeBalance<'a>,
    modes: &'a SingleModes,
    /// Real and imaginary parts of D_k.
    receptance: Vec<[Vec<f32>; 2]>,
    blocks: Vec<SingleBlock>,
}

/// Derivative of one force component of a pair by one of its displacement components, less K_c.
#[derive(Debug)]
struct SingleBlock {
    /// Rows of the force and of the displacement in a coefficient.
    rows: [usize; 2],
    /// By columns, each filled up with zeros to whole vectors.
    columns: Vec<f32>,
}

impl SingleMatrix {
    fn new<'a>(rows: usize, columns: impl ExactSizeIterator<Item = &'a [f64]>) -> Self {
        Self {
            columns: filled(rows, columns),
            stride: rows.next_multiple_of(LANES),
        }
    }

    /// A x for each `x`, one after the other.
    #[inline(always)]
    fn times<S: Simd>(&self, simd: S, x: &[&[f32]]) -> Vec<f32> {
        let mut y = vec![0.0; x.len() * self.stride];
        for (x, y) in x.chunks(4).zip(y.chunks_mut(4 * self.stride)) {
            let y = y.chunks_exact_mut(self.stride);
            match *x {
                [a, b, c, d] => self.add(simd, [a, b, c, d], y),
                [a, b, c] => self.add(simd, [a, b, c], y),
                [a, b] => self.add(simd, [a, b], y),
                [a] => self.add(simd, [a], y),
                _ => {}
            }
        }
        y
    }

    #[inline(always)]
    fn add<'y, S: Simd, const K: usize>(
        &self,
        simd: S,
        x: [&[f32]; K],
        mut y: impl Iterator<Item = &'y mut [f32]>,
    ) {
        let y = std::array::from_fn(|_| y.next().unwrap_or_default());
        add_products::<S, K>(simd, 1.0, &self.columns, x, 1, y);
    }
}

impl SingleModes {
    pub(in crate::hb) fn new(free: &FreeBalance<'_>) -> Self {
        let (reference, problem) = (free.reference, free.balance.problem);
        let n = free.balance.layout.n_relative();
        let parts = problem.model.parts.iter().map(|part| {
            let single = |shapes: &Mat<f64>| {
                let mut loads = shapes.transpose().to_owned();
                loads *= faer::Scale(part.multiplicity);
                let modes = shapes.ncols();
                SingleShapes {
                    shapes: SingleMatrix::new(n, (0..modes).map(|j| shapes.col_as_slice(j))),
                    loads: SingleMatrix::new(modes, (0..n).map(|j| loads.col_as_slice(j))),
                }
            };
            SinglePart {
                real: single(&part.contact.real),
                imaginary: part.contact.imaginary.as_ref().map(single),
            }
        });
        let compliance = &reference.compliance;
        Self {
            parts: parts.collect(),
            compliance: SingleMatrix::new(n, (0..n).map(|j| compliance.col_as_slice(j))),
            reference: rounded(&reference.stiffness),
            stiffness: rounded(&problem.stuck_stiffness),
        }
    }
}

impl<'a> SingleJacobian<'a> {
    pub(in crate::hb) fn new(
        free: &'a FreeBalance<'a>,
        modes: &'a SingleModes,
        contact: &ContactResponse,
        motion: &FreeMotion,
    ) -> Self {
        let (n_c, m) = (
            free.balance.layout.n_pairs,
            free.balance.layout.n_coefficients,
        );
        let stride = m.next_multiple_of(LANES);
        let mut blocks = Vec::new();
        for tangent in &contact.active {
            for (row, column, block) in &tangent.blocks {
                let mut columns = vec![0.0; stride * m];
                let mut entries = vec![0.0; m];
                for (a, row) in block.chunks_exact(m).enumerate() {
                    round(row, &mut entries);
                    for (j, entry) in entries.iter().enumerate() {
                        columns[j * stride + a] = *entry;
                    }
                }
                let rows = [row, column].map(|component| component * n_c + tangent.pair);
                blocks.push(SingleBlock { rows, columns });
            }
        }
        let receptance = motion.receptance.iter().map(|d| {
            let (real, imaginary): (Vec<f64>, Vec<f64>) = d.iter().map(|d| (d.re, d.im)).unzip();
            [rounded(&real), rounded(&imaginary)]
        });
        Self {
            receptance: receptance.collect(),
            free,
            modes,
            blocks,
        }
    }

    /// J x for each `x`.
    pub(in crate::hb) fn products(&self, x: &[Vec<f32>]) -> Vec<Vec<f32>> {
        Arch::new().dispatch(Products { jacobian: self, x })
    }

    /// (∂F/∂r) x.
    #[inline(always)]
    fn contact_rate(&self, x: &[f32]) -> Vec<f32> {
        let (n, m) = (
            self.modes.stiffness.len(),
            self.free.balance.layout.n_coefficients,
        );
        let stride = m.next_multiple_of(LANES);
        let mut rate = x.to_vec();
        for coefficient in rate.chunks_exact_mut(n) {
            for (rate, k) in coefficient.iter_mut().zip(&self.modes.stiffness) {
                *rate *= k;
            }
        }
        let mut force = vec![0.0; stride];
        for SingleBlock { rows, columns } in &self.blocks {
            force.fill(0.0);
            for (a, column) in columns.chunks_exact(stride).enumerate() {
                let x = x[a * n + rows[1]];
                for (force, entry) in force.iter_mut().zip(column) {
                    *force += entry * x;
                }
            }
            for (a, force) in force[..m].iter().enumerate() {
                rate[a * n + rows[0]] += force;
            }
        }
        rate
    }

    /// `out`₀ += G_ref (rate₀ − K_ref x₀) for each vector.
    #[inline(always)]
    fn add_rest<S: Simd>(&self, simd: S, x: &[Vec<f32>], rates: &[Vec<f32>], out: &mut [Vec<f32>]) {
        let n = self.modes.reference.len();
        let mut forces = Vec::with_capacity(x.len());
        for (x, rate) in x.iter().zip(rates) {
            let mut force = rate[..n].to_vec();
            for ((force, x), k) in force.iter_mut().zip(x).zip(&self.modes.reference) {
                *force -= k * x;
            }
            forces.push(force);
        }
        let forces: Vec<&[f32]> = forces.iter().map(Vec::as_slice).collect();
        let moved = self.modes.compliance.times(simd, &forces);
        let moved = moved.chunks_exact(self.modes.compliance.stride);
        for (out, moved) in out.iter_mut().zip(moved) {
            add(moved, &mut out[..n]);
        }
    }

    /// `out`ₖ += L D_k Lᵀ rateₖ for the harmonics `of_part` of each vector.
    #[inline(always)]
    fn add_dynamic<S: Simd>(
        &self,
        simd: S,
        part: &SinglePart,
        of_part: &[usize],
        rates: &[Vec<f32>],
        out: &mut [Vec<f32>],
    ) {
        let n = self.modes.stiffness.len();
        let mut forces: Vec<&[f32]> = Vec::new();
        for rate in rates {
            for j in 0..2 * of_part.len() {
                let a = coefficient(of_part, j);
                forces.push(&rate[a * n..(a + 1) * n]);
            }
        }
        let SinglePart { real, imaginary } = part;
        let mut modal = real.loads.times(simd, &forces);
        let stride = real.loads.stride;
        if let Some(imaginary) = imaginary {
            // −i (f_c − i f_s)
            add_turned(
                &imaginary.loads.times(simd, &forces),
                -1.0,
                stride,
                &mut modal,
            );
        }
        for (i, both) in modal.chunks_exact_mut(2 * stride).enumerate() {
            let [real, imaginary] = &self.receptance[of_part[i % of_part.len()]];
            let (cosine, sine) = both.split_at_mut(stride);
            for (((c, s), re), im) in (cosine.iter_mut().zip(sine)).zip(real).zip(imaginary) {
                (*c, *s) = (re * *c + im * *s, re * *s - im * *c);
            }
        }
        let modes = self.receptance[of_part[0]][0].len();
        let modal: Vec<&[f32]> = modal.chunks_exact(stride).map(|x| &x[..modes]).collect();
        let stride = real.shapes.stride;
        let mut moved = real.shapes.times(simd, &modal);
        if let Some(imaginary) = imaginary {
            add_turned(
                &imaginary.shapes.times(simd, &modal),
                1.0,
                stride,
                &mut moved,
            );
        }
        let mut moved = moved.chunks_exact(stride);
        for out in out {
            for (j, moved) in (0..2 * of_part.len()).zip(&mut moved) {
                let a = coefficient(of_part, j);
                add(moved, &mut out[a * n..(a + 1) * n]);
            }
        }
    }
}

/// The arguments of [`SingleJacobian::products`], for the instruction set that is found at run time.
struct Products<'a> {
    jacobian: &'a SingleJacobian<'a>,
    x: &'a [Vec<f32>],
}

impl WithSimd for Products<'_> {
    type Output = Vec<Vec<f32>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<Vec<f32>> {
        let Self { jacobian, x } = self;
        let mut rates = Vec::with_capacity(x.len());
        for x in x {
            rates.push(jacobian.contact_rate(x));
        }
        let mut out = x.to_vec();
        jacobian.add_rest(simd, x, &rates, &mut out);
        for (part, of_part) in jacobian.free.groups() {
            let part = &jacobian.modes.parts[*part];
            jacobian.add_dynamic(simd, part, of_part, &rates, &mut out);
        }
        out
    }
}

/// y += `sign` i x, amplitude by amplitude: cosines of length `stride`, and sines.
#[inline(always)]
fn add_turned(x: &[f32], sign: f32, stride: usize, y: &mut [f32]) {
    for (x, y) in x
        .chunks_exact(2 * stride)
        .zip(y.chunks_exact_mut(2 * stride))
    {
        let (x, y) = (x.split_at(stride), y.split_at_mut(stride));
        for (y, x) in y.0.iter_mut().zip(x.1) {
            *y += sign * x;
        }
        for (y, x) in y.1.iter_mut().zip(x.0) {
            *y -= sign * x;
        }
    }
}

#[inline(always)]
fn add(x: &[f32], y: &mut [f32]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += x;
    }
}
