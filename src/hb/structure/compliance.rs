//! The structure with all contacts stuck under harmonic loads, and its compliance at the contacts.
//!
//! The contact force is split into that of stuck contacts and a deviation, F = K_c r + g. Harmonic k of the equation of motion
//! is then
//!
//! ```text
//! η̂ₖ = Z_s(kω)⁻¹ (f̂ₖ − ΦᵀBᵀ ĝₖ),   Z_s = Z + ΦᵀBᵀ K_c BΦ
//! r̂ₖ = BΦ η̂ₖ = r̂ₖ^stuck − Gₖ ĝₖ,    Gₖ(ω) = BΦ Z_s⁻¹ ΦᵀBᵀ
//! ```
//!
//! G is finite also where the free strip can move as a rigid body. g is zero for a contact that sticks, so that only pairs
//! that slip or open enter the nonlinear system.

use super::linear::{LinearModel, ModalPart};
use super::springs::Symmetric;
use crate::linalg::vector::axpy_complex;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use faer::{Accum, Par};
use pulp::{Arch, Simd, WithSimd};

/// The stuck structure at all harmonics above 0 of one excitation frequency.
#[derive(Debug)]
pub struct Compliance<'p> {
    /// Excitation frequency ω (rad/s).
    pub omega: f64,
    /// One entry per harmonic above 0, in the order of the set.
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
    /// The structure for harmonic k: the whole one, or the half of its parity.
    pub part: &'p ModalPart,
    stuck_stiffness: &'p [f64],
    modes: FreeModes,
}

/// A mode is called loose if the stuck contacts are stiffer against it than the free structure, Z at this frequency, by this
/// factor: rigid-body modes, modes of a light strip, modes close to resonance. To condense one would lose this factor in
/// precision, twice.
const LOOSE: f64 = 100.0;

/// The modes of the free structure at one frequency; the stuck contacts enter by G (Woodbury's identity). Modes are condensed
/// to the contacts by their receptance 1/Z. Loose modes are not: their receptance is large against the compliance of the
/// stuck contacts, and the difference would cancel. Modes that damping couples have no receptance of their own and count as
/// loose.
#[derive(Debug)]
struct FreeModes {
    /// Ω (rad/s).
    frequency: f64,
    /// Diagonal of Z. Shape: `[n]`.
    impedance: Vec<c64>,
    /// 1/Z, zero for loose modes. Shape: `[n]`.
    receptance: Vec<c64>,
    /// Loose modes, the coupled ones first.
    loose: Vec<usize>,
    /// R, relative displacements of the stuck structure per load on the loose modes. Shape: 3·n_contacts × loose.
    per_load: Mat<c64>,
    /// Factors of S, the dynamic stiffness of the loose modes.
    dynamic: PartialPivLu<c64>,
}

impl<'p> Compliance<'p> {
    /// The stuck structure at `omega` for the stuck stiffness `k_c` (N/m, shape `[3·n_contacts]`).
    #[must_use]
    pub fn new(model: &'p LinearModel, k_c: &'p [f64], orders: &[usize], omega: f64) -> Self {
        let held: Vec<Vec<f64>> = (model.parts.iter())
            .map(|part| stiffness_against_modes(part, k_c))
            .collect();
        let harmonics = (orders.iter().filter(|&&k| k > 0))
            .map(|&order| {
                let held = &held[order % held.len()];
                HarmonicCompliance::new(model.part(order), k_c, held, order, omega)
            })
            .collect();
        Self { omega, harmonics }
    }
}

impl<'p> HarmonicCompliance<'p> {
    /// `k_c` is the stiffness of the stuck contacts (N/m), `held` that against each mode of `part`.
    fn new(part: &'p ModalPart, k_c: &'p [f64], held: &[f64], order: usize, omega: f64) -> Self {
        let (modes, stuck) = FreeModes::new(part, k_c, held, order as f64 * omega);
        Self {
            order,
            real: stuck.real,
            imaginary: stuck.imaginary,
            part,
            stuck_stiffness: k_c,
            modes,
        }
    }

