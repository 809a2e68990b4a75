//! The balance equations of one problem on one harmonic set.
//!
//! The unknowns r are the relative displacements at the contacts, coefficient-major, `[n_coefficients][3·n_contacts]`. The
//! deviation g = F(r) − K_c r is the contact force minus that of contacts that stick. A solution has R = 0 with
//!
//! ```text
//! R₀ = r₀ − r₀^stuck + G₀ g₀
//! R̂ₖ = r̂ₖ − BΦ η̂ₖ = r̂ₖ − r̂ₖ^stuck + Gₖ ĝₖ,    k = 1, 2, ...
//! ```
//!
//! where r^stuck is the response of the structure with stuck contacts, and G is its compliance at the contacts
//! ([`crate::hb::structure::compliance`]). Source: Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019.

use super::layout::{Layout, PairTangent};
use super::problem::Problem;
use crate::aft::{
    AftBatch, AftForces, AftPlan, AftScratch, AftSettings, Laps, Periodicity, StateCounts,
    StateSummary, Tangent, TangentBlock, Want, evaluate,
};
use crate::contact::{Events, FrictionLaw};
use crate::harmonics::HarmonicSet;
use crate::hb::settings::HbSettings;
use crate::hb::structure::compliance::{Compliance, HarmonicCompliance};
use faer::prelude::*;
use std::cell::RefCell;

/// A problem on one harmonic set, with the time points at which its contact forces are evaluated.
#[derive(Debug)]
pub struct Balance<'p> {
    /// The problem.
    pub problem: &'p Problem<'p>,
    /// Harmonics of the unknowns.
    pub harmonics: HarmonicSet,
    /// Order of the unknowns.
    pub layout: Layout,
    plan: AftPlan<f64>,
    /// Buffers of the contact evaluation, which a study calls millions of times.
    scratch: RefCell<AftScratch<f64>>,
}

/// Contact forces at one point r.
#[derive(Debug)]
pub struct ContactResponse {
    /// F, the contact forces (N), positive in compression (normal) and along the displacement (tangential). Shape: as r.
    pub force: Vec<f64>,
    /// ∂g/∂r = ∂F/∂r − K_c of the pairs that do not stick all the time, plus the springs of [`Balance::holding_stiffness`]; empty if no
    /// derivatives were asked for.
    pub active: Vec<PairTangent>,
    /// What each pair does. Shape: `[n_pairs]`.
    pub counts: Vec<StateCounts>,
    /// Whether the motion of every slider is periodic. Always true where the study gives the number of laps.
    pub steady: bool,
}

/// Motion of the whole structure in modal coordinates η.
#[derive(Debug)]
pub struct StructureMotion {
    /// η₀. Shape: `[n]`.
    pub rest: Vec<f64>,
    /// η̂ₖ of the harmonics k ≥ 1, in the order of the set. Shape: `[n_harmonics][n]`.
    pub dynamic: Vec<Vec<c64>>,
}

/// Derivatives, along a path of points, of what acts on the structure.
#[derive(Debug, Clone, Copy)]
pub struct LoadRate<'a> {
    /// Derivative of the force deviation g (N per unit of the path). Shape: as r.
    pub deviation: &'a [f64],
    /// Derivative of the frequency (rad/s per unit of the path).
    pub omega: f64,
    /// Derivative of the excitation level.
    pub level: f64,
}

/// Stiffness of the springs that hold the mean position of a floating part during a Newton step, over the stiffness of its
/// contacts. If all contacts of a part slip over the whole period, their mean tractions do not depend on the mean position of
/// the part. Nothing else determines this position either: the static equations are singular, and a Newton step would be
/// metres long. The springs enter the derivatives only, not the residual, so that they change no solution (proximal point
/// method).
/// Source: Rockafellar 1976, SIAM J. Control Optim. 14, 877–898.
const HELD: f64 = 1e-9;

