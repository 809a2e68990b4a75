//! All sectors of a disk for disturbances of a travelling wave: the linear part wave by wave, the contacts sector by sector.
//!
//! Waves of the whole ring do not know of each other but for the contacts, whose derivatives differ from sector to sector. Contacts that keep
//! their derivatives over the whole period, as those that always stick do, belong to the linear part: D₀. A step of the march
//! ([`super::march`], here with the damping in it) is, for the wave w,
//!
//! ```text
//! Z = Λ + s² + s Ĉ + Bᴴ D₀ B,   Y = Z⁻¹,   L = Y Bᴴ
//! p₀ = (η − Y s (Ĉ η + s η + η̇) + L g)/h,   g = D B η + E w
//! p = p₀ − L D ρ,   (1 + X D) ρ = B p₀,   X = B L
//! ```
//!
//! where the last equation is for the contacts of all sectors together. Where only contacts couple the sectors, forces of these contacts reach
//! the neighbours alone within a step: farther ones feel them through the stuck contacts from the next step on.

use super::contact_steps::PairStep;
use super::structure::DisturbedWave;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use faer::sparse::linalg::solvers::Lu;
use faer::sparse::{SparseColMat, Triplet};
use std::f64::consts::TAU;

/// A derivative of forces by displacements of one pair.
type Stiffness = [[f64; 3]; 3];

/// Most unknowns of the contacts of all sectors, where more than contacts couple them.
const MOST_DENSE: usize = 1500;

/// The linear part at the complex frequency of a step.
#[derive(Debug)]
pub(super) struct Sectors {
    /// Number N of sectors.
    pub(super) n_sectors: usize,
    /// Pairs of a sector whose derivatives change over the period.
    pub(super) active: Vec<usize>,
    /// Waves 0 to N/2.
    pub(super) waves: Vec<RingWave>,
    /// exp(−2πi w j/N)/√N of wave w in sector j. Shape: N × N, symmetric.
    turns: Mat<c64>,
    /// X by how many sectors a displacement is ahead of the force. Shape: `[N]`, 3·active square.
    compliance: Vec<Mat<c64>>,
    /// Whether a force reaches farther than the neighbours of its sector.
    far: bool,
}

/// A wave, and the one in the other direction where it travels.
#[derive(Debug)]
pub(super) struct RingWave {
    /// Entries of Ĉ (1/s) that are not zero.
    pub(super) damping: Vec<(usize, usize, c64)>,
    pub(super) forward: WaveResponse,
    pub(super) backward: Option<WaveResponse>,
}

/// A wave in one direction.
#[derive(Debug)]
pub(super) struct WaveResponse {
    /// Y. Shape: n × n.
    receptance: Mat<c64>,
    /// L. Shape: n × 3·active.
    per_force: Mat<c64>,
    /// B. Shape: 3·active × n, the three of a pair together.
    contact: Mat<c64>,
}

impl Sectors {
    /// The ring of these `waves`, whose pairs have the derivatives of `constant` or, where it says none, changing ones; `s` is the complex
    /// frequency of a step (1/s). `uncoupled`: only contacts couple the sectors. `None` if the contacts are too many.
    pub(super) fn new(
        waves: Vec<DisturbedWave>,
        constant: &[Option<Stiffness>],
        s: c64,
        n_sectors: usize,
        uncoupled: bool,
    ) -> Option<Self> {
        let active: Vec<usize> = (0..constant.len())
            .filter(|&p| constant[p].is_none())
            .collect();
        let far = !uncoupled && n_sectors > 3;
        if !uncoupled && 3 * active.len() * n_sectors > MOST_DENSE {
            return None;
        }
        let turn = |k: usize| {
            let (sin, cos) = libm::sincos(TAU * k as f64 / n_sectors as f64);
            c64::new(cos, -sin) / (n_sectors as f64).sqrt()
        };
        let waves: Vec<RingWave> = (waves.iter().enumerate())
            .map(|(wave, of)| RingWave::new(of, constant, &active, s, (2 * wave) % n_sectors == 0))
            .collect();
        let mut sectors = Self {
            n_sectors,
            waves,
            turns: Mat::from_fn(n_sectors, n_sectors, |wave, sector| {
                turn(wave * sector % n_sectors)
            }),
            compliance: Vec::new(),
            far,
            active,
        };
        sectors.compliance = sectors.compliances();
        Some(sectors)
    }

