//! The fully stuck structure under harmonic loads, and its compliance at the contacts.
//!
//! With the contact force split into its stuck part and a deviation, f = K_c r + g, harmonic k of the balance reads
//! η̂ₖ = Z_s(kω)⁻¹ (f̂ₖ − ΦᵀBᵀ ĝₖ),  Z_s = Z + ΦᵀBᵀ K_c BΦ,  r̂ₖ = BΦ η̂ₖ = r̂ₖ^stuck − Gₖ(ω) ĝₖ,  Gₖ = BΦ Z_s⁻¹ ΦᵀBᵀ.
//! G stays finite where the free strip floats, and g vanishes where a contact sticks: only slipping and
//! separating pairs enter the nonlinear system.

use super::linear::{LinearModel, Part, Structure};
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;

/// The stuck structure at all dynamic harmonics of one excitation frequency.
#[derive(Debug)]
pub struct Compliance<'p> {
    /// Excitation frequency ω (rad/s).
    pub omega: f64,
    /// One entry per dynamic harmonic of the set, in its order.
    pub harmonics: Vec<HarmonicCompliance<'p>>,
}

/// The stuck structure at harmonic k of ω.
#[derive(Debug)]
pub struct HarmonicCompliance<'p> {
    /// k.
    pub order: usize,
    /// Re Gₖ (m/N). Shape: 3·n_contacts square.
    pub real: Mat<f64>,
    /// Im Gₖ (m/N). Shape: 3·n_contacts square.
    pub imaginary: Mat<f64>,
    /// The structure that harmonic k sees.
    pub part: &'p Part,
    stuck_stiffness: &'p [f64],
    impedance: Impedance,
}

/// What Z_s⁻¹ is applied with.
#[derive(Debug)]
enum Impedance {
    /// Reciprocal diagonal of the *free* modal impedance Z; the stuck contacts enter by G (Woodbury).
    Free(Vec<c64>),
    /// LU factors of Z_s.
    Stuck(PartialPivLu<c64>),
}

impl<'p> Compliance<'p> {
    /// The stuck structure at `omega` for the stuck stiffness `k_c` (N/m, shape `[3·n_contacts]`).
    #[must_use]
    pub fn new(model: &'p LinearModel, k_c: &'p [f64], orders: &[usize], omega: f64) -> Self {
        let harmonics = (orders.iter().filter(|&&k| k > 0))
            .map(|&order| HarmonicCompliance::new(model.part(order), k_c, order, omega))
            .collect();
        Self { omega, harmonics }
    }
}

impl<'p> HarmonicCompliance<'p> {
    fn new(part: &'p Part, k_c: &'p [f64], order: usize, omega: f64) -> Self {
        let frequency = order as f64 * omega;
        let (impedance, real, imaginary) = match &part.structure {
            Structure::Modal { lambda, damping } => {
                let inverse: Vec<c64> = (lambda.iter().zip(damping))
                    .map(|(&l, &c)| c64::new(l - frequency * frequency, frequency * c).inv())
                    .collect();
                let (real, imaginary) = compliance_of_free(part, &inverse, k_c);
                (Impedance::Free(inverse), real, imaginary)
            }
            Structure::Physical { mass, damping, .. } => {
                let stiffness = part.stiffness_with_springs(k_c);
                let z = Mat::from_fn(mass.nrows(), mass.ncols(), |i, j| {
                    let inertia = frequency * frequency * mass[(i, j)];
                    c64::new(stiffness[(i, j)] - inertia, frequency * damping[(i, j)])
                });
                let lu = z.partial_piv_lu();
                let b = &part.contact;
                let columns = lu.solve(Mat::from_fn(b.ncols(), b.nrows(), |i, j| {
                    c64::new(part.images * b[(j, i)], 0.0)
                }));
                let times_b = |f: fn(&c64) -> f64| {
                    b * Mat::from_fn(b.ncols(), b.nrows(), |i, j| f(&columns[(i, j)]))
                };
                let (real, imaginary) = (times_b(|z| z.re), times_b(|z| z.im));
                (Impedance::Stuck(lu), real, imaginary)
            }
        };
        Self {
            order,
            real,
            imaginary,
            part,
            stuck_stiffness: k_c,
            impedance,
        }
    }