impl<'p> Balance<'p> {
    /// The balance equations of `problem` on `harmonics`, with contacts evaluated as `aft` says.
    #[must_use]
    pub fn new(problem: &'p Problem<'p>, harmonics: HarmonicSet, aft: AftSettings) -> Self {
        let layout = Layout {
            n_pairs: problem.contacts.len(),
            n_coefficients: harmonics.n_coefficients(),
        };
        let plan = AftPlan::new(&harmonics, aft);
        Self {
            problem,
            harmonics,
            layout,
            plan,
            scratch: RefCell::default(),
        }
    }

    /// The same problem on other harmonics, with the same time points.
    #[must_use]
    pub fn on(&self, harmonics: HarmonicSet) -> Self {
        Self::new(self.problem, harmonics, self.plan.settings())
    }

    /// How its contacts are evaluated.
    #[cfg(feature = "gpu")]
    pub(crate) fn plan(&self) -> &AftPlan<f64> {
        &self.plan
    }

    /// Time points per period.
    #[must_use]
    pub fn n_time(&self) -> usize {
        self.plan.settings().n_time
    }

    /// Whether start and end of slip and separation are located between the time points.
    #[must_use]
    pub fn events(&self) -> Events {
        self.plan.settings().events
    }

    /// The friction law.
    #[must_use]
    pub fn law(&self) -> FrictionLaw {
        self.plan.settings().law
    }

