//! A predicted peak, with the inverse Jacobian of a peak of another sample as preconditioner: nothing is factorised.
//!
//! The method and its rules are those of [`super::predicted`]; the equations are those in free modes
//! ([`crate::hb::equations::free`]). Newton's correction and the tangent of the branch are solved for together, in single
//! precision with residuals in double precision. The directions of one iteration precondition the next one, and the tangent of
//! one starts that of the next. What must be small is P R, with P the inverse of the anchor, and not R: P R is
//! about the error of the displacements. Where contacts are stiff against a light mode R is larger than this error by the ratio of both
//! stiffnesses.
//!
//! A peak found like this is evaluated once more as all others are, and must have a residual within the tolerance.

use super::growth::{Growth, Limits, MAX_ITERATIONS, PeakSearch};
use super::predicted::{CORRECTIONS, MEASURING_STEP, PeakPrediction, limits};
use super::search::{HIGHER, Located, PeakSettings, highest_beside};
use crate::aft::Want;
use crate::hb::equations::balance::{Balance, ContactResponse};
use crate::hb::equations::free::{FreeBalance, FreeMotion, StaticReference};
use crate::hb::equations::inverse::InverseJacobian;
use crate::hb::equations::single_free::{SingleJacobian, SingleModes};
use crate::hb::newton::{Iterate, Point};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use crate::linalg::recycled::{RecycledSpace, norm};
use crate::linalg::single::{round, rounded};
use crate::linalg::vector::{self, axpy};
use faer::prelude::c64;

/// Tolerance of a linear solve over the size of the residual: Newton's method leaves about its square.
const FORCING: f64 = 0.1;
/// Largest and smallest tolerance of a tangent.
const TANGENT: [f64; 2] = [1e-2, 1e-10];
/// Smallest tolerance of a correction: the next iteration corrects what it leaves.
const CORRECTION: f64 = 1e-3;
/// Relative residual that one solve in single precision reaches at the best.
const SINGLE: f64 = 1e-5;
/// Most solves with a refined residual for one correction and tangent.
const MOST_REFINEMENTS: usize = 4;
/// Most rounds of products of one solve: 3 to 15 are needed where the inverse is one close by.
const MOST_ROUNDS: usize = 40;
/// Size of the residual that the search asks for, over the tolerance of the residual that is checked at the end.
const CLOSER: f64 = 0.3;
/// Size of a residual whose solves are exact enough to measure a sharpness.
const MEASURING_SIZE: f64 = 1e-3;
/// A solve ends at this multiple of the residual asked for.
const ENOUGH: f64 = 2.0;

/// Phase (rad) on both sides of a flat maximum where searches for a higher one start.
const BESIDE: f64 = 0.05;

/// What helps to find the peaks of samples close to one that is solved.
#[derive(Debug, Clone, Copy)]
pub struct AnchorInverse<'a> {
    /// What holds harmonic 0 for all samples.
    pub reference: &'a StaticReference,
    /// The inverse Jacobian at the peak of the solved sample.
    pub inverse: &'a InverseJacobian,
}

impl AnchorInverse<'_> {
    /// The inverse Jacobian of `balance` at `point`; none where the equations have no free form.
    #[must_use]
    pub fn inverse_at(
        reference: &StaticReference,
        balance: &Balance<'_>,
        point: &Point,
    ) -> Option<InverseJacobian> {
        let free = FreeBalance::new(balance, reference)?;
        let contact = balance.contact(&point.r, Want::ForcesAndTangents);
        let motion = free.motion(point.omega, point.level, &contact.force);
        InverseJacobian::new(&free, &contact, &motion)
    }
}