    /// η̂ = Z_s⁻¹ `load`. Shape: `[n]`.
    #[must_use]
    pub fn solve(&self, load: &[c64]) -> Vec<c64> {
        match &self.impedance {
            Impedance::Stuck(lu) => lu
                .solve(Col::from_fn(load.len(), |i| load[i]))
                .iter()
                .copied()
                .collect(),
            Impedance::Free(inverse) => {
                // G cancels close to a resonance of the free structure; one step of refinement takes that away
                let coarse = self.solve_by_compliance(inverse, load);
                let missing = self.missing_load(inverse, load, &coarse);
                let fine = self.solve_by_compliance(inverse, &missing);
                coarse.iter().zip(&fine).map(|(a, b)| a + b).collect()
            }
        }
    }

    /// (D − D ΦᵀBᵀ (K_c − K_c G K_c) BΦ D) `load` with the modal receptance D = Z⁻¹.
    fn solve_by_compliance(&self, receptance: &[c64], load: &[c64]) -> Vec<c64> {
        let free = times(receptance, load);
        let r = self.part.relative(&free);
        let held = minus(&r, &self.apply(&self.spring(&r)));
        let hold = times(receptance, &self.part.contact_load(&self.spring(&held)));
        minus(&free, &hold)
    }

    /// `load` − Z_s η.
    fn missing_load(&self, receptance: &[c64], load: &[c64], eta: &[c64]) -> Vec<c64> {
        let held = (self.part).contact_load(&self.spring(&self.part.relative(eta)));
        (load.iter().zip(eta).zip(receptance).zip(held))
            .map(|(((f, x), d), s)| f - x / d - s)
            .collect()
    }

    /// K_c r.
    fn spring(&self, r: &[c64]) -> Vec<c64> {
        let k = self.stuck_stiffness;
        r.iter().zip(k).map(|(r, k)| r * *k).collect()
    }

    /// G x. Shape: `[3·n_contacts]`.
    fn apply(&self, x: &[c64]) -> Vec<c64> {
        let (mut cosine, mut sine) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        let x_cosine: Vec<f64> = x.iter().map(|z| z.re).collect();
        let x_sine: Vec<f64> = x.iter().map(|z| -z.im).collect();
        self.add_real((&x_cosine, &x_sine), (&mut cosine, &mut sine));
        (cosine.iter().zip(&sine))
            .map(|(&c, &s)| c64::new(c, -s))
            .collect()
    }

    /// (c, s) += G (x_c, x_s) in cosine and sine coefficients; x̂ = x_c − i x_s.
    pub fn add_real(&self, x: (&[f64], &[f64]), y: (&mut [f64], &mut [f64])) {
        for (j, (&x_c, &x_s)) in x.0.iter().zip(x.1).enumerate() {
            if x_c == 0.0 && x_s == 0.0 {
                continue;
            }
            let real = self.real.col_as_slice(j);
            let imaginary = self.imaginary.col_as_slice(j);
            for (((c, s), &a), &b) in (y.0.iter_mut().zip(y.1.iter_mut()))
                .zip(real)
                .zip(imaginary)
            {
                *c += a * x_c + b * x_s;
                *s += a * x_s - b * x_c;
            }
        }
    }
}

fn times(d: &[c64], x: &[c64]) -> Vec<c64> {
    d.iter().zip(x).map(|(d, x)| d * x).collect()
}

fn minus(a: &[c64], b: &[c64]) -> Vec<c64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// G = (I + H K_c)⁻¹ H with H = L D Lᵀ, the receptance of the free structure.
fn compliance_of_free(part: &Part, inverse: &[c64], k_c: &[f64]) -> (Mat<f64>, Mat<f64>) {
    let l = &part.contact;
    let (m, n) = (l.nrows(), l.ncols());
    let receptance = |f: fn(&c64) -> f64| {
        Mat::from_fn(m, n, |i, j| part.images * l[(i, j)] * f(&inverse[j])) * l.transpose()
    };
    let (h_real, h_imaginary) = (receptance(|z| z.re), receptance(|z| z.im));
    let h = Mat::from_fn(m, m, |i, j| c64::new(h_real[(i, j)], h_imaginary[(i, j)]));
    let held = Mat::from_fn(m, m, |i, j| {
        h[(i, j)] * k_c[j] + if i == j { 1.0 } else { 0.0 }
    });
    let g = held.partial_piv_lu().solve(h);
    let part = |f: fn(&c64) -> f64| Mat::from_fn(m, m, |i, j| f(&g[(i, j)]));
    (part(|z| z.re), part(|z| z.im))
}
