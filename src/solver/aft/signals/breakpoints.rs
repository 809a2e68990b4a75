//! Breakpoints: phases at which the motion of a contact may change.
//!
//! The slider of the box law rests at z = k_t w unless one of its bounds k_t u ∓ mu N pushes it. Breakpoints are the roots of the gap
//! function and the phases at which a bound turns away from the slider. Between two breakpoints the gap keeps its sign, and a bound
//! that pushes the slider pushes up to the second one. Therefore it is enough to apply the law at the breakpoints: the slider there
//! is exact.
//!
//! The signals are trigonometric polynomials. Their samples and the samples of their rates bracket the breakpoints; Halley's
//! method locates roots to rounding, and turns to its square root, since the bound depends on the square of that error. Where a bound
//! turns towards the slider and cannot touch it, the sample before the turn is the breakpoint.

use super::polynomial::{basis_row, derivatives, rate, root, value};
use super::roots::{crossing_share, dips, linear_share, turn_share, turns_twice};
use crate::aft::lanes::lane::{Components, LANES, Lane};
use crate::aft::lanes::masks::View;
use crate::aft::lanes::workspace::{Workspace, flag};
use crate::aft::plan::AftPlan;
use crate::contact::{ContactParameters, FrictionLaw, Real};
use pulp::Simd;
use std::f64::consts::TAU;

/// Marks of an interval between two samples: the gap function changes sign, or dips towards zero and back.
const CROSSING: u32 = 1;
const DIP: u32 = 2;
/// The rate of a bound changes sign, or may do so twice. Shifted by 2 × direction + side.
const TURN: u32 = 4;
const TURN_PAIR: u32 = 64;

/// A phase and the signals there.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Breakpoint<T> {
    /// Phase in [0, 2π].
    pub theta: T,
    /// Tangential displacements (m).
    pub u: [T; 2],
    /// Gap function (N); exactly 0 at its roots.
    pub gap: T,
    /// Whether the contact is open from here to the next breakpoint. While breakpoints are collected: whether it opens or closes here.
    pub open: bool,
}

/// Signals of one state as trigonometric polynomials. Shape of each: `[m]`.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Signals<T> {
    /// Tangential displacements (m).
    pub u: [Vec<T>; 2],
    /// Gap function n_0 + k_n v (N).
    pub gap: Vec<T>,
    /// Lower and upper bound k_t u ∓ mu g of k_t w, per direction (N).
    pub bounds: [[Vec<T>; 2]; 2],
    /// Basis row at the present trial of a root search.
    row: Vec<T>,
}

/// Rates of the signals at the samples, and what the samples tell of the intervals after them.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Intervals<T> {
    /// Derivatives of u₁, u₂ and v by the phase. Shape: `[time]`.
    pub rates: Vec<Components<T>>,
    /// Sum of marks. Shape: `[time]`.
    marks: Vec<Lane<T>>,
}

impl<T: Real> Signals<T> {
    /// Sets the signals of a contact with the parameters `p`, whose displacement component c (t1, t2, n) has the coefficient `q(c, j)` (m).
    #[inline(always)]
    pub(in crate::aft) fn set(
        &mut self,
        plan: &AftPlan<T>,
        q: impl Fn(usize, usize) -> T,
        p: &ContactParameters<T>,
    ) {
        for (c, target) in self.u.iter_mut().enumerate() {
            target.clear();
            target.extend((0..plan.m).map(|j| q(c, j)));
        }
        self.gap.clear();
        self.gap.extend((0..plan.m).map(|j| p.k_n * q(2, j)));
        self.gap[0] += p.n_0;
        for d in 0..2 {
            for (side, factor) in [-p.mu, p.mu].into_iter().enumerate() {
                let bound = &mut self.bounds[d][side];
                bound.clear();
                let pairs = self.u[d].iter().zip(&self.gap);
                bound.extend(pairs.map(|(&u, &g)| p.k_t[d] * u + factor * g));
            }
        }
        self.row.resize(plan.m, T::ONE);
    }

    /// The signals at a phase.
    #[inline(always)]
    fn at(&mut self, plan: &AftPlan<T>, theta: T) -> Breakpoint<T> {
        basis_row(plan, theta, &mut self.row);
        let value = |q: &[T]| value(&self.row, q);
        Breakpoint {
            theta,
            u: [value(&self.u[0]), value(&self.u[1])],
            gap: value(&self.gap),
            open: false,
        }
    }
}

