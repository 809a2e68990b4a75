//! The modes of a blade in time.
//!
//! Between two steps the force on a mode is a line, and the mode's motion under it is written down exactly: frequency and damping are those
//! of the mode at any step, where a method of differences would shift a resonance as narrow as the blade's.

use super::blade::Blade;

/// What a step of one mode is made of.
#[derive(Debug, Clone, Copy)]
struct ModeStep {
    /// [displacement, velocity] from those of the last step.
    kept: [[f64; 2]; 2],
    /// Both by the force at the last step...
    by_last: [f64; 2],
    /// ...and by that at this one.
    by_next: [f64; 2],
}

impl ModeStep {
    /// A step of the length `h` (s) of a mode of the angular frequency `omega` (rad/s) with the damping ratio `zeta` below 1:
    /// η̈ + 2ζω η̇ + ω² η = f.
    fn new(omega: f64, zeta: f64, h: f64) -> Self {
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let decay = libm::exp(-zeta * omega * h);
        let (sine, cosine) = (libm::sin(damped * h), libm::cos(damped * h));
        let lag = zeta * omega / damped * sine;
        let velocity = decay * sine / damped;
        let kept = [
            [decay * (cosine + lag), velocity],
            [-omega * omega * velocity, decay * (cosine - lag)],
        ];
        // under f = a + b t the mode follows α + β t, β = b/ω², α = (a − 2ζω β)/ω²; the rest of it decays freely
        let line = |alpha: f64, beta: f64| {
            let free = |row: [f64; 2]| row[0] * alpha + row[1] * beta;
            [alpha + beta * h - free(kept[0]), beta - free(kept[1])]
        };
        let square = omega * omega;
        let beta = 1.0 / (h * square);
        let lag = 2.0 * zeta * beta / omega;
        Self {
            kept,
            by_last: line(1.0 / square + lag, -beta),
            by_next: line(-lag, beta),
        }
    }
}

/// State of a mode during the march.
#[derive(Debug, Clone, Copy)]
struct Moving {
    step: ModeStep,
    /// Displacement and velocity.
    state: [f64; 2],
    /// Force at the last step.
    force: f64,
}

/// State of the blade during the march from rest.
#[derive(Debug)]
pub(super) struct BladeMarch<'a> {
    blade: &'a Blade,
    moving: Vec<Moving>,
    /// Displacement of the platform by a unit force on it within a step (m/N).
    pub(super) flexibility: f64,
}

impl<'a> BladeMarch<'a> {
    /// With steps of the length `h` (s).
    pub(super) fn new(blade: &'a Blade, h: f64) -> Self {
        let moving: Vec<Moving> = (blade.modes.iter())
            .map(|mode| Moving {
                step: ModeStep::new(mode.omega, blade.damping_ratio, h),
                state: [0.0; 2],
                force: 0.0,
            })
            .collect();
        let modes = blade.modes.iter().zip(&moving);
        let of_step = modes.map(|(mode, moving)| mode.platform.powi(2) * moving.step.by_next[0]);
        Self {
            blade,
            flexibility: blade.at_rest[1] + of_step.sum::<f64>(),
            moving,
        }
    }

    /// Goes one step on under the force `force` (N) of the excitation, without traction; the platform's displacement (m).
    pub(super) fn without_traction(&mut self, force: f64) -> f64 {
        let mut platform = self.blade.at_rest[0] * force;
        for (mode, moving) in self.blade.modes.iter().zip(&mut self.moving) {
            let (step, [q, v]) = (moving.step, moving.state);
            let next = mode.excited * force;
            moving.state = [0, 1].map(|row| {
                let [by_q, by_v] = step.kept[row];
                by_q * q + by_v * v + step.by_last[row] * moving.force + step.by_next[row] * next
            });
            moving.force = next;
            platform += mode.platform * moving.state[0];
        }
        platform
    }

    /// Adds the traction (N) of this step, which acts against the platform's displacement.
    pub(super) fn add_traction(&mut self, traction: f64) {
        for (mode, moving) in self.blade.modes.iter().zip(&mut self.moving) {
            let force = mode.platform * traction;
            moving.force -= force;
            for (state, by_next) in moving.state.iter_mut().zip(moving.step.by_next) {
                *state -= by_next * force;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under a force that is a line the mode is where the closed form of its motion from rest says, at steps of any length.
    ///
    /// Seen to fail with the forces of both ends exchanged.
    #[test]
    fn a_line_is_followed_exactly() {
        let (omega, zeta, slope): (f64, f64, f64) = (50.0, 0.02, 3.0);
        for n in [1, 7, 400] {
            let h = 0.4 / f64::from(n);
            let step = ModeStep::new(omega, zeta, h);
            let mut state = [0.0; 2];
            for k in 0..n {
                let forces = [f64::from(k), f64::from(k + 1)].map(|k| slope * h * k);
                let of = |row: usize| {
                    step.kept[row][0] * state[0]
                        + step.kept[row][1] * state[1]
                        + step.by_last[row] * forces[0]
                        + step.by_next[row] * forces[1]
                };
                state = [of(0), of(1)];
            }
            // from rest under b t: b/ω² (t − 2ζ/ω + e^(−ζωt) (2ζ/ω cos ω_d t + (2ζ² − 1)/ω_d sin ω_d t))
            let (t, damped) = (0.4, omega * (1.0 - zeta * zeta).sqrt());
            let free = 2.0 * zeta / omega * libm::cos(damped * t)
                + (2.0 * zeta * zeta - 1.0) / damped * libm::sin(damped * t);
            let expected = slope / omega.powi(2)
                * (t - 2.0 * zeta / omega + libm::exp(-zeta * omega * t) * free);
            assert!(
                (state[0] / expected - 1.0).abs() < 1e-9,
                "{n} steps: {} {expected}",
                state[0]
            );
        }
    }
}
