//! The forced response between two solutions: cubics of frequency and dynamic stiffness, their error, their points.

use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::structure::resonance::Band;
use faer::prelude::c64;

/// If the slopes dω/dt at the ends of a segment, over that of its chord, are in this range, the parameter is ω.
const STRAIGHT: std::ops::Range<f64> = 0.1..10.0;
/// Scaled distance between two points of the curve.
const SPACING: f64 = 0.04;
/// Points per segment at most.
const MOST_POINTS: f64 = 24.0;

/// Scales of the frequency and of the complex response.
#[derive(Debug, Clone, Copy)]
pub(super) struct ComplexScales {
    /// Half-power half-width of an oscillator with the phase rate of the peak (rad/s), no more than the band.
    pub(super) width: f64,
    height: f64,
}

impl ComplexScales {
    pub(super) fn of(peak: &BranchPoint<'_>, band: Band) -> Self {
        let half_width = (peak.tangent.omega / peak.phase_rate()).abs();
        Self {
            width: half_width.min(band.width()),
            height: peak.response.norm(),
        }
    }

    /// Scaled frequency, real and imaginary part of the response.
    fn place(&self, omega: f64, response: c64) -> [f64; 3] {
        [
            omega / self.width,
            response.re / self.height,
            response.im / self.height,
        ]
    }

    /// Distance of a place from the tangent at `point`: differences along the curve do not count.
    fn distance(&self, omega: f64, response: c64, point: &BranchPoint<'_>) -> f64 {
        let omega = omega - point.iterate.point.omega;
        let away = self.place(omega, response - point.response);
        let along = self.place(point.tangent.omega, point.response_rate);
        let share = dot(away, along) / dot(along, along);
        let normal: [f64; 3] = std::array::from_fn(|i| away[i] - share * along[i]);
        dot(normal, normal).sqrt()
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The cubics between two solutions, over a parameter that runs from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct CubicSegment {
    omega: [f64; 2],
    omega_rate: [f64; 2],
    stiffness: [c64; 2],
    stiffness_rate: [c64; 2],
    /// Arclength in the metric of the start, and in that of the end.
    pub(super) length: f64,
    length_at_end: f64,
    /// Whether the parameter is the frequency, not the arclength.
    by_frequency: bool,
}

impl CubicSegment {
    pub(super) fn new(from: &BranchPoint<'_>, to: &BranchPoint<'_>, length: f64) -> Self {
        // each tangent has unit length in the metric of its own point; both rates must be per the same arclength
        let length_at_end = from.length_at(to, length);
        let rate = |p: &BranchPoint<'_>, length: f64| {
            -p.response_rate / (p.response * p.response) * length
        };
        Self {
            omega: [from.iterate.point.omega, to.iterate.point.omega],
            omega_rate: [
                from.tangent.omega * length,
                to.tangent.omega * length_at_end,
            ],
            stiffness: [from.response.inv(), to.response.inv()],
            stiffness_rate: [rate(from, length), rate(to, length_at_end)],
            length,
            length_at_end,
            by_frequency: false,
        }
        .straightened()
    }

    /// The segment between two solutions of a branch without folds, with the frequency as its parameter.
    pub(super) fn over_frequency(from: &BranchPoint<'_>, to: &BranchPoint<'_>) -> Self {
        let omega = [from, to].map(|p| p.iterate.point.omega);
        let chord = omega[1] - omega[0];
        let rate = |p: &BranchPoint<'_>| {
            -p.response_rate / (p.response * p.response) * (chord / p.tangent.omega)
        };
        Self {
            omega,
            omega_rate: [chord; 2],
            stiffness: [from.response.inv(), to.response.inv()],
            stiffness_rate: [rate(from), rate(to)],
            length: 1.0,
            length_at_end: 1.0,
            by_frequency: true,
        }
    }

    /// The same segment with the frequency as its parameter, unless it has or nearly has a fold.
    fn straightened(mut self) -> Self {
        let chord = self.omega[1] - self.omega[0];
        if self
            .omega_rate
            .iter()
            .all(|rate| STRAIGHT.contains(&(rate / chord)))
        {
            for i in 0..2 {
                self.stiffness_rate[i] *= chord / self.omega_rate[i];
                self.omega_rate[i] = chord;
            }
            self.by_frequency = true;
        }
        self
    }

    /// The same segment in the opposite direction.
    pub(super) fn reversed(self) -> Self {
        let swap = |[a, b]: [f64; 2]| [b, a];
        let [a, b] = self.stiffness_rate;
        Self {
            omega: swap(self.omega),
            omega_rate: swap(self.omega_rate).map(|r| -r),
            stiffness: [self.stiffness[1], self.stiffness[0]],
            stiffness_rate: [-b, -a],
            length: self.length_at_end,
            length_at_end: self.length,
            by_frequency: self.by_frequency,
        }
    }

    /// Frequency and response at the parameter `t`, in or beyond [0, 1].
    fn at(&self, t: f64) -> (f64, c64) {
        let u = 1.0 - t;
        let value = [u * u * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t)];
        let slope = [t * u * u, -t * t * u];
        let omega = (0..2).map(|i| self.omega[i] * value[i] + self.omega_rate[i] * slope[i]);
        let stiffness = (0..2)
            .map(|i| self.stiffness[i] * value[i] + self.stiffness_rate[i] * slope[i])
            .sum::<c64>();
        (omega.sum(), stiffness.inv())
    }

    /// Largest error of the cubics on the segment, from their distance to the solution `next`, which lies `length` beyond its
    /// end. The error is taken to vary as t²(1 − t)², which is 1/16 in the middle.
    pub(super) fn error(&self, scales: &ComplexScales, length: f64, next: &BranchPoint<'_>) -> f64 {
        let t = match self.by_frequency {
            true => (next.iterate.point.omega - self.omega[0]) / (self.omega[1] - self.omega[0]),
            false => 1.0 + length / self.length_at_end,
        };
        let (omega, response) = self.at(t);
        let missed = scales.distance(omega, response, next);
        missed / (16.0 * (t * (t - 1.0)).powi(2))
    }

    /// Frequencies and responses at even parameters in (0, 1], close together after scaling.
    pub(super) fn points(&self, scales: &ComplexScales) -> impl Iterator<Item = (f64, c64)> {
        let [a, b] = [0, 1].map(|i| scales.place(self.omega[i], self.stiffness[i].inv()));
        let chord: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let n = (dot(chord, chord).sqrt() / SPACING).ceil();
        let n = n.clamp(2.0, MOST_POINTS);
        (1..=n as usize).map(move |i| self.at(i as f64 / n))
    }
}