impl<T: Real> Intervals<T> {
    /// Looks at all intervals between the samples of `work`, whose rates are computed here; at the bounds of the box
    /// law only.
    #[inline(always)]
    pub(in crate::aft) fn mark<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        work: &mut Workspace<T>,
    ) {
        let bounds = plan.settings().law == FrictionLaw::Box;
        let n = plan.n_time();
        self.rates.resize(n, [T::ZERO; 3 * LANES]);
        self.marks.resize(n, [T::ZERO; LANES]);
        let rates = &mut self.rates;
        work.synthesize_rates(simd, plan, |i, rate| rates[i] = rate);
        let step = T::from_f64(TAU / n as f64);
        let p = &work.parameters;
        for i in 0..n {
            let next = if i + 1 == n { 0 } else { i + 1 };
            let (a, b) = (&work.samples[i], &work.samples[next]);
            let (ra, rb) = (&self.rates[i], &self.rates[next]);
            let marks = &mut self.marks[i];
            for l in 0..LANES {
                let gap = [a.gap[l], b.gap[l]];
                let v = 2 * LANES + l;
                let rate_of_gap = step * p.k_n[l];
                let gap_rate = [rate_of_gap * ra[v], rate_of_gap * rb[v]];
                let mut mark: T = number(CROSSING, (gap[0] > T::ZERO) != (gap[1] > T::ZERO));
                mark += number(DIP, dips(gap, gap_rate));
                if !bounds {
                    marks[l] = mark;
                    continue;
                }
                let mu = p.mu[l];
                let friction = [mu * gap[0], mu * gap[1], mu * gap_rate[0], mu * gap_rate[1]];
                let first = [a.u[0][l], b.u[0][l], step * ra[l], step * rb[l]];
                let second = [
                    a.u[1][l],
                    b.u[1][l],
                    step * ra[LANES + l],
                    step * rb[LANES + l],
                ];
                mark += bound_marks(0, p.k_t[0][l], first, friction);
                mark += bound_marks(2, p.k_t[1][l], second, friction);
                marks[l] = mark;
            }
        }
    }

    /// Breakpoints of one lane, ascending from phase 0, which is always one.
    #[inline(always)]
    pub(in crate::aft) fn breakpoints(
        &self,
        plan: &AftPlan<T>,
        work: &Workspace<T>,
        lane: usize,
        signals: &mut Signals<T>,
        points: &mut Vec<Breakpoint<T>>,
    ) {
        let view = View { plan, work, lane };
        let first = &work.samples[0];
        points.clear();
        let mut open = first.gap[lane] <= T::ZERO;
        points.push(Breakpoint {
            theta: T::ZERO,
            u: [first.u[0][lane], first.u[1][lane]],
            gap: first.gap[lane],
            open,
        });
        for (i, marks) in self.marks.iter().enumerate() {
            if marks[lane] != T::ZERO {
                let from = points.len();
                self.interval(view, i, signals, points);
                points[from..].sort_by(|a, b| a.theta.to_f64().total_cmp(&b.theta.to_f64()));
            }
        }
        for point in &mut points[1..] {
            open ^= point.open;
            point.open = open;
        }
    }

    /// Breakpoints between sample i and the next one; at this stage their field `open` says whether the contact opens or closes there.
    #[inline(always)]
    fn interval(
        &self,
        view: View<T>,
        i: usize,
        signals: &mut Signals<T>,
        points: &mut Vec<Breakpoint<T>>,
    ) {
        let View { plan, work, lane } = view;
        let next = if i + 1 == plan.n_time() { 0 } else { i + 1 };
        // a whole number below 1024
        let marks = self.marks[i][lane].to_f64() as u32;
        let before = points.len();
        self.gap_roots(view, i, marks, signals, points);
        let gaps = [i, next].map(|i| work.samples[i].gap[lane]);
        if gaps[0] <= T::ZERO && gaps[1] <= T::ZERO && points.len() == before {
            return;
        }
        // A bound may touch the slider without a push: where the contact has just closed, and at the start of the period.
        let touches = points.len() > before || i == 0;
        self.turns(view, i, marks, touches, signals, points);
    }

    /// Roots of the gap function between sample i and the next one.
    #[inline(always)]
    fn gap_roots(
        &self,
        view: View<T>,
        i: usize,
        marks: u32,
        signals: &mut Signals<T>,
        points: &mut Vec<Breakpoint<T>>,
    ) {
        let View { plan, work, lane } = view;
        let next = if i + 1 == plan.n_time() { 0 } else { i + 1 };
        let step = T::from_f64(TAU / plan.n_time() as f64);
        let ends = interval_ends(plan, i);
        let crossing = |signals: &mut Signals<T>, theta: T| Breakpoint {
            gap: T::ZERO,
            open: true,
            ..signals.at(plan, theta)
        };
        let gaps = [i, next].map(|i| work.samples[i].gap[lane]);
        if marks & CROSSING != 0 {
            let rate =
                |i: usize| step * work.parameters.k_n[lane] * self.rates[i][2 * LANES + lane];
            let guess = ends[0] + step * crossing_share(gaps, [i, next].map(rate));
            let theta = signals.gap_root(plan, ends, gaps[1] > T::ZERO, guess);
            points.push(crossing(signals, theta));
        } else if marks & DIP != 0 {
            let rising = gaps[0] < T::ZERO;
            let guess = T::from_f64(0.5) * (ends[0] + ends[1]);
            let turn = root::<1, T>(
                plan,
                &mut signals.row,
                &signals.gap,
                T::ZERO,
                ends,
                !rising,
                guess,
            );
            let extreme = signals.at(plan, turn).gap;
            if (extreme > T::ZERO) != (gaps[0] > T::ZERO) {
                let before = ends[0] + (turn - ends[0]) * linear_share(gaps[0], extreme);
                let after = turn + (ends[1] - turn) * linear_share(extreme, gaps[1]);
                let first = signals.gap_root(plan, [ends[0], turn], rising, before);
                let second = signals.gap_root(plan, [turn, ends[1]], !rising, after);
                points.push(crossing(signals, first));
                points.push(crossing(signals, second));
            }
        }
    }

    /// Phases between sample i and the next one where a bound turns. `touches` says whether a bound may touch the slider there
    /// without a push.
    #[inline(always)]
    fn turns(
        &self,
        view: View<T>,
        i: usize,
        marks: u32,
        touches: bool,
        signals: &mut Signals<T>,
        points: &mut Vec<Breakpoint<T>>,
    ) {
        let View { plan, work, lane } = view;
        let next = if i + 1 == plan.n_time() { 0 } else { i + 1 };
        let step = T::from_f64(TAU / plan.n_time() as f64);
        let ends = interval_ends(plan, i);
        for bound in 0..4 {
            let (d, side) = (bound / 2, bound % 2);
            if marks & (TURN << bound) != 0 {
                let (low, first) = self.bound_at(work, i, lane, d, side);
                let (high, second) = self.bound_at(work, next, lane, d, side);
                let rates = [first, second];
                let turns_away = (rates[1] > T::ZERO) == (side == 1);
                if turns_away || touches {
                    let guess = ends[0] + step * turn_share(high - low, rates.map(|r| step * r));
                    let rising = rates[1] > T::ZERO;
                    let theta = signals.turn(plan, d, side, ends, rising, guess);
                    points.push(signals.at(plan, theta));
                } else {
                    // The bound turns towards the slider and does not touch it: the sample before is near enough.
                    points.push(sampled(work, i, lane, ends[0]));
                }
            } else if marks & (TURN_PAIR << bound) != 0
                && let Some(turns) = signals.turn_pair(plan, d, side, ends)
            {
                points.extend(turns.map(|theta| signals.at(plan, theta)));
            }
        }
    }

    /// Value and rate of a bound at a sample.
    #[inline(always)]
    pub(in crate::aft) fn bound_at(
        &self,
        work: &Workspace<T>,
        i: usize,
        lane: usize,
        d: usize,
        side: usize,
    ) -> (T, T) {
        let p = work.parameters.of(lane);
        let factor = if side == 0 { -p.mu } else { p.mu };
        let (s, rates) = (&work.samples[i], &self.rates[i]);
        let friction = factor * (p.k_n * rates[2 * LANES + lane]);
        (
            p.k_t[d] * s.u[d][lane] + factor * s.gap[lane],
            p.k_t[d] * rates[d * LANES + lane] + friction,
        )
    }
}

