//! What becomes of a small disturbance of a travelling wave, which may be any wave of the disk.
//!
//! Sector j does what sector 0 did earlier, so that its contacts have the derivatives of sector 0, earlier. After the time in which
//! the vibration passes to another sector everything is as it was, but for the numbers of the sectors. A lap of the march is the shortest
//! such time: with g the greatest common divisor of the engine order r and the number N of sectors, g/N of a period, in which sector j
//! becomes sector j + σ, where σ r = g mod N. N/g laps are a period. The eigenvalues of a lap γ give the multipliers:
//!
//! ```text
//! μ = γ^(N/g) ζ^(−σ)
//! ```
//!
//! with ζ = exp(−2πi c/g), the factor by which a disturbance of class c differs between the sectors j and j + N/g. The contacts of these two
//! sectors have the same derivatives at all times.
//!
//! A ring of few unknowns has all multipliers by a dense matrix; of others the largest ones are found by what becomes of a few
//! disturbances (`leading`).

use super::contact_steps::{PairStep, PairSteps};
use super::march::ROOT;
use super::period_map::{PeriodicMotion, pair_steps};
use super::sectors::{Factors, Sectors};
use super::structure::{DisturbedWave, EnergyNorm};
use crate::hb::equations::problem::Problem;
use crate::hb::structure::linear::TunedRing;
use faer::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2, TAU};

/// Largest estimated memory of the factors of a lap (bytes).
const MOST_MEMORY: usize = 1 << 30;

/// The map of a lap, for disturbances of all sectors.
#[derive(Debug)]
pub struct RingMap {
    sectors: Sectors,
    /// Derivatives of the active pairs of sector 0.
    pairs: Vec<PairSteps>,
    /// Sliders of a sector that remember: active pair, direction, and its scale.
    sliders: Vec<(usize, usize, f64)>,
    /// Factors of each step of a lap.
    lap: Vec<Factors>,
    /// Length of a step (s).
    step: f64,
    /// Steps that sector j lags behind sector 0.
    lags: Vec<usize>,
    /// σ.
    shift: usize,
    /// N/g.
    laps: usize,
    /// Energy coordinates of the waves 0 to N/2: in them a disturbance of stuck contacts never grows, not even for part of a period.
    norms: Vec<EnergyNorm>,
}

/// A coordinate of a wave in a disturbance: x(real) + i `sign` x(imaginary).
#[derive(Debug, Clone, Copy)]
pub(super) struct WaveCoordinate {
    /// Row of the real part.
    pub(super) real: usize,
    /// Row of the imaginary part; `None` for a wave that stands.
    pub(super) imaginary: Option<usize>,
    /// −1 for the wave in the other direction.
    pub(super) sign: f64,
}

