//! The nonlinear problem of one sample: linear model, contact parameters and static load.

use super::effort::Effort;
use crate::contact::ContactParameters;
use crate::hb::ProblemError;
use crate::hb::settings::SliderAnchor;
use crate::hb::structure::linear::{LinearModel, ModalPart};
use crate::linalg::Scalar;
use faer::linalg::solvers::Llt;
use faer::prelude::*;

/// What is solved. How it is solved stands in [`crate::hb::HbSettings`].
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
    /// Number of the response whose amplitude defines resonance: 0, but for the blades of a mistuned disk.
    pub resonance_response: usize,
    /// Work so far, and Newton iterations left to the search that runs (no bound until [`Effort::grant`]).
    pub effort: Effort,
}

/// The stuck structure at rest under the mean force deviation g₀: η₀ = `eta` − `eta_per_force` g₀ and
/// r₀ = `relative` − `compliance` g₀.
#[derive(Debug, Clone)]
pub struct StuckStatic {
    /// Modal coordinates under the static load. Shape: `[n]`.
    pub eta: Vec<f64>,
    /// Modal coordinates per contact force. Shape: n × 3·n_contacts.
    pub eta_per_force: Mat<f64>,
    /// Relative displacements under the static load (m). Shape: `[3·n_contacts]`.
    pub relative: Vec<f64>,
    /// The same where the preloads n₀ act as well and push the surfaces apart (m). Shape: `[3·n_contacts]`.
    pub preloaded: Vec<f64>,
    /// Sums of the sizes of the displacements by the load and by the preload of each pair, which may balance each other (m). Shape:
    /// `[3·n_contacts]`.
    pub balanced: Vec<f64>,
    /// G₀ (m/N). Shape: 3·n_contacts square.
    pub compliance: Mat<f64>,
    /// Largest relative displacement under the unit excitation applied statically (m).
    pub excitation_scale: f64,
}

impl<'m> Problem<'m> {
    /// The problem of one sample. Sets the anchors of `contacts` as `anchor` says.
    ///
    /// # Errors
    /// [`ProblemError::NotFinite`] if a contact parameter is no finite number;
    /// [`ProblemError::NotHeld`] if the structure with stuck contacts can still move as a rigid body in the 0th harmonic;
    /// [`ProblemError::NoLoad`] if there are contact pairs and the harmonic force moves none of them;
    /// [`ProblemError::NotHeldWithoutFriction`] and [`ProblemError::NoStaticEquilibrium`] if `anchor` asks for a static equilibrium without
    /// friction, and there is none or it is not found.
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
                let rest = frictionless_equilibrium(model, &contacts, static_load_scale)?;
                rest.into_iter().map(|[t1, t2, _]| [t1, t2]).collect()
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
            resonance_response: 0,
            effort: Effort::default(),
        })
    }

    /// Begins every slider where its contact, at rest without friction, would carry these shares of its friction limit along t1 and t2.
    /// Shape: `[n_contacts]`.
    ///
    /// # Errors
    /// [`ProblemError::NotHeldWithoutFriction`] or [`ProblemError::NoStaticEquilibrium`] if there is no such rest.
    pub fn begin_with_tractions(&mut self, shares: &[[f64; 2]]) -> Result<(), ProblemError> {
        assert_eq!(
            shares.len(),
            self.contacts.len(),
            "one pair of shares per contact pair"
        );
        let rest = frictionless_equilibrium(self.model, &self.contacts, self.static_load_scale)?;
        for ((contact, at), share) in self.contacts.iter_mut().zip(rest).zip(shares) {
            let limit = contact.mu * (contact.n_0 + contact.k_n * at[2]).max(0.0);
            let anchor = |d: usize| match contact.k_t[d] {
                k if k > 0.0 => at[d] - share[d] * limit / k,
                _ => at[d],
            };
            contact.anchor = [anchor(0), anchor(1)];
        }
        Ok(())
    }

    /// The same problem with the response of this number as the one that defines resonance, and no work yet.
    #[must_use]
    pub(crate) fn with_resonance_response(&self, number: usize) -> Self {
        Self {
            model: self.model,
            contacts: self.contacts.clone(),
            stuck_stiffness: self.stuck_stiffness.clone(),
            stuck_static: self.stuck_static.clone(),
            static_load_scale: self.static_load_scale,
            resonance_response: number,
            effort: Effort::default(),
        }
    }

    /// Displacement (m) that residuals are divided by at an excitation level. It does not depend on the unknowns: else a point
    /// with very large displacements would count as converged.
    #[must_use]
    pub(crate) fn displacement_scale(&self, level: f64) -> f64 {
        // what is left where preloads balance the load, or each other, is round-off
        let left = largest(&self.stuck_static.preloaded);
        let at_rest = left.max(ROUND_OFF * largest(&self.stuck_static.balanced));
        at_rest + level * self.stuck_static.excitation_scale
    }

    /// Smallest relative residual that round-off allows: static load and preloads may be large and balance each other.
    #[must_use]
    pub(crate) fn round_off(&self, level: f64) -> f64 {
        ROUND_OFF * largest(&self.stuck_static.balanced) / self.displacement_scale(level)
    }
}

