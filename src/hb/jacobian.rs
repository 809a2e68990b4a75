//! The Jacobian I + G dg of the balance equations and its inverse.
//!
//! dg = dF − K_c is zero for a pair that sticks all period long, so the system is solved for the other
//! ("active") pairs only; the rest follow by substitution. Few active unknowns are factorised densely, many are
//! solved by GMRES preconditioned by the diagonal blocks of the harmonics: a dense factor grows with the cube of
//! the number of harmonics, the block solve linearly.

use super::balance::Layout;
use super::compliance::Compliance;
use super::problem::Problem;
use crate::linalg::gmres::{GmresSettings, gmres};
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use std::cell::OnceCell;

/// Up to so many active unknowns a dense factor is cheaper than any Krylov solve.
const DENSE_LIMIT: usize = 350;

/// Up to so many it is cheaper than a Krylov solve that does not converge quickly.
const DENSE_FALLBACK_LIMIT: usize = 1400;

/// Krylov vectors tried before such a dense factor; soft contacts need 20 to 30, stiff ones a hundred.
const QUICK_ITERATIONS: usize = 45;

/// Krylov solves are this exact for the tangents: at 1e-7 the top of a blade's curve was found 2.8e-5 off in frequency.
const GMRES: GmresSettings = GmresSettings {
    tolerance: 1e-8,
    max_iterations: 250,
};

/// GMRES results worse than this are discarded in favour of a dense factor.
const GMRES_ACCEPTED: f64 = 1e-3;

/// Derivative of the force deviation g of one pair: blocks (force component, displacement component, m × m).
#[derive(Debug, Clone)]
pub struct PairTangent {
    /// Index of the pair.
    pub pair: usize,
    /// Nonzero blocks, row-major, row = force coefficient, column = displacement coefficient.
    pub blocks: Vec<(usize, usize, Vec<f64>)>,
}

/// J = I + G dg at one iterate, ready to be solved with.
#[derive(Debug)]
pub struct Jacobian<'a> {
    layout: Layout,
    compliance: &'a Compliance<'a>,
    static_compliance: &'a Mat<f64>,
    active: &'a [PairTangent],
    /// Positions of the active unknowns among the relative displacements of one coefficient.
    rows: Vec<usize>,
    /// G restricted to the active rows and columns: harmonic 0, then (real, imaginary) of the others.
    restricted: Vec<(Mat<f64>, Option<Mat<f64>>)>,
    solver: Solver,
}

#[derive(Debug)]
enum Solver {
    /// Nothing slips or separates: J = I.
    Identity,
    /// Dense LU of the active unknowns.
    Dense(PartialPivLu<f64>),
    /// LU of the diagonal blocks as preconditioner; the dense LU once a solve was too slow.
    Krylov {
        blocks: Vec<PartialPivLu<f64>>,
        dense: OnceCell<PartialPivLu<f64>>,
    },
}

impl<'a> Jacobian<'a> {
    /// Factorises what the solves need.
    #[must_use]
    pub fn new(
        layout: &Layout,
        problem: &'a Problem<'_>,
        compliance: &'a Compliance<'a>,
        active: &'a [PairTangent],
    ) -> Self {
        let rows: Vec<usize> = (0..3)
            .flat_map(|component| {
                active
                    .iter()
                    .map(move |t| component * layout.n_pairs + t.pair)
            })
            .collect();
        let pick =
            |g: &Mat<f64>| Mat::from_fn(rows.len(), rows.len(), |i, j| g[(rows[i], rows[j])]);
        let static_compliance = &problem.stuck_static.compliance;
        let restricted = std::iter::once((pick(static_compliance), None))
            .chain(
                compliance
                    .harmonics
                    .iter()
                    .map(|h| (pick(&h.real), Some(pick(&h.imaginary)))),
            )
            .collect();
        let mut jacobian = Self {
            layout: *layout,
            compliance,
            static_compliance,
            active,
            rows,
            restricted,
            solver: Solver::Identity,
        };
        let n = jacobian.n_active();
        if n > DENSE_LIMIT {
            let blocks = jacobian.diagonal_factors();
            jacobian.solver = Solver::Krylov {
                blocks,
                dense: OnceCell::new(),
            };
        } else if n > 0 {
            jacobian.solver = Solver::Dense(jacobian.dense_factor());
        }
        jacobian
    }

    fn n_active(&self) -> usize {
        self.rows.len() * self.layout.n_coefficients
    }

