//! A point in the space of unknowns, and directions between points.

use crate::hb::equations::balance::Balance;

/// A point in the space of unknowns, frequency and level.
#[derive(Debug, Clone)]
pub struct Point {
    /// Relative displacements (m), order of [`crate::hb::equations::layout::Layout`].
    pub r: Vec<f64>,
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Excitation level.
    pub level: f64,
}

impl Point {
    /// Solution of the fully stuck structure at the frequency `omega` (rad/s).
    #[must_use]
    pub fn stuck(balance: &Balance<'_>, omega: f64, level: f64) -> Self {
        let at = balance.compliance(omega);
        let zero = vec![0.0; balance.layout.n_unknowns()];
        let force = zero.clone();
        let motion = balance.motion(&at, level, &zero, &force);
        let residual = balance.residual(&motion, &zero, &force);
        Self {
            r: residual.iter().map(|r| -r).collect(),
            omega,
            level,
        }
    }

    /// The point after a step of `length` along `direction`, at the same level.
    #[must_use]
    pub fn moved(&self, direction: &Direction, length: f64) -> Self {
        Self {
            r: (self.r.iter().zip(&direction.r))
                .map(|(r, d)| r + length * d)
                .collect(),
            omega: self.omega + length * direction.omega,
            level: self.level,
        }
    }

    /// The point with the frequency `omega` (rad/s) on the straight line to `other`, or beyond it; at the level of this point.
    #[must_use]
    pub(crate) fn at_frequency(&self, other: &Self, omega: f64) -> Self {
        let line = Direction::between(self, other);
        let share = (omega - self.omega) / line.omega;
        Self {
            omega,
            ..self.moved(&line, share)
        }
    }

    /// The same motion on the harmonics of another balance.
    #[must_use]
    pub fn padded(&self, from: &Balance<'_>, to: &Balance<'_>) -> Self {
        let n_relative = from.layout.n_relative();
        Self {
            r: from.harmonics.convert(&self.r, n_relative, &to.harmonics),
            omega: self.omega,
            level: self.level,
        }
    }

    /// Largest change of a dynamic displacement by a step over the largest dynamic displacement.
    #[must_use]
    pub(crate) fn relative_step(&self, balance: &Balance<'_>, step: &Direction) -> f64 {
        let n = balance.layout.n_relative();
        let [moved, largest] =
            [&step.r, &self.r].map(|x| x[n..].iter().map(|x| x.abs()).fold(0.0, f64::max));
        match step.r.iter().all(|x| x.is_finite()) {
            true => moved / largest,
            false => f64::NAN,
        }
    }

    /// Largest dynamic displacement over the scale of the residual: a small excitation moves the contacts little
    /// compared with what the static load does.
    #[must_use]
    pub(crate) fn dynamic_share(&self, balance: &Balance<'_>) -> f64 {
        let dynamic = &self.r[balance.layout.n_relative()..];
        let largest = dynamic.iter().map(|r| r.abs()).fold(0.0, f64::max);
        largest / balance.problem.displacement_scale(self.level)
    }
}

/// Rate of change of a point along a path.
#[derive(Debug, Clone)]
pub struct Direction {
    /// Rate of the relative displacements.
    pub r: Vec<f64>,
    /// Rate of the frequency.
    pub omega: f64,
}

impl Direction {
    /// From one point to another.
    #[must_use]
    pub fn between(from: &Point, to: &Point) -> Self {
        Self {
            r: (to.r.iter().zip(&from.r))
                .map(|(to, from)| to - from)
                .collect(),
            omega: to.omega - from.omega,
        }
    }

    /// `factor` times this direction.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            r: self.r.iter().map(|r| factor * r).collect(),
            omega: factor * self.omega,
        }
    }
}

/// Inner product of directions. The 0th harmonic is left out: the mean position of a strip is so soft that it would
/// swallow every step.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// Weight of the dynamic displacements (1/m²).
    pub displacement: f64,
    /// Weight of the frequency (s²/rad²).
    pub frequency: f64,
    /// Number of relative displacements, which are the entries of the 0th harmonic.
    n_relative: usize,
}

impl Metric {
    /// Relative to the dynamic displacements at `point` and to `omega_scale` (rad/s).
    #[must_use]
    pub fn at(balance: &Balance<'_>, point: &Point, omega_scale: f64) -> Self {
        let n = balance.layout.n_relative();
        let size: f64 = point.r[n..].iter().map(|r| r * r).sum();
        let floor = balance.problem.displacement_scale(point.level) * 1e-6;
        Self {
            displacement: 1.0 / size.max(floor * floor),
            frequency: 1.0 / (omega_scale * omega_scale),
            n_relative: n,
        }
    }

    /// Change of frequency that counts as much as a relative change of 1 of the displacements (rad/s).
    #[must_use]
    pub(crate) fn omega_scale(&self) -> f64 {
        self.frequency.sqrt().recip()
    }

    /// ⟨a, b⟩.
    #[must_use]
    pub fn dot(&self, a: &Direction, b: &Direction) -> f64 {
        let [a_r, b_r] = [a, b].map(|direction| &direction.r[self.n_relative..]);
        let r: f64 = a_r.iter().zip(b_r).map(|(a, b)| a * b).sum();
        self.displacement * r + self.frequency * a.omega * b.omega
    }

    /// Length √⟨a, a⟩.
    #[must_use]
    pub fn length(&self, a: &Direction) -> f64 {
        self.dot(a, a).sqrt()
    }
}