/// Disturbances of all sectors, one column each.
struct Disturbances {
    /// η and η̇ of the waves 0 to N/2.
    eta: Vec<Mat<c64>>,
    rate: Vec<Mat<c64>>,
    /// Displacements of the active pairs. Rows: `[N][active][3]`.
    relative: Mat<f64>,
    /// Sliders. Rows: `[N][active][2]`.
    slider: Mat<f64>,
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

impl RingMap {
    /// The map of `motion` of `problem`, a sector of `ring`, with at least `n_steps` steps per period; `None` for a ring with
    /// too many contacts.
    #[must_use]
    pub fn new(
        problem: &Problem<'_>,
        ring: &TunedRing,
        motion: &PeriodicMotion<'_>,
        n_steps: usize,
    ) -> Option<Self> {
        let (n, order) = (ring.disk.n_sectors, ring.engine_order);
        let common = gcd(order, n);
        let laps = n / common;
        let of_lap = n_steps.div_ceil(laps);
        let n_steps = laps * of_lap;
        let step = TAU / motion.omega / n_steps as f64;
        let pairs = pair_steps(problem, motion, n_steps);
        let constant: Vec<_> = pairs.iter().map(PairSteps::constant).collect();
        let stuck = &problem.stuck_stiffness;
        let waves: Vec<DisturbedWave> = (ring.waves()?.iter())
            .map(|part| DisturbedWave::new(part, stuck, motion.omega))
            .collect::<Option<_>>()?;
        let norm = |wave: &DisturbedWave| wave.energy_norm(stuck, motion.omega);
        let norms = waves.iter().map(norm).collect::<Option<_>>()?;
        let s = c64::new(ROOT[0], ROOT[1]) / step;
        let uncoupled = ring.disk.is_uncoupled();
        let sectors = Sectors::new(waves, &constant, s, n, uncoupled)?;
        let is_active = |pair: &usize| constant[*pair].is_none();
        let kept = |pair: usize| (pairs[pair].clone(), problem.contacts[pair].k_t);
        let (pairs, k_t): (Vec<_>, Vec<_>) =
            (0..constant.len()).filter(is_active).map(kept).unzip();
        let directions = (0..pairs.len()).flat_map(|pair| [(pair, 0), (pair, 1)]);
        let scaled = |(pair, d): (usize, usize)| (pair, d, k_t[pair][d].sqrt().max(1.0));
        let mut map = Self {
            norms,
            sliders: directions
                .filter(|&(pair, d)| pairs[pair].moves[d])
                .map(scaled)
                .collect(),
            pairs,
            lap: Vec::new(),
            step,
            lags: (0..n)
                .map(|j| j * (order % n) % n / common * of_lap)
                .collect(),
            shift: (0..n).find(|j| j * (order % n) % n == common % n)?,
            laps,
            sectors,
        };
        if map.memory(of_lap) > MOST_MEMORY {
            return None;
        }
        let steps = (0..of_lap).map(|step| map.sectors.factor(&map.at(step)));
        map.lap = steps.collect::<Option<_>>()?;
        Some(map)
    }

    /// Estimated memory of the factors of so many steps (bytes).
    fn memory(&self, steps: usize) -> usize {
        let width = 3 * self.sectors.active.len();
        // a dense matrix, or six blocks of a sector, of complex numbers
        let blocks = self.sectors.n_sectors.min(6);
        16 * steps * width * width * self.sectors.n_sectors * blocks
    }

    /// Derivatives of all active pairs, sector by sector, in a step.
    fn at(&self, step: usize) -> Vec<&PairStep> {
        let of_sector = |lag: &usize| {
            let lag = *lag;
            self.pairs.iter().map(move |pair| {
                let n = pair.steps.len();
                &pair.steps[(step + n - lag) % n]
            })
        };
        self.lags.iter().flat_map(of_sector).collect()
    }

    /// Number of unknowns of a disturbance.
    #[must_use]
    pub fn size(&self) -> usize {
        let n = self.sectors.n_sectors;
        let rows: usize = (0..self.norms.len()).map(|wave| self.rows(wave)).sum();
        2 * rows + n * self.sliders.len()
    }

    /// Whether a wave stands: its η is real.
    fn stands(&self, wave: usize) -> bool {
        (2 * wave).is_multiple_of(self.sectors.n_sectors)
    }

    /// Rows of η of a wave in a disturbance, and as many of η̇: real parts, then imaginary ones.
    fn rows(&self, wave: usize) -> usize {
        let modes = self.norms[wave].scales.len();
        if self.stands(wave) { modes } else { 2 * modes }
    }

    /// N/g, the number of laps in a period.
    pub(super) fn laps(&self) -> usize {
        self.laps
    }

    /// What a lap makes of disturbances, one column each. Rows: `size`.
    pub(super) fn lap(&self, disturbances: &Mat<f64>) -> Mat<f64> {
        let mut state = self.unpack(disturbances);
        for (step, factors) in self.lap.iter().enumerate() {
            self.advance(&mut state, &self.at(step), factors);
        }
        self.pack(&state, self.shift)
    }

    /// All Floquet multipliers, in no order, by a dense matrix; `None` if they were not found.
    #[must_use]
    pub fn multipliers(&self) -> Option<Vec<c64>> {
        let n = self.size();
        let lap = self.lap(&Mat::identity(n, n));
        let mut period = lap.clone();
        (1..self.laps).for_each(|_| period = &lap * &period);
        let sectors = self.sectors.n_sectors;
        let back = (sectors - self.shift * self.laps % sectors) % sectors;
        self.pack(&self.unpack(&period), back).eigenvalues().ok()
    }

