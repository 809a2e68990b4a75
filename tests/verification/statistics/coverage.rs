//! Each kind of interval, repeated 1000 times on fresh samples: it must cover the truth as often as it says.

use super::{Numbers, REPETITIONS, assert_coverage, coverage, pick_freeze_points};
use microslip::statistics::{
    Better, Bootstrap, CurveSet, Interval, MissingPoints, Observed, Side, compare, depth_band,
    exceedance, first_order_index, joint_region, moment_estimate, proportion, quantile_estimate,
    simultaneous_band, sobol_indices, tolerance_bound, weighted_exceedance, weighted_quantile,
};
use rayon::prelude::*;
use statrs::distribution::{Binomial, Discrete};
use std::f64::consts::TAU;

/// Samples of a uniform law, whose p-quantile is p; with `failed` of them unknown.
fn uniform_sample(numbers: &mut Numbers, n: usize, failed: usize) -> Observed {
    Observed::of((0..n).map(|i| match (numbers.uniform(), i < failed) {
        (_, true) => f64::NAN,
        (u, false) => u,
    }))
}

/// Seen to fail with ranks (l + 1, u).
#[test]
fn quantile_intervals_cover() {
    for (n, p) in [(100, 0.5), (200, 0.95), (60, 0.1)] {
        let estimate = |o: &Observed| quantile_estimate(o, p, 0.95).unwrap();
        let stated = estimate(&Observed::of((0..n).map(f64::from))).coverage;
        let n = n as usize;
        let measured = coverage(|numbers| {
            estimate(&uniform_sample(numbers, n, 0))
                .interval
                .contains(p)
        });
        assert_coverage("quantile", measured, stated);
        let holed = coverage(|numbers| {
            estimate(&uniform_sample(numbers, n, 3))
                .interval
                .contains(p)
        });
        assert!(holed >= stated - 0.015, "{holed} {stated}");
    }
}

/// Seen to fail with the order of n + 1 samples.
#[test]
fn tolerance_bounds_cover() {
    for (n, content) in [(59, 0.95), (200, 0.95), (46, 0.9)] {
        for side in [Side::Lower, Side::Upper] {
            let bound = |o: &Observed| tolerance_bound(o, side, content, 0.95);
            let stated = bound(&Observed::of((0..n).map(f64::from))).achieved_confidence;
            assert!(stated >= 0.95, "{stated}");
            let n = n as usize;
            let measured = coverage(|numbers| {
                let limit = bound(&uniform_sample(numbers, n, 0)).limit.value().unwrap();
                match side {
                    Side::Lower => limit <= 1.0 - content,
                    Side::Upper => limit >= content,
                }
            });
            assert_coverage("tolerance", measured, stated);
        }
    }
}

/// Clopper–Pearson is conservative by its discreteness: measured against the exact sum over the binomial.
/// Seen to fail with Beta(k, n − k) limits.
#[test]
fn exceedance_intervals_cover() {
    for (n, p) in [(50, 0.1), (200, 0.5), (100, 0.02)] {
        let count = Binomial::new(p, n as u64).unwrap();
        let covered = |k: &usize| {
            let limits = proportion(*k, n, 0.95).unwrap();
            limits.lower <= p && p <= limits.upper
        };
        let exact: f64 = (0..=n).filter(covered).map(|k| count.pmf(k as u64)).sum();
        assert!(exact >= 0.95);
        let measured = coverage(|numbers| {
            let found = exceedance(&uniform_sample(numbers, n, 0), 1.0 - p, 0.95).unwrap();
            found.probability.lower <= p && p <= found.probability.upper
        });
        assert_coverage("exceedance", measured, exact);
    }
}

/// Mean and standard deviation of a normal and of a uniform law.
/// Seen to fail with t at the level 0.95 in place of 0.975, and with the kurtosis of the normal law for all.
#[test]
fn moment_intervals_cover() {
    type Draw = fn(&mut Numbers) -> f64;
    let laws: [(Draw, f64, f64); 2] = [
        (Numbers::normal, 0.0, 1.0),
        (Numbers::uniform, 0.5, 1.0 / 12_f64.sqrt()),
    ];
    for (draw, mean, deviation) in laws {
        let estimate = |numbers: &mut Numbers| {
            let values: Vec<f64> = (0..80).map(|_| draw(numbers)).collect();
            moment_estimate(&Observed::of(values), Interval::UNBOUNDED, 0.95).unwrap()
        };
        let of_mean = coverage(|numbers| estimate(numbers).mean.contains(mean));
        assert_coverage("mean", of_mean, 0.95);
        let of_deviation =
            coverage(|numbers| estimate(numbers).standard_deviation.contains(deviation));
        assert_coverage("standard deviation", of_deviation, 0.95);
    }
}