    /// The compliance of the stuck structure at the excitation frequency `omega` (rad/s).
    #[must_use]
    pub fn compliance(&self, omega: f64) -> Compliance<'p> {
        let problem = self.problem;
        Compliance::new(
            problem.model,
            &problem.stuck_stiffness,
            self.harmonics.orders(),
            omega,
        )
    }

    /// Contact forces at `r`, with their derivatives if `want` says so.
    #[must_use]
    pub fn contact(&self, r: &[f64], want: Want) -> ContactResponse {
        let (n_c, m) = (self.layout.n_pairs, self.layout.n_coefficients);
        let batch = AftBatch {
            n_states: n_c,
            displacement: transpose_blocks(r, m, 3, n_c),
            parameters: self.problem.contacts.clone(),
        };
        let mut forces = AftForces::default();
        let scratch = &mut *self.scratch.borrow_mut();
        evaluate(&self.plan, &batch, want, scratch, &mut forces);
        let searched = self.plan.settings().laps == Laps::Periodic;
        let lost = |s: &StateSummary| s.periodicity == Periodicity::NotPeriodic;
        ContactResponse {
            force: transpose_blocks(&forces.forces, 3, m, n_c),
            active: self.active_pairs(&forces),
            counts: (forces.summaries.iter().zip(&batch.parameters))
                .map(|(summary, pair)| match pair.k_t == [0.0; 2] {
                    true => summary.counts.without_traction(),
                    false => summary.counts,
                })
                .collect(),
            steady: !(searched && forces.summaries.iter().any(lost)),
        }
    }

    /// ∂F/∂r − K_c of the pairs that do not stick all the time, plus the springs of [`Self::holding_stiffness`].
    fn active_pairs(&self, forces: &AftForces<f64>) -> Vec<PairTangent> {
        let (n_c, m) = (self.layout.n_pairs, self.layout.n_coefficients);
        let deviation = |pair: usize, offset: usize, block: TangentBlock| {
            let (row, column) = (block.row_component(), block.column_component());
            let mut values = forces.block(offset, block).to_vec();
            if row == column {
                let k = self.problem.stuck_stiffness[row * n_c + pair];
                (0..m).for_each(|a| values[a * m + a] -= k);
                if row < 2 {
                    values[0] += self.holding_stiffness(row * n_c + pair);
                }
            }
            (row, column, values)
        };
        (forces.tangents.iter().enumerate())
            .filter_map(|(pair, tangent)| match *tangent {
                Tangent::Stuck => None,
                Tangent::Blocks(offset) => {
                    let blocks = (TangentBlock::ALL.into_iter())
                        .map(|block| deviation(pair, offset, block))
                        .filter(|(.., values)| values.iter().any(|v| *v != 0.0))
                        .collect();
                    Some(PairTangent { pair, blocks })
                }
            })
            .collect()
    }

    /// Stiffness (N/m) of the spring that the derivatives have on the mean of the tangential displacement `row`,
    /// 0 ≤ `row` < 2·n_contacts, of a pair that does not stick all the time (`HELD`).
    #[must_use]
    pub fn holding_stiffness(&self, row: usize) -> f64 {
        match self.problem.model.floats {
            true => HELD * self.problem.stuck_stiffness[row],
            false => 0.0,
        }
    }

    /// g = F − K_c r (N) for the displacements `r` (m) and the contact forces `force` (N). Shape: as r.
    #[must_use]
    pub fn deviation(&self, r: &[f64], force: &[f64]) -> Vec<f64> {
        let k_c = self.problem.stuck_stiffness.iter().cycle();
        (force.iter().zip(r).zip(k_c))
            .map(|((f, r), k)| f - k * r)
            .collect()
    }

    /// The residual R(r) (m) for the contact forces `force` = F(r) and the motion that they cause. Shape: as r.
    #[must_use]
    pub fn residual(&self, motion: &StructureMotion, r: &[f64], force: &[f64]) -> Vec<f64> {
        let n = self.layout.n_relative();
        let g = self.deviation(r, force);
        let mut out = r.to_vec();
        let rest = &self.problem.stuck_static;
        (out.iter_mut().zip(&rest.relative)).for_each(|(r, stuck)| *r -= stuck);
        for (j, g) in g[..n].iter().enumerate() {
            (out.iter_mut().zip(rest.compliance.col(j).iter())).for_each(|(r, c)| *r += c * g);
        }
        let orders = self.harmonics.orders().iter().filter(|&&k| k > 0);
        for ((i, &k), eta) in orders.enumerate().zip(&motion.dynamic) {
            let (r_c, r_s) = out[(2 * i + 1) * n..(2 * i + 3) * n].split_at_mut(n);
            let moved = self.problem.model.part(k).relative(eta);
            for ((c, s), z) in r_c.iter_mut().zip(r_s).zip(moved) {
                *c -= z.re;
                *s += z.im;
            }
        }
        out
    }

    /// ∂R/∂level at fixed r (m per unit level). Shape: as r.
    #[must_use]
    pub fn level_slope(&self, at: &Compliance<'_>) -> Vec<f64> {
        let mut out = vec![0.0; self.layout.n_unknowns()];
        if let Some(first) = at.harmonics.first() {
            self.store(0, &self.stuck_relative(first, 1.0), -1.0, &mut out);
        }
        out
    }

    /// ∂R/∂ω at fixed r (m/(rad/s)): BΦ Z_s⁻¹ (dZ/dω) η, harmonic by harmonic. Shape: as r.
    #[must_use]
    pub fn frequency_slope(&self, at: &Compliance<'_>, motion: &StructureMotion) -> Vec<f64> {
        let mut out = vec![0.0; self.layout.n_unknowns()];
        for (i, (h, eta)) in at.harmonics.iter().zip(&motion.dynamic).enumerate() {
            let load = h.part.impedance_slope(h.order, at.omega, eta);
            self.store(i, &h.part.relative(&h.solve_rate(&load)), 1.0, &mut out);
        }
        out
    }

    /// Motion of the structure under the excitation and the contact forces.
    #[must_use]
    pub fn motion(
        &self,
        at: &Compliance<'_>,
        level: f64,
        r: &[f64],
        force: &[f64],
    ) -> StructureMotion {
        let n = self.layout.n_relative();
        let rest = &self.problem.stuck_static;
        let g = self.deviation(r, force);
        let pushed = &rest.eta_per_force * Col::from_fn(n, |i| g[i]);
        let dynamic = (at.harmonics.iter().enumerate())
            .map(|(i, h)| {
                let mut load = h.part.contact_load(&self.complex(i, &g));
                load.iter_mut().for_each(|f| *f = -*f);
                if h.order == 1 {
                    (load.iter_mut().zip(&h.part.force)).for_each(|(l, f)| *l += f * level);
                }
                h.solve(&load)
            })
            .collect();
        StructureMotion {
            rest: rest
                .eta
                .iter()
                .zip(pushed.iter())
                .map(|(a, b)| a - b)
                .collect(),
            dynamic,
        }
    }

    /// Derivative of the first harmonic of the response that defines resonance (m) along the path whose derivatives are `rate`, per
    /// unit of the path.
    #[must_use]
    pub fn response_rate(
        &self,
        at: &Compliance<'_>,
        motion: &StructureMotion,
        rate: &LoadRate<'_>,
    ) -> c64 {
        let (first, eta) = (&at.harmonics[0], &motion.dynamic[0]);
        let part = first.part;
        let mut load = part.contact_load(&self.complex(0, rate.deviation));
        let inertia = part.impedance_slope(first.order, at.omega, eta);
        for ((load, inertia), force) in load.iter_mut().zip(&inertia).zip(&part.force) {
            *load = force * rate.level - *load - inertia * rate.omega;
        }
        part.responses(&first.solve_rate(&load))[self.problem.resonance_response]
    }

    /// r̂₁ (m) of the stuck structure.
    fn stuck_relative(&self, first: &HarmonicCompliance<'_>, level: f64) -> Vec<c64> {
        let load: Vec<c64> = first.part.force.iter().map(|f| f * level).collect();
        first.part.relative(&first.solve_rate(&load))
    }

    /// Complex amplitudes x̂ = x_c − i x_s of the i-th harmonic above 0, from a coefficient-major vector.
    #[must_use]
    pub fn complex(&self, i: usize, x: &[f64]) -> Vec<c64> {
        let n = self.layout.n_relative();
        let (c, s) = (
            &x[(2 * i + 1) * n..(2 * i + 2) * n],
            &x[(2 * i + 2) * n..(2 * i + 3) * n],
        );
        c.iter().zip(s).map(|(&c, &s)| c64::new(c, -s)).collect()
    }

    /// Writes `factor` times the complex amplitudes `z` as the i-th harmonic above 0 of a coefficient-major vector.
    pub(in crate::hb) fn store(&self, i: usize, z: &[c64], factor: f64, out: &mut [f64]) {
        let n = self.layout.n_relative();
        for (j, z) in z.iter().enumerate() {
            out[(2 * i + 1) * n + j] = factor * z.re;
            out[(2 * i + 2) * n + j] = -factor * z.im;
        }
    }
}

