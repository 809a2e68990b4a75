//! The balance equations in the modes of the free structure, for solvers that treat many samples alike.
//!
//! [`super::balance`] attaches the contacts' stiffness to the structure: its compliance G is another one for each sample and
//! each frequency. Here the whole contact force F is a load on the free structure, whose modes all samples share. With
//! L = BΦ and D_k = 1/(Λ − (kω)² + ikω C), a division per mode,
//!
//! ```text
//! R₀ = r₀ − r_ref + G_ref (F₀ − K_ref r₀)
//! R̂ₖ = r̂ₖ − L η̂ₖ,   η̂ₖ = D_k (level f̂ₖ − Lᴴ F̂ₖ),   k = 1, 2, …
//! J x:  x₀ + G_ref (F'₀ − K_ref x₀),  x̂ₖ + L D_k Lᴴ F̂'ₖ,   F' = (∂F/∂r) x
//! ```
//!
//! Harmonics that are waves of a disk have a complex L of their own.
//!
//! A free structure may float, so harmonic 0 is held by reference springs K_ref, the same ones for all samples
//! ([`StaticReference`]). Both forms have the same solutions and Newton steps: R of this form is (I + H K_c) times that of
//! the other, H being the compliance of the free structure. Where H K_c is large this residual holds fewer digits; P R with
//! P ≈ J⁻¹ holds as many.

use super::balance::{Balance, ContactResponse};
use super::problem::Problem;
use crate::hb::structure::linear::{LinearModel, ModalPart};
use crate::linalg::vector::axpy;
use faer::linalg::matmul::matmul;
use faer::prelude::*;
use faer::{Accum, Par};

/// The structure at rest with reference springs at its contacts.
#[derive(Debug, Clone)]
pub struct StaticReference {
    /// Diagonal of K_ref (N/m). Shape: `[3·n_contacts]`.
    pub stiffness: Vec<f64>,
    /// G_ref (m/N). Shape: 3·n_contacts square.
    pub compliance: Mat<f64>,
    /// Relative displacements per static load on the modes. Shape: 3·n_contacts × n.
    per_load: Mat<f64>,
}

impl StaticReference {
    /// The stuck contacts of `problem` as reference springs.
    #[must_use]
    pub fn new(problem: &Problem<'_>) -> Self {
        let rest = &problem.stuck_static;
        let images = problem.model.part(0).multiplicity;
        Self {
            stiffness: problem.stuck_stiffness.clone(),
            compliance: rest.compliance.clone(),
            per_load: rest.eta_per_force.transpose() * Scale(1.0 / images),
        }
    }

    /// r_ref (m) under the static load of `problem`. Shape: `[3·n_contacts]`.
    fn displacement(&self, problem: &Problem<'_>) -> Vec<f64> {
        let (force, scale) = (
            &problem.model.part(0).static_force,
            problem.static_load_scale,
        );
        let load = Col::from_fn(force.len(), |i| scale * force[i]);
        (&self.per_load * load).iter().copied().collect()
    }
}

/// The free form of the equations of one problem on one harmonic set.
#[derive(Debug)]
pub struct FreeBalance<'a> {
    /// The problem, its harmonics and contact forces.
    pub balance: &'a Balance<'a>,
    /// What holds harmonic 0.
    pub reference: &'a StaticReference,
    /// r_ref (m).
    rest: Vec<f64>,
    /// Harmonics above 0.
    orders: Vec<usize>,
    /// Parts of the model with the harmonics above 0 that belong to them, by their numbers in `orders`.
    groups: Vec<(usize, Vec<usize>)>,
}

/// Motion of the free structure under excitation and contact forces.
#[derive(Debug)]
pub struct FreeMotion {
    /// Excitation frequency ω (rad/s).
    pub omega: f64,
    /// D_k of the harmonics above 0. Shape: `[n_harmonics][n]`.
    pub receptance: Vec<Vec<c64>>,
    /// η̂ₖ. Shape: `[n_harmonics][n]`.
    pub dynamic: Vec<Vec<c64>>,
}

impl<'a> FreeBalance<'a> {
    /// The free form of `balance`; none for damping that couples modes, whose D_k is no diagonal.
    #[must_use]
    pub fn new(balance: &'a Balance<'a>, reference: &'a StaticReference) -> Option<Self> {
        let model = balance.problem.model;
        let coupled = |part: &ModalPart| !part.structure.coupling.modes.is_empty();
        if model.parts.iter().any(coupled) {
            return None;
        }
        let orders: Vec<usize> = (balance.harmonics.orders().iter().copied())
            .filter(|&k| k > 0)
            .collect();
        let of_part = |part: usize| {
            let mine = |i: &usize| orders[*i] % model.parts.len() == part;
            (part, (0..orders.len()).filter(mine).collect::<Vec<usize>>())
        };
        let groups = (0..model.parts.len()).map(of_part);
        Some(Self {
            rest: reference.displacement(balance.problem),
            groups: groups.filter(|(_, of_part)| !of_part.is_empty()).collect(),
            balance,
            reference,
            orders,
        })
    }

