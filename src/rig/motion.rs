//! What the contact of configuration a does: strip, box and friction in time.
//!
//! Unknowns: tangential displacement s of the strip's contact zone, and displacements b and c of the box along its transducers.
//! The platform moves by p(t), which is given or that of a blade under a force and the traction (`platform`); every contact pair sees
//! the same u = p − s, with its own stiffness and Coulomb limit:
//!
//! m s̈ = Σ T_i(u) − k (s − b) − d (ṡ − ḃ),   M b̈ = k (s − b) + d (ṡ − ḃ) − K11 b − K12 c − …,   M c̈ = N − K12 b − K22 c − …
//!
//! The mass m is that of the strip's moving half and of the punch; so inertia below and around resonances of the rig is in the
//! measured force. The contact zone of the strip is rigid and stays parallel to the platform: it has no rocking and no
//! shear lag, and the normal load of a pair is the load of the map times the regulator's fluctuation.
//!
//! Method: second-order backward differences (Gear 1971) at equal steps, the contact forces implicit. The method damps what a
//! step does not resolve (the strip's mode above 100 kHz), and is of second order for what it does. Harmonic balance would give the steady
//! state at less cost, but no run-in and no load that fluctuates. Each step is one monotone equation in u, since the linear part has three unknowns.

use super::blade::Blade;
use super::excitation::Excitation;
use super::loading::{LoadMap, Loading};
use super::noise::Noise;
use super::platform::Platform;
use super::settings::StripSettings;
use super::support::SupportSettings;
use crate::contact::law::box_step;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Fewest steps of a cycle.
const STEPS_PER_CYCLE: usize = 1000;
/// Most iterations of a step; Newton's method takes two or three.
const MOST_ITERATIONS: usize = 100;
/// Error of u in a step over the amplitude of the platform, or over what it is under a force.
const TOLERANCE: f64 = 1e-13;

/// Contact pairs that see one displacement.
#[derive(Debug, Clone)]
pub struct Interface {
    /// Tangential stiffness of each pair (N/m).
    stiffness: Vec<f64>,
    /// Coulomb limit of each pair at the mean load (N).
    limit: Vec<f64>,
    /// k_t w of each pair's slider (N).
    slider: Vec<f64>,
}

impl Interface {
    /// The stiffness `k_t` (N/m) is shared by area, and no pair has moved.
    #[must_use]
    pub fn new(map: &LoadMap, k_t: f64, mu: f64) -> Self {
        let area: f64 = map.cells.iter().map(|cell| cell.area).sum();
        Self {
            stiffness: (map.cells.iter()).map(|c| k_t * c.area / area).collect(),
            limit: map.loads.iter().map(|load| mu * load).collect(),
            slider: vec![0.0; map.loads.len()],
        }
    }

    /// Traction (N) and its slope (N/m) at the displacement `u`, with the loads times `factor`; sliders stay.
    fn traction(&self, u: f64, factor: f64) -> (f64, f64) {
        let pairs = self.stiffness.iter().zip(&self.limit).zip(&self.slider);
        pairs.fold((0.0, 0.0), |(sum, slope), ((&k, &limit), &slider)| {
            let limit = factor * limit;
            let (traction, _) = box_step(limit, k * u, slider);
            let sticks = (k * u - slider).abs() < limit;
            (sum + traction, if sticks { slope + k } else { slope })
        })
    }

    /// Moves the sliders to where `u` leaves them. The traction (N).
    fn advance(&mut self, u: f64, factor: f64) -> f64 {
        let pairs = self.stiffness.iter().zip(&self.limit);
        let pairs = pairs.zip(&mut self.slider);
        pairs.fold(0.0, |sum, ((&k, &limit), slider)| {
            let (traction, moved) = box_step(factor * limit, k * u, *slider);
            *slider = moved;
            sum + traction
        })
    }

    /// Coulomb limit of all pairs at the mean load (N).
    fn whole_limit(&self) -> f64 {
        self.limit.iter().sum()
    }

    /// Stiffness of all pairs (N/m).
    fn whole_stiffness(&self) -> f64 {
        self.stiffness.iter().sum()
    }
}

/// Structure between platform and ground.
#[derive(Debug, Clone)]
pub struct Structure {
    mass: Matrix3<f64>,
    damping: Matrix3<f64>,
    stiffness: Matrix3<f64>,
    /// K11 and K22 (N/m), and the damping of the support over its stiffness (s).
    transducers: [f64; 2],
    damping_time: f64,
}

