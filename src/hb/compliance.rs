//! Compliance of the fully stuck structure at its contacts.
//!
//! With the contact force split into its stuck part and a deviation, f = K_c r + g, harmonic k of the balance reads
//! r̂ₖ = r̂ₖ^stuck − Gₖ(ω) ĝₖ,  Gₖ = (I + Hₖ K_c)⁻¹ Hₖ,  Hₖ = BΦ Z(kω)⁻¹ ΦᵀBᵀ.
//! G stays finite where the free strip floats, and g vanishes where a contact sticks: only slipping and
//! separating pairs enter the nonlinear system.

use super::modal::{FreeImpedance, ModalModel};
use faer::prelude::*;

/// Compliances of all dynamic harmonics at one excitation frequency.
#[derive(Debug)]
pub struct Compliance {
    /// Excitation frequency ω (rad/s).
    pub omega: f64,
    /// One entry per dynamic harmonic of the set, in its order.
    pub harmonics: Vec<HarmonicCompliance>,
}

/// Compliance of harmonic k at ω.
#[derive(Debug)]
pub struct HarmonicCompliance {
    /// k.
    pub order: usize,
    /// Z(kω) of the free structure.
    pub impedance: FreeImpedance,
    /// Re Gₖ. Shape: 3·n_contacts square.
    pub real: Mat<f64>,
    /// Im Gₖ. Shape: 3·n_contacts square.
    pub imaginary: Mat<f64>,
}

impl Compliance {
    /// Compliances at `omega` for the stuck stiffness `k_c` (N/m, shape `[3·n_contacts]`) of each relative displacement.
    #[must_use]
    pub fn new(model: &ModalModel, k_c: &[f64], orders: &[usize], omega: f64) -> Self {
        let harmonics = orders
            .iter()
            .filter(|&&k| k > 0)
            .map(|&order| HarmonicCompliance::new(model, k_c, order, omega))
            .collect();
        Self { omega, harmonics }
    }
}

impl HarmonicCompliance {
    fn new(model: &ModalModel, k_c: &[f64], order: usize, omega: f64) -> Self {
        let impedance = model.impedance(order as f64 * omega);
        let (h_real, h_imaginary) = impedance.receptance(&model.contact);
        let n = k_c.len();
        let h = Mat::from_fn(n, n, |i, j| c64::new(h_real[(i, j)], h_imaginary[(i, j)]));
        let a = Mat::from_fn(n, n, |i, j| {
            h[(i, j)] * k_c[j] + if i == j { 1.0 } else { 0.0 }
        });
        let g = a.partial_piv_lu().solve(h);
        Self {
            order,
            impedance,
            real: Mat::from_fn(n, n, |i, j| g[(i, j)].re),
            imaginary: Mat::from_fn(n, n, |i, j| g[(i, j)].im),
        }
    }

    /// G x. Shape: `[3·n_contacts]`.
    #[must_use]
    pub fn apply(&self, x: &[c64]) -> Vec<c64> {
        let (mut cosine, mut sine) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        let x_cosine: Vec<f64> = x.iter().map(|z| z.re).collect();
        let x_sine: Vec<f64> = x.iter().map(|z| -z.im).collect();
        self.add_real((&x_cosine, &x_sine), (&mut cosine, &mut sine));
        (cosine.iter().zip(&sine)).map(|(&c, &s)| c64::new(c, -s)).collect()
    }

    /// (c, s) += G (x_c, x_s) in cosine and sine coefficients; x̂ = x_c − i x_s.
    pub fn add_real(&self, x: (&[f64], &[f64]), y: (&mut [f64], &mut [f64])) {
        for (j, (&x_c, &x_s)) in x.0.iter().zip(x.1).enumerate() {
            if x_c == 0.0 && x_s == 0.0 {
                continue;
            }
            let real = self.real.col_as_slice(j);
            let imaginary = self.imaginary.col_as_slice(j);
            for (((c, s), &a), &b) in (y.0.iter_mut().zip(y.1.iter_mut())).zip(real).zip(imaginary) {
                *c += a * x_c + b * x_s;
                *s += a * x_s - b * x_c;
            }
        }
    }
}
