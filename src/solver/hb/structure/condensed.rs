//! The modes of the free structure condensed to the contacts, which stick, but for the loose ones.
//!
//! With L = BΦ, K = K_c, D the receptance of the modes that are not loose, and index l for the loose ones:
//!
//! ```text
//! H = L D Lᴴ                 compliance of the free structure without the loose modes
//! G' = (I + H K)⁻¹ H          the same with stuck contacts
//! W = (I − G' K) L_l          relative displacements per motion of a loose mode
//! V = L_lᴴ (I − K G')         load on the loose modes per force at the contacts; Wᵀ where L is real
//! S = Z_l + L_lᴴ K W          dynamic stiffness of the loose modes
//! R = W S⁻¹,  G = G' + R V
//! ```

use super::linear::ModalPart;
use super::springs::ContactCompliance;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use faer::{Accum, Par};

/// The modes of one part at one frequency: those that are condensed, and the loose ones.
pub(super) struct SplitModes<'a> {
    pub(super) part: &'a ModalPart,
    /// D, zero for loose modes. Shape: `[n]`.
    pub(super) receptance: &'a [c64],
    pub(super) loose: &'a [usize],
    /// Z_l. Shape: loose × loose.
    pub(super) free: Mat<c64>,
}

/// The loose modes with stuck contacts.
#[derive(Debug)]
pub(super) struct HeldModes {
    /// R, relative displacements of the stuck structure per load on the loose modes. Shape: 3·n_contacts × loose.
    pub(super) per_load: Mat<c64>,
    /// (S⁻¹ V)ᵀ; none where it is R, by symmetry. Shape as R.
    per_force: Option<Mat<c64>>,
    /// Factors of S.
    pub(super) dynamic: PartialPivLu<c64>,
}

impl HeldModes {
    /// Motion of the loose mode b per force at the contacts. Shape: `[3·n_contacts]`.
    pub(super) fn per_force(&self, b: usize) -> &[c64] {
        let per_force = self.per_force.as_ref().unwrap_or(&self.per_load);
        per_force.col_as_slice(b)
    }
}

impl SplitModes<'_> {
    /// The loose modes and G, for the stiffness `k_c` of the stuck contacts.
    pub(super) fn with_stuck_contacts(&self, k_c: &[f64]) -> (HeldModes, ContactCompliance) {
        match self.part.is_real() {
            true => self.symmetric(k_c),
            false => self.of_wave(k_c),
        }
    }

    fn symmetric(&self, k_c: &[f64]) -> (HeldModes, ContactCompliance) {
        let part = self.part;
        let springs: Vec<c64> = k_c.iter().map(|&k| c64::new(k, 0.0)).collect();
        let mut stuck = receptance_at_contacts(part, self.receptance).with_springs(&springs);
        let (moved, pull) = motion_of_loose_modes(part, k_c, self.loose, &stuck);
        let held = [&moved[0], &moved[1]].map(|w| pull.transpose() * w);
        let n = self.loose.len();
        let dynamic = Mat::from_fn(n, n, |a, b| {
            let spring = c64::new(held[0][(a, b)], held[1][(a, b)]) * part.multiplicity;
            spring + self.free[(a, b)]
        });
        let dynamic = dynamic.partial_piv_lu();
        let per_load = add_loose_modes(&mut stuck, part.multiplicity, &moved, &dynamic);
        let held = HeldModes {
            per_load,
            per_force: None,
            dynamic,
        };
        (held, stuck)
    }

    fn of_wave(&self, k_c: &[f64]) -> (HeldModes, ContactCompliance) {
        let (m, contact) = (k_c.len(), self.part.contact.complex());
        let factor = self.part.multiplicity;
        let scaled = Mat::from_fn(m, contact.ncols(), |i, j| {
            contact[(i, j)] * self.receptance[j] * factor
        });
        let springs: Vec<c64> = k_c.iter().map(|&k| c64::new(k, 0.0)).collect();
        let free = &scaled * contact.adjoint();
        let mut stuck = ContactCompliance::of_wave(&free).with_springs(&springs);
        let loose = Mat::from_fn(m, self.loose.len(), |i, b| contact[(i, self.loose[b])]);
        let pull = Mat::from_fn(m, self.loose.len(), |i, b| loose[(i, b)] * k_c[i]);
        let g = stuck.complex();
        let moved = &loose - &g * &pull;
        let taken = loose.adjoint() - pull.adjoint() * &g;
        let dynamic = &self.free + pull.adjoint() * &moved * Scale(c64::new(factor, 0.0));
        let dynamic = dynamic.partial_piv_lu();
        let per_force = dynamic.solve(&taken);
        let mut per_load = moved.transpose().to_owned();
        dynamic.solve_transpose_in_place(&mut per_load);
        stuck =
            ContactCompliance::of_wave(&(g + &moved * &per_force * Scale(c64::new(factor, 0.0))));
        let held = HeldModes {
            per_load: per_load.transpose().to_owned(),
            per_force: Some(per_force.transpose().to_owned()),
            dynamic,
        };
        (held, stuck)
    }
}

