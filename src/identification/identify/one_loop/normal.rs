//! Normal stiffness: normal force over approach.

use super::slope::{Line, pairwise_line};
use crate::identify::cycles::mean_loop::{MeanLoop, extremes, smooth};

/// Share of the variance of the approach that its lowest harmonics must hold; below it there is noise alone.
const MOTION: f64 = 0.5;
/// Part of the swing of the approach at each end that is left out: there pairs of samples are close together.
const ENDS: f64 = 0.1;

/// The line of the normal force over the approach, mean of loading and unloading; none where the approach was not measured, or is noise.
pub(super) fn normal_line(cycle: &MeanLoop) -> Option<Line> {
    let approach = cycle.approach.as_deref()?;
    let motion = smooth(approach);
    let mean = motion.iter().sum::<f64>() / motion.len() as f64;
    let square = |values: &[f64]| values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    if square(&motion) < MOTION * square(approach) || square(&motion) <= 0.0 {
        return None;
    }
    let n = motion.len();
    let [bottom, top] = extremes(&motion)?;
    let [low, high] = [motion[bottom], motion[top]];
    let inside = |i: &usize| {
        let share = (motion[*i] - low) / (high - low);
        (ENDS..=1.0 - ENDS).contains(&share) && cycle.normal[*i] > 0.0
    };
    let half_line = |from: usize, to: usize, turned: bool| {
        let count = (to + n - from) % n;
        let mut places: Vec<usize> = (0..=count).map(|k| (from + k) % n).filter(inside).collect();
        if turned {
            places.reverse();
        }
        let x: Vec<f64> = places.iter().map(|i| approach[*i]).collect();
        let y: Vec<f64> = places.iter().map(|i| cycle.normal[*i]).collect();
        pairwise_line(&x, &y)
    };
    let (rise, fall) = (
        half_line(bottom, top, false)?,
        half_line(top, bottom, true)?,
    );
    let error = rise.standard_error.zip(fall.standard_error);
    Some(Line {
        slope: 0.5 * (rise.slope + fall.slope),
        intercept: 0.5 * (rise.intercept + fall.intercept),
        deviation: rise.deviation.max(fall.deviation),
        standard_error: error.map(|(a, b)| 0.5 * a.hypot(b)),
        model_error: 0.0,
    })
}
