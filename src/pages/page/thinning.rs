//! As many points as a panel can show.

/// Dots per level and panel; more are thinned evenly.
const MAX_DOTS: usize = 1500;

/// At most so many points as a panel can show.
pub fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let stride = points.len().div_ceil(MAX_DOTS).max(1);
    points.into_iter().step_by(stride).collect()
}
