//! The segment of a branch between two of its points, and solutions on it: at a frequency, at a distance, at the tip of a
//! fold. They are predicted by a cubic through both points with their tangents.

use super::branch_point::{BranchPoint, distance};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Iterate, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;

/// Largest distance between a prediction and its solution, over the length of the segment, at which both surely lie on one
/// branch.
pub(in crate::hb) const CLOSE: f64 = 0.5;
/// Smallest such distance that is required: tolerances leave as much.
const FLOOR: f64 = 1e-3;
/// Halvings of a segment before the search for a frequency on it ends.
const MOST_HALVINGS: usize = 7;
/// Length, over that of the segment, to which the tip of a fold is located.
const TIP: f64 = 1e-4;
/// Most solutions for one tip.
const MOST_TIPS: usize = 12;

/// The segment of a branch between two of its points.
#[derive(Debug)]
pub struct BranchSegment<'s, 'p> {
    /// Where it begins.
    pub from: &'s BranchPoint<'p>,
    /// Where it ends.
    pub to: &'s BranchPoint<'p>,
    /// Length along the tangent of `from`. If the branch has a corner, parts of a segment may be longer than the segment.
    pub length: f64,
}

impl<'s, 'p> BranchSegment<'s, 'p> {
    /// The segment between two points of a branch.
    #[must_use]
    pub fn new(from: &'s BranchPoint<'p>, to: &'s BranchPoint<'p>) -> Self {
        let [length, _] = from.distances(&to.iterate.point);
        Self { from, to, length }
    }

    /// Whether the segment has a fold past which the frequency turns back, in a sweep in the direction `sign`.
    #[must_use]
    pub(crate) fn turns_back(&self, sign: f64) -> bool {
        sign * self.from.tangent.omega > 0.0 && sign * self.to.tangent.omega < 0.0
    }

    /// The last solution that is found before the fold of a segment that turns back.
    pub fn tip(&self, balance: &Balance<'p>, newton: NewtonSettings) -> Option<BranchPoint<'p>> {
        let sign = self.from.tangent.omega.signum();
        let (mut before, mut after) = (0.0, self.length);
        let mut rates = [self.from.tangent.omega, self.to.tangent.omega].map(|rate| sign * rate);
        let mut tip = None;
        for _ in 0..MOST_TIPS {
            if after - before <= TIP * self.length {
                break;
            }
            let share = (rates[0] / (rates[0] - rates[1])).clamp(0.1, 0.9);
            let at = before + share * (after - before);
            let point = self.inside(balance, at, newton).ok()?;
            let rate = sign * point.tangent.omega;
            if rate > 0.0 {
                (before, rates[0]) = (at, rate);
                tip = Some(point);
            } else {
                (after, rates[1]) = (at, rate);
            }
        }
        tip
    }

    /// Whether the solution `other` lies on the segment.
    #[must_use]
    pub fn passes(&self, other: &Point) -> bool {
        let [along, normal] = self.from.distances(other);
        let slack = FLOOR * self.length;
        (-slack..=self.length + slack).contains(&along) && normal <= CLOSE * self.length
    }

    /// The solution at `omega`, where the band ends within the segment.
    pub fn clipped(
        &self,
        balance: &Balance<'p>,
        omega: f64,
        newton: NewtonSettings,
    ) -> Option<BranchPoint<'p>> {
        let iterate = self.crossing(balance, omega, newton).ok()?;
        let scale = self.from.metric.omega_scale();
        let point = BranchPoint::new(balance, iterate, scale);
        Some(point.following(&self.from.tangent))
    }

