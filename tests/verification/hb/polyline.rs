//! Distances in the plane of frequency and amplitude.

use microslip::hb::Solution;

/// Half of the frequencies around the peak at which the amplitude exceeds 0.7 of it.
pub(super) fn half_width(dense: &[Solution], top: f64) -> f64 {
    let high = dense.iter().filter(|s| s.amplitude(0) > 0.7 * top);
    let (low, high) = high.fold((f64::INFINITY, 0.0f64), |(l, h), s| {
        (l.min(s.omega), h.max(s.omega))
    });
    0.5 * (high - low)
}

/// Solutions as points: frequency over `width`, amplitude over `height`.
pub(super) fn points(solutions: &[Solution], [width, height]: [f64; 2]) -> Vec<[f64; 2]> {
    let point = |s: &Solution| [s.omega / width, s.amplitude(0) / height];
    solutions.iter().map(point).collect()
}

/// Largest distance of points from the straight lines between those of `line`.
pub(super) fn distance(points: &[[f64; 2]], line: &[[f64; 2]]) -> f64 {
    let nearest = |p: &[f64; 2]| {
        let segments = line.windows(2).map(|s| to_segment(*p, s[0], s[1]));
        segments.fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max)
}

fn to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let share = (ab[0] * ap[0] + ab[1] * ap[1]) / (ab[0] * ab[0] + ab[1] * ab[1]);
    let share = share.clamp(0.0, 1.0);
    f64::hypot(ap[0] - share * ab[0], ap[1] - share * ab[1])
}
