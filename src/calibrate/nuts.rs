//! The no-U-turn sampler: Hoffman & Gelman, J. Mach. Learn. Res. 15 (2014) 1593–1623, algorithm 6, whose names it bears, with
//! multinomial sampling of the path and the general criterion of a turn (Betancourt, arXiv 1701.02434), and the warm-up of Stan:
//! step by dual averaging, dense mass matrix from windows of doubling length.
//!
//! Own code and no crate: sums run in one order on every processor, so a chain is the same bits on all of them.

use super::warm_up::{WarmUp, Windows};
use crate::special::normal_quantile;
use libm::{exp, log};
use nalgebra::{DMatrix, DVector};
use rand::Rng;
use rand_chacha::ChaCha20Rng;

/// Logarithm of a density but for a constant; it writes the gradient. Not finite where there is none.
pub(super) type LogDensity<'a> = dyn Fn(&[f64], &mut [f64]) -> f64 + 'a;

/// Doublings of a path at most: 1023 steps.
const MOST_DOUBLINGS: u32 = 10;
/// Growth of the energy along a path beyond which its steps mean nothing.
const DIVERGENT: f64 = 1000.0;

/// A place on a path.
#[derive(Debug, Clone)]
struct ChainPoint {
    position: Vec<f64>,
    momentum: Vec<f64>,
    gradient: Vec<f64>,
    density: f64,
}

/// Where a path is made longer.
#[derive(Debug, Clone, Copy)]
enum TimeDirection {
    Backward,
    Forward,
}

impl TimeDirection {
    /// Indices of the end of a path in this direction and of its other end.
    fn ends(self) -> [usize; 2] {
        match self {
            Self::Backward => [0, 1],
            Self::Forward => [1, 0],
        }
    }
}

/// The leaves of a subtree: a piece of the path, in the order in which it was built.
struct Subtree {
    /// Momenta at its ends.
    ends: [Vec<f64>; 2],
    /// Sum of all momenta.
    sum: Vec<f64>,
    /// A place drawn from it by its weights.
    proposal: ChainPoint,
    /// Logarithm of the sum of the weights.
    log_weight: f64,
    /// No U-turn and no divergence.
    is_valid: bool,
}

/// What the building of one path tells of its step.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    steps: u32,
    acceptance: f64,
    diverged: bool,
}

/// The inverse of the mass matrix: the covariance Σ of the coordinates.
struct Metric {
    covariance: DMatrix<f64>,
    /// L of Σ = L Lᵀ.
    factor: DMatrix<f64>,
}

impl Metric {
    /// `None` if the covariance is not definite.
    fn new(covariance: DMatrix<f64>) -> Option<Self> {
        let factor = covariance.clone().cholesky()?.unpack();
        Some(Self { covariance, factor })
    }

    fn unit(dimension: usize) -> Self {
        let identity = DMatrix::identity(dimension, dimension);
        Self {
            covariance: identity.clone(),
            factor: identity,
        }
    }

    /// L⁻ᵀ z: a momentum of covariance Σ⁻¹ from independent normal numbers.
    fn momentum(&self, normals: &DVector<f64>) -> DVector<f64> {
        // the factor of a definite matrix has no zero on its diagonal
        self.factor.tr_solve_lower_triangular_unchecked(normals)
    }

    /// Σ p.
    fn velocity(&self, momentum: &[f64]) -> DVector<f64> {
        &self.covariance * DVector::from_column_slice(momentum)
    }
}

/// A chain that goes on.
pub(super) struct Chain<'a> {
    density: &'a LogDensity<'a>,
    generator: ChaCha20Rng,
    at: ChainPoint,
    step: f64,
    metric: Metric,
}

impl<'a> Chain<'a> {
    /// A chain that starts at `position`; `None` where the density is not finite there.
    pub(super) fn start(
        density: &'a LogDensity<'a>,
        position: Vec<f64>,
        generator: ChaCha20Rng,
    ) -> Option<Self> {
        let n = position.len();
        let mut gradient = vec![0.0; n];
        let value = density(&position, &mut gradient);
        let finite = value.is_finite() && gradient.iter().all(|g| g.is_finite());
        finite.then(|| Self {
            density,
            generator,
            at: ChainPoint {
                position,
                momentum: vec![0.0; n],
                gradient,
                density: value,
            },
            step: WarmUp::FIRST_STEP,
            metric: Metric::unit(n),
        })
    }

    /// Adapts step and mass matrix over `draws` draws.
    pub(super) fn warm_up(&mut self, draws: usize) {
        let mut windows = Windows::of(draws, self.at.position.len());
        let mut step = WarmUp::from(self.step);
        for draw in 0..draws {
            let tally = self.transition();
            self.step = step.next(tally.acceptance / f64::from(tally.steps.max(1)));
            if let Some(metric) = (windows.add(draw, &self.at.position)).and_then(Metric::new) {
                self.metric = metric;
                step = WarmUp::from(self.step);
            }
        }
        self.step = step.settled();
    }

    /// The next draw, and whether its path diverged.
    pub(super) fn draw(&mut self) -> (&[f64], bool) {
        let tally = self.transition();
        (&self.at.position, tally.diverged)
    }