/// Phases of sample i and of the next one.
#[inline(always)]
fn interval_ends<T: Real>(plan: &AftPlan<T>, i: usize) -> [T; 2] {
    [i, i + 1].map(|i| T::from_f64(i as f64 * TAU / plan.n_time() as f64))
}

/// The signals at a sample, as a breakpoint where the contact neither opens nor closes.
#[inline(always)]
fn sampled<T: Real>(work: &Workspace<T>, i: usize, lane: usize, theta: T) -> Breakpoint<T> {
    let s = &work.samples[i];
    Breakpoint {
        theta,
        u: [s.u[0][lane], s.u[1][lane]],
        gap: s.gap[lane],
        open: false,
    }
}

impl<T: Real> Signals<T> {
    /// Root of the gap function between two phases.
    #[inline(always)]
    fn gap_root(&mut self, plan: &AftPlan<T>, ends: [T; 2], rising: bool, guess: T) -> T {
        let (row, gap) = (&mut self.row, &self.gap);
        root::<0, T>(plan, row, gap, T::ZERO, ends, rising, guess)
    }

    /// Turning point of a bound between two phases.
    #[inline(always)]
    fn turn(
        &mut self,
        plan: &AftPlan<T>,
        d: usize,
        side: usize,
        ends: [T; 2],
        rising: bool,
        guess: T,
    ) -> T {
        let (row, bound) = (&mut self.row, &self.bounds[d][side]);
        root::<1, T>(plan, row, bound, T::ZERO, ends, rising, guess)
    }