    /// Number of factorisations that `new` did (0 or 1).
    #[must_use]
    pub fn factorizations(&self) -> usize {
        usize::from(!self.active.is_empty())
    }

    /// x = J⁻¹ b. Shape: `[n_coefficients][3·n_contacts]`.
    #[must_use]
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let active_b = self.restrict(b);
        let active_x = match &self.solver {
            Solver::Identity => return b.to_vec(),
            Solver::Dense(lu) => solve_dense(lu, &active_b),
            Solver::Krylov { blocks, dense } => self.solve_krylov(blocks, dense, &active_b),
        };
        let mut x = vec![0.0; b.len()];
        self.prolong(&active_x, &mut x);
        let mut g_dg_x = vec![0.0; b.len()];
        self.add_compliance(&self.deviation(&x), &mut g_dg_x);
        let mut out: Vec<f64> = b.iter().zip(&g_dg_x).map(|(b, y)| b - y).collect();
        self.prolong(&active_x, &mut out);
        out
    }

    /// dg x. Shape: `[n_coefficients][3·n_contacts]`.
    #[must_use]
    pub fn deviation(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for tangent in self.active {
            tangent.add_product(&self.layout, x, &mut y);
        }
        y
    }

    /// y += G x, harmonic by harmonic.
    pub fn add_compliance(&self, x: &[f64], y: &mut [f64]) {
        let n = self.layout.n_relative();
        add_columns(self.static_compliance, &x[..n], &mut y[..n]);
        for (h, (x, y)) in (self.compliance.harmonics.iter()).zip(
            x[n..]
                .chunks_exact(2 * n)
                .zip(y[n..].chunks_exact_mut(2 * n)),
        ) {
            let (y_c, y_s) = y.split_at_mut(n);
            h.add_real((&x[..n], &x[n..]), (y_c, y_s));
        }
    }

    fn solve_krylov(
        &self,
        blocks: &[PartialPivLu<f64>],
        dense: &OnceCell<PartialPivLu<f64>>,
        b: &[f64],
    ) -> Vec<f64> {
        if let Some(lu) = dense.get() {
            return solve_dense(lu, b);
        }
        let precondition = |v: &[f64]| -> Vec<f64> {
            let mut rest = v;
            let mut out = Vec::with_capacity(v.len());
            for lu in blocks {
                let (part, after) = rest.split_at(lu.L().nrows());
                out.extend(solve_dense(lu, part));
                rest = after;
            }
            out
        };
        let small = b.len() <= DENSE_FALLBACK_LIMIT;
        let max_iterations = if small {
            QUICK_ITERATIONS
        } else {
            GMRES.max_iterations
        };
        let accepted = if small {
            GMRES.tolerance
        } else {
            GMRES_ACCEPTED
        };
        let settings = GmresSettings {
            max_iterations,
            ..GMRES
        };
        let result = gmres(|v| self.apply_active(v), precondition, b, settings);
        if result.relative_residual <= accepted {
            result.solution
        } else {
            solve_dense(dense.get_or_init(|| self.dense_factor()), b)
        }
    }

    /// (I + G dg) v on the active unknowns.
    fn apply_active(&self, v: &[f64]) -> Vec<f64> {
        let n = self.rows.len();
        let mut full = vec![0.0; self.layout.n_unknowns()];
        self.prolong(v, &mut full);
        let dg = self.restrict(&self.deviation(&full));
        let mut y = v.to_vec();
        add_columns(&self.restricted[0].0, &dg[..n], &mut y[..n]);
        for ((real, imaginary), (dg, y)) in (self.restricted[1..].iter()).zip(
            dg[n..]
                .chunks_exact(2 * n)
                .zip(y[n..].chunks_exact_mut(2 * n)),
        ) {
            let (y_c, y_s) = y.split_at_mut(n);
            add_columns(real, &dg[..n], y_c);
            add_columns(real, &dg[n..], y_s);
            if let Some(imaginary) = imaginary {
                add_columns(imaginary, &dg[n..], y_c);
                subtract_columns(imaginary, &dg[..n], y_s);
            }
        }
        y
    }

    fn diagonal_factors(&self) -> Vec<PartialPivLu<f64>> {
        (0..self.restricted.len())
            .map(|k| self.factor(k..k + 1))
            .collect()
    }

    fn dense_factor(&self) -> PartialPivLu<f64> {
        self.factor(0..self.restricted.len())
    }

    /// LU factors of I + G dg restricted to a range of harmonics.
    fn factor(&self, range: std::ops::Range<usize>) -> PartialPivLu<f64> {
        let n = self.rows.len();
        let start =
            |k: usize| ((2 * k).saturating_sub(1) - (2 * range.start).saturating_sub(1)) * n;
        let size = start(range.end);
        let mut matrix = Mat::<f64>::identity(size, size);
        for k in range.clone() {
            for l in range.clone() {
                let block = self.block(k, l);
                let mut target =
                    matrix.submatrix_mut(start(k), start(l), block.nrows(), block.ncols());
                target += &block;
            }
        }
        matrix.partial_piv_lu()
    }

    /// Block (k, l) of G dg: harmonic k of the balance against harmonic l of the displacement.
    fn block(&self, k: usize, l: usize) -> Mat<f64> {
        let n = self.rows.len();
        let n_active_pairs = self.active.len();
        let parts = |harmonic: usize| if harmonic == 0 { 1 } else { 2 };
        let first = |harmonic: usize| (2 * harmonic).saturating_sub(1);
        let m = self.layout.n_coefficients;
        let (real, imaginary) = &self.restricted[k];
        let mut out = Mat::<f64>::zeros(parts(k) * n, parts(l) * n);
        for (s, tangent) in self.active.iter().enumerate() {
            for (row, column, values) in &tangent.blocks {
                let source = row * n_active_pairs + s;
                for part in 0..parts(l) {
                    let entry = |k_part: usize| values[(first(k) + k_part) * m + first(l) + part];
                    let target = out.col_as_slice_mut(part * n + column * n_active_pairs + s);
                    match imaginary {
                        None => axpy(entry(0), real.col_as_slice(source), target),
                        Some(imaginary) => {
                            let (c, s) = target.split_at_mut(n);
                            axpy(entry(0), real.col_as_slice(source), c);
                            axpy(entry(1), imaginary.col_as_slice(source), c);
                            axpy(entry(1), real.col_as_slice(source), s);
                            axpy(-entry(0), imaginary.col_as_slice(source), s);
                        }
                    }
                }
            }
        }
        out
    }

    fn restrict(&self, x: &[f64]) -> Vec<f64> {
        x.chunks_exact(self.layout.n_relative())
            .flat_map(|coefficient| self.rows.iter().map(|&i| coefficient[i]))
            .collect()
    }

    fn prolong(&self, active: &[f64], x: &mut [f64]) {
        for (coefficient, values) in
            (x.chunks_exact_mut(self.layout.n_relative())).zip(active.chunks_exact(self.rows.len()))
        {
            for (&i, &value) in self.rows.iter().zip(values) {
                coefficient[i] = value;
            }
        }
    }
}