    /// η̂ = Z_s⁻¹ `load`. Shape: `[n]`.
    #[must_use]
    pub fn solve(&self, load: &[c64]) -> Vec<c64> {
        Arch::new().dispatch(Solving {
            compliance: self,
            load,
            refined: true,
        })
    }

    /// The same with a relative error of 1e-10 instead of 1e-13, at half of the cost. This suffices for derivatives, which
    /// choose a step but enter no residual.
    #[must_use]
    pub fn solve_rate(&self, load: &[c64]) -> Vec<c64> {
        Arch::new().dispatch(Solving {
            compliance: self,
            load,
            refined: false,
        })
    }

    /// See [`Self::solve`].
    #[inline(always)]
    fn refined(&self, load: &[c64]) -> Vec<c64> {
        let mut eta = self.solve_by_compliance(load);
        let missing = self.missing_load(load, &eta);
        let fine = self.solve_by_compliance(&missing);
        (eta.iter_mut().zip(&fine)).for_each(|(a, b)| *a += b);
        eta
    }

    /// Z_s⁻¹ `load`, as exact as G. With D, the receptance of all modes but the loose ones, and the load f,
    /// r = (I − G K_c) BΦ D f + R f_l and η̂ = D (f − ΦᵀBᵀ K_c r). The loose modes follow from the symmetry of Z_s⁻¹.
    #[inline(always)]
    fn solve_by_compliance(&self, load: &[c64]) -> Vec<c64> {
        let modes = &self.modes;
        let mut eta = times(&modes.receptance, load);
        let mut held = self.part.relative(&eta);
        let pull = self.spring(&held);
        self.take_motion(&pull, &mut held);
        let mut loose = Col::from_fn(modes.loose.len(), |b| load[modes.loose[b]]);
        modes.dynamic.solve_in_place(&mut loose);
        for (b, &mode) in modes.loose.iter().enumerate() {
            let per_load = modes.per_load.col_as_slice(b);
            (held.iter_mut().zip(per_load)).for_each(|(r, p)| *r += p * load[mode]);
            let pulled = per_load.iter().zip(&pull).map(|(p, f)| p * f);
            loose[b] -= pulled.sum::<c64>() * self.part.multiplicity;
        }
        let hold = self.part.contact_load(&self.spring(&held));
        for ((eta, d), hold) in eta.iter_mut().zip(&modes.receptance).zip(&hold) {
            *eta -= d * hold;
        }
        for (&mode, x) in modes.loose.iter().zip(loose.iter()) {
            eta[mode] = *x;
        }
        eta
    }

    /// `load` − Z_s η.
    #[inline(always)]
    fn missing_load(&self, load: &[c64], eta: &[c64]) -> Vec<c64> {
        let held = (self.part).contact_load(&self.spring(&self.part.relative(eta)));
        let free = self.modes.free_load(self.part, eta);
        (load.iter().zip(free).zip(held))
            .map(|((f, z_eta), s)| f - z_eta - s)
            .collect()
    }

    /// K_c r.
    #[inline(always)]
    fn spring(&self, r: &[c64]) -> Vec<c64> {
        let k = self.stuck_stiffness;
        r.iter().zip(k).map(|(r, k)| r * *k).collect()
    }

    /// r −= G x.
    #[inline(always)]
    fn take_motion(&self, x: &[c64], r: &mut [c64]) {
        let n = x.len();
        let mut parts = vec![0.0; 4 * n];
        let (x_parts, moved) = parts.split_at_mut(2 * n);
        let (cosine, sine) = x_parts.split_at_mut(n);
        for ((x, c), s) in x.iter().zip(&mut *cosine).zip(&mut *sine) {
            (*c, *s) = (x.re, -x.im);
        }
        let (moved_cosine, moved_sine) = moved.split_at_mut(n);
        self.add_real((cosine, sine), (&mut *moved_cosine, &mut *moved_sine));
        for ((r, c), s) in r.iter_mut().zip(moved_cosine).zip(moved_sine) {
            *r -= c64::new(*c, -*s);
        }
    }