    /// Two turning points of a bound whose rate has the same sign at both phases, if it has another one between them.
    fn turn_pair(
        &mut self,
        plan: &AftPlan<T>,
        d: usize,
        side: usize,
        ends: [T; 2],
    ) -> Option<[T; 2]> {
        let middle = |a: T, b: T| T::from_f64(0.5) * (a + b);
        let bound = &self.bounds[d][side];
        let slopes = ends.map(|theta| {
            basis_row(plan, theta, &mut self.row);
            derivatives::<2, T>(plan, &self.row, bound)[0] > T::ZERO
        });
        if slopes[0] == slopes[1] {
            return None;
        }
        let guess = middle(ends[0], ends[1]);
        let top = root::<2, T>(plan, &mut self.row, bound, T::ZERO, ends, slopes[1], guess);
        let sign = |theta: T, row: &mut [T]| {
            basis_row(plan, theta, row);
            rate(plan, row, bound) > T::ZERO
        };
        let (outside, inside) = (sign(ends[0], &mut self.row), sign(top, &mut self.row));
        if outside == inside {
            return None;
        }
        let first = self.turn(plan, d, side, [ends[0], top], inside, middle(ends[0], top));
        let second = self.turn(plan, d, side, [top, ends[1]], outside, middle(top, ends[1]));
        Some([first, second])
    }

    /// Phase at which a bound that is monotone from breakpoint `a` to `b` reaches `level`. The samples between them,
    /// value and rate, narrow the bracket.
    #[inline(always)]
    pub(in crate::aft) fn reaches(
        &mut self,
        plan: &AftPlan<T>,
        d: usize,
        side: usize,
        level: T,
        [mut a, mut b]: [(T, T); 2],
        sampled: impl Fn(usize) -> (T, T),
    ) -> T {
        let n = plan.n_time() as f64;
        let rising = b.1 > a.1;
        let mut rates = [None; 2];
        let (mut low, mut high) = (
            first_sample_from(a.0.to_f64(), n),
            first_sample_from(b.0.to_f64(), n),
        );
        while low < high {
            let middle = usize::midpoint(low, high);
            let (value, rate) = sampled(middle);
            let point = (T::from_f64(middle as f64 * TAU / n), value);
            if (value > level) == rising {
                (high, b, rates[1]) = (middle, point, Some(rate));
            } else {
                (low, a, rates[0]) = (middle + 1, point, Some(rate));
            }
        }
        let (values, width) = ([a.1 - level, b.1 - level], b.0 - a.0);
        let share = match rates {
            [Some(first), Some(second)] => crossing_share(values, [width * first, width * second]),
            _ => linear_share(values[0], values[1]),
        };
        let guess = a.0 + width * share;
        let bound = &self.bounds[d][side];
        root::<0, T>(plan, &mut self.row, bound, level, [a.0, b.0], rising, guess)
    }
}

/// Index of the first of `n` samples at or after the phase.
#[inline(always)]
pub(in crate::aft) fn first_sample_from(theta: f64, n: f64) -> usize {
    (theta * (n / TAU)).ceil().clamp(0.0, n) as usize
}

/// The mark as a number if `holds`, else 0.
#[inline(always)]
fn number<T: Real>(mark: u32, holds: bool) -> T {
    T::from_f64(f64::from(mark)) * flag(holds)
}

/// Marks of both bounds of one direction from displacement and friction limit: values, then rates, at both ends.
#[inline(always)]
fn bound_marks<T: Real>(shift: u32, k_t: T, u: [T; 4], friction: [T; 4]) -> T {
    let mut mark = T::ZERO;
    for (side, sign) in [-T::ONE, T::ONE].into_iter().enumerate() {
        let shift = shift + side as u32;
        let rise = k_t * (u[1] - u[0]) + sign * (friction[1] - friction[0]);
        let rate = [
            k_t * u[2] + sign * friction[2],
            k_t * u[3] + sign * friction[3],
        ];
        mark += number(TURN << shift, (rate[0] > T::ZERO) != (rate[1] > T::ZERO));
        mark += number(TURN_PAIR << shift, turns_twice(rise, rate));
    }
    mark
}