    /// g, the number of classes: disturbances of class c have waves whose number is c mod g, and those in the other direction where it
    /// is −c; they do not mix with others.
    pub(super) fn classes(&self) -> usize {
        self.sectors.n_sectors / self.laps
    }

    /// Coordinates of the waves of a class, 0 to N − 1, in a disturbance.
    pub(super) fn coordinates_of_class(&self, class: usize) -> Vec<WaveCoordinate> {
        let n = self.sectors.n_sectors;
        let mut rows = Vec::new();
        let mut first = 0;
        for (wave, norm) in self.norms.iter().enumerate() {
            let modes = norm.scales.len();
            let (stands, width) = (self.stands(wave), self.rows(wave));
            for (of, sign) in [(wave, 1.0), (n - wave, -1.0)] {
                let twice = stands && sign < 0.0;
                if of % self.classes() != class || twice {
                    continue;
                }
                // of η, then of η̇
                for start in [first, first + width] {
                    rows.extend((start..start + modes).map(|real| WaveCoordinate {
                        real,
                        imaginary: (!stands).then_some(real + modes),
                        sign,
                    }));
                }
            }
            first += 2 * width;
        }
        rows
    }

    /// ζ^(−σ) of a class.
    pub(super) fn turn_of_class(&self, class: usize) -> c64 {
        let angle = TAU * (class * self.shift) as f64 / self.classes() as f64;
        c64::new(libm::cos(angle), libm::sin(angle))
    }

    fn unpack(&self, x: &Mat<f64>) -> Disturbances {
        let n = self.sectors.n_sectors;
        let mut first = 0;
        let mut take = |count: usize| {
            let rows = x.subrows(first, count);
            first += count;
            rows
        };
        let mut read = |wave: usize| -> Mat<c64> {
            let modes = self.norms[wave].scales.len();
            let re = take(modes);
            match self.stands(wave) {
                true => Mat::from_fn(modes, x.ncols(), |i, j| c64::new(re[(i, j)], 0.0)),
                false => {
                    let im = take(modes);
                    Mat::from_fn(modes, x.ncols(), |i, j| {
                        c64::new(re[(i, j)], im[(i, j)]) * FRAC_1_SQRT_2
                    })
                }
            }
        };
        let waves = 0..self.norms.len();
        let (eta, rate): (Vec<_>, Vec<_>) = waves
            .map(|wave| (self.norms[wave].eta(&read(wave)), read(wave)))
            .unzip();
        let active = self.sectors.active.len();
        let mut slider = Mat::zeros(2 * active * n, x.ncols());
        for sector in 0..n {
            let rows = take(self.sliders.len());
            for (i, &(pair, d, scale)) in self.sliders.iter().enumerate() {
                let row = 2 * (active * sector + pair) + d;
                (0..x.ncols()).for_each(|j| slider[(row, j)] = rows[(i, j)] / scale);
            }
        }
        Disturbances {
            relative: self.relative(&eta),
            eta,
            rate,
            slider,
        }
    }

    /// Displacements of the active pairs of all sectors.
    fn relative(&self, eta: &[Mat<c64>]) -> Mat<f64> {
        let n = self.sectors.n_sectors;
        let relative = |wave: usize| match eta.get(wave) {
            Some(eta) => self.sectors.direction(wave).relative(eta),
            None => {
                let same = self.sectors.direction(n - wave).relative(&eta[n - wave]);
                same.conjugate().to_owned()
            }
        };
        let n_fields = eta[0].ncols();
        let waves = side_by_side(
            (0..n).map(relative),
            3 * self.sectors.active.len(),
            n_fields,
        );
        let sectors = self.sectors.to_sectors(&waves, n_fields);
        Mat::from_fn(sectors.nrows(), n_fields, |i, j| sectors[(i, j)].re)
    }

