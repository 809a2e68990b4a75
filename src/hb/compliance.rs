//! The fully stuck structure under harmonic loads, and its compliance at the contacts.
//!
//! With the contact force split into its stuck part and a deviation, f = K_c r + g, harmonic k of the balance reads
//! η̂ₖ = Z_s(kω)⁻¹ (f̂ₖ − ΦᵀBᵀ ĝₖ),  Z_s = Z + ΦᵀBᵀ K_c BΦ,  r̂ₖ = BΦ η̂ₖ = r̂ₖ^stuck − Gₖ(ω) ĝₖ,  Gₖ = BΦ Z_s⁻¹ ΦᵀBᵀ.
//! G stays finite where the free strip floats, and g vanishes where a contact sticks: only slipping and
//! separating pairs enter the nonlinear system.

use super::linear::{LinearModel, Part, Structure};
use super::springs::Symmetric;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::solvers::{DenseSolveCore, PartialPivLu};
use faer::prelude::*;
use faer::{Accum, Par};

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

/// A mode is loose where the stuck contacts are stiffer against it than the free structure by this factor: rigid-body
/// modes, those of a light strip and those close to resonance. Condensing one would lose as many digits, twice.
const LOOSE: f64 = 100.0;

/// A structure with what the stuck contacts do to it at any frequency.
enum Held<'p> {
    /// Λ, diagonal of Ĉ, and the stiffness of the contacts against each mode. Shapes: `[n]`.
    Modes {
        lambda: &'p [f64],
        damping: &'p [f64],
        held: Vec<f64>,
    },
    /// M, C and K + ΦᵀBᵀ K_c BΦ. Shapes: n × n.
    Matrices {
        mass: &'p Mat<f64>,
        damping: &'p Mat<f64>,
        stiffness: Mat<f64>,
    },
}

/// What Z_s⁻¹ is applied with.
#[derive(Debug)]
enum Impedance {
    /// The *free* modal impedance; the stuck contacts enter by G (Woodbury).
    Free(FreeModes),
    /// LU factors of Z_s.
    Stuck(PartialPivLu<c64>),
}

/// The modes of the free structure at one frequency. All but the loose ones are condensed to the contacts by their
/// receptance; that of a loose mode is large against the compliance of the stuck contacts and would cancel.
#[derive(Debug)]
struct FreeModes {
    /// Diagonal of Z. Shape: `[n]`.
    impedance: Vec<c64>,
    /// 1/Z, zero for loose modes. Shape: `[n]`.
    receptance: Vec<c64>,
    /// Loose modes.
    loose: Vec<usize>,
    /// R, relative displacements of the stuck structure per load on the loose modes. Shape: 3·n_contacts × loose.
    per_load: Mat<c64>,
    /// Motion of the loose modes per load on them. Shape: loose square.
    loose_receptance: Mat<c64>,
}

impl<'p> Compliance<'p> {
    /// The stuck structure at `omega` for the stuck stiffness `k_c` (N/m, shape `[3·n_contacts]`).
    #[must_use]
    pub fn new(model: &'p LinearModel, k_c: &'p [f64], orders: &[usize], omega: f64) -> Self {
        let held: Vec<Held<'_>> = (model.parts.iter())
            .map(|part| Held::new(part, k_c))
            .collect();
        let harmonics = (orders.iter().filter(|&&k| k > 0))
            .map(|&order| {
                let held = &held[order % held.len()];
                HarmonicCompliance::new(model.part(order), (k_c, held), order, omega)
            })
            .collect();
        Self { omega, harmonics }
    }
}