    /// (c, s) += G (x_c, x_s) in cosine and sine coefficients; x̂ = x_c − i x_s.
    #[inline(always)]
    pub fn add_real(&self, x: (&[f64], &[f64]), y: (&mut [f64], &mut [f64])) {
        for (j, (&x_c, &x_s)) in x.0.iter().zip(x.1).enumerate() {
            if x_c == 0.0 && x_s == 0.0 {
                continue;
            }
            let column = [&self.real, &self.imaginary].map(|part| part.col_as_slice(j));
            axpy_complex((x_c, x_s), column, (&mut *y.0, &mut *y.1));
        }
    }
}

#[inline(always)]
fn times(d: &[c64], x: &[c64]) -> Vec<c64> {
    d.iter().zip(x).map(|(d, x)| d * x).collect()
}

/// The arguments of [`HarmonicCompliance::solve`], for the instruction set that is found at run time.
struct Solving<'a, 'p> {
    compliance: &'a HarmonicCompliance<'p>,
    load: &'a [c64],
    refined: bool,
}

impl WithSimd for Solving<'_, '_> {
    type Output = Vec<c64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<c64> {
        if self.refined {
            self.compliance.refined(self.load)
        } else {
            self.compliance.solve_by_compliance(self.load)
        }
    }
}

impl FreeModes {
    /// The modes and G, with L = BΦ, K = K_c, and index l for the loose modes:
    ///
    /// ```text
    /// H = L D Lᵀ                 compliance of the free structure without the loose modes
    /// G' = (I + H K)⁻¹ H          the same with stuck contacts
    /// W = (I − G' K) L_l          relative displacements per motion of a loose mode
    /// S = Z_l + L_lᵀ K W          dynamic stiffness of the loose modes
    /// R = W S⁻¹,  G = G' + R Wᵀ
    /// ```
    fn new(part: &ModalPart, k_c: &[f64], held: &[f64], frequency: f64) -> (Self, Symmetric) {
        let structure = &part.structure;
        let impedance: Vec<c64> = (structure.lambda.iter().zip(&structure.damping))
            .map(|(&l, &c)| c64::new(l - frequency * frequency, frequency * c))
            .collect();
        let coupled = &structure.coupling.modes;
        let is_loose = |j: &usize| {
            held[*j] * held[*j] > LOOSE * LOOSE * impedance[*j].norm_sqr() && !coupled.contains(j)
        };
        let mut loose = coupled.clone();
        loose.extend((0..impedance.len()).filter(is_loose));
        let mut receptance: Vec<c64> = impedance.iter().map(|z| z.inv()).collect();
        for &j in &loose {
            receptance[j] = c64::new(0.0, 0.0);
        }
        let springs: Vec<c64> = k_c.iter().map(|&k| c64::new(k, 0.0)).collect();
        let mut stuck = receptance_at_contacts(part, &receptance).with_springs(&springs);
        let (moved, pull) = motion_of_loose_modes(part, k_c, &loose, &stuck);
        let held = [&moved[0], &moved[1]].map(|w| pull.transpose() * w);
        let n = loose.len();
        let dynamic = Mat::from_fn(n, n, |a, b| {
            let spring = c64::new(held[0][(a, b)], held[1][(a, b)]) * part.multiplicity;
            let free = match a == b {
                true => impedance[loose[a]],
                false if a.max(b) < coupled.len() => {
                    c64::new(0.0, frequency * structure.coupling.damping[(a, b)])
                }
                false => c64::new(0.0, 0.0),
            };
            spring + free
        });
        let dynamic = dynamic.partial_piv_lu();
        let per_load = add_loose_modes(&mut stuck, part.multiplicity, &moved, &dynamic);
        let modes = Self {
            frequency,
            impedance,
            receptance,
            loose,
            per_load,
            dynamic,
        };
        (modes, stuck)
    }

