//! Sobol' points against `SciPy`'s and against what scrambling promises.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its design fails"
)]

use microslip::sampling::sobol::{MOST_DIMENSIONS, Sobol};

const SEED: u64 = 9;

#[derive(serde::Deserialize)]
struct Fixture {
    first: Vec<Vec<u64>>,
    far_index: u64,
    far: Vec<Vec<u64>>,
}

/// Bit for bit the points of `scipy.stats.qmc.Sobol(64, scramble=False)`, the first 128 and four after 2^20.
///
/// Seen to fail with the binary instead of the Gray code order.
#[test]
fn unscrambled_points_are_those_of_scipy() {
    let text = include_str!("sobol.json");
    let fixture: Fixture = serde_json::from_str(text).unwrap();
    let sobol = Sobol::new(MOST_DIMENSIONS);
    let far = (fixture.far_index..).zip(&fixture.far);
    let mut compared = 0;
    for (index, row) in (0..).zip(&fixture.first).chain(far) {
        for (dimension, integer) in row.iter().enumerate() {
            let expected = *integer as f64 / 2_f64.powi(30);
            let found = sobol.plain(index, dimension);
            assert_eq!(found, expected, "point {index}, dimension {dimension}");
            compared += 1;
        }
    }
    assert_eq!(compared, 132 * 64);
}

/// Scrambled points `first` … in the first `dimensions` coordinates.
fn points(dimensions: usize, replicate: u64, indices: std::ops::Range<u64>) -> Vec<Vec<f64>> {
    let sobol = Sobol::new(dimensions);
    indices
        .map(|i| sobol.scrambled(SEED, replicate, 0, i))
        .collect()
}

/// One point in each elementary interval of every 2ᵐ: in each coordinate, and in the plane of the first two.
///
/// Seen to fail with digits flipped by a hash of the digits below them.
#[test]
fn every_prefix_fills_its_elementary_intervals() {
    for m in 0..=9_u32 {
        let n = 1_usize << m;
        let set = points(MOST_DIMENSIONS, 0, 0..n as u64);
        for dimension in 0..MOST_DIMENSIONS {
            let mut seen = vec![false; n];
            set.iter()
                .for_each(|p| seen[(p[dimension] * n as f64) as usize] = true);
            assert!(
                seen.iter().all(|s| *s),
                "2^{m} points, dimension {dimension}"
            );
        }
        for split in 0..=m {
            let (a, b) = (1_usize << split, 1_usize << (m - split));
            let mut seen = vec![false; n];
            for p in &set {
                let cell = [(p[0] * a as f64) as usize, (p[1] * b as f64) as usize];
                seen[cell[0] * b + cell[1]] = true;
            }
            assert!(seen.iter().all(|s| *s), "2^{m} points, {a} x {b} cells");
        }
    }
}

/// Later blocks of 2ᵐ points fill the intervals too, so an extended design is as even as one made at once.
#[test]
fn numbers_are_inside_the_open_interval_and_blocks_are_even() {
    let block = points(3, 4, 64..128);
    for dimension in 0..3 {
        let mut seen = [false; 64];
        for p in &block {
            assert!(p[dimension] > 0.0 && p[dimension] < 1.0);
            seen[(p[dimension] * 64.0) as usize] = true;
        }
        assert!(seen.iter().all(|s| *s), "dimension {dimension}");
    }
}

/// Mean of Π (1 + (e^u − e + 1)/2), exactly 1, in three coordinates over `n` points.
fn mean(points: &[Vec<f64>]) -> f64 {
    let e = std::f64::consts::E;
    let factor = |u: &f64| 1.0 + 0.5 * (u.exp() - e + 1.0);
    let sum: f64 = points
        .iter()
        .map(|p| p.iter().map(factor).product::<f64>())
        .sum();
    sum / points.len() as f64
}

/// Root mean square error over 32 replicates falls faster than 1/n, where Monte Carlo has 1/√n; at 1024 points it is
/// 100 times below that of Monte Carlo.
///
/// Seen to fail with digits flipped by a hash of the digits below them.
#[test]
fn smooth_means_converge_faster_than_monte_carlo() {
    let rms = |n: u64| {
        let squares = (0..32).map(|r| (mean(&points(3, r, 0..n)) - 1.0).powi(2));
        (squares.sum::<f64>() / 32.0).sqrt()
    };
    let (few, many) = (rms(64), rms(1024));
    let order = (few / many).log2() / 4.0;
    assert!(order > 1.1, "order {order}: {few:e} to {many:e}");
    let monte_carlo = |r: u64| -> Vec<Vec<f64>> {
        let u = |i, j| microslip::sampling::stream::uniform(100 + r, i, j);
        (0..1024)
            .map(|i| (0..3).map(|j| u(i, j)).collect())
            .collect()
    };
    let squares = (0..32).map(|r| (mean(&monte_carlo(r)) - 1.0).powi(2));
    let plain = (squares.sum::<f64>() / 32.0).sqrt();
    assert!(plain > 100.0 * many, "{plain:e} against {many:e}");
}

/// The same point of 4000 replicates is uniform in the plane: χ² of 64 cells, 63 degrees of freedom, 99.9 % at 103.4.
/// And two neighbouring replicates are uncorrelated: |r| below 4 / √4000.
///
/// Seen to fail with the replicate left out of the key.
#[test]
fn replicates_are_independent() {
    let sobol = Sobol::new(2);
    let of = |r: u64| sobol.scrambled(SEED, r, 0, 5);
    let mut cells = [0.0_f64; 64];
    let mut products = 0.0;
    for r in 0..4000 {
        let (p, next) = (of(r), of(r + 1));
        cells[8 * (p[0] * 8.0) as usize + (p[1] * 8.0) as usize] += 1.0;
        products += 12.0 * (p[0] - 0.5) * (next[0] - 0.5);
    }
    let expected = 4000.0 / 64.0;
    let chi_squared: f64 = cells
        .iter()
        .map(|n| (n - expected).powi(2) / expected)
        .sum();
    assert!(chi_squared < 103.4, "chi squared {chi_squared}");
    let r = products / 4000.0;
    assert!(r.abs() < 4.0 / 4000.0_f64.sqrt(), "correlation {r}");
}
