//! The loop of an elastic-Coulomb contact, and how far a measured one is from it.

use crate::identify::cycles::mean_loop::{MeanLoop, median, swing};
use crate::identify::found::result::Misfit;

/// Misfit above which a contact is not elastic-Coulomb.
const LARGE: f64 = 0.05;

/// Tangential force (N) of a spring of this stiffness (N/m) in series with a Coulomb slider of this friction coefficient, over the
/// motion and normal force of a loop in its steady cycle. Without a coefficient it sticks.
pub(in crate::identify) fn elastic_coulomb(
    cycle: &MeanLoop,
    stiffness: f64,
    friction: Option<f64>,
) -> Vec<f64> {
    let n = cycle.samples();
    let (mut force, mut column) = (0.0, vec![0.0; n]);
    // one lap from any start reaches the steady cycle, if the contact slips at all
    for i in 0..2 * n {
        let (now, before) = (i % n, (i + n - 1) % n);
        force += stiffness * (cycle.displacement[now] - cycle.displacement[before]);
        if let Some(friction) = friction {
            let limit = (friction * cycle.normal[now]).max(0.0);
            force = force.clamp(-limit, limit);
        }
        column[now] = force;
    }
    column
}

/// Difference of a fitted loop from a measured one, less its median offset, and the misfit that it makes.
pub(in crate::identify) fn misfit(measured: &[f64], fitted: &mut [f64]) -> (Vec<f64>, Misfit) {
    let rest =
        |fitted: &[f64]| -> Vec<f64> { measured.iter().zip(fitted).map(|(a, b)| a - b).collect() };
    let offset = median(&mut rest(fitted)).unwrap_or(0.0);
    fitted.iter_mut().for_each(|force| *force += offset);
    let rest = rest(fitted);
    let square = rest.iter().map(|r| r * r).sum::<f64>() / rest.len() as f64;
    let relative_rms = square.sqrt() / swing(measured);
    (
        rest,
        Misfit {
            relative_rms,
            large: relative_rms > LARGE,
        },
    )
}
