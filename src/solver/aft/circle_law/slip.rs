//! One step of slip of the coupled (circle) law. The step is of second order, and the traction stays exactly on the circle.
//!
//! In slip the traction is T = L e with L = mu N and |e| = 1. The displacement turns its direction: L e' = (I − e eᵀ) s' with
//! s = k_t u. Let e = (cos φ, sin φ). Then ψ = (cos φ/2, sin φ/2), times any factor, obeys the linear equation ψ' = ½ A ψ with
//! A = [a₁ a₂; a₂ −a₁] and a = s'/L. Where a is constant, the solution is the exponential of a symmetric matrix; the code calls it
//! the boost, as relativity does.
//!
//! A step takes a = Δs/L̄. Then it turns ψ towards the velocity at the end of the step, because the velocity turns during the step:
//! in short steps by the commutator of Magnus' series (Blanes et al., Phys. Rep. 470, 2009), in long ones by the angle by which the
//! traction follows behind the velocity. In long steps the direction at the end does not depend on the one at the start. For
//! e^{-y} the code takes 1/(1 + y + ... + y⁵/120), which also goes to 0 for long steps.

use crate::aft::vector::dot;
use crate::contact::Real;

/// Largest y = |Δs|/L̄ of a step. Then the direction at the end does not depend on the one at the start, but for a share of 1e-13.
const LONGEST: f64 = 1e3;

/// What a step of slip depends on, apart from the direction before it; also the derivatives of a number by these.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct SlipStep<T> {
    /// Change of s = k_t u (N).
    pub path: [T; 2],
    /// s' at the end (N per radian).
    pub rate: [T; 2],
    /// Mean L of the start and the end (N).
    pub limit: T,
    /// Length (rad).
    pub length: T,
}

/// The intermediate results of a step.
#[derive(Debug, Clone, Copy)]
struct Parts<T> {
    /// |Δs| (N).
    distance: T,
    /// L̄ (N), but at least so large that y is at most [`LONGEST`].
    limit: T,
    /// 1/L̄; 0 where the limit is 0.
    flexibility: T,
    y: T,
    /// (e^y − 1)/y.
    growth: T,
    /// 1/(2 e^y).
    scale: T,
    /// Factors of the unit matrix and of A in the boost.
    even: T,
    odd: T,
    /// s' at the end times the length (N).
    ahead: [T; 2],
    /// Cross product of Δs with `ahead` (N²), and 1 over the sum of the squares of both.
    cross: T,
    inverse_of_squares: T,
    /// Factor of the cross product in the turn, and the polynomial in that factor.
    weight: T,
    polynomial: T,
    /// Tangent of half the angle by which the traction turns after the boost.
    turn: T,
}

/// Derivatives of some of the parts by y.
#[derive(Debug, Clone, Copy)]
struct PartRates<T> {
    even: T,
    odd: T,
    weight: T,
}

impl<T: Real> Parts<T> {
    #[inline(always)]
    fn rates_by_y(&self) -> PartRates<T> {
        let number = T::from_f64;
        let Parts {
            y, growth, scale, ..
        } = *self;
        let growth_by_y =
            ((number(1.0 / 30.0) * y + number(0.125)) * y + number(1.0 / 3.0)) * y + number(0.5);
        let exponential_by_y = growth + growth_by_y * y;
        let even_by_y = -(exponential_by_y + exponential_by_y) * scale * scale;
        let odd_by_y = growth_by_y * scale + growth * even_by_y;
        let polynomial_by_y = (number(0.025) * y + number(0.05)) * y + number(1.0 / 12.0);
        let risen = (polynomial_by_y * y + self.polynomial + self.polynomial) * y;
        let weight_by_y = (scale + scale) * (risen - self.weight * exponential_by_y);
        PartRates {
            even: even_by_y,
            odd: odd_by_y,
            weight: weight_by_y,
        }
    }
}

impl<T: Real> SlipStep<T> {
    #[inline(always)]
    fn parts(&self) -> Parts<T> {
        let number = T::from_f64;
        let [p, q] = self.path;
        let square = p * p + q * q;
        let distance = square.sqrt();
        let limit = self.limit.or_larger(number(1.0 / LONGEST) * distance);
        let floor = number(f64::from(f32::MIN_POSITIVE));
        let flexibility = if limit > floor {
            T::ONE / limit
        } else {
            T::ZERO
        };
        let y = distance * flexibility;
        let growth = ((number(1.0 / 120.0) * y + number(1.0 / 24.0)) * y + number(1.0 / 6.0)) * y;
        let growth = (growth + number(0.5)) * y + T::ONE;
        let exponential = growth * y + T::ONE;
        let scale = T::ONE / (exponential + exponential);
        let ahead = self.rate.map(|rate| rate * self.length);
        let cross = p * ahead[1] - q * ahead[0];
        let squares = square + ahead[0] * ahead[0] + ahead[1] * ahead[1];
        let squares = squares + T::EPSILON * limit * limit;
        let inverse_of_squares = if squares > T::ZERO {
            T::ONE / squares
        } else {
            T::ZERO
        };
        let polynomial = (number(1.0 / 120.0) * y + number(1.0 / 40.0)) * y;
        let polynomial = (polynomial + number(1.0 / 12.0)) * y + number(1.0 / 6.0);
        let weight = polynomial * y * y * (scale + scale);
        Parts {
            distance,
            limit,
            flexibility,
            y,
            growth,
            scale,
            even: number(0.5) + scale,
            odd: growth * scale,
            ahead,
            cross,
            inverse_of_squares,
            weight,
            polynomial,
            turn: weight * cross * inverse_of_squares,
        }
    }

