//! The nonlinear problem of one sample: a linear model, contact parameters and the static load.

use super::effort::Effort;
use crate::aft::Backend;
use crate::contact::ContactParameters;
use crate::hb::ProblemError;
use crate::hb::settings::SliderAnchor;
use crate::hb::structure::linear::{LinearModel, ModalPart};
use faer::linalg::solvers::Llt;
use faer::prelude::*;

/// What is solved, without any choice of how: see [`crate::hb::HbSettings`] for that.
#[derive(Debug)]
pub struct Problem<'m> {
    /// Linear part.
    pub model: &'m LinearModel,
    /// Contact parameters, anchors included. Shape: `[n_contacts]`.
    pub contacts: Vec<ContactParameters<f64>>,
    /// Diagonal of K_c, stiffness of the stuck contacts (N/m). Shape: `[3·n_contacts]`, t1 of every pair, t2, n.
    pub stuck_stiffness: Vec<f64>,
    /// Static (0th harmonic) solution of the stuck structure.
    pub stuck_static: StuckStatic,
    /// Factor on the static force f₀.
    pub static_load_scale: f64,
    /// Who evaluates the contacts: the processor, unless it is set otherwise.
    pub backend: Backend<'m>,
    /// Work so far, and Newton iterations left to the search that runs; unbounded until some are granted.
    pub effort: Effort,
}

/// Stuck structure at rest: η₀ = `eta` − `eta_per_force` g₀, r₀ = `relative` − `compliance` g₀.
#[derive(Debug)]
pub struct StuckStatic {
    /// Modal coordinates under the static load. Shape: `[n]`.
    pub eta: Vec<f64>,
    /// Modal coordinates per contact force. Shape: n × 3·n_contacts.
    pub eta_per_force: Mat<f64>,
    /// Relative displacements under the static load (m). Shape: `[3·n_contacts]`.
    pub relative: Vec<f64>,
    /// The same while the preloads n₀ push the surfaces apart, too (m). Shape: `[3·n_contacts]`.
    pub preloaded: Vec<f64>,
    /// G₀ (m/N). Shape: 3·n_contacts square.
    pub compliance: Mat<f64>,
    /// Largest relative displacement under the unit excitation applied statically (m).
    pub excitation_scale: f64,
}

impl<'m> Problem<'m> {
    /// Sets the sample up; the anchors of `contacts` are set here by the policy.
    ///
    /// # Errors
    /// [`ProblemError::NotFinite`] if a contact parameter is no finite number;
    /// [`ProblemError::NotHeld`] if the stuck structure has a rigid-body motion left in the 0th harmonic;
    /// [`ProblemError::NoLoad`] if neither static nor harmonic force moves a contact or the structure.
    pub fn new(
        model: &'m LinearModel,
        mut contacts: Vec<ContactParameters<f64>>,
        static_load_scale: f64,
        anchor: SliderAnchor,
    ) -> Result<Self, ProblemError> {
        assert_eq!(
            contacts.len(),
            model.n_contacts(),
            "one parameter set per contact pair"
        );
        let finite = |c: &ContactParameters<f64>| {
            [c.k_n, c.k_t[0], c.k_t[1], c.mu, c.n_0]
                .iter()
                .all(|x| x.is_finite())
        };
        if let Some(pair) = contacts.iter().position(|c| !finite(c)) {
            return Err(ProblemError::NotFinite { pair });
        }
        let anchors = match anchor {
            SliderAnchor::Unloaded => vec![[0.0; 2]; contacts.len()],
            SliderAnchor::StaticEquilibrium => {
                frictionless_equilibrium(model, &contacts, static_load_scale)?
            }
        };
        for (contact, anchor) in contacts.iter_mut().zip(anchors) {
            contact.anchor = anchor;
        }
        let stuck_stiffness = stuck_stiffness(&contacts);
        let stuck_static = StuckStatic::new(model, &contacts, &stuck_stiffness, static_load_scale)?;
        Ok(Self {
            model,
            contacts,
            stuck_stiffness,
            stuck_static,
            static_load_scale,
            backend: Backend::Cpu,
            effort: Effort::default(),
        })
    }

    /// Fixed scale of the residual at an excitation level (m): it must not grow with the iterate, or a strip
    /// that flies off would pass for converged.
    #[must_use]
    pub fn displacement_scale(&self, level: f64) -> f64 {
        largest(&self.stuck_static.preloaded) + level * self.stuck_static.excitation_scale
    }

    /// Residual over that scale that round-off of the static load leaves, which preloads may balance.
    #[must_use]
    pub fn round_off(&self, level: f64) -> f64 {
        ROUND_OFF * largest(&self.stuck_static.relative) / self.displacement_scale(level)
    }
}