/// The maximum of |ŷ| next to `prediction`, preconditioned by `anchor`; the highest one where another lies beside it, as
/// `search::highest_beside` says.
///
/// # Errors
/// The statuses of [`super::predicted::correct`]; [`Status::MaxIterations`], too, if the inverse is of no use for this sample or its
/// equations have no free form.
pub fn anchored<'p>(
    balance: &Balance<'p>,
    anchor: AnchorInverse<'_>,
    prediction: PeakPrediction,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    if anchor.inverse.size() != balance.layout.n_unknowns() {
        return Err(Status::MaxIterations);
    }
    let free = FreeBalance::new(balance, anchor.reference).ok_or(Status::MaxIterations)?;
    let modes = SingleModes::new(&free);
    let limits = limits(balance, &prediction.point, settings, newton);
    let search = AnchoredSearch {
        free: &free,
        modes: &modes,
        inverse: anchor.inverse,
        limits,
        settings,
    };
    let (point, sharpness) = search.from(prediction)?;
    let found = confirmed(balance, point, sharpness, limits)?;
    if !found.is_flat() {
        return Ok(found);
    }
    match search.higher_beside(&found) {
        Ok(None) => Ok(found),
        Ok(Some((point, sharpness))) => confirmed(balance, point, sharpness, limits),
        Err(_) => Ok(highest_beside(balance, found, settings, newton)),
    }
}

/// Where the iterations for one sample take what they need.
struct AnchoredSearch<'a> {
    free: &'a FreeBalance<'a>,
    modes: &'a SingleModes,
    inverse: &'a InverseJacobian,
    limits: Limits,
    settings: PeakSettings,
}

impl<'a> AnchoredSearch<'a> {
    /// The maximum next to `prediction`, and its sharpness.
    fn from(&self, prediction: PeakPrediction) -> Result<(Point, Option<f64>), Status> {
        let limits = Limits {
            tolerance: CLOSER * self.limits.tolerance,
            ..self.limits
        };
        let effort = &self.free.balance.problem.effort;
        let mut search = PeakSearch::new(limits, prediction.phasor, prediction.sharpness);
        let (mut point, mut last) = (prediction.point, None);
        let mut solver = PreconditionedSolver::new(self.inverse, point.r.len());
        for _ in 0..MAX_ITERATIONS {
            let iterate = FreeIterate::new(self.free, point);
            let size = iterate.size(self.inverse);
            if search.ends(size, iterate.contact.steady)? {
                let falls = |last| solver.falls_further_on(&iterate, self.modes, last);
                return match search.has_measured_maximum() || last.is_some_and(falls) {
                    true => Ok((iterate.point, search.sharpness())),
                    false => Err(Status::MaxIterations),
                };
            }
            if effort.is_spent() {
                return Err(Status::BudgetSpent);
            }
            effort.spend(0);
            let jacobian =
                SingleJacobian::new(self.free, self.modes, &iterate.contact, &iterate.motion);
            let correction = solver.solve(&iterate, &jacobian, size / limits.share);
            let correction = correction.ok_or(Status::MaxIterations)?;
            let here = iterate.growth(&correction, &solver.tangent, limits.growth_error(size));
            let step = search.step(size, here)?;
            let omega_step = step.length / here.phase_rate;
            if step.by_growth {
                last = Some(here);
            }
            point = iterate.point;
            axpy(1.0, &correction, &mut point.r);
            axpy(omega_step, &solver.tangent, &mut point.r);
            point.omega += omega_step;
            if !self.settings.band.contains(point.omega) {
                return Err(Status::NoPeakInBand);
            }
        }
        Err(Status::MaxIterations)
    }

    /// A higher maximum beside the flat one `found`, searched from both sides, and its sharpness.
    ///
    /// # Errors
    /// Why one of the searches failed.
    fn higher_beside(&self, found: &Located<'_>) -> Result<Option<(Point, Option<f64>)>, Status> {
        let iterate = FreeIterate::new(self.free, found.iterate.point.clone());
        let mut solver = PreconditionedSolver::new(self.inverse, iterate.point.r.len());
        let jacobian =
            SingleJacobian::new(self.free, self.modes, &iterate.contact, &iterate.motion);
        let correction = solver.solve(&iterate, &jacobian, MEASURING_SIZE);
        let correction = correction.ok_or(Status::MaxIterations)?;
        let here = iterate.growth(&correction, &solver.tangent, 0.0);
        let mut highest = (iterate.height(), None);
        for phase in [-BESIDE, BESIDE] {
            let mut point = iterate.point.clone();
            let omega_step = phase / here.phase_rate;
            axpy(omega_step, &solver.tangent, &mut point.r);
            point.omega += omega_step;
            // climbs from where it starts, whatever the branch is known to do at the maximum
            let start = PeakPrediction::new(point, here.response * c64::cis(phase), None);
            let (point, sharpness) = self.from(start)?;
            let other = FreeIterate::new(self.free, point);
            if other.height() > (1.0 + HIGHER) * highest.0 {
                highest = (other.height(), Some((other.point, sharpness)));
            }
        }
        Ok(highest.1)
    }
}

