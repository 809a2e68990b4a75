//! Verification of `sampling`: inverse against distribution function, moments against closed forms, repeatability.

mod designs;
mod file;
mod sobol;

use microslip::sampling::{Design, Distribution, Input, Shape};

const SAMPLES: u64 = 20_000;

/// Every family, with the closed forms of its mean and variance.
fn families() -> Vec<(Shape, f64, f64)> {
    let (low, high) = (0.1_f64, 10.0_f64);
    let log_width = (high / low).ln();
    let log_mean = (high - low) / log_width;
    let log_variance = (high * high - low * low) / (2.0 * log_width) - log_mean * log_mean;
    let s = 0.3_f64;
    vec![
        (Shape::Fixed { value: 2.5 }, 2.5, 0.0),
        (
            Shape::Uniform {
                low: 0.1,
                high: 0.8,
            },
            0.45,
            0.49 / 12.0,
        ),
        (Shape::LogUniform { low, high }, log_mean, log_variance),
        (
            Shape::Normal {
                mean: 0.6,
                standard_deviation: 0.1,
            },
            0.6,
            0.01,
        ),
        (
            Shape::Lognormal {
                median: 2.0,
                log_standard_deviation: s,
            },
            2.0 * (s * s / 2.0).exp(),
            4.0 * (s * s).exp() * ((s * s).exp() - 1.0),
        ),
        (
            Shape::Triangular {
                low: 1.0,
                mode: 2.0,
                high: 4.0,
            },
            7.0 / 3.0,
            (1.0 + 4.0 + 16.0 - 2.0 - 4.0 - 8.0) / 18.0,
        ),
        (
            Shape::Beta {
                alpha: 2.0,
                beta: 5.0,
                low: -1.0,
                high: 3.0,
            },
            -1.0 + 4.0 * 2.0 / 7.0,
            16.0 * 10.0 / (49.0 * 8.0),
        ),
    ]
}

fn draw(distribution: &Distribution, seed: u64) -> Vec<f64> {
    (0..SAMPLES)
        .map(|i| distribution.quantile(microslip::sampling::stream::uniform(seed, i, 0)))
        .collect()
}

/// F(F⁻¹(p)) = p, plain and cut to the middle. Seen to fail with the cut's `kept` not subtracted in `cdf`.
#[test]
fn quantile_inverts_the_distribution_function() {
    for (shape, mean, variance) in families() {
        if variance == 0.0 {
            continue;
        }
        let sd = variance.sqrt();
        for truncation in [None, Some([mean - 0.5 * sd, mean + 0.8 * sd])] {
            let distribution = Distribution::new(shape, truncation).unwrap();
            for p in [1e-6, 0.001, 0.05, 0.3, 0.5, 0.77, 0.95, 0.999] {
                let x = distribution.quantile(p);
                let error = (distribution.cdf(x) - p).abs();
                assert!(
                    error < 1e-9,
                    "{shape:?} {truncation:?}: F(F^-1({p})) is off by {error:e}"
                );
                let [low, high] = distribution.support();
                assert!(
                    (low..=high).contains(&x),
                    "{shape:?}: {x} outside {low}..{high}"
                );
            }
        }
    }
}

/// The density is the slope of the distribution function (central difference), plain and cut; 0 outside.
///
/// Seen to fail with the cut's normalisation left out.
#[test]
fn the_density_is_the_slope_of_the_distribution_function() {
    for (shape, mean, variance) in families() {
        let sd = variance.sqrt();
        for truncation in [None, Some([mean - 0.5 * sd, mean + 0.8 * sd])] {
            if variance == 0.0 {
                continue;
            }
            let distribution = Distribution::new(shape, truncation).unwrap();
            for p in [0.05, 0.3, 0.77, 0.95] {
                let x = distribution.quantile(p);
                let h = 1e-5 * sd;
                let slope = (distribution.cdf(x + h) - distribution.cdf(x - h)) / (2.0 * h);
                let density = distribution.density(x).unwrap();
                assert!(
                    (density / slope - 1.0).abs() < 1e-5,
                    "{shape:?} {truncation:?}: {density} at {x}, not {slope}"
                );
            }
            let [low, high] = distribution.support();
            for outside in [low - 1.0, high + 1.0]
                .into_iter()
                .filter(|x| x.is_finite())
            {
                assert_eq!(distribution.density(outside), Some(0.0));
            }
        }
    }
    assert_eq!(Distribution::fixed(2.0).unwrap().density(2.0), None);
}

/// Mean and variance of 20000 samples within 4 standard errors (the variance's from the sample's fourth moment).
///
/// A right sampler fails one of the 12 comparisons with a probability below 1e-3, and the seed is fixed.
/// Seen to fail with the standard deviation doubled in `Shape::law`.
#[test]
fn moments_agree_with_closed_forms() {
    for (shape, mean, variance) in families() {
        let values = draw(&Distribution::new(shape, None).unwrap(), 3);
        let n = SAMPLES as f64;
        let sample_mean = values.iter().sum::<f64>() / n;
        let moment = |k: i32| {
            values
                .iter()
                .map(|x| (x - sample_mean).powi(k))
                .sum::<f64>()
                / n
        };
        let (second, fourth) = (moment(2), moment(4));
        let bound = 4.0 * (variance / n).sqrt() + 1e-12;
        assert!(
            (sample_mean - mean).abs() <= bound,
            "{shape:?}: mean {sample_mean}, not {mean}"
        );
        let bound = 4.0 * ((fourth - second * second).max(0.0) / n).sqrt() + 1e-12;
        assert!(
            (second - variance).abs() <= bound,
            "{shape:?}: variance {second}, not {variance}"
        );
    }
}

