//! Adaptation of a chain before its draws count: its step, and the covariance of its coordinates.

use libm::{exp, log, pow};
use nalgebra::{DMatrix, DVector};

/// Step by dual averaging (Nesterov 2009, as Hoffman & Gelman 2014, section 3.2).
#[derive(Debug, Clone, Copy)]
pub(super) struct WarmUp {
    /// Logarithm of the step that iterations shrink to.
    towards: f64,
    log_step: f64,
    log_mean: f64,
    /// Mean of how far acceptance stays below what is wanted.
    lack: f64,
    n: f64,
}

/// Mean acceptance along a path that the step aims at.
const WANTED_ACCEPTANCE: f64 = 0.8;
/// Strength of the pull towards the first step, weight of the first iterations, and power of their forgetting.
const PULL: f64 = 0.05;
const INERTIA: f64 = 10.0;
const FORGETTING: f64 = 0.75;
/// Shares of the warm-up before the first window and after the last one.
const EDGES: [f64; 2] = [0.15, 0.1];
/// Draws of the first window.
const FIRST_WINDOW: usize = 25;
/// Weight of the prior variance, in draws, and that variance.
const PRIOR_DRAWS: f64 = 5.0;
const PRIOR_VARIANCE: f64 = 1e-3;

impl WarmUp {
    /// Step before anything is known, in standard deviations of the prior.
    pub(super) const FIRST_STEP: f64 = 0.1;

    /// Begins anew from `step`.
    pub(super) fn from(step: f64) -> Self {
        Self {
            towards: log(10.0 * step),
            log_step: log(step),
            log_mean: 0.0,
            lack: 0.0,
            n: 0.0,
        }
    }

    /// The step after a path with this mean acceptance.
    pub(super) fn next(&mut self, acceptance: f64) -> f64 {
        self.n += 1.0;
        let weight = 1.0 / (self.n + INERTIA);
        self.lack += weight * (WANTED_ACCEPTANCE - acceptance - self.lack);
        self.log_step = self.towards - self.n.sqrt() / PULL * self.lack;
        let share = pow(self.n, -FORGETTING);
        self.log_mean += share * (self.log_step - self.log_mean);
        exp(self.log_step)
    }

    /// The step that the iterations settled at.
    pub(super) fn settled(&self) -> f64 {
        match self.n > 0.0 {
            true => exp(self.log_mean),
            false => exp(self.log_step),
        }
    }
}

/// Windows of draws that give covariances, each twice as long as the one before.
#[derive(Debug, Clone)]
pub(super) struct Windows {
    /// First draw of the first window, and the draw after the last one.
    range: [usize; 2],
    /// Draw after the present window, and its length.
    end: usize,
    length: usize,
    n: f64,
    mean: DVector<f64>,
    /// Σ (x − mean) (x − mean)ᵀ of the present window.
    products: DMatrix<f64>,
}

impl Windows {
    /// Windows of a warm-up of so many draws.
    pub(super) fn of(draws: usize, dimension: usize) -> Self {
        let share = |share: f64| (share * draws as f64) as usize;
        let range = [share(EDGES[0]), draws - share(EDGES[1])];
        let mut windows = Self {
            range,
            end: range[0],
            length: FIRST_WINDOW,
            n: 0.0,
            mean: DVector::zeros(dimension),
            products: DMatrix::zeros(dimension, dimension),
        };
        windows.open();
        windows
    }

    /// The next window; the last one takes what would leave too little for another.
    fn open(&mut self) {
        let after = self.end + self.length;
        let last = after + 2 * self.length > self.range[1];
        self.end = if last { self.range[1] } else { after };
        self.length *= 2;
        self.n = 0.0;
        self.mean.fill(0.0);
        self.products.fill(0.0);
    }

    /// Counts a draw; the covariance where it ends a window. It is definite, since a little of the prior variance is added.
    pub(super) fn add(&mut self, draw: usize, position: &[f64]) -> Option<DMatrix<f64>> {
        if draw < self.range[0] || draw >= self.range[1] {
            return None;
        }
        self.n += 1.0;
        let away = DVector::from_column_slice(position) - &self.mean;
        self.mean += &away / self.n;
        self.products += &away * away.transpose() * (1.0 - 1.0 / self.n);
        if draw + 1 < self.end || self.n < 2.0 {
            return None;
        }
        let all = self.n + PRIOR_DRAWS;
        let mut found = &self.products * (self.n / (all * (self.n - 1.0)));
        (0..position.len()).for_each(|i| found[(i, i)] += PRIOR_VARIANCE * PRIOR_DRAWS / all);
        self.open();
        Some(found)
    }
}
