//! Error alert: how much would the harmonics left out change the amplitude?
//!
//! The solution is padded with zeros onto an enlarged harmonic set and corrected by one Newton step there. This is
//! the role of the Jacobian Alert Algorithm of Gastaldi & Berruti 2017: an estimate below about 10 %, an alarm above.
//! With lift-off it can be too low: of peaks that it put below 0.1 % one in five changed by more on 31 harmonics, at
//! most by 0.5 % (`cargo bench --bench peaks -- certified`).

use super::balance::Balance;
use super::newton::{Condition, Iterate, Point, newton_step};
use crate::aft::AftSettings;
use crate::harmonics::HarmonicSet;

/// The next larger set that is tried: about 1.6 times the highest harmonic, without gaps.
#[must_use]
pub fn enlarged(harmonics: &HarmonicSet, cap: Option<usize>) -> HarmonicSet {
    let highest = harmonics.highest();
    let next = (highest + (highest * 3).div_ceil(5)).max(highest + 2);
    HarmonicSet::up_to(cap.map_or(next, |cap| next.min(cap)))
}

/// Time points that keep the sampling error of `harmonics` below the truncation error: at least 12 per period of the
/// highest harmonic, and never fewer than asked for.
#[must_use]
pub fn time_points(aft: AftSettings, harmonics: &HarmonicSet) -> AftSettings {
    let wanted = (12 * harmonics.highest()).next_power_of_two();
    AftSettings {
        n_time: aft.n_time.max(wanted),
        ..aft
    }
}

/// Relative change of |ŷ| by one Newton step on `larger`, under `condition`.
#[must_use]
pub fn truncation_error(
    balance: &Balance<'_>,
    solution: &Iterate<'_>,
    larger: &Balance<'_>,
    condition: Condition<'_>,
) -> f64 {
    let amplitude = solution.response(balance).norm();
    let padded = pad(balance, &solution.point, larger);
    let iterate = Iterate::new(larger, padded);
    let jacobian = iterate.jacobian(larger);
    let step = newton_step(larger, &iterate, &jacobian, condition);
    let rate = iterate.response_rate(larger, &jacobian, &step, 0.0);
    let corrected = (iterate.response(larger) + rate).norm();
    (corrected - amplitude).abs() / amplitude
}

/// The same motion on another harmonic set.
#[must_use]
pub fn pad(from: &Balance<'_>, point: &Point, to: &Balance<'_>) -> Point {
    Point {
        r: from
            .harmonics
            .convert(&point.r, from.layout.n_relative(), &to.harmonics),
        omega: point.omega,
        level: point.level,
    }
}