impl Structure {
    /// Strip, loading and support.
    #[must_use]
    pub fn new(strip: &StripSettings, loading: &Loading, support: &SupportSettings) -> Self {
        let (added_mass, added_stiffness) = loading.added();
        let k = strip.axial_stiffness() + added_stiffness;
        let d = k * strip.loss_at_1_khz / (1e3 * TAU);
        let [k11, k22, k12] = support.stiffness();
        let time = support.damping_time();
        let m = support.box_mass_kg;
        let spring = Matrix3::new(1.0, -1.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0);
        let held = Matrix3::new(0.0, 0.0, 0.0, 0.0, k11, k12, 0.0, k12, k22);
        Self {
            mass: Matrix3::from_diagonal(&Vector3::new(strip.moving_mass() + added_mass, m, m)),
            damping: spring * d + held * time,
            stiffness: spring * k + held,
            transducers: [k11, k22],
            damping_time: time,
        }
    }

    /// Mass, diagonal, and stiffness of strip and box along both cells.
    pub(super) fn matrices(&self) -> (&Matrix3<f64>, &Matrix3<f64>) {
        (&self.mass, &self.stiffness)
    }
}

/// True signals of a test and what the transducers feel. Shape of each: `[samples]`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    /// Time from the start of the record (s).
    pub time: Vec<f64>,
    /// p: platform (m).
    pub platform: Vec<f64>,
    /// u: platform less strip (m).
    pub displacement: Vec<f64>,
    /// Contact force T (N).
    pub tangential: Vec<f64>,
    /// Contact force N (N).
    pub normal: Vec<f64>,
    /// Forces of the transducers [T, N] (N), before decoupling and gains.
    pub felt: Vec<[f64; 2]>,
    /// Largest |T| over the Coulomb limit of the whole interface, against and along the displacement: 1 is gross slip.
    pub mobilised: [f64; 2],
}

/// The displacements of the last two steps, for backward differences.
struct History {
    q: [Vector3<f64>; 2],
    v: [Vector3<f64>; 2],
}

/// Effective linear equations of a step: q = A⁻¹ (r + e T).
struct Step<'a> {
    structure: &'a Structure,
    inverse: Matrix3<f64>,
    h: f64,
}

impl<'a> Step<'a> {
    /// `None` if the matrix is singular, which no settings that were checked give.
    fn new(structure: &'a Structure, h: f64) -> Option<Self> {
        let rate = 1.5 / h;
        let a = structure.mass * (rate * rate) + structure.damping * rate + structure.stiffness;
        Some(Self {
            structure,
            inverse: a.try_inverse()?,
            h,
        })
    }

    /// Displacements without traction, under the normal load `n` (N).
    fn without_traction(&self, history: &History, n: f64) -> Vector3<f64> {
        let [vh, ah] = [&history.q, &history.v].map(|[last, before]| self.behind(last, before));
        let structure = self.structure;
        let inertia = structure.mass * (vh * (1.5 / self.h) + ah);
        self.inverse * (inertia + structure.damping * vh + Vector3::new(0.0, 0.0, n))
    }

    /// Part of the backward difference that is known: (4 x₋₁ − x₋₂)/2h.
    fn behind(&self, last: &Vector3<f64>, before: &Vector3<f64>) -> Vector3<f64> {
        (last * 4.0 - before) / (2.0 * self.h)
    }
}

/// A test from rest.
pub struct March<'a> {
    /// Strip, loading and support.
    pub structure: &'a Structure,
    /// Step-sine of platform or force.
    pub excitation: &'a Excitation,
    /// What carries the platform; absent, the platform moves as the excitation says.
    pub blade: Option<&'a Blade>,
    /// Standard deviation of the load over its mean and its time constant (s).
    pub fluctuation: Option<(f64, f64)>,
    /// Normal load (N).
    pub load: f64,
}

