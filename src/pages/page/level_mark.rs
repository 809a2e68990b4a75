//! Colour and shape of an excitation level: levels are told apart without colour, too.

use std::fmt::Write;

/// Shapes of the marks of the levels, one after the other, as SVG paths relative to their middle.
const SHAPES: [&str; 6] = [
    "m-2.2 0a2.2 2.2 0 1 0 4.4 0a2.2 2.2 0 1 0-4.4 0z",
    "m-2 -2h4v4h-4z",
    "m0-2.9l2.8 4.9h-5.6z",
    "m0-3.1l3.1 3.1-3.1 3.1-3.1-3.1z",
    "m0 2.9l2.8-4.9h-5.6z",
    "m-3-1h2v-2h2v2h2v2h-2v2h-2v-2h-2z",
];

/// Ramp from navy over violet to orange, low levels dark. It runs along blue-red-yellow, which the common colour
/// deficiencies keep apart, and stays readable on white.
const ON_WHITE: [[f64; 3]; 6] = [
    [16.0, 28.0, 100.0],
    [28.0, 92.0, 190.0],
    [118.0, 72.0, 200.0],
    [186.0, 50.0, 150.0],
    [222.0, 74.0, 82.0],
    [242.0, 146.0, 56.0],
];

/// The same hues, light enough for a dark ground.
const ON_DARK: [[f64; 3]; 6] = [
    [138.0, 160.0, 255.0],
    [92.0, 164.0, 255.0],
    [178.0, 148.0, 255.0],
    [238.0, 128.0, 210.0],
    [255.0, 134.0, 134.0],
    [255.0, 190.0, 106.0],
];

/// Shape of the marks of level `i`.
pub(super) fn shape(i: usize) -> &'static str {
    SHAPES[i % SHAPES.len()]
}

/// What the marks stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ground {
    /// Paper, and windows with a light scheme.
    White,
    /// Windows with a dark scheme.
    Dark,
}

/// Style sheet rules with the colours of `n` levels.
pub(super) fn colours(n: usize, ground: Ground) -> String {
    let stops = match ground {
        Ground::White => &ON_WHITE,
        Ground::Dark => &ON_DARK,
    };
    let mut rules = String::new();
    for i in 0..n {
        let _ = writeln!(rules, ".l{i} {{ --c: {}; }}", colour(stops, i, n));
    }
    rules
}

/// Place `i` of `n` on a ramp.
fn colour(stops: &[[f64; 3]; 6], i: usize, n: usize) -> String {
    let position = i as f64 / (n.max(2) - 1) as f64 * (stops.len() - 1) as f64;
    let stop = (position as usize).min(stops.len() - 2);
    let share = position - stop as f64;
    let mix = |c: usize| stops[stop][c] + share * (stops[stop + 1][c] - stops[stop][c]);
    format!("rgb({:.0} {:.0} {:.0})", mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of a colour (WCAG 2.2).
    fn luminance(rgb: [f64; 3]) -> f64 {
        let linear = rgb.map(|c| match c / 255.0 {
            dark if dark <= 0.04045 => dark / 12.92,
            light => ((light + 0.055) / 1.055).powf(2.4),
        });
        0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    }

    /// Marks stand out from what they stand on. Seen to fail with the colours of white on the dark ground.
    #[test]
    fn colours_have_contrast() {
        let contrast = |a: f64, b: f64| (a.max(b) + 0.05) / (a.min(b) + 0.05);
        for (stops, ground) in [(ON_WHITE, [255.0; 3]), (ON_DARK, [20.0, 24.0, 29.0])] {
            for stop in stops {
                let found = contrast(luminance(stop), luminance(ground));
                assert!(found >= 2.2, "{stop:?} on {ground:?}: {found:.2}");
            }
        }
    }

    /// Levels beside each other have different shapes. Seen to fail with a shape twice in the list.
    #[test]
    fn neighbouring_levels_have_different_shapes() {
        for i in 0..20 {
            for j in i + 1..i + SHAPES.len() {
                assert_ne!(shape(i), shape(j), "levels {i} and {j}");
            }
        }
    }
}