/// Real and imaginary part of W, the relative displacements of the stuck structure per motion of a loose mode, and K L_l, the
/// forces of the stuck contacts per such motion. Shape: 3·n_contacts × loose.
fn motion_of_loose_modes(
    part: &ModalPart,
    k_c: &[f64],
    loose: &[usize],
    stuck: &ContactCompliance,
) -> ([Mat<f64>; 2], Mat<f64>) {
    let (m, n) = (k_c.len(), loose.len());
    let mut moved = [Mat::zeros(m, n), Mat::zeros(m, n)];
    for (b, &j) in loose.iter().enumerate() {
        moved[0]
            .col_as_slice_mut(b)
            .copy_from_slice(part.contact.real.col_as_slice(j));
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
    stuck: &mut ContactCompliance,
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

/// Rows from which on zeros of L are left out of H.
const SPARSE_ROWS: usize = 100;
/// Largest share of L that may then be other than zero: sectors of a ring that only contacts couple.
const SPARSE_SHARE: f64 = 0.125;

/// H = L D Lᵀ by the entries of L that are not zero; none where these are many.
fn sparse_receptance(l: &Mat<f64>, receptance: &[c64]) -> Option<ContactCompliance> {
    let (m, n) = (l.nrows(), l.ncols());
    let filled = (0..n).map(|j| l.col_as_slice(j).iter().filter(|x| **x != 0.0).count());
    if m < SPARSE_ROWS || filled.sum::<usize>() as f64 > SPARSE_SHARE * (m * n) as f64 {
        return None;
    }
    let [mut real, mut imaginary] = [Mat::zeros(m, m), Mat::zeros(m, m)];
    let condensed = receptance
        .iter()
        .enumerate()
        .filter(|(_, d)| d.norm_sqr() > 0.0);
    for (j, d) in condensed {
        let column = l.col_as_slice(j);
        let rows: Vec<usize> = (0..m).filter(|&i| column[i] != 0.0).collect();
        for (at, &b) in rows.iter().enumerate() {
            let scaled = d * column[b];
            for &a in &rows[at..] {
                real[(a, b)] += column[a] * scaled.re;
                imaginary[(a, b)] += column[a] * scaled.im;
            }
        }
    }
    Some(ContactCompliance {
        real,
        imaginary,
        symmetric: true,
    })
}

/// H = L D Lᵀ. Shape: `receptance` `[n]`.
fn receptance_at_contacts(part: &ModalPart, receptance: &[c64]) -> ContactCompliance {
    let l = &part.contact.real;
    if part.multiplicity == 1.0
        && let Some(sparse) = sparse_receptance(l, receptance)
    {
        return sparse;
    }
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
    ContactCompliance {
        real: product(|z| z.re),
        imaginary: product(|z| z.im),
        symmetric: true,
    }
}