    fn model(&self) -> &'a LinearModel {
        self.balance.problem.model
    }

    fn part(&self, i: usize) -> &'a ModalPart {
        self.model().part(self.orders[i])
    }

    /// Harmonics above 0.
    pub(crate) fn orders(&self) -> &[usize] {
        &self.orders
    }

    /// r_ref (m). Shape: `[3·n_contacts]`.
    pub(crate) fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// Parts of the model with the numbers of their harmonics above 0.
    pub(in crate::hb) fn groups(&self) -> &[(usize, Vec<usize>)] {
        &self.groups
    }

    /// Motion at the frequency `omega` (rad/s) under the excitation `level` and the contact forces `force` (N).
    #[must_use]
    pub fn motion(&self, omega: f64, level: f64, force: &[f64]) -> FreeMotion {
        let receptance: Vec<Vec<c64>> = (0..self.orders.len())
            .map(|i| {
                let frequency = self.orders[i] as f64 * omega;
                let structure = &self.part(i).structure;
                (structure.lambda.iter().zip(&structure.damping))
                    .map(|(&l, &c)| c64::new(l - frequency * frequency, frequency * c).inv())
                    .collect()
            })
            .collect();
        let mut dynamic = self.loads(force);
        for (i, load) in dynamic.iter_mut().enumerate() {
            load.iter_mut().for_each(|f| *f = -*f);
            if self.orders[i] == 1 {
                let excitation = self.part(i).force.iter();
                (load.iter_mut().zip(excitation)).for_each(|(l, f)| *l += f * level);
            }
        }
        multiply(&mut dynamic, &receptance);
        FreeMotion {
            omega,
            receptance,
            dynamic,
        }
    }

    /// The residual R(r) (m) for the contact forces `force` = F(r) and the motion that they cause. Shape: as r.
    #[must_use]
    pub fn residual(&self, motion: &FreeMotion, r: &[f64], force: &[f64]) -> Vec<f64> {
        let mut out = r.to_vec();
        (out.iter_mut().zip(&self.rest)).for_each(|(r, rest)| *r -= rest);
        self.add_rest(r, force, &mut out);
        self.add_relative(&motion.dynamic, -1.0, &mut out);
        out
    }

    /// (∂F/∂r) `x` (N). Shape: as r.
    #[must_use]
    pub fn contact_rate(&self, contact: &ContactResponse, x: &[f64]) -> Vec<f64> {
        let (n_c, m) = (
            self.balance.layout.n_pairs,
            self.balance.layout.n_coefficients,
        );
        let n = 3 * n_c;
        let springs = self.balance.problem.stuck_stiffness.iter().cycle();
        let mut rate: Vec<f64> = x.iter().zip(springs).map(|(x, k)| k * x).collect();
        let mut of_pair = vec![0.0; m];
        for tangent in &contact.active {
            for (row, column, block) in &tangent.blocks {
                for (a, x_a) in of_pair.iter_mut().enumerate() {
                    *x_a = x[a * n + column * n_c + tangent.pair];
                }
                for (a, entries) in block.chunks_exact(m).enumerate() {
                    let sum: f64 = entries.iter().zip(&of_pair).map(|(b, x)| b * x).sum();
                    rate[a * n + row * n_c + tangent.pair] += sum;
                }
            }
        }
        rate
    }

    /// J x (m), if `rate` is (∂F/∂r) `x`. Shape: as r.
    #[must_use]
    pub fn product(&self, motion: &FreeMotion, x: &[f64], rate: &[f64]) -> Vec<f64> {
        let mut out = x.to_vec();
        self.add_rest(x, rate, &mut out);
        let mut eta = self.loads(rate);
        multiply(&mut eta, &motion.receptance);
        self.add_relative(&eta, 1.0, &mut out);
        out
    }

    /// ∂R/∂ω at fixed r (m/(rad/s)). Shape: as r.
    #[must_use]
    pub fn frequency_slope(&self, motion: &FreeMotion) -> Vec<f64> {
        let mut out = vec![0.0; self.balance.layout.n_unknowns()];
        let mut eta: Vec<Vec<c64>> = (0..self.orders.len())
            .map(|i| self.impedance_slope(i, motion))
            .collect();
        multiply(&mut eta, &motion.receptance);
        self.add_relative(&eta, 1.0, &mut out);
        out
    }

    /// Complex amplitude of the first harmonic of the response that defines resonance (m).
    #[must_use]
    pub fn response(&self, motion: &FreeMotion) -> c64 {
        self.part(0).responses(&motion.dynamic[0])[self.balance.problem.resonance_response]
    }

    /// Its derivative along a path on which the contact forces have the derivative `rate` and the frequency `omega`.
    #[must_use]
    pub fn response_rate(&self, motion: &FreeMotion, rate: &[f64], omega: f64) -> c64 {
        let part = self.part(0);
        let load = part.contact_load(&self.balance.complex(0, rate));
        let inertia = self.impedance_slope(0, motion);
        let eta: Vec<c64> = (load.iter().zip(&inertia).zip(&motion.receptance[0]))
            .map(|((load, inertia), d)| -(load + inertia * omega) * d)
            .collect();
        part.responses(&eta)[self.balance.problem.resonance_response]
    }

    /// (dZ/dω) η̂ of the i-th harmonic above 0.
    fn impedance_slope(&self, i: usize, motion: &FreeMotion) -> Vec<c64> {
        (self.part(i)).impedance_slope(self.orders[i], motion.omega, &motion.dynamic[i])
    }

    /// `out`₀ += G_ref (f₀ − K_ref x₀).
    fn add_rest(&self, x: &[f64], f: &[f64], out: &mut [f64]) {
        let n = self.balance.layout.n_relative();
        for (j, k) in self.reference.stiffness.iter().enumerate() {
            let column = self.reference.compliance.col_as_slice(j);
            axpy(f[j] - k * x[j], column, &mut out[..n]);
        }
    }

    /// Lᴴ f̂ₖ with the forces of the mirror images. Shape: `[n_harmonics][n]`.
    fn loads(&self, f: &[f64]) -> Vec<Vec<c64>> {
        let n = self.balance.layout.n_relative();
        let mut loads = vec![Vec::new(); self.orders.len()];
        for (part, of_part) in &self.groups {
            let part = &self.model().parts[*part];
            let forces = Mat::from_fn(n, 2 * of_part.len(), |i, j| {
                f[coefficient(of_part, j) * n + i]
            });
            let real = part.contact.real.transpose();
            let along = product(real, &forces, part.multiplicity);
            let imaginary = part.contact.imaginary.as_ref();
            let across = imaginary.map(|a| product(a.transpose(), &forces, part.multiplicity));
            for (j, &i) in of_part.iter().enumerate() {
                let [c, s] = [2 * j, 2 * j + 1];
                loads[i] = amplitudes(along.col_as_slice(c), along.col_as_slice(s));
                if let Some(across) = &across {
                    let turned = amplitudes(across.col_as_slice(c), across.col_as_slice(s));
                    for (load, turned) in loads[i].iter_mut().zip(turned) {
                        *load -= c64::new(0.0, 1.0) * turned;
                    }
                }
            }
        }
        loads
    }

    /// `out`ₖ += `factor` L η̂ₖ.
    fn add_relative(&self, eta: &[Vec<c64>], factor: f64, out: &mut [f64]) {
        let n = self.balance.layout.n_relative();
        for (part, of_part) in &self.groups {
            let shapes = &self.model().parts[*part].contact;
            let modal = Mat::from_fn(shapes.ncols(), 2 * of_part.len(), |i, j| {
                let eta = eta[of_part[j / 2]][i];
                if j % 2 == 0 { eta.re } else { -eta.im }
            });
            let along = product(shapes.real.as_ref(), &modal, factor);
            let imaginary = shapes.imaginary.as_ref();
            let across = imaginary.map(|a| product(a.as_ref(), &modal, factor));
            for j in 0..modal.ncols() {
                let a = coefficient(of_part, j);
                let to = &mut out[a * n..(a + 1) * n];
                axpy(1.0, along.col_as_slice(j), to);
                if let Some(across) = &across {
                    // i (x_c − i x_s) has the cosine x_s and the sine −x_c
                    let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
                    axpy(sign, across.col_as_slice(j ^ 1), to);
                }
            }
        }
    }
}

/// Number of the coefficient whose column has the number `j` beside those of the harmonics `of_part`: cosine and sine of each.
pub(in crate::hb) fn coefficient(of_part: &[usize], j: usize) -> usize {
    2 * of_part[j / 2] + 1 + j % 2
}

/// `factor` A X.
fn product(a: MatRef<'_, f64>, x: &Mat<f64>, factor: f64) -> Mat<f64> {
    let mut y = Mat::zeros(a.nrows(), x.ncols());
    let to = y.as_mut();
    matmul(to, Accum::Replace, a, x.as_ref(), factor, Par::Seq);
    y
}

/// x_c − i x_s.
fn amplitudes(cosine: &[f64], sine: &[f64]) -> Vec<c64> {
    let both = cosine.iter().zip(sine);
    both.map(|(&c, &s)| c64::new(c, -s)).collect()
}

/// x ← d x, mode by mode.
fn multiply(x: &mut [Vec<c64>], d: &[Vec<c64>]) {
    for (x, d) in x.iter_mut().flatten().zip(d.iter().flatten()) {
        *x *= *d;
    }
}