    /// Uniform number in (0, 1).
    fn uniform(&mut self) -> f64 {
        ((self.generator.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    fn transition(&mut self) -> Tally {
        let n = self.at.momentum.len();
        let normals = DVector::from_fn(n, |_, _| normal_quantile(self.uniform()));
        let momentum = self.metric.momentum(&normals);
        self.at.momentum.copy_from_slice(momentum.as_slice());
        let start = self.energy(&self.at);
        let momentum = self.at.momentum.clone();
        let mut path = Subtree {
            ends: [momentum.clone(), momentum.clone()],
            sum: momentum,
            proposal: self.at.clone(),
            log_weight: 0.0,
            is_valid: true,
        };
        let mut outermost = [self.at.clone(), self.at.clone()];
        let mut tally = Tally::default();
        for depth in 0..MOST_DOUBLINGS {
            let direction = match self.uniform() < 0.5 {
                true => TimeDirection::Forward,
                false => TimeDirection::Backward,
            };
            let [end, _] = direction.ends();
            let further = self.build_tree(&mut outermost[end], direction, depth, start, &mut tally);
            if !further.is_valid {
                break;
            }
            // later subtrees are preferred to earlier ones, which moves farther and keeps the distribution
            let log_probability = further.log_weight - path.log_weight;
            path = self.joined(path, further, direction, log_probability);
            if !path.is_valid {
                break;
            }
        }
        self.at = path.proposal;
        tally
    }

    /// Takes 2^depth steps from `at`, which ends at the last one.
    fn build_tree(
        &mut self,
        at: &mut ChainPoint,
        direction: TimeDirection,
        depth: u32,
        start: f64,
        tally: &mut Tally,
    ) -> Subtree {
        if depth == 0 {
            return self.one_step(at, direction, start, tally);
        }
        let first = self.build_tree(at, direction, depth - 1, start, tally);
        if !first.is_valid {
            return first;
        }
        let second = self.build_tree(at, direction, depth - 1, start, tally);
        if !second.is_valid {
            return second;
        }
        let total = log_sum(first.log_weight, second.log_weight);
        let log_probability = second.log_weight - total;
        // both were built away from the start, so that the second follows the first whatever the direction
        self.joined(first, second, TimeDirection::Forward, log_probability)
    }

    fn one_step(
        &self,
        at: &mut ChainPoint,
        direction: TimeDirection,
        start: f64,
        tally: &mut Tally,
    ) -> Subtree {
        let step = match direction {
            TimeDirection::Forward => self.step,
            TimeDirection::Backward => -self.step,
        };
        for (p, g) in at.momentum.iter_mut().zip(&at.gradient) {
            *p += 0.5 * step * g;
        }
        let velocity = self.metric.velocity(&at.momentum);
        for (q, v) in at.position.iter_mut().zip(velocity.iter()) {
            *q += step * v;
        }
        at.density = (self.density)(&at.position, &mut at.gradient);
        for (p, g) in at.momentum.iter_mut().zip(&at.gradient) {
            *p += 0.5 * step * g;
        }
        let log_weight = start - self.energy(at);
        let finite = log_weight.is_finite();
        let log_weight = if finite {
            log_weight
        } else {
            f64::NEG_INFINITY
        };
        let is_valid = log_weight > -DIVERGENT;
        tally.steps += 1;
        tally.acceptance += exp(log_weight.min(0.0));
        tally.diverged |= !is_valid;
        Subtree {
            ends: [at.momentum.clone(), at.momentum.clone()],
            sum: at.momentum.clone(),
            proposal: at.clone(),
            log_weight,
            is_valid,
        }
    }

    /// `path` with `further` at its end in this direction; it proposes what `further` proposes with the probability
    /// e^`log_probability`, at most 1.
    fn joined(
        &mut self,
        path: Subtree,
        further: Subtree,
        direction: TimeDirection,
        log_probability: f64,
    ) -> Subtree {
        let takes_further = log(self.uniform()) < log_probability;
        let plus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<f64>>();
        let sum = plus(&path.sum, &further.sum);
        let [inner, outer] = &further.ends;
        let [near_end, far_end] = direction.ends();
        let (near, far) = (&path.ends[near_end], &path.ends[far_end]);
        // the joined path, and each of the two with the first momentum of the other
        let is_valid = self.has_no_u_turn(&sum, far, outer)
            && self.has_no_u_turn(&plus(&path.sum, inner), far, inner)
            && self.has_no_u_turn(&plus(&further.sum, near), near, outer);
        let mut ends = path.ends.clone();
        ends[near_end].clone_from(outer);
        Subtree {
            ends,
            sum,
            log_weight: log_sum(path.log_weight, further.log_weight),
            proposal: match takes_further {
                true => further.proposal,
                false => path.proposal,
            },
            is_valid,
        }
    }

    /// Whether a path with this sum of momenta still moves away at both ends.
    fn has_no_u_turn(&self, sum: &[f64], one: &[f64], other: &[f64]) -> bool {
        let moved = self.metric.velocity(sum);
        let along = |end: &[f64]| -> f64 { moved.iter().zip(end).map(|(v, p)| v * p).sum() };
        along(one) > 0.0 && along(other) > 0.0
    }

    fn energy(&self, at: &ChainPoint) -> f64 {
        let velocity = self.metric.velocity(&at.momentum);
        let twice: f64 = velocity.iter().zip(&at.momentum).map(|(v, p)| v * p).sum();
        0.5 * twice - at.density
    }
}

/// ln(eᵃ + eᵇ).
fn log_sum(a: f64, b: f64) -> f64 {
    let most = a.max(b);
    match most.is_finite() {
        true => most + log(exp(a - most) + exp(b - most)),
        false => most,
    }
}