/// Published quantiles: Φ⁻¹(0.975) = 1.959963984540054; I⁻¹_{1/2}(2, 2) = 1/2; I_x(2, 1) = x².
#[test]
fn quantiles_known_in_closed_form() {
    let normal = Shape::Normal {
        mean: 0.0,
        standard_deviation: 1.0,
    };
    let beta = |alpha: f64, beta: f64| Shape::Beta {
        alpha,
        beta,
        low: 0.0,
        high: 1.0,
    };
    let cases = [
        (normal, 0.975, 1.959_963_984_540_054),
        (beta(2.0, 2.0), 0.5, 0.5),
        (beta(2.0, 1.0), 0.49, 0.7),
        (
            Shape::LogUniform {
                low: 0.01,
                high: 100.0,
            },
            0.75,
            10.0,
        ),
        (
            Shape::Triangular {
                low: 0.0,
                mode: 1.0,
                high: 1.0,
            },
            0.25,
            0.5,
        ),
        (
            Shape::Lognormal {
                median: 3.0,
                log_standard_deviation: 0.7,
            },
            0.5,
            3.0,
        ),
    ];
    for (shape, p, expected) in cases {
        let x = Distribution::new(shape, None).unwrap().quantile(p);
        assert!(
            (x - expected).abs() < 1e-9 * expected,
            "{shape:?}: {x}, not {expected}"
        );
    }
}

/// Sample i does not depend on order, and an input's values do not depend on which other inputs there are.
///
/// Seen to fail with the position in the list as the dimension.
#[test]
fn samples_do_not_depend_on_order_or_company() {
    let k = Distribution::new(
        Shape::LogUniform {
            low: 0.1,
            high: 10.0,
        },
        None,
    )
    .unwrap();
    let mu = Distribution::new(
        Shape::Uniform {
            low: 0.1,
            high: 0.8,
        },
        None,
    )
    .unwrap();
    let both = Design::new(
        11,
        vec![
            (Input::FrictionCoefficient, mu.clone()),
            (Input::StiffnessScale, k),
        ],
    )
    .unwrap();
    let alone = Design::new(11, vec![(Input::FrictionCoefficient, mu)]).unwrap();
    let forward: Vec<_> = (0..100).map(|i| both.sample(i)).collect();
    let backward: Vec<_> = (0..100).rev().map(|i| both.sample(i)).collect();
    for (i, sample) in forward.iter().enumerate() {
        assert_eq!(sample, &backward[99 - i]);
        assert_eq!(sample[1], alone.sample(i as u64)[0]);
    }
    assert_ne!(forward[0], forward[1]);
}

/// The 2-d points fill the unit square evenly: χ² of 100 cells, 99 degrees of freedom, 99.9 % quantile 148.2.
#[test]
fn dimensions_are_independent() {
    let mut cells = [0.0_f64; 100];
    for i in 0..SAMPLES {
        let u = |dimension| microslip::sampling::stream::uniform(2, i, dimension);
        cells[10 * (u(0) * 10.0) as usize + (u(3) * 10.0) as usize] += 1.0;
    }
    let expected = SAMPLES as f64 / 100.0;
    let chi_squared: f64 = cells
        .iter()
        .map(|n| (n - expected).powi(2) / expected)
        .sum();
    assert!(chi_squared < 148.2, "chi squared {chi_squared}");
}

#[test]
fn inadmissible_distributions_are_refused() {
    let uniform = |low: f64, high: f64| Shape::Uniform { low, high };
    let normal = |mean: f64, standard_deviation: f64| Shape::Normal {
        mean,
        standard_deviation,
    };
    let log_uniform = Shape::LogUniform {
        low: 0.0,
        high: 1.0,
    };
    let triangular = Shape::Triangular {
        low: 0.0,
        mode: 2.0,
        high: 1.0,
    };
    let beta = Shape::Beta {
        alpha: -1.0,
        beta: 1.0,
        low: 0.0,
        high: 1.0,
    };
    let bad = [
        (uniform(1.0, 1.0), None, "high"),
        (log_uniform, None, "low"),
        (normal(0.0, 0.0), None, "standard_deviation"),
        (normal(f64::NAN, 1.0), None, "mean"),
        (triangular, None, "mode"),
        (beta, None, "alpha"),
        (uniform(0.0, 1.0), Some([0.5, 2.0]), "truncation"),
        (normal(0.0, 1.0), Some([20.0, 30.0]), "truncation"),
        (normal(0.0, 1.0), Some([1.0, f64::NAN]), "truncation"),
    ];
    for (shape, truncation, key) in bad {
        let error = Distribution::new(shape, truncation).unwrap_err();
        assert_eq!(error.key, key, "{shape:?}: {error}");
    }
    let negative = Distribution::new(normal(1.0, 0.1), None).unwrap();
    let error = Design::new(1, vec![(Input::StiffnessScale, negative)]).unwrap_err();
    assert_eq!(error.key, "stiffness_scale.distribution");
}