impl<'p> HarmonicCompliance<'p> {
    fn new(part: &'p Part, (k_c, held): (&'p [f64], &Held<'_>), order: usize, omega: f64) -> Self {
        let frequency = order as f64 * omega;
        let (impedance, real, imaginary) = match held {
            Held::Modes {
                lambda,
                damping,
                held,
            } => {
                let impedance: Vec<c64> = (lambda.iter().zip(*damping))
                    .map(|(&l, &c)| c64::new(l - frequency * frequency, frequency * c))
                    .collect();
                let (modes, stuck) = FreeModes::new(part, (k_c, held), impedance);
                (Impedance::Free(modes), stuck.real, stuck.imaginary)
            }
            Held::Matrices {
                mass,
                damping,
                stiffness,
            } => {
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
            Impedance::Free(modes) => {
                // takes the error of the motion from 1e-10 to 1e-13
                let coarse = self.solve_by_compliance(modes, load);
                let missing = self.missing_load(modes, load, &coarse);
                let fine = self.solve_by_compliance(modes, &missing);
                coarse.iter().zip(&fine).map(|(a, b)| a + b).collect()
            }
        }
    }

    /// Z_s⁻¹ `load` up to the round-off of G. With the receptance D of all modes but the loose ones
    /// r = (I − G K_c) BΦ D f + R f_l and η̂ = D (f − ΦᵀBᵀ K_c r); the loose ones follow from the symmetry of Z_s⁻¹.
    fn solve_by_compliance(&self, modes: &FreeModes, load: &[c64]) -> Vec<c64> {
        let free = times(&modes.receptance, load);
        let r = self.part.relative(&free);
        let pull = self.spring(&r);
        let mut held = minus(&r, &self.apply(&pull));
        let mut loose = vec![c64::new(0.0, 0.0); modes.loose.len()];
        for (b, &mode) in modes.loose.iter().enumerate() {
            let per_load = modes.per_load.col_as_slice(b);
            (held.iter_mut().zip(per_load)).for_each(|(r, p)| *r += p * load[mode]);
            let pulled = per_load.iter().zip(&pull).map(|(p, f)| p * f);
            loose[b] -= pulled.sum::<c64>() * self.part.images;
            let receptance = modes.loose_receptance.col_as_slice(b);
            (loose.iter_mut().zip(receptance)).for_each(|(x, d)| *x += d * load[mode]);
        }
        let hold = times(
            &modes.receptance,
            &self.part.contact_load(&self.spring(&held)),
        );
        let mut eta = minus(&free, &hold);
        for (&mode, x) in modes.loose.iter().zip(loose) {
            eta[mode] = x;
        }
        eta
    }

    /// `load` − Z_s η.
    fn missing_load(&self, modes: &FreeModes, load: &[c64], eta: &[c64]) -> Vec<c64> {
        let held = (self.part).contact_load(&self.spring(&self.part.relative(eta)));
        (load.iter().zip(eta).zip(&modes.impedance).zip(held))
            .map(|(((f, x), z), s)| f - x * z - s)
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

impl FreeModes {
    /// The modes and G.
    ///
    /// Without the loose modes the stuck structure has the compliance G' = (I + H K)⁻¹ H, H = L D Lᵀ. A motion x of the
    /// loose modes moves its contacts by W x, W = (I − G' K) L_l, and obeys S x = f_l with S = Z_l + L_lᵀ K W. So
    /// R = W S⁻¹ and G = G' + R Wᵀ.
    fn new(part: &Part, (k_c, held): (&[f64], &[f64]), impedance: Vec<c64>) -> (Self, Symmetric) {
        let loose: Vec<usize> = (0..impedance.len())
            .filter(|&j| held[j] * held[j] > LOOSE * LOOSE * impedance[j].norm_sqr())
            .collect();
        let mut receptance: Vec<c64> = impedance.iter().map(|z| z.inv()).collect();
        for &j in &loose {
            receptance[j] = c64::new(0.0, 0.0);
        }
        let mut stuck = receptance_at_contacts(part, &receptance).with_springs(k_c);
        let (m, n) = (k_c.len(), loose.len());
        let mut moved = [Mat::zeros(m, n), Mat::zeros(m, n)];
        for (b, &j) in loose.iter().enumerate() {
            moved[0]
                .col_as_slice_mut(b)
                .copy_from_slice(part.contact.col_as_slice(j));
        }
        let mut pull = moved[0].clone();
        for b in 0..n {
            (pull.col_as_slice_mut(b).iter_mut().zip(k_c)).for_each(|(x, k)| *x *= k);
        }
        for (moved, g) in moved.iter_mut().zip([&stuck.real, &stuck.imaginary]) {
            add_product(moved, -1.0, g.as_ref(), pull.as_ref());
        }
        let held = [&moved[0], &moved[1]].map(|w| pull.transpose() * w);
        let dynamic = Mat::from_fn(n, n, |a, b| {
            let spring = c64::new(held[0][(a, b)], held[1][(a, b)]) * part.images;
            if a == b {
                spring + impedance[loose[a]]
            } else {
                spring
            }
        });
        let loose_receptance = dynamic.partial_piv_lu().inverse();
        let inverse = [|z: &c64| z.re, |z: &c64| z.im]
            .map(|f| Mat::from_fn(n, n, |a, b| f(&loose_receptance[(a, b)])));
        let mut per_load = [Mat::zeros(m, n), Mat::zeros(m, n)];
        let [real, imaginary] = &mut per_load;
        add_complex_product(
            [real, imaginary],
            1.0,
            moved.each_ref().map(Mat::as_ref),
            inverse.each_ref().map(Mat::as_ref),
        );
        add_complex_product(
            [&mut stuck.real, &mut stuck.imaginary],
            part.images,
            per_load.each_ref().map(Mat::as_ref),
            moved.each_ref().map(Mat::transpose),
        );
        let modes = Self {
            impedance,
            receptance,
            loose,
            per_load: Mat::from_fn(m, n, |i, b| {
                c64::new(per_load[0][(i, b)], per_load[1][(i, b)])
            }),
            loose_receptance,
        };
        (modes, stuck)
    }
}

/// y += factor a b.
fn add_product(y: &mut Mat<f64>, factor: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(y.as_mut(), Accum::Add, a, b, factor, Par::Seq);
}

/// y += factor a b of complex matrices, real and imaginary parts apart.
fn add_complex_product(
    [real, imaginary]: [&mut Mat<f64>; 2],
    factor: f64,
    a: [MatRef<'_, f64>; 2],
    b: [MatRef<'_, f64>; 2],
) {
    add_product(real, factor, a[0], b[0]);
    add_product(real, -factor, a[1], b[1]);
    add_product(imaginary, factor, a[0], b[1]);
    add_product(imaginary, factor, a[1], b[0]);
}

impl<'p> Held<'p> {
    fn new(part: &'p Part, k_c: &[f64]) -> Self {
        let against = |j| {
            let shape = part.contact.col_as_slice(j);
            let energies = shape.iter().zip(k_c).map(|(x, k)| k * x * x);
            part.images * energies.sum::<f64>()
        };
        match &part.structure {
            Structure::Modal { lambda, damping } => Self::Modes {
                lambda,
                damping,
                held: (0..part.n_coordinates()).map(against).collect(),
            },
            Structure::Physical { mass, damping, .. } => Self::Matrices {
                mass,
                damping,
                stiffness: part.stiffness_with_springs(k_c),
            },
        }
    }
}

/// H = L D Lᵀ. Shape: `receptance` `[n]`.
fn receptance_at_contacts(part: &Part, receptance: &[c64]) -> Symmetric {
    let l = &part.contact;
    let product = |f: fn(&c64) -> f64| {
        let mut scaled = l.clone();
        for (j, d) in receptance.iter().enumerate() {
            let factor = part.images * f(d);
            (scaled.col_as_slice_mut(j).iter_mut()).for_each(|x| *x *= factor);
        }
        let mut h = Mat::zeros(l.nrows(), l.nrows());
        let (full, lower) = (BlockStructure::Rectangular, BlockStructure::TriangularLower);
        let (left, right) = (scaled.as_ref(), l.transpose());
        triangular::matmul(
            h.as_mut(),
            lower,
            Accum::Replace,
            left,
            full,
            right,
            full,
            1.0,
            Par::Seq,
        );
        h
    };
    Symmetric {
        real: product(|z| z.re),
        imaginary: product(|z| z.im),
    }
}