/// Re-weighted samples: z ~ N(0, 1) made to stand for N(0.6, 1). Seen to fail with n in place of n_e.
#[test]
fn weighted_intervals_cover() {
    let estimates = |numbers: &mut Numbers| {
        let z = numbers.normals(400);
        let weights: Vec<f64> = z.iter().map(|z| (0.6 * z).exp()).collect();
        let median = weighted_quantile(&z, &weights, 0.5, 0.95).unwrap();
        let above = weighted_exceedance(&z, &weights, 0.6, 0.95).unwrap();
        (median.interval, above)
    };
    let of_median = coverage(|numbers| estimates(numbers).0.contains(0.6));
    assert_coverage("weighted quantile", of_median, 0.95);
    let of_share = coverage(|numbers| {
        let above = estimates(numbers).1;
        above.lower <= 0.5 && 0.5 <= above.upper
    });
    assert_coverage("weighted exceedance", of_share, 0.95);
}

/// The content of a rectangle over two independent uniform results is its area.
/// Seen to fail with one cut more than the order allows.
#[test]
fn joint_regions_cover() {
    for n in [153, 300] {
        let region = |numbers: &mut Numbers| {
            let pairs: Vec<_> = (0..n)
                .map(|_| (numbers.uniform(), numbers.uniform()))
                .collect();
            joint_region(&pairs, 0.95, 0.95)
        };
        let length = |side: Interval| side.upper.value().unwrap() - side.lower.value().unwrap();
        let measured = coverage(|numbers| {
            let found = region(numbers);
            length(found.x) * length(found.y) >= 0.95
        });
        let stated = region(&mut Numbers::of(0)).achieved_confidence;
        assert!(stated >= 0.95, "{stated}");
        assert_coverage("joint region", measured, stated);
    }
}

/// A fresh curve lies in the band with the probability that it states, for few samples too, and with failed ones.
/// Seen to fail with rank ⌈m level⌉ in place of ⌈(m + 1) level⌉.
#[test]
fn bands_cover_fresh_curves() {
    let grid: Vec<f64> = (0..6).map(|i| TAU * f64::from(i) / 6.0).collect();
    let curve = |numbers: &mut Numbers| -> Vec<f64> {
        let (a, b) = (numbers.normal(), numbers.normal());
        grid.iter().map(|t| a * t.cos() + b * t.sin()).collect()
    };
    let build = |kind: usize, numbers: &mut Numbers, n: usize, failed: usize| {
        let rows = (0..n).map(|i| Some(curve(numbers)).filter(|_| i >= failed));
        let set = CurveSet::from_rows(grid.clone(), rows.collect());
        match kind {
            0 => simultaneous_band(&set, 0.85, 0.95, MissingPoints::Outside),
            _ => depth_band(&set, 0.8, 0.95, MissingPoints::Outside),
        }
    };
    for (kind, n, level) in [(0, 58, 0.85), (1, 158, 0.8)] {
        let band = build(kind, &mut Numbers::of(0), n, 0).unwrap();
        let expected = band.expected_coverage;
        assert!((level..level + 0.02).contains(&expected), "{expected}");
        let covered = |failed: usize| {
            coverage(|numbers| {
                // A refusal is a band without edges.
                let band = build(kind, numbers, n, failed);
                let fresh = curve(numbers);
                band.is_err()
                    || band.unwrap().points.iter().zip(&fresh).all(|(point, y)| {
                        let point = point.unwrap();
                        point.lower <= *y && *y <= point.upper
                    })
            })
        };
        let measured = covered(0);
        match kind {
            0 => assert_coverage("simultaneous", measured, expected),
            // Several curves may need the same member of the family, which then holds more than it must.
            _ => assert!(
                measured >= expected - 0.015 && measured <= expected + 0.03,
                "{measured}"
            ),
        }
        assert!(covered(4) >= expected - 0.015);
    }
}