    /// The direction of a wave 0 to N − 1.
    pub(super) fn direction(&self, wave: usize) -> &WaveResponse {
        match self.waves.get(wave) {
            Some(of) => &of.forward,
            None => {
                let of = &self.waves[self.n_sectors - wave];
                of.backward.as_ref().unwrap_or(&of.forward)
            }
        }
    }

    /// Factor of a sector in a wave.
    pub(super) fn turn(&self, wave: usize, sector: usize) -> c64 {
        self.turns[(wave, sector % self.n_sectors)]
    }

    fn compliances(&self) -> Vec<Mat<c64>> {
        let n = 3 * self.active.len();
        let of_waves: Vec<Mat<c64>> = (0..self.n_sectors)
            .map(|wave| {
                let of = self.direction(wave);
                &of.contact * &of.per_force
            })
            .collect();
        let scale = 1.0 / (self.n_sectors as f64).sqrt();
        (0..self.n_sectors)
            .map(|ahead| {
                let mut sum = Mat::zeros(n, n);
                for (wave, of) in of_waves.iter().enumerate() {
                    sum += of * Scale(self.turn(wave, ahead) * scale);
                }
                sum
            })
            .collect()
    }

    /// Transforms fields from sectors to waves. A column of `fields` holds one field of all sectors; a column of the result holds one wave of all
    /// fields. Rows: `[N][width]` → `[field][width]`.
    pub(super) fn to_waves(&self, fields: &Mat<c64>) -> Mat<c64> {
        let width = fields.nrows() / self.n_sectors;
        let mut by_sector = Mat::zeros(width * fields.ncols(), self.n_sectors);
        for j in 0..fields.ncols() {
            let of_sectors = fields.col_as_slice(j).chunks_exact(width.max(1));
            for (sector, from) in of_sectors.enumerate() {
                by_sector.col_as_slice_mut(sector)[j * width..][..width].copy_from_slice(from);
            }
        }
        by_sector * self.turns.conjugate()
    }

    /// The opposite.
    pub(super) fn to_sectors(&self, waves: &Mat<c64>, n_fields: usize) -> Mat<c64> {
        let by_sector = waves * &self.turns;
        let width = by_sector.nrows() / n_fields;
        let mut fields = Mat::zeros(self.n_sectors * width, n_fields);
        for j in 0..n_fields {
            let of_sectors = fields.col_as_slice_mut(j).chunks_exact_mut(width.max(1));
            for (sector, to) in of_sectors.enumerate() {
                to.copy_from_slice(&by_sector.col_as_slice(sector)[j * width..][..width]);
            }
        }
        fields
    }

    /// Factors of 1 + X D for the derivatives of every active pair, sector by sector; `None` if it is singular.
    pub(super) fn factor(&self, steps: &[&PairStep]) -> Option<Factors> {
        let width = 3 * self.active.len();
        let size = width * self.n_sectors;
        let stiffness = |force: usize, column: usize| {
            let (pair, of) = (column / 3, steps[column / 3]);
            match force / 3 == pair {
                true => of.stiffness[force % 3][column % 3],
                false => 0.0,
            }
        };
        let entry = |row: usize, column: usize| {
            let ahead = (row / width + self.n_sectors - column / width) % self.n_sectors;
            let x = &self.compliance[ahead];
            let pair = column / 3 * 3;
            let sum: c64 = (pair..pair + 3)
                .map(|force| x[(row % width, force % width)] * stiffness(force, column))
                .sum();
            match row == column {
                true => sum + 1.0,
                false => sum,
            }
        };
        if self.far || self.n_sectors <= 3 {
            let matrix = Mat::from_fn(size, size, entry);
            return Some(Factors::Dense(matrix.partial_piv_lu()));
        }
        let mut triplets = Vec::new();
        for column in 0..size {
            let sector = column / width;
            for at in [sector + self.n_sectors - 1, sector, sector + 1] {
                let first = at % self.n_sectors * width;
                for row in first..first + width {
                    let value = entry(row, column);
                    if value != c64::new(0.0, 0.0) {
                        triplets.push(Triplet::new(row, column, value));
                    }
                }
            }
        }
        let matrix = SparseColMat::<usize, c64>::try_new_from_triplets(size, size, &triplets);
        Some(Factors::Sparse(matrix.ok()?.sp_lu().ok()?))
    }
}