/// The balance equations of `problem` on `harmonics`, with contacts evaluated as [`evaluation_on`] says.
#[must_use]
pub fn balance_on<'p>(
    problem: &'p Problem<'p>,
    harmonics: HarmonicSet,
    settings: &HbSettings,
) -> Balance<'p> {
    let aft = evaluation_on(settings, &harmonics);
    Balance::new(problem, harmonics, aft)
}

/// How contacts are evaluated on `harmonics`: as the study says on its own, with as many time points as they need on others.
#[must_use]
pub fn evaluation_on(settings: &HbSettings, harmonics: &HarmonicSet) -> AftSettings {
    match *harmonics == settings.harmonics {
        true => settings.aft,
        false => time_points(settings.aft, harmonics),
    }
}

/// The settings `aft` with enough time points for `harmonics`: at least 12 per period of the highest harmonic, so that the error by the
/// sampling is below that by the harmonics left out, and never fewer than `aft` asks for.
#[must_use]
pub fn time_points(aft: AftSettings, harmonics: &HarmonicSet) -> AftSettings {
    let wanted = (12 * harmonics.highest()).next_power_of_two();
    AftSettings {
        n_time: aft.n_time.max(wanted),
        ..aft
    }
}

/// `[a][b][width]` → `[b][a][width]`.
fn transpose_blocks(x: &[f64], a: usize, b: usize, width: usize) -> Vec<f64> {
    let mut out = Vec::with_capacity(x.len());
    for j in 0..b {
        for i in 0..a {
            out.extend_from_slice(&x[(i * b + j) * width..(i * b + j + 1) * width]);
        }
    }
    out
}