    /// The disturbances of the sectors that are `by` ahead.
    fn pack(&self, state: &Disturbances, by: usize) -> Mat<f64> {
        let n = self.sectors.n_sectors;
        let width = state.slider.ncols();
        let mut x = Mat::zeros(self.size(), width);
        let root = (n as f64).sqrt();
        let mut first = 0;
        let mut write = |wave: usize, values: &Mat<c64>| {
            let turn = self.sectors.turn(wave, by) * root;
            let modes = values.nrows();
            let stands = self.stands(wave);
            for j in 0..width {
                for (i, value) in values.col(j).iter().enumerate() {
                    let turned = turn * value;
                    if stands {
                        x[(first + i, j)] = turned.re;
                    } else {
                        x[(first + i, j)] = SQRT_2 * turned.re;
                        x[(first + modes + i, j)] = SQRT_2 * turned.im;
                    }
                }
            }
            first += self.rows(wave);
        };
        for (wave, (eta, rate)) in state.eta.iter().zip(&state.rate).enumerate() {
            write(wave, &self.norms[wave].energy_coordinates(eta));
            write(wave, rate);
        }
        let active = self.sectors.active.len();
        for sector in 0..n {
            let from = 2 * active * ((sector + by) % n);
            for &(pair, d, scale) in &self.sliders {
                let row = from + 2 * pair + d;
                (0..width).for_each(|j| x[(first, j)] = scale * state.slider[(row, j)]);
                first += 1;
            }
        }
        x
    }

    /// One step; `at` are the derivatives of all active pairs.
    fn advance(&self, state: &mut Disturbances, at: &[&PairStep], factors: &Factors) {
        let width = state.slider.ncols();
        let mut load = Mat::zeros(3 * at.len(), width);
        for j in 0..width {
            let [relative, slider] = [&state.relative, &state.slider].map(|of| of.col_as_slice(j));
            let load = load.col_as_slice_mut(j).chunks_exact_mut(3);
            for (pair, (of, load)) in at.iter().zip(load).enumerate() {
                load.copy_from_slice(&force(of, &relative[3 * pair..], &slider[2 * pair..]));
            }
        }
        let load = self.sectors.to_waves(&load);
        let n = self.sectors.n_sectors;
        let mut p: Vec<Mat<c64>> = (0..n)
            .map(|wave| self.without_change(state, wave, of_wave(&load, wave, width)))
            .collect();
        let right =
            (p.iter().enumerate()).map(|(wave, p)| self.sectors.direction(wave).relative(p));
        let right = side_by_side(right, 3 * self.sectors.active.len(), width);
        let rho = factors.solve(self.sectors.to_sectors(&right, width));
        let mut change = Mat::zeros(3 * at.len(), width);
        for j in 0..width {
            let rho = rho.col_as_slice(j);
            let change = change.col_as_slice_mut(j).chunks_exact_mut(3);
            for (pair, (of, change)) in at.iter().zip(change).enumerate() {
                change.copy_from_slice(&pulled(of, &rho[3 * pair..]));
            }
        }
        let change = self.sectors.to_waves(&change);
        for (wave, p) in p.iter_mut().enumerate() {
            *p -= self
                .sectors
                .direction(wave)
                .moved_by(of_wave(&change, wave, width));
        }
        self.move_waves(state, &p);
        let factor = 4.0 * ROOT[1] * self.step;
        let after = Mat::from_fn(rho.nrows(), width, |i, j| {
            state.relative[(i, j)] + factor * rho[(i, j)].im
        });
        let before = std::mem::replace(&mut state.relative, after);
        for j in 0..width {
            let [old, new] = [&before, &state.relative].map(|of| of.col_as_slice(j));
            let sliders = state.slider.col_as_slice_mut(j).chunks_exact_mut(2);
            for (pair, (of, slider)) in at.iter().zip(sliders).enumerate() {
                slide(of, &old[3 * pair..], &new[3 * pair..], slider);
            }
        }
    }