/// Paired differences with a common part far larger than the difference, of median 0.2.
/// Seen to fail with the 0.4-quantile in place of the median.
#[test]
fn comparisons_cover() {
    let found = |numbers: &mut Numbers| {
        let common = numbers.normals(200);
        let a: Vec<f64> = common
            .iter()
            .map(|c| 10.0 * c + 0.2 + numbers.normal())
            .collect();
        let b: Vec<f64> = common.iter().map(|c| 10.0 * c).collect();
        compare(&a, &b, Better::Smaller, 0.95).unwrap()
    };
    let stated = found(&mut Numbers::of(0))
        .median_difference
        .unwrap()
        .coverage;
    let of_median = coverage(|numbers| {
        let median = found(numbers).median_difference.unwrap();
        median.interval.contains(0.2)
    });
    assert_coverage("median difference", of_median, stated);
    let truth = 0.420_740_29; // Φ(−0.2)
    let of_share = coverage(|numbers| {
        let better = found(numbers).a_better;
        better.lower <= truth && truth <= better.upper
    });
    assert!((0.945..=0.98).contains(&of_share), "{of_share}");
}

/// Repetitions of resampling intervals, in parallel because each resamples.
fn parallel_coverage(covers: impl Fn(&mut Numbers, u64) -> bool + Sync) -> f64 {
    let hits = (0..REPETITIONS).into_par_iter();
    let hits = hits.filter(|&r| covers(&mut Numbers::of(r), r));
    hits.count() as f64 / REPETITIONS as f64
}

/// y = x₁ + x₂/2 + x₁x₂ of centred uniform inputs: variances 1/12, 1/48 and 1/144.
#[test]
#[cfg_attr(
    debug_assertions,
    ignore = "resampling takes a minute without optimisation"
)]
fn sobol_intervals_cover() {
    let (v1, v2, v12) = (1.0 / 12.0, 1.0 / 48.0, 1.0 / 144.0);
    let whole: f64 = v1 + v2 + v12;
    let hits: Vec<[bool; 2]> = (0..REPETITIONS)
        .into_par_iter()
        .map(|seed| {
            let mut numbers = Numbers::of(seed);
            let table: Vec<Vec<f64>> = (0..200).map(|_| numbers.uniforms(4)).collect();
            let points = pick_freeze_points(&table);
            let y = |p: &Vec<f64>| {
                let (a, b) = (p[0] - 0.5, p[1] - 0.5);
                a + b / 2.0 + a * b
            };
            let results: Vec<f64> = points.iter().map(y).collect();
            let bootstrap = Bootstrap {
                seed,
                replicates: 199,
                confidence: 0.95,
            };
            let found = sobol_indices(&results, 2, &bootstrap).unwrap();
            let holds = |i: microslip::statistics::Index, v: f64| i.lower <= v && v <= i.upper;
            [
                holds(found[1].first, v2 / whole),
                holds(found[0].total, (v1 + v12) / whole),
            ]
        })
        .collect();
    for kind in 0..2 {
        let measured = hits.iter().filter(|h| h[kind]).count() as f64 / REPETITIONS as f64;
        assert_coverage(["first", "total"][kind], measured, 0.95);
    }
}

/// Index 1/5 of x₂ in y = x₁ + x₂/2, and 0 of an input that does not enter.
#[test]
#[cfg_attr(
    debug_assertions,
    ignore = "resampling takes half a minute without optimisation"
)]
fn given_data_intervals_cover() {
    let cover = |input: usize, exact: f64| {
        parallel_coverage(|numbers, seed| {
            let rows: Vec<Vec<f64>> = (0..300).map(|_| numbers.uniforms(3)).collect();
            let x: Vec<f64> = rows.iter().map(|r| r[input]).collect();
            let y: Vec<f64> = rows.iter().map(|r| r[0] + r[1] / 2.0).collect();
            let bootstrap = Bootstrap {
                seed,
                replicates: 199,
                confidence: 0.95,
            };
            let index = first_order_index(&x, &y, &bootstrap).unwrap().index;
            index.lower <= exact && exact <= index.upper
        })
    };
    assert_coverage("given data", cover(1, 0.2), 0.95);
    assert_coverage("given data, inert input", cover(2, 0.0), 0.95);
}