/// Factors of 1 + X D.
#[derive(Debug)]
pub(super) enum Factors {
    Dense(PartialPivLu<c64>),
    /// Where forces reach the neighbours alone.
    Sparse(Lu<usize, c64>),
}

impl Factors {
    /// Shape: unknowns × right-hand sides.
    pub(super) fn solve(&self, mut x: Mat<c64>) -> Mat<c64> {
        match self {
            Self::Dense(factors) => factors.solve_in_place(&mut x),
            Self::Sparse(factors) => factors.solve_in_place(&mut x),
        }
        x
    }
}

impl RingWave {
    fn new(
        of: &DisturbedWave,
        constant: &[Option<Stiffness>],
        active: &[usize],
        s: c64,
        stands: bool,
    ) -> Self {
        let n = of.lambda.len();
        let zero = c64::new(0.0, 0.0);
        let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let damping: Vec<(usize, usize, c64)> = all
            .map(|(i, j)| (i, j, of.damping[(i, j)]))
            .filter(|(_, _, c)| *c != zero)
            .collect();
        let turned: Vec<_> = damping.iter().map(|&(i, j, c)| (i, j, c.conj())).collect();
        let other = of.contact.conjugate().to_owned();
        let direction = |damping: &[(usize, usize, c64)], contact: &Mat<c64>| {
            WaveResponse::new(&of.lambda, damping, contact, constant, active, s)
        };
        Self {
            forward: direction(&damping, &of.contact),
            backward: (!stands).then(|| direction(&turned, &other)),
            damping,
        }
    }

    /// s (Ĉ η + s η + η̇) of the wave, or of the one in the other direction.
    pub(super) fn pull(&self, eta: &Mat<c64>, rate: &Mat<c64>, s: c64, backward: bool) -> Mat<c64> {
        let turned = |x: c64| if backward { x.conj() } else { x };
        let mut sum = Mat::from_fn(eta.nrows(), eta.ncols(), |i, j| {
            s * (s * turned(eta[(i, j)]) + turned(rate[(i, j)]))
        });
        for j in 0..eta.ncols() {
            let (sum, eta) = (sum.col_as_slice_mut(j), eta.col_as_slice(j));
            for &(i, k, c) in &self.damping {
                sum[i] += s * turned(c * eta[k]);
            }
        }
        sum
    }
}

impl WaveResponse {
    fn new(
        lambda: &[f64],
        damping: &[(usize, usize, c64)],
        contact: &Mat<c64>,
        constant: &[Option<Stiffness>],
        active: &[usize],
        s: c64,
    ) -> Self {
        let (n, pairs) = (lambda.len(), constant.len());
        let mut dynamic = Mat::from_fn(n, n, |i, j| match i == j {
            true => s * s + lambda[i],
            false => c64::new(0.0, 0.0),
        });
        (damping.iter()).for_each(|&(i, j, c)| dynamic[(i, j)] += s * c);
        let mut held = Mat::<c64>::zeros(contact.nrows(), n);
        for (pair, stiffness) in constant.iter().enumerate() {
            for (row, of_row) in stiffness.iter().flatten().enumerate() {
                for (column, d) in of_row.iter().enumerate().filter(|(_, d)| **d != 0.0) {
                    let [to, from] = [row, column].map(|c| c * pairs + pair);
                    (0..n).for_each(|j| held[(to, j)] += contact[(from, j)] * *d);
                }
            }
        }
        dynamic += contact.adjoint() * held;
        let identity = Mat::<c64>::identity(n, n);
        let receptance = dynamic.partial_piv_lu().solve(identity);
        let contact = Mat::from_fn(3 * active.len(), n, |i, j| {
            contact[(i % 3 * pairs + active[i / 3], j)]
        });
        Self {
            per_force: &receptance * contact.adjoint(),
            receptance,
            contact,
        }
    }

    /// Y x.
    pub(super) fn moved(&self, x: &Mat<c64>) -> Mat<c64> {
        &self.receptance * x
    }

    /// L f.
    pub(super) fn moved_by(&self, force: MatRef<'_, c64>) -> Mat<c64> {
        &self.per_force * force
    }

    /// B η.
    pub(super) fn relative(&self, eta: &Mat<c64>) -> Mat<c64> {
        &self.contact * eta
    }
}