    /// The matrix that multiplies ψ, row-major; its norm is about 1 or less.
    #[inline(always)]
    pub(in crate::aft) fn map(&self) -> [T; 4] {
        let parts = self.parts();
        let factor = parts.odd * parts.flexibility;
        let [c, s] = self.path.map(|path| factor * path);
        let (even, turn) = (parts.even, parts.turn);
        let boost = [even + c, s, s, even - c];
        [
            boost[0] - turn * boost[2],
            boost[1] - turn * boost[3],
            boost[2] + turn * boost[0],
            boost[3] + turn * boost[1],
        ]
    }

    /// Derivatives of the angle after the step from the direction `before` by what the step depends on.
    #[inline(always)]
    pub(in crate::aft) fn angle_rates(&self, before: HalfAngle<T>) -> Self {
        let number = T::from_f64;
        let parts = self.parts();
        let part_rates = parts.rates_by_y();
        // A ψ; ψ after the boost; the angle by which a change of ψ after the boost turns it.
        let a = self.path.map(|path| path * parts.flexibility);
        let [c, s] = before.psi;
        let image = [a[0] * c + a[1] * s, a[1] * c - a[0] * s];
        let boosted = [
            parts.even * c + parts.odd * image[0],
            parts.even * s + parts.odd * image[1],
        ];
        let inverse = T::ONE / dot(boosted, boosted);
        let turned = |x: T, y: T| (inverse + inverse) * (boosted[0] * y - boosted[1] * x);

        // The chain rule: from the angle back over the turn and the boost to the step.
        let by_turn = number(2.0) / (T::ONE + parts.turn * parts.turn);
        let by_share = by_turn * parts.inverse_of_squares;
        let by_cross = by_share * parts.weight;
        let by_squares = -(by_cross * parts.cross * parts.inverse_of_squares);
        let twice = by_squares + by_squares;
        let by_y = part_rates.even * turned(c, s)
            + part_rates.odd * turned(image[0], image[1])
            + by_share * part_rates.weight * parts.cross;
        let by_a = [parts.odd * turned(c, -s), parts.odd * turned(s, c)];

        let (ahead, flexibility) = (parts.ahead, parts.flexibility);
        let inverse_distance = if parts.distance > T::ZERO {
            T::ONE / parts.distance
        } else {
            T::ZERO
        };
        let unit = self.path.map(|path| path * inverse_distance);
        let mut path = [
            flexibility * (by_a[0] + by_y * unit[0]) + by_cross * ahead[1] + twice * self.path[0],
            flexibility * (by_a[1] + by_y * unit[1]) - by_cross * ahead[0] + twice * self.path[1],
        ];
        let mut limit =
            twice * T::EPSILON * parts.limit - flexibility * (by_y * parts.y + dot(by_a, a));
        if parts.limit > self.limit {
            let share = number(1.0 / LONGEST) * limit;
            path = [path[0] + share * unit[0], path[1] + share * unit[1]];
            limit = T::ZERO;
        }
        let by_ahead = [
            twice * ahead[0] - by_cross * self.path[1],
            twice * ahead[1] + by_cross * self.path[0],
        ];
        Self {
            path,
            rate: by_ahead.map(|x| x * self.length),
            limit,
            length: dot(by_ahead, self.rate),
        }
    }
}

/// The direction of the traction.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct HalfAngle<T> {
    /// ψ.
    psi: [T; 2],
    /// The unit vector e.
    pub e: [T; 2],
}

impl<T: Real> HalfAngle<T> {
    /// Of the unit vector `e`.
    #[inline(always)]
    pub(in crate::aft) fn of(e: [T; 2]) -> Self {
        let psi = if e[0] > T::ZERO {
            [T::ONE + e[0], e[1]]
        } else {
            [e[1], T::ONE - e[0]]
        };
        Self { psi, e }
    }