    /// The step of the waves by p of the waves 0 to N − 1.
    fn move_waves(&self, state: &mut Disturbances, p: &[Mat<c64>]) {
        let n = self.sectors.n_sectors;
        let a = c64::new(ROOT[0], ROOT[1]);
        let factor = 4.0 * ROOT[1];
        // the part of the wave in the imaginary part of the field
        let imaginary = |x: c64, y: c64| (x - y.conj()) * c64::new(0.0, -0.5);
        for wave in 0..state.eta.len() {
            let (there, back) = (&p[wave], &p[(n - wave) % n]);
            for j in 0..there.ncols() {
                let [there, back] = [there, back].map(|of| of.col_as_slice(j));
                let eta = state.eta[wave].col_as_slice_mut(j);
                let rate = state.rate[wave].col_as_slice_mut(j);
                for (i, (x, y)) in there.iter().zip(back).enumerate() {
                    eta[i] += imaginary(*x, *y) * (factor * self.step);
                    rate[i] += imaginary(a * x, a * y) * factor;
                }
            }
        }
    }

    /// p₀ of a wave 0 to N − 1.
    fn without_change(&self, state: &Disturbances, wave: usize, load: MatRef<'_, c64>) -> Mat<c64> {
        let n = self.sectors.n_sectors;
        let s = c64::new(ROOT[0], ROOT[1]) / self.step;
        let backward = wave >= state.eta.len();
        let of = if backward { n - wave } else { wave };
        let (eta, rate) = (&state.eta[of], &state.rate[of]);
        let direction = self.sectors.direction(wave);
        let pull = self.sectors.waves[of].pull(eta, rate, s, backward);
        let mut p = direction.moved_by(load) - direction.moved(&pull);
        let turned = |x: c64| if backward { x.conj() } else { x };
        let scale = 1.0 / self.step;
        for j in 0..p.ncols() {
            for (p, eta) in p.col_as_slice_mut(j).iter_mut().zip(eta.col_as_slice(j)) {
                *p = (*p + turned(*eta)) * scale;
            }
        }
        p
    }
}

/// Fields of all waves, a column for each wave. Shape: width × fields each → fields · width × waves.
fn side_by_side(
    waves: impl ExactSizeIterator<Item = Mat<c64>>,
    width: usize,
    n_fields: usize,
) -> Mat<c64> {
    let mut all = Mat::zeros(n_fields * width, waves.len());
    for (wave, of) in waves.enumerate() {
        let to = all.col_as_slice_mut(wave).chunks_exact_mut(width.max(1));
        to.enumerate()
            .for_each(|(j, to)| to.copy_from_slice(of.col_as_slice(j)));
    }
    all
}

/// Those of one wave.
fn of_wave(all: &Mat<c64>, wave: usize, n_fields: usize) -> MatRef<'_, c64> {
    let column = all.col_as_slice(wave);
    MatRef::from_column_major_slice(column, column.len() / n_fields, n_fields)
}

/// D r + E w of a pair.
fn force(of: &PairStep, relative: &[f64], slider: &[f64]) -> [c64; 3] {
    [0, 1, 2].map(|row| {
        let springs: f64 = (0..3).map(|c| of.stiffness[row][c] * relative[c]).sum();
        let memory = match of.memory.get(row) {
            Some(memory) => memory[0] * slider[0] + memory[1] * slider[1],
            None => 0.0,
        };
        c64::new(springs + memory, 0.0)
    })
}

/// Where the sliders of a pair go, whose displacements go from `old` to `new`.
fn slide(of: &PairStep, old: &[f64], new: &[f64], slider: &mut [f64]) {
    let was = [slider[0], slider[1]];
    for (d, slider) in slider.iter_mut().enumerate() {
        let mut moved = of.kept[d][0] * was[0] + of.kept[d][1] * was[1];
        for c in 0..3 {
            moved += of.by_start[d][c] * old[c] + of.by_end[d][c] * new[c];
        }
        *slider = moved;
    }
}

/// D ρ of a pair.
fn pulled(of: &PairStep, rho: &[c64]) -> [c64; 3] {
    [0, 1, 2].map(|row| (0..3).map(|c| rho[c] * of.stiffness[row][c]).sum())
}