/// Residual over the displacement by the static load that is round-off.
const ROUND_OFF: f64 = 1e-14;

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Stiffness of the stuck contacts (N/m). Shape: `[3·n_contacts]`, t1 of every pair, t2, n.
#[must_use]
pub fn stuck_stiffness(contacts: &[ContactParameters<f64>]) -> Vec<f64> {
    (contacts.iter().map(|c| c.k_t[0]))
        .chain(contacts.iter().map(|c| c.k_t[1]))
        .chain(contacts.iter().map(|c| c.k_n))
        .collect()
}

impl StuckStatic {
    fn new(
        model: &LinearModel,
        contacts: &[ContactParameters<f64>],
        k_c: &[f64],
        load_scale: f64,
    ) -> Result<Self, ProblemError> {
        let part = model.part(0);
        let factor = static_factor(part, k_c)?;
        let eta: Vec<f64> = solve(&factor, &part.static_force)
            .iter()
            .map(|x| x * load_scale)
            .collect();
        let eta_per_force = factor.solve(part.contact.transpose() * Scale(part.multiplicity));
        let excited = model.part(1);
        let factor = static_factor(excited, k_c)?;
        let force = |f: fn(&c64) -> f64| excited.force.iter().map(f).collect::<Vec<f64>>();
        let excitation_scale = [force(|f| f.re), force(|f| f.im)]
            .iter()
            .flat_map(|f| relative(excited, &solve(&factor, f)))
            .fold(0.0, |m: f64, r| m.max(r.abs()));
        if excitation_scale == 0.0 && model.n_contacts() > 0 {
            return Err(ProblemError::NoLoad);
        }
        let (relative, compliance) = (relative(part, &eta), &part.contact * &eta_per_force);
        let n_t = 2 * contacts.len();
        let preload = Col::from_fn(3 * contacts.len(), |i| match i.checked_sub(n_t) {
            Some(pair) => contacts[pair].n_0.max(0.0), // a gap pulls nothing
            None => 0.0,
        });
        let pushed = &compliance * preload;
        Ok(Self {
            preloaded: (relative.iter().zip(pushed.iter()))
                .map(|(r, p)| r - p)
                .collect(),
            relative,
            compliance,
            eta,
            eta_per_force,
            excitation_scale,
        })
    }
}

fn solve(factor: &Llt<f64>, f: &[f64]) -> Vec<f64> {
    let eta = factor.solve(Col::from_fn(f.len(), |i| f[i]));
    eta.iter().copied().collect()
}

fn relative(part: &ModalPart, eta: &[f64]) -> Vec<f64> {
    let r = &part.contact * Col::from_fn(eta.len(), |i| eta[i]);
    r.iter().copied().collect()
}

/// Cholesky factor of Λ + retention + (BΦ)ᵀ diag(k) BΦ.
fn static_factor(part: &ModalPart, k: &[f64]) -> Result<Llt<f64>, ProblemError> {
    let mut stiffness = part.stiffness_with_springs(k);
    let n = stiffness.nrows();
    if let Some(retention) = &part.retention {
        stiffness += retention;
    }
    let largest = (0..n).map(|i| stiffness[(i, i)]).fold(0.0, f64::max);
    let factor = stiffness
        .llt(faer::Side::Lower)
        .map_err(|_| ProblemError::NotHeld)?;
    let smallest_pivot = (0..n)
        .map(|i| factor.L()[(i, i)])
        .fold(f64::INFINITY, f64::min);
    if smallest_pivot * smallest_pivot <= largest * f64::EPSILON {
        return Err(ProblemError::NotHeld);
    }
    Ok(factor)
}

/// Tangential displacements at rest when the contacts only push: active set on the closed pairs.
fn frictionless_equilibrium(
    model: &LinearModel,
    contacts: &[ContactParameters<f64>],
    load_scale: f64,
) -> Result<Vec<[f64; 2]>, ProblemError> {
    let part = model.part(0);
    let n_c = contacts.len();
    let mut closed = vec![true; n_c];
    let limit = 2 * n_c + 10;
    for _ in 0..limit {
        let mut k = vec![0.0; 3 * n_c];
        let mut preload = Col::<f64>::zeros(3 * n_c);
        for (i, c) in contacts.iter().enumerate().filter(|(i, _)| closed[*i]) {
            k[2 * n_c + i] = c.k_n;
            preload[2 * n_c + i] = c.n_0;
        }
        let factor = static_factor(part, &k)?;
        let load = Col::from_fn(part.n_coordinates(), |j| load_scale * part.static_force[j]);
        let eta =
            factor.solve(load - part.contact.transpose() * preload * Scale(part.multiplicity));
        let r = &part.contact * eta;
        let now: Vec<bool> = (contacts.iter().enumerate())
            .map(|(i, c)| c.n_0 + c.k_n * r[2 * n_c + i] > 0.0)
            .collect();
        if now == closed {
            return Ok((0..n_c).map(|i| [r[i], r[n_c + i]]).collect());
        }
        closed = now;
    }
    Err(ProblemError::NoStaticEquilibrium)
}
