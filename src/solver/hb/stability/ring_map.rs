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
//! with ζ, a root of unity of order g, by which the disturbance differs from sector j to j + N/g, between which nothing differs.
//!
//! A ring of few unknowns has all of them by a dense matrix. Of others the largest ones are found in a Krylov space.

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
    /// Of the waves 0 to N/2: in these coordinates what is stuck does not grow, also for a while.
    norms: Vec<EnergyNorm>,
}

/// A disturbance of all sectors.
struct Disturbance {
    /// η and η̇ of the waves 0 to N/2.
    eta: Vec<Vec<c64>>,
    rate: Vec<Vec<c64>>,
    /// Displacements of the active pairs. Shape: `[N][active][3]`.
    relative: Vec<f64>,
    /// Sliders. Shape: `[N][active][2]`.
    slider: Vec<f64>,
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
        let sectors = Sectors::new(waves, &constant, s, (n, uncoupled))?;
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
        let modes = |(i, norm): (usize, &EnergyNorm)| match (2 * i) % n {
            0 => norm.scales.len(),
            _ => 2 * norm.scales.len(),
        };
        let modes: usize = self.norms.iter().enumerate().map(modes).sum();
        2 * modes + n * self.sliders.len()
    }

    /// N/g, the number of laps in a period.
    #[must_use]
    pub fn laps(&self) -> usize {
        self.laps
    }

    /// What a lap makes of a disturbance. Shape: `[size]`.
    #[must_use]
    pub fn lap(&self, disturbance: &[f64]) -> Vec<f64> {
        let mut state = self.unpack(disturbance);
        for (step, factors) in self.lap.iter().enumerate() {
            self.advance(&mut state, &self.at(step), factors);
        }
        self.pack(&state, self.shift)
    }

    /// The same disturbance, of the sectors that are `by` ahead.
    #[must_use]
    pub fn shifted(&self, disturbance: &[f64], by: usize) -> Vec<f64> {
        self.pack(&self.unpack(disturbance), by)
    }

    /// All Floquet multipliers, in no order, by a dense matrix; `None` if they were not found.
    #[must_use]
    pub fn multipliers(&self) -> Option<Vec<c64>> {
        let n = self.size();
        let columns = |of: &dyn Fn(&[f64]) -> Vec<f64>| {
            let unit = |j: usize| {
                (0..n)
                    .map(|i| f64::from(u8::from(i == j)))
                    .collect::<Vec<_>>()
            };
            let columns: Vec<Vec<f64>> = (0..n).map(|j| of(&unit(j))).collect();
            Mat::from_fn(n, n, |i, j| columns[j][i])
        };
        let lap = columns(&|x| self.lap(x));
        let mut period = lap.clone();
        (1..self.laps).for_each(|_| period = &lap * &period);
        let sectors = self.sectors.n_sectors;
        let back = (sectors - self.shift * self.laps % sectors) % sectors;
        let period = columns(&|x| self.shifted(x, back)) * period;
        period.eigenvalues().ok()
    }

    /// ζ^(−σ) of the eigenvector of a lap with these real and imaginary parts.
    #[must_use]
    pub fn turn_of_class(&self, vector: &[Vec<f64>; 2]) -> c64 {
        let sectors = self.sectors.n_sectors;
        let classes = sectors / self.laps;
        if classes == 1 {
            return c64::new(1.0, 0.0);
        }
        let [re, im] = vector;
        let [turned_re, turned_im] = [re, im].map(|x| self.shifted(x, self.laps % sectors));
        let along: c64 = (0..re.len())
            .map(|i| c64::new(re[i], -im[i]) * c64::new(turned_re[i], turned_im[i]))
            .sum();
        let class = (libm::atan2(along.im, along.re) / TAU * classes as f64).round();
        let angle = -TAU * class * self.shift as f64 / classes as f64;
        c64::new(libm::cos(angle), libm::sin(angle))
    }

    fn unpack(&self, x: &[f64]) -> Disturbance {
        let n = self.sectors.n_sectors;
        let mut rest = x;
        let mut take = |count: usize| {
            let (now, later) = rest.split_at(count);
            rest = later;
            now
        };
        let mut read = |wave: usize| -> Vec<c64> {
            let re = take(self.norms[wave].scales.len());
            match (2 * wave) % n {
                0 => re.iter().map(|re| c64::new(*re, 0.0)).collect(),
                _ => {
                    let im = take(re.len());
                    let both = re.iter().zip(im);
                    both.map(|(re, im)| c64::new(*re, *im) * FRAC_1_SQRT_2)
                        .collect()
                }
            }
        };
        let waves = 0..self.norms.len();
        let (eta, rate): (Vec<_>, Vec<_>) = waves
            .map(|wave| (self.norms[wave].coordinates(&read(wave)), read(wave)))
            .unzip();
        let active = self.sectors.active.len();
        let mut slider = vec![0.0; 2 * active * n];
        for of_sector in slider.chunks_exact_mut((2 * active).max(1)) {
            for (&(pair, d, scale), x) in self.sliders.iter().zip(take(self.sliders.len())) {
                of_sector[2 * pair + d] = x / scale;
            }
        }
        Disturbance {
            relative: self.relative(&eta),
            eta,
            rate,
            slider,
        }
    }

    /// Displacements of the active pairs of all sectors.
    fn relative(&self, eta: &[Vec<c64>]) -> Vec<f64> {
        let n = self.sectors.n_sectors;
        let waves: Vec<c64> = (0..n)
            .flat_map(|wave| match eta.get(wave) {
                Some(eta) => self.sectors.direction(wave).relative(eta),
                None => {
                    let same = self.sectors.direction(n - wave).relative(&eta[n - wave]);
                    same.iter().map(|x| x.conj()).collect()
                }
            })
            .collect();
        let sectors = self.sectors.to_sectors(&waves);
        sectors.iter().flatten().map(|x| x.re).collect()
    }

    /// The disturbance of the sectors that are `by` ahead.
    fn pack(&self, state: &Disturbance, by: usize) -> Vec<f64> {
        let n = self.sectors.n_sectors;
        let mut x = Vec::with_capacity(self.size());
        let root = (n as f64).sqrt();
        let mut write = |wave: usize, values: &[c64]| {
            let turn = self.sectors.turn(wave, by) * root;
            let turned = values.iter().map(|x| turn * x);
            match (2 * wave) % n {
                0 => x.extend(turned.map(|x| x.re)),
                _ => {
                    x.extend(turned.clone().map(|x| SQRT_2 * x.re));
                    x.extend(turned.map(|x| SQRT_2 * x.im));
                }
            }
        };
        for (wave, (eta, rate)) in state.eta.iter().zip(&state.rate).enumerate() {
            write(wave, &self.norms[wave].of(eta));
            write(wave, rate);
        }
        let active = self.sectors.active.len();
        for sector in 0..n {
            let first = 2 * active * ((sector + by) % n);
            let of = |&(pair, d, scale): &(usize, usize, f64)| {
                scale * state.slider[first + 2 * pair + d]
            };
            x.extend(self.sliders.iter().map(of));
        }
        x
    }

    /// One step; `at` are the derivatives of all active pairs.
    fn advance(&self, state: &mut Disturbance, at: &[&PairStep], factors: &Factors) {
        let (n, h) = (self.sectors.n_sectors, self.step);
        let a = c64::new(ROOT[0], ROOT[1]);
        let load: Vec<c64> = (at.iter().enumerate())
            .flat_map(|(pair, of)| {
                force(of, &state.relative[3 * pair..], &state.slider[2 * pair..])
            })
            .collect();
        let load = self.sectors.to_waves(&load);
        let mut p: Vec<Vec<c64>> = (0..n)
            .map(|wave| self.without_change(state, wave, &load[wave]))
            .collect();
        let right: Vec<c64> = (p.iter().enumerate())
            .flat_map(|(wave, p)| self.sectors.direction(wave).relative(p))
            .collect();
        let right = self.sectors.to_sectors(&right).concat();
        let rho = factors.solve(&right);
        let change: Vec<c64> = (at.iter().enumerate())
            .flat_map(|(pair, of)| pulled(of, &rho[3 * pair..]))
            .collect();
        for (wave, change) in self.sectors.to_waves(&change).iter().enumerate() {
            let moved = self.sectors.direction(wave).moved_by(change);
            (p[wave].iter_mut().zip(moved)).for_each(|(p, moved)| *p -= moved);
        }
        let factor = 4.0 * ROOT[1];
        for wave in 0..state.eta.len() {
            let (there, back) = (&p[wave], &p[(n - wave) % n]);
            for i in 0..there.len() {
                // the part of the wave in the imaginary part of the field
                let imaginary = |x: c64, y: c64| (x - y.conj()) * c64::new(0.0, -0.5);
                state.eta[wave][i] += imaginary(there[i], back[i]) * (factor * h);
                state.rate[wave][i] += imaginary(a * there[i], a * back[i]) * factor;
            }
        }
        let after: Vec<f64> = (state.relative.iter().zip(&rho))
            .map(|(r, rho)| r + factor * h * rho.im)
            .collect();
        let before = std::mem::replace(&mut state.relative, after);
        for (pair, of) in at.iter().enumerate() {
            let [old, new] = [&before[3 * pair..], &state.relative[3 * pair..]];
            let slider = &mut state.slider[2 * pair..2 * pair + 2];
            let was = [slider[0], slider[1]];
            for (d, slider) in slider.iter_mut().enumerate() {
                let mut moved = of.kept[d][0] * was[0] + of.kept[d][1] * was[1];
                for c in 0..3 {
                    moved += of.by_start[d][c] * old[c] + of.by_end[d][c] * new[c];
                }
                *slider = moved;
            }
        }
    }

    /// p₀ of a wave 0 to N − 1.
    fn without_change(&self, state: &Disturbance, wave: usize, load: &[c64]) -> Vec<c64> {
        let n = self.sectors.n_sectors;
        let s = c64::new(ROOT[0], ROOT[1]) / self.step;
        let backward = wave >= state.eta.len();
        let of = if backward { n - wave } else { wave };
        let (eta, rate) = (&state.eta[of], &state.rate[of]);
        let direction = self.sectors.direction(wave);
        let pull = self.sectors.waves[of].pull(eta, rate, s, backward);
        let moved = direction.moved(&pull);
        let loaded = direction.moved_by(load);
        let turned = |x: &c64| if backward { x.conj() } else { *x };
        (eta.iter().zip(moved).zip(loaded))
            .map(|((eta, moved), loaded)| (turned(eta) - moved + loaded) * (1.0 / self.step))
            .collect()
    }
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

/// D ρ of a pair.
fn pulled(of: &PairStep, rho: &[c64]) -> [c64; 3] {
    [0, 1, 2].map(|row| (0..3).map(|c| rho[c] * of.stiffness[row][c]).sum())
}