impl PairTangent {
    /// y += dg x for this pair.
    fn add_product(&self, layout: &Layout, x: &[f64], y: &mut [f64]) {
        let m = layout.n_coefficients;
        let stride = layout.n_relative();
        for (row, column, values) in &self.blocks {
            let from = column * layout.n_pairs + self.pair;
            let to = row * layout.n_pairs + self.pair;
            let gathered: Vec<f64> = (0..m).map(|b| x[b * stride + from]).collect();
            for (a, line) in values.chunks_exact(m).enumerate() {
                let product: f64 = line.iter().zip(&gathered).map(|(d, x)| d * x).sum();
                y[a * stride + to] += product;
            }
        }
    }
}

fn solve_dense(lu: &PartialPivLu<f64>, b: &[f64]) -> Vec<f64> {
    let mut x = Col::from_fn(b.len(), |i| b[i]);
    lu.solve_in_place(&mut x);
    x.iter().copied().collect()
}

fn axpy(factor: f64, x: &[f64], y: &mut [f64]) {
    if factor != 0.0 {
        for (y, x) in y.iter_mut().zip(x) {
            *y += factor * x;
        }
    }
}

fn add_columns(a: &Mat<f64>, x: &[f64], y: &mut [f64]) {
    for (j, &x) in x.iter().enumerate() {
        axpy(x, a.col_as_slice(j), y);
    }
}

fn subtract_columns(a: &Mat<f64>, x: &[f64], y: &mut [f64]) {
    for (j, &x) in x.iter().enumerate() {
        axpy(-x, a.col_as_slice(j), y);
    }
}
