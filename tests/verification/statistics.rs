//! Statistics: exact laws, published values and the coverage that each kind of interval claims.

mod comparison;
mod coverage;
mod curves;
mod failed;
mod sensitivity;
mod values;

#[path = "../../benches/coverage/functions.rs"]
mod functions;

use functions::Numbers;
use microslip::ensemble::test_function::TestFunction;
use microslip::sampling::pick_freeze::at_place;

/// Ishigami's function of three uniform numbers, with a = 7 and b = 0.1.
fn ishigami(u: &[f64]) -> f64 {
    TestFunction::Ishigami.value(u)
}

/// Sobol's G-function with the coefficients 0, 1, 4.5, 9, 99, 99, 99, 99.
fn g_function(u: &[f64]) -> f64 {
    TestFunction::GFunction.value(u)
}

/// Water flow through a borehole (Harper & Gupta 1983, inputs of the library uqtestfuns) at eight uniform numbers.
fn borehole(u: &[f64]) -> f64 {
    use statrs::distribution::{ContinuousCDF, Normal};
    let z = |j: usize| Normal::standard().inverse_cdf(u[j]);
    let between = |j: usize, low: f64, high: f64| low + u[j] * (high - low);
    TestFunction::Borehole.value(&[
        0.1 + 0.016_181_2 * z(0),
        (7.71 + 1.0056 * z(1)).exp(),
        between(2, 63_070.0, 115_600.0),
        between(3, 990.0, 1100.0),
        between(4, 63.1, 116.0),
        between(5, 700.0, 820.0),
        between(6, 1120.0, 1680.0),
        between(7, 9985.0, 12_045.0),
    ])
}

/// Points of a pick-freeze design. Shape: `table` has rows of 2d numbers, A in the first d.
fn pick_freeze_points(table: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let row = |row: &Vec<f64>| -> Vec<Vec<f64>> {
        let (a, b) = row.split_at(row.len() / 2);
        (0..a.len() as u64 + 2)
            .map(|place| at_place(a.to_vec(), b.to_vec(), place))
            .collect()
    };
    table.iter().flat_map(row).collect()
}