/// The peak at `point`, if its residual is within the tolerance. A small excitation asks for more digits than both forms of the static
/// equations have in common: then the residual is taken off once, which solves them where contacts stick.
fn confirmed<'p>(
    balance: &Balance<'p>,
    point: Point,
    sharpness: Option<f64>,
    limits: Limits,
) -> Result<Located<'p>, Status> {
    let is_solved = |at: &Iterate<'_>| at.relative_residual(balance) <= limits.tolerance;
    let mut iterate = Iterate::new(balance, point);
    if !is_solved(&iterate) {
        let mut point = iterate.point;
        axpy(-1.0, &iterate.residual, &mut point.r);
        iterate = Iterate::new(balance, point);
    }
    match is_solved(&iterate) {
        true => Ok(Located { iterate, sharpness }),
        false => Err(Status::MaxIterations),
    }
}

/// The free form of the equations evaluated at one point.
struct FreeIterate<'a> {
    free: &'a FreeBalance<'a>,
    point: Point,
    contact: ContactResponse,
    motion: FreeMotion,
    residual: Vec<f64>,
}

impl<'a> FreeIterate<'a> {
    fn new(free: &'a FreeBalance<'a>, point: Point) -> Self {
        let want = Want::ForcesAndTangents;
        let contact = free.balance.contact(&point.r, want);
        let motion = free.motion(point.omega, point.level, &contact.force);
        let residual = free.residual(&motion, &point.r, &contact.force);
        Self {
            free,
            point,
            contact,
            motion,
            residual,
        }
    }

    /// Largest component of P R over the displacement scale of the problem.
    fn size(&self, inverse: &InverseJacobian) -> f64 {
        let (whole, b) = scaled(&self.residual);
        let preconditioned = inverse.times(&[b]);
        let largest = (preconditioned.iter().flatten()).fold(0.0, |m: f32, x| {
            if x.is_nan() { *x } else { m.max(x.abs()) }
        });
        let scale = self
            .free
            .balance
            .problem
            .displacement_scale(self.point.level);
        f64::from(largest) * whole / scale
    }

    /// |ŷ| (m).
    fn height(&self) -> f64 {
        self.free.response(&self.motion).norm()
    }

    /// J x.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        let rate = self.free.contact_rate(&self.contact, x);
        self.free.product(&self.motion, x, &rate)
    }

    /// What the branch through this point tells, after the `correction` at its frequency, along its `tangent`.
    fn growth(&self, correction: &[f64], tangent: &[f64], error: f64) -> Growth {
        let along = |x: &[f64], omega: f64| {
            let rate = self.free.contact_rate(&self.contact, x);
            self.free.response_rate(&self.motion, &rate, omega)
        };
        let response = self.free.response(&self.motion) + along(correction, 0.0);
        Growth::new(self.point.omega, response, along(tangent, 1.0), error)
    }
}

/// Solves for corrections and tangents, iteration by iteration.
struct PreconditionedSolver<'a> {
    inverse: &'a InverseJacobian,
    space: RecycledSpace,
    /// dr/dω of the last iterate.
    tangent: Vec<f64>,
}

impl<'a> PreconditionedSolver<'a> {
    fn new(inverse: &'a InverseJacobian, size: usize) -> Self {
        Self {
            inverse,
            space: RecycledSpace::default(),
            tangent: vec![0.0; size],
        }
    }