    /// Z η.
    #[inline(always)]
    fn free_load(&self, part: &ModalPart, eta: &[c64]) -> Vec<c64> {
        let mut load = times(&self.impedance, eta);
        let coupling = &part.structure.coupling;
        coupling.add_product(c64::new(0.0, self.frequency), eta, &mut load);
        load
    }
}

/// Real and imaginary part of W, the relative displacements of the stuck structure per motion of a loose mode, and K L_l, the
/// forces of the stuck contacts per such motion. Shape: 3·n_contacts × loose.
fn motion_of_loose_modes(
    part: &ModalPart,
    k_c: &[f64],
    loose: &[usize],
    stuck: &Symmetric,
) -> ([Mat<f64>; 2], Mat<f64>) {
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
    (moved, pull)
}

/// Adds R Wᵀ to the compliance G' of the structure without loose modes, and returns R = W S⁻¹. `moved` are the parts of W,
/// `dynamic` the factors of S.
fn add_loose_modes(
    stuck: &mut Symmetric,
    multiplicity: f64,
    moved: &[Mat<f64>; 2],
    dynamic: &PartialPivLu<c64>,
) -> Mat<c64> {
    let (m, n) = (moved[0].nrows(), moved[0].ncols());
    // column by column: with a closure for each entry the compliance takes a tenth more time
    let mut transposed = Mat::zeros(n, m);
    for b in 0..n {
        let [real, imaginary] = moved.each_ref().map(|w| w.col_as_slice(b));
        for (i, (&re, &im)) in real.iter().zip(imaginary).enumerate() {
            transposed[(b, i)] = c64::new(re, im);
        }
    }
    dynamic.solve_in_place(&mut transposed);
    let mut per_load = Mat::zeros(m, n);
    let [mut real, mut imaginary] = [Mat::zeros(m, n), Mat::zeros(m, n)];
    for i in 0..m {
        for (b, &r) in transposed.col_as_slice(i).iter().enumerate() {
            per_load[(i, b)] = r;
            real[(i, b)] = multiplicity * r.re;
            imaginary[(i, b)] = multiplicity * r.im;
        }
    }
    let [moved_real, moved_imaginary] = moved.each_ref().map(Mat::transpose);
    add_product(&mut stuck.real, 1.0, real.as_ref(), moved_real);
    add_product(&mut stuck.real, -1.0, imaginary.as_ref(), moved_imaginary);
    add_product(&mut stuck.imaginary, 1.0, real.as_ref(), moved_imaginary);
    add_product(&mut stuck.imaginary, 1.0, imaginary.as_ref(), moved_real);
    per_load
}

/// y += factor a b.
fn add_product(y: &mut Mat<f64>, factor: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(y.as_mut(), Accum::Add, a, b, factor, Par::Seq);
}

/// Stiffness of the stuck contacts against each mode. Shape: `[n]`.
fn stiffness_against_modes(part: &ModalPart, k_c: &[f64]) -> Vec<f64> {
    let against = |j| {
        let shape = part.contact.col_as_slice(j);
        let energies = shape.iter().zip(k_c).map(|(x, k)| k * x * x);
        part.multiplicity * energies.sum::<f64>()
    };
    (0..part.n_coordinates()).map(against).collect()
}

/// H = L D Lᵀ. Shape: `receptance` `[n]`.
fn receptance_at_contacts(part: &ModalPart, receptance: &[c64]) -> Symmetric {
    let l = &part.contact;
    let product = |f: fn(&c64) -> f64| {
        let mut scaled = l.clone();
        for (j, d) in receptance.iter().enumerate() {
            let factor = part.multiplicity * f(d);
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