/// Round-off of a displacement or a residual, over the displacements that balance each other.
pub(in crate::hb) const ROUND_OFF: f64 = 1e-14;

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
        let contact = &part.contact.real;
        let eta_per_force = factor.solve(contact.transpose() * Scale(part.multiplicity));
        let excitation_scale = static_excitation(model.part(1), k_c)?;
        if excitation_scale == 0.0 && model.n_contacts() > 0 {
            return Err(ProblemError::NoLoad);
        }
        let (relative, compliance) = (relative(part, &eta), contact * &eta_per_force);
        let n_t = 2 * contacts.len();
        let preload = Col::from_fn(3 * contacts.len(), |i| match i.checked_sub(n_t) {
            Some(pair) => contacts[pair].n_0.max(0.0), // an open gap transmits no force
            None => 0.0,
        });
        let pushed = &compliance * &preload;
        let pushed_by_each = |i: usize| -> f64 {
            let pairs = 0..preload.nrows();
            pairs.map(|j| (compliance[(i, j)] * preload[j]).abs()).sum()
        };
        Ok(Self {
            balanced: (relative.iter().enumerate())
                .map(|(i, r)| r.abs() + pushed_by_each(i))
                .collect(),
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
    let r = &part.contact.real * Col::from_fn(eta.len(), |i| eta[i]);
    r.iter().copied().collect()
}

/// Largest relative displacement of the stuck structure under the unit excitation applied statically (m).
fn static_excitation(part: &ModalPart, k_c: &[f64]) -> Result<f64, ProblemError> {
    let largest = |r: &mut dyn Iterator<Item = f64>| r.fold(0.0, |m: f64, r| m.max(r.abs()));
    if part.is_real() {
        let factor = static_factor(part, k_c)?;
        let force = |f: fn(&c64) -> f64| part.force.iter().map(f).collect::<Vec<f64>>();
        let parts = [force(|f| f.re), force(|f| f.im)];
        let moved = |f: &Vec<f64>| relative(part, &solve(&factor, f));
        return Ok(largest(&mut parts.iter().flat_map(moved)));
    }
    let mut stiffness = part.wave_stiffness_with_springs(k_c);
    if let Some(retention) = &part.retention {
        stiffness += retention.complex();
    }
    let eta = cholesky(&stiffness)?.solve(Col::from_fn(part.force.len(), |i| part.force[i]));
    let eta: Vec<c64> = eta.iter().copied().collect();
    let moved = part.relative(&eta).into_iter();
    Ok(largest(&mut moved.flat_map(|r| [r.re, r.im])))
}

/// Cholesky factor of Λ + retention + (BΦ)ᵀ diag(k) BΦ.
fn static_factor(part: &ModalPart, k: &[f64]) -> Result<Llt<f64>, ProblemError> {
    let mut stiffness = part.stiffness_with_springs(k);
    if let Some(retention) = &part.retention {
        stiffness += &retention.real;
    }
    cholesky(&stiffness)
}

/// Cholesky factor of a stiffness that holds the structure.
fn cholesky<E: Scalar>(stiffness: &Mat<E>) -> Result<Llt<E>, ProblemError> {
    let n = stiffness.nrows();
    let pivots = |a: MatRef<'_, E>| (0..n).map(|i| a[(i, i)].real_part()).collect::<Vec<f64>>();
    let largest = pivots(stiffness.as_ref()).into_iter().fold(0.0, f64::max);
    let factor = stiffness
        .llt(faer::Side::Lower)
        .map_err(|_| ProblemError::NotHeld)?;
    let smallest_pivot = pivots(factor.L()).into_iter().fold(f64::INFINITY, f64::min);
    if smallest_pivot * smallest_pivot <= largest * f64::EPSILON {
        return Err(ProblemError::NotHeld);
    }
    Ok(factor)
}

/// Displacements t1, t2, n (m) at rest of contacts without friction that can push but not pull, by an active-set method on the
/// closed pairs.
fn frictionless_equilibrium(
    model: &LinearModel,
    contacts: &[ContactParameters<f64>],
    load_scale: f64,
) -> Result<Vec<[f64; 3]>, ProblemError> {
    let part = model.part(0);
    let contact = &part.contact.real;
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
        let factor = static_factor(part, &k).map_err(|_| ProblemError::NotHeldWithoutFriction)?;
        let load = Col::from_fn(part.n_coordinates(), |j| load_scale * part.static_force[j]);
        let eta = factor.solve(load - contact.transpose() * preload * Scale(part.multiplicity));
        let r = contact * eta;
        let now: Vec<bool> = (contacts.iter().enumerate())
            .map(|(i, c)| c.n_0 + c.k_n * r[2 * n_c + i] > 0.0)
            .collect();
        if now == closed {
            let of_pair = |i: usize| [r[i], r[n_c + i], r[2 * n_c + i]];
            return Ok((0..n_c).map(of_pair).collect());
        }
        closed = now;
    }
    Err(ProblemError::NoStaticEquilibrium)
}
