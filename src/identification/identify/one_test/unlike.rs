//! How far the loops of a test, and both sides of its loop, differ from each other.

use crate::identify::found::result::{LoopResult, LoopScatter};
use crate::identify::found::uncertain::Uncertain;

/// Difference of the stiffness after both reversals, over their mean, from which on they are told apart.
const SIDES_APART: f64 = 0.2;

/// The larger stiffness of both sides over the smaller one, less 1; absent where they are as alike as a contact's are, or as their errors
/// leave them.
pub(super) fn sides_apart(sides: &[Option<Uncertain>; 2]) -> Option<f64> {
    let [Some(a), Some(b)] = sides else {
        return None;
    };
    let difference = (a.value - b.value).abs();
    let error = a.standard_error.hypot(b.standard_error);
    let apart = difference > SIDES_APART * 0.5 * (a.value + b.value) && difference > 2.0 * error;
    apart.then(|| difference / a.value.min(b.value))
}

/// Scatter of the loops that are steady.
pub(super) fn scatter_of(loops: &[LoopResult]) -> LoopScatter {
    let of = |number: &dyn Fn(&LoopResult) -> Option<f64>| {
        let steady = loops.iter().filter(|one| one.steady);
        relative_deviation(&steady.filter_map(number).collect::<Vec<f64>>())
    };
    LoopScatter {
        friction_coefficient: of(&|one| Some(one.friction_coefficient?.value)),
        tangential_stiffness: of(&|one| {
            let [a, b] = one.tangential_stiffness_n_per_um;
            Some(0.5 * (a?.value + b?.value))
        }),
        energy: of(&|one| Some(one.energy_j)),
    }
}

/// Standard deviation over the mean.
fn relative_deviation(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    Some((square / (n - 1.0)).sqrt() / mean.abs()).filter(|share| share.is_finite())
}