impl March<'_> {
    /// Signals at the samples of the record.
    #[must_use]
    pub fn run(&self, mut interface: Interface, frequency_hz: f64, noise: &mut Noise) -> Motion {
        let excitation = self.excitation;
        let per_sample =
            (self.least_steps(&interface, frequency_hz)).div_ceil(excitation.samples_per_cycle);
        let per_cycle = per_sample * excitation.samples_per_cycle;
        let h = 1.0 / (frequency_hz * per_cycle as f64);
        let mut motion = Motion::default();
        let Some(step) = Step::new(self.structure, h) else {
            return motion;
        };
        let at_rest = self.at_rest();
        let zero = Vector3::zeros();
        let mut history = History {
            q: [at_rest; 2],
            v: [zero; 2],
        };
        let settling = self.blade.map_or(0, |blade| blade.settling_cycles);
        let begin = (excitation.run_in_cycles + settling) * per_cycle;
        let end = begin + excitation.cycles * per_cycle;
        let mut platform = Platform::at_rest(excitation, self.blade, frequency_hz, h);
        let (mut load, mut u) = (Fluctuation::new(self.fluctuation, h), 0.0);
        for k in 1..end {
            let factor = load.next(noise);
            let p = platform.without_traction(k as f64 * h);
            let free = step.without_traction(&history, factor * self.load);
            let flexibility = step.inverse[(0, 0)] + platform.flexibility();
            let given = [p - free[0], flexibility, platform.scale(p)];
            u = displacement(&interface, factor, given, u);
            let traction = interface.advance(u, factor);
            platform.add_traction(traction);
            let q = free + step.inverse.column(0) * traction;
            let v = q * (1.5 / h) - step.behind(&history.q[0], &history.q[1]);
            history.q = [q, history.q[0]];
            history.v = [v, history.v[0]];
            if k < begin {
                continue;
            }
            let share = traction / (factor * interface.whole_limit());
            motion.mobilised[0] = motion.mobilised[0].max(-share);
            motion.mobilised[1] = motion.mobilised[1].max(share);
            if (k - begin).is_multiple_of(per_sample) {
                motion.time.push((k - begin) as f64 * h);
                motion.platform.push(p - platform.flexibility() * traction);
                motion.displacement.push(u);
                motion.tangential.push(traction);
                motion.normal.push(factor * self.load);
                motion.felt.push(self.felt(&q, &v));
            }
        }
        motion
    }

    /// Displacements under the normal load alone.
    fn at_rest(&self) -> Vector3<f64> {
        let load = Vector3::new(0.0, 0.0, self.load);
        let inverse = self.structure.stiffness.try_inverse();
        inverse.map_or_else(Vector3::zeros, |inverse| inverse * load)
    }

    /// Forces of the transducers.
    fn felt(&self, q: &Vector3<f64>, v: &Vector3<f64>) -> [f64; 2] {
        let structure = self.structure;
        [0, 1].map(|i| structure.transducers[i] * (q[1 + i] + structure.damping_time * v[1 + i]))
    }

    fn least_steps(&self, interface: &Interface, frequency_hz: f64) -> usize {
        let of_blade = |blade: &Blade| blade.least_steps(frequency_hz, interface.whole_stiffness());
        self.blade.map_or(0, of_blade).max(STEPS_PER_CYCLE)
    }
}

/// u with u + G T(u) = d: by Newton's method from the last u, kept between bounds, since u + G T(u) grows with u. `scale` is the
/// displacement that a tolerance is of.
fn displacement(
    interface: &Interface,
    factor: f64,
    [d, flexibility, scale]: [f64; 3],
    start: f64,
) -> f64 {
    let reach = flexibility * factor * interface.whole_limit();
    let (mut low, mut high) = (d - reach, d + reach);
    let mut u = start.clamp(low, high);
    let tolerance = TOLERANCE * scale;
    for _ in 0..MOST_ITERATIONS {
        let (traction, slope) = interface.traction(u, factor);
        let residual = u + flexibility * traction - d;
        if residual > 0.0 {
            high = u;
        } else {
            low = u;
        }
        if residual.abs() <= tolerance {
            break;
        }
        let newton = u - residual / (1.0 + flexibility * slope);
        u = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
    }
    u
}

/// Load over its mean: 1, and what the regulator adds, as a first-order autoregressive process.
struct Fluctuation {
    deviation: f64,
    keep: f64,
    fresh: f64,
}

impl Fluctuation {
    fn new(settings: Option<(f64, f64)>, h: f64) -> Self {
        let (sigma, time) = settings.unwrap_or((0.0, 1.0));
        let keep = libm::exp(-h / time);
        Self {
            deviation: 0.0,
            keep,
            fresh: sigma * (1.0 - keep * keep).sqrt(),
        }
    }

    fn next(&mut self, noise: &mut Noise) -> f64 {
        if self.fresh > 0.0 {
            self.deviation = self.keep * self.deviation + self.fresh * noise.normal();
        }
        // no load that pulls
        (1.0 + self.deviation).max(0.0)
    }
}