    /// Whether the growth falls from `here`, the branch at the peak `iterate`, to a point a little further along the branch.
    fn falls_further_on(
        &mut self,
        iterate: &FreeIterate<'_>,
        modes: &SingleModes,
        here: Growth,
    ) -> bool {
        let mut point = iterate.point.clone();
        let omega_step = MEASURING_STEP / here.phase_rate.abs();
        axpy(omega_step, &self.tangent, &mut point.r);
        point.omega += omega_step;
        for _ in 0..CORRECTIONS {
            let further = FreeIterate::new(iterate.free, point);
            let jacobian =
                SingleJacobian::new(iterate.free, modes, &further.contact, &further.motion);
            let Some(correction) = self.solve(&further, &jacobian, MEASURING_SIZE) else {
                return false;
            };
            if here.falls_to(&further.growth(&correction, &self.tangent, 0.0)) {
                return true;
            }
            point = further.point;
            axpy(1.0, &correction, &mut point.r);
        }
        false
    }

    /// The correction −J⁻¹ R at `iterate`; sets the tangent to −J⁻¹ ∂R/∂ω. `size` is the residual P R over the dynamic displacement, and
    /// decides how exactly both are solved for. None if a solve does not converge.
    fn solve(
        &mut self,
        iterate: &FreeIterate<'_>,
        jacobian: &SingleJacobian<'_>,
        size: f64,
    ) -> Option<Vec<f64>> {
        let Self {
            inverse,
            space,
            tangent,
        } = self;
        space.next_system();
        let product = |x: &[Vec<f32>]| inverse.times(&jacobian.products(x));
        let mut slope = iterate.free.frequency_slope(&iterate.motion);
        axpy(1.0, &iterate.product(tangent), &mut slope);
        let sides = [iterate.residual.clone(), slope];
        let mut left = sides.clone();
        let mut solved = [0, 1].map(|i| vec![0.0; sides[i].len()]);
        let mut goals = None;
        for _ in 0..MOST_REFINEMENTS {
            let [(whole_0, b_0), (whole_1, b_1)] = left.each_ref().map(|x| scaled(x));
            let whole = [whole_0, whole_1];
            let b = inverse.times(&[b_0, b_1]);
            let sizes = [0, 1].map(|i| f64::from(norm(&b[i])) * whole[i]);
            let goals = *goals.get_or_insert_with(|| goals_of(sizes, tangent, size));
            let is_done = |i: usize, share: f64| goals[i] >= share * sizes[i];
            if (0..2).all(|i| is_done(i, 1.0 / ENOUGH)) {
                break;
            }
            let reach = [0, 1].map(|i| goals[i].max(SINGLE * sizes[i]) / whole[i]);
            let mut single = [0.0; 2];
            round(&reach, &mut single);
            let x = space.solve(product, b, &single, MOST_ROUNDS)?;
            for i in 0..2 {
                let terms = solved[i].iter_mut().zip(&x[i]);
                terms.for_each(|(sum, x)| *sum += whole[i] * f64::from(*x));
            }
            if (0..2).all(|i| is_done(i, SINGLE)) {
                break;
            }
            for i in 0..2 {
                left[i].copy_from_slice(&sides[i]);
                axpy(-1.0, &iterate.product(&solved[i]), &mut left[i]);
            }
        }
        let [correction, change] = solved;
        axpy(-1.0, &change, tangent);
        Some(correction.iter().map(|x| -x).collect())
    }
}

/// Residuals at which the correction and the tangent are solved, for right-hand sides of these `sizes`.
fn goals_of(sizes: [f64; 2], tangent: &[f64], size: f64) -> [f64; 2] {
    let forcing = FORCING * size;
    let known = vector::norm(tangent);
    let [loosest, finest] = TANGENT;
    [
        sizes[0] * forcing.clamp(CORRECTION, loosest),
        sizes[1].max(known) * forcing.clamp(finest, loosest),
    ]
}

/// The largest component of `x`, and x over it in single precision.
fn scaled(x: &[f64]) -> (f64, Vec<f32>) {
    let largest = x.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
    let shares: Vec<f64> = x.iter().map(|x| x / largest).collect();
    (largest, rounded(&shares))
}
