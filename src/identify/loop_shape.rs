//! Where the mean loop of a test sticks and where it slips; the same places then serve every loop of the test.

use super::branch::{Window, slope, window};
use super::half::{Half, halves};
use super::mean_loop::MeanLoop;
use super::plateau::plateau;

/// Places of a loop.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoopShape {
    /// The way down, and the way up.
    pub(super) halves: [Half; 2],
    /// Windows of the stick branches, after the reversal at the greatest displacement and at the least.
    pub(super) windows: [Option<Window>; 2],
    /// First and last place of both plateaus, where the whole contact slips.
    pub(super) plateaus: Option<[[usize; 2]; 2]>,
    /// Normal force below which T/N is not taken (N).
    pub(super) least_normal: f64,
}

/// Normal force over its mean, below which the contact may be open and T/N is not taken.
const LEAST_NORMAL: f64 = 0.02;

/// Places of the mean loop.
///
/// # Errors
/// Why it is no loop.
pub(super) fn shape(cycle: &MeanLoop) -> Result<LoopShape, String> {
    let normal = cycle.normal.iter().sum::<f64>() / cycle.samples() as f64;
    if normal <= 0.0 {
        return Err(format!(
            "has a mean normal force of {normal:.4e} N: compression is positive, and must prevail"
        ));
    }
    let least_normal = LEAST_NORMAL * normal;
    let halves = halves(cycle, least_normal);
    let ends = halves.map(|half| half.end_ratio(cycle, least_normal));
    let [Some(down), Some(up)] = ends else {
        return Err(
            "has no normal force before its reversals: the contact is open there".to_owned(),
        );
    };
    if down + up <= 0.0 {
        return Err("has a tangential force against the displacement: one of them needs the other sign, or this is no hysteresis loop".to_owned());
    }
    let windows = [0, 1].map(|side| {
        let before = [up, down][side];
        let share = |r: Option<f64>| r.map(|r| (r + before) / (down + up));
        let shares: Vec<_> = halves[side]
            .ratio(cycle, least_normal)
            .into_iter()
            .map(share)
            .collect();
        window(&halves[side], cycle, &shares)
    });
    let lines = [0, 1].map(|side| windows[side].and_then(|w| slope(&halves[side], cycle, &w)));
    let slopes: Vec<f64> = lines.iter().flatten().map(|line| line.slope).collect();
    if slopes.is_empty() {
        return Err(
            "has no sample in its stick branches: record more samples per cycle".to_owned(),
        );
    }
    let stick = slopes.iter().sum::<f64>() / slopes.len() as f64;
    if stick <= 0.0 {
        return Err("has stick branches along which the force falls: one of the signals needs the other sign, or this is no hysteresis loop".to_owned());
    }
    let [a, b] = halves.map(|half| plateau(&half, cycle, stick, least_normal));
    Ok(LoopShape {
        halves,
        windows,
        plateaus: a.zip(b).map(|(a, b)| [a, b]),
        least_normal,
    })
}
