//! One step of the node-to-node contact law with variable normal load.
//!
//! The law of Yang, Chu and Menq (J. Sound Vib. 210, 1998) and Petrov and Ewins (J. Turbomach. 125, 2003): a
//! unilateral normal spring, and per tangential direction a spring in series with a Coulomb slider. Every function is
//! free of branches that depend on numbers, so that a loop over independent states becomes vector code.

use super::Real;

/// Normal force N = max(0, g) of the gap function g = n_0 + k_n v (N); not-a-number passes through.
#[inline(always)]
#[must_use]
pub fn normal_force<T: Real>(gap: T) -> T {
    T::ZERO.or_larger(gap)
}

/// Instant of closing θ ∈ [0, 1) between two samples with gap functions g₋ ≤ 0 < g, by linear interpolation:
/// θ = g₋/(g₋ − g); 0 if the contact does not close between them.
#[inline(always)]
#[must_use]
pub fn closing_instant<T: Real>(gap_before: T, gap: T) -> T {
    if gap_before <= T::ZERO && gap > T::ZERO {
        gap_before / (gap_before - gap)
    } else {
        T::ZERO
    }
}

/// Slider position after closing at the instant θ: a separated slider follows the surface, so it stood at the
/// displacement of the sample before, and is anchored at w + θ (u − w). θ = 0 changes nothing.
#[inline(always)]
#[must_use]
pub fn anchored_at_closing<T: Real>(slider: T, displacement: T, instant: T) -> T {
    slider + instant * (displacement - slider)
}

/// Traction (N) and slider position (m) of one direction under its own limit L = mu N: T = clip(k_t (u − w), −L, L).
///
/// `flexibility` is 1/k_t, or 0 for an absent spring. L = 0 gives T = 0 and a slider that follows.
#[inline(always)]
#[must_use]
pub fn box_step<T: Real>(k_t: T, flexibility: T, limit: T, u: T, slider: T) -> (T, T) {
    let trial = k_t * (u - slider);
    let below = if trial > limit { limit } else { trial };
    let traction = if below < -limit { -limit } else { below };
    let moved = u - traction * flexibility;
    let slider = if traction == trial { slider } else { moved };
    (traction, slider)
}

/// What one step of the coupled law gives.
#[derive(Debug, Clone, Copy)]
pub struct CircleStep<T> {
    /// Traction (N).
    pub traction: [T; 2],
    /// Slider position (m).
    pub slider: [T; 2],
    /// Predicted traction T* = k_t (u − w) (N).
    pub trial: [T; 2],
    /// L/|T*| where the contact slips, else 1.
    pub ratio: T,
    /// Whether it slips: |T*| > L.
    pub slips: bool,
    /// Whether it slips or touches the limit to within `margin`: the slider is then tied to this instant, and
    /// derivatives take it as slipping, whichever way a rounding error falls.
    pub touches: bool,
}

/// Radial return of both directions to the disc of radius L = mu N; the sliders follow as w = u − T/k_t.
///
/// `margin` (N) covers the rounding errors of T*; they grow with k_t u, not with L, since u − w cancels.
#[inline(always)]
#[must_use]
pub fn circle_step<T: Real>(
    k_t: [T; 2],
    flexibility: [T; 2],
    (limit, margin): (T, T),
    u: [T; 2],
    slider: [T; 2],
) -> CircleStep<T> {
    let trial = [k_t[0] * (u[0] - slider[0]), k_t[1] * (u[1] - slider[1])];
    let square = trial[0] * trial[0] + trial[1] * trial[1];
    let slips = square > limit * limit;
    let inside = T::ZERO.or_larger(limit - margin);
    let touches = square > inside * inside;
    let returned = limit / square.sqrt();
    let ratio = if slips { returned } else { T::ONE };
    let traction = [ratio * trial[0], ratio * trial[1]];
    let moved = [
        u[0] - traction[0] * flexibility[0],
        u[1] - traction[1] * flexibility[1],
    ];
    CircleStep {
        traction,
        slider: [
            if slips { moved[0] } else { slider[0] },
            if slips { moved[1] } else { slider[1] },
        ],
        trial,
        ratio,
        slips,
        touches,
    }
}