    /// The solution at a frequency `omega` between those of the ends, for a segment without fold.
    ///
    /// # Errors
    /// The status of the last attempt.
    pub fn crossing(
        &self,
        balance: &Balance<'p>,
        omega: f64,
        newton: NewtonSettings,
    ) -> Result<Iterate<'p>, Status> {
        self.crossing_within(balance, omega, newton, MOST_HALVINGS)
    }

    /// The solution at `omega` on a segment on which it could not be located, because the branch is ragged there: from its ends, the nearer
    /// one first, no farther from them than they are apart, straight or along the tangent (around a corner the first is more), or a
    /// solution to which both lead.
    ///
    /// # Errors
    /// `failure`, if there is none of these.
    pub(in crate::hb) fn solved_from_ends(
        &self,
        balance: &Balance<'p>,
        omega: f64,
        newton: NewtonSettings,
        failure: Status,
    ) -> Result<Iterate<'p>, Status> {
        let mut ends = [self.from, self.to].map(|end| &end.iterate.point);
        let apart = distance(balance, ends[0], ends[1]).max(self.length);
        let away = |end: &Point| (end.omega - omega).abs();
        ends.sort_by(|a, b| away(a).total_cmp(&away(b)));
        let mut farther: Vec<Iterate<'p>> = Vec::new();
        for end in ends {
            let start = Point {
                omega,
                ..end.clone()
            };
            let solved = solve(balance, start.clone(), Condition::FixedFrequency, newton);
            if let Ok(found) = solved {
                if distance(balance, &found.point, &start) <= apart {
                    return Ok(found);
                }
                farther.push(found);
            }
        }
        let [one, other] = <[Iterate<'p>; 2]>::try_from(farther).map_err(|_| failure)?;
        match distance(balance, &one.point, &other.point) <= FLOOR * apart {
            true => Ok(one),
            false => Err(failure),
        }
    }

    /// [`Self::crossing`] with at most so many `halvings` of the segment.
    fn crossing_within(
        &self,
        balance: &Balance<'p>,
        omega: f64,
        newton: NewtonSettings,
        halvings: usize,
    ) -> Result<Iterate<'p>, Status> {
        let predicted = self.at_frequency(omega);
        let fixed = Condition::FixedFrequency;
        let failure = match solve(balance, predicted.clone(), fixed, newton) {
            Ok(found) => {
                let apart = distance(balance, &found.point, &predicted);
                if apart <= FLOOR.max(CLOSE * self.length) {
                    return Ok(found);
                }
                Status::StepTooSmall
            }
            Err(status) => status,
        };
        if halvings == 0 {
            return Err(failure);
        }
        let middle = self.inside(balance, 0.5 * self.length, newton);
        let middle = middle.map_err(|_| failure)?;
        let at = middle.iterate.point.omega;
        let is_first = (self.from.iterate.point.omega - omega) * (at - omega) <= 0.0;
        let half = match is_first {
            true => BranchSegment::new(self.from, &middle),
            false => BranchSegment::new(&middle, self.to),
        };
        half.crossing_within(balance, omega, newton, halvings - 1)
    }

    /// The solution at the distance `at` from the start, in the metric of the start. Its tangent turns less than 90° from that
    /// of the start.
    ///
    /// # Errors
    /// The status of the solve, or [`Status::StepTooSmall`] if it led to another branch.
    pub fn inside(
        &self,
        balance: &Balance<'p>,
        at: f64,
        newton: NewtonSettings,
    ) -> Result<BranchPoint<'p>, Status> {
        let from = self.from;
        let on_cubic = self.cubic(at / self.length);
        let [along, _] = from.distances(&on_cubic);
        let predicted = on_cubic.moved(&from.tangent, at - along);
        let found = from.step_to(balance, predicted.clone(), at, newton)?;
        if distance(balance, &found.point, &predicted) > FLOOR.max(CLOSE * self.length) {
            return Err(Status::StepTooSmall);
        }
        let scale = from.metric.omega_scale();
        let point = BranchPoint::new(balance, found, scale).following(&from.tangent);
        match BranchSegment::new(&point, self.to).length > 0.0 {
            true => Ok(point),
            false => Err(Status::StepTooSmall),
        }
    }

    /// The point at the share `t` of the cubic through both ends with their tangents.
    fn cubic(&self, t: f64) -> Point {
        let (a, b) = (&self.from.iterate.point, &self.to.iterate.point);
        let (ta, tb) = (&self.from.tangent, &self.to.tangent);
        let weights = self.weights(t);
        let at = |values: [f64; 4]| weights.iter().zip(values).map(|(w, v)| w * v).sum::<f64>();
        Point {
            r: (0..a.r.len())
                .map(|i| at([a.r[i], ta.r[i], b.r[i], tb.r[i]]))
                .collect(),
            omega: at([a.omega, ta.omega, b.omega, tb.omega]),
            level: a.level,
        }
    }

    /// Weights of value and tangent at the start, value and tangent at the end, of the cubic at the share `t`.
    fn weights(&self, t: f64) -> [f64; 4] {
        // each tangent has unit length in the metric of its own point
        let length_at_end = self.from.length_at(self.to, self.length);
        let [a, ta, b, tb] = hermite(t);
        [a, ta * self.length, b, tb * length_at_end]
    }

    /// The point with the frequency `omega` on the cubic.
    fn at_frequency(&self, omega: f64) -> Point {
        let (a, b) = (&self.from.iterate.point, &self.to.iterate.point);
        let ends = [
            a.omega,
            self.from.tangent.omega,
            b.omega,
            self.to.tangent.omega,
        ];
        let sign = (b.omega - a.omega).signum();
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            let weights = self.weights(middle);
            let at: f64 = weights.iter().zip(ends).map(|(w, v)| w * v).sum();
            match sign * (at - omega) < 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        Point {
            omega,
            ..self.cubic(0.5 * (low + high))
        }
    }
}

/// Weights of value and slope at 0, value and slope at 1, of the cubic at `t`.
pub(in crate::hb) fn hermite(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    [
        u * u * (1.0 + 2.0 * t),
        t * u * u,
        t * t * (3.0 - 2.0 * t),
        -t * t * u,
    ]
}