    /// After a step.
    #[inline(always)]
    pub(in crate::aft) fn after(self, map: [T; 4]) -> Self {
        let [c, s] = self.psi;
        let [c, s] = [map[0] * c + map[1] * s, map[2] * c + map[3] * s];
        let inverse = T::ONE / (c * c + s * s);
        Self {
            psi: [c, s],
            e: [(c * c - s * s) * inverse, (c * s + c * s) * inverse],
        }
    }

    /// Derivative of the angle after a step by that before it.
    #[inline(always)]
    pub(in crate::aft) fn angle_rate(self, map: [T; 4], after: Self) -> T {
        let determinant = map[0] * map[3] - map[1] * map[2];
        determinant * dot(self.psi, self.psi) / dot(after.psi, after.psi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step of s from `start` at the velocity `rate` and with the curvature `bend`, from the direction `angle`.
    fn angle_after(
        angle: f64,
        rate: [f64; 2],
        bend: [f64; 2],
        limit: [f64; 2],
        length: f64,
    ) -> f64 {
        let step = SlipStep {
            path: [0, 1].map(|d| length * (rate[d] + 0.5 * length * bend[d])),
            rate: [0, 1].map(|d| rate[d] + length * bend[d]),
            limit: 0.5 * (limit[0] + limit[1]),
            length,
        };
        let before = HalfAngle::of([angle.cos(), angle.sin()]);
        let [x, y] = before.after(step.map()).e;
        y.atan2(x)
    }

    /// The same by many steps of the explicit midpoint rule for φ' = (s₂' cos φ − s₁' sin φ)/L.
    fn angle_marched(
        angle: f64,
        rate: [f64; 2],
        bend: [f64; 2],
        limit: [f64; 2],
        length: f64,
    ) -> f64 {
        const STEPS: usize = 20_000;
        let h = length / STEPS as f64;
        let slope = |phi: f64, t: f64| {
            let v = [0, 1].map(|d| rate[d] + t * bend[d]);
            (v[1] * phi.cos() - v[0] * phi.sin()) / (limit[0] + (limit[1] - limit[0]) * t / length)
        };
        (0..STEPS).fold(angle, |phi, i| {
            let t = i as f64 * h;
            phi + h * slope(phi + 0.5 * h * slope(phi, t), t + 0.5 * h)
        })
    }

    /// Short steps have an error of third order, long ones come to the slow lag behind the velocity. Seen to fail
    /// without the turn after the boost.
    #[test]
    fn a_step_follows_the_marched_direction() {
        let (rate, bend, limit) = ([1.0, 0.3], [-0.8, 1.1], [0.4, 0.5]);
        let error = |length: f64| {
            let limit = [limit[0], limit[0] + (limit[1] - limit[0]) * length];
            (angle_after(1.2, rate, bend, limit, length)
                - angle_marched(1.2, rate, bend, limit, length))
            .abs()
        };
        let order = (error(0.2) / error(0.05)).ln() / 4f64.ln();
        assert!((2.7..3.5).contains(&order), "order {order}");
        assert!(error(0.05) < 1e-5, "{:e}", error(0.05));
        for limit in [[0.01, 0.01], [0.002, 0.003]] {
            let found = angle_after(1.2, rate, bend, limit, 0.05);
            let exact = angle_marched(1.2, rate, bend, limit, 0.05);
            assert!((found - exact).abs() < 5e-3, "{limit:?}: {found} {exact}");
        }
    }

    /// Of a short step, one in which y is not small, and the longest. Seen to fail without the derivative of the
    /// squares by the path.
    #[test]
    fn derivatives_of_a_step_agree_with_differences() {
        for limit in [0.1, 0.01, 2e-5] {
            let inputs = [0.03, -0.02, 0.9, -0.3, limit, 0.05, 0.7];
            let step = |x: [f64; 7]| SlipStep {
                path: [x[0], x[1]],
                rate: [x[2], x[3]],
                limit: x[4],
                length: x[5],
            };
            let before = |x: [f64; 7]| HalfAngle::of([x[6].cos(), x[6].sin()]);
            let angle = |x: [f64; 7]| {
                let e = before(x).after(step(x).map()).e;
                e[1].atan2(e[0])
            };
            let start = before(inputs);
            let turned = start.angle_rate(step(inputs).map(), start.after(step(inputs).map()));
            let by = step(inputs).angle_rates(start);
            let by = [
                by.path[0], by.path[1], by.rate[0], by.rate[1], by.limit, by.length, turned,
            ];
            for (i, by) in by.into_iter().enumerate() {
                let moved = [-1e-5, 1e-5].map(|h| {
                    let mut x = inputs;
                    x[i] += h * x[i];
                    angle(x)
                });
                let slope = (moved[1] - moved[0]) / (2e-5 * inputs[i]);
                assert!(
                    (slope - by).abs() < 1e-6 * by.abs().max(1.0),
                    "limit {limit}, input {i}: {slope} {by}"
                );
            }
        }
    }
}
