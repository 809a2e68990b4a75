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
/// displacement of the sample before, and is anchored at w + θ (u − w). θ = 0 changes nothing. In m or in N.
#[inline(always)]
#[must_use]
pub fn anchored_at_closing<T: Real>(slider: T, displacement: T, instant: T) -> T {
    slider + instant * (displacement - slider)
}

/// Traction T = clip(s − z, −L, L) and slider z of one direction under its own limit L = mu N, all in N: s = k_t u is
/// the path of the surface and z = k_t w.
#[inline(always)]
#[must_use]
pub fn box_step<T: Real>(limit: T, path: T, slider: T) -> (T, T) {
    (
        clip(path - slider, -limit, limit),
        box_slider(limit, path, slider),
    )
}

/// Slider of [`box_step`] alone.
///
/// It is a play: pushed by the bounds s ∓ L, so that the next step waits for two comparisons only. Rounding is monotone,
/// so a slider that moves leaves |T| = L exactly.
#[inline(always)]
#[must_use]
pub fn box_slider<T: Real>(limit: T, path: T, slider: T) -> T {
    clip(slider, path - limit, path + limit)
}

#[inline(always)]
fn clip<T: Real>(x: T, lower: T, upper: T) -> T {
    let above = if lower > x { lower } else { x };
    if upper < above { upper } else { above }
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
    limit: T,
    margin: T,
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
