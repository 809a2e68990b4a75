//! Failed samples: counted, never dropped, never a number.

use super::comparison::exact;
use super::{Numbers, ishigami, pick_freeze_points};
use microslip::statistics::{
    Better, Bootstrap, GivenData, Interval, Limit, Observed, SensitivityRefusal, Side, compare,
    conditional_means, exceedance, failure_pattern, first_order_index, joint_region,
    moment_estimate, quantile_estimate, sobol_indices, tolerance_bound, weighted_exceedance,
    weighted_quantile,
};

const BOOTSTRAP: Bootstrap = Bootstrap {
    seed: 1,
    replicates: 100,
    confidence: 0.95,
};

/// Failures in the bad tail: every interval still holds the truth and the exceedance probability never falls.
/// Seen to fail with the share among the valid samples for the upper limit.
#[test]
fn failures_in_the_tail_never_lower_an_exceedance() {
    let truth = 0.158_655;
    let complete = Numbers::of(1).normals(20_000);
    let mut numbers = Numbers::of(2);
    let holed: Vec<f64> = complete
        .iter()
        .map(|&v| match v > 1.0 && numbers.uniform() < 0.14 {
            true => f64::NAN,
            false => v,
        })
        .collect();
    let all = exceedance(&Observed::of(complete), 1.0, 0.95)
        .unwrap()
        .probability;
    let with_failed = exceedance(&Observed::of(holed.clone()), 1.0, 0.95).unwrap();
    let p = with_failed.probability;
    assert!(p.unknown > 400 && p.total() == 20_000);
    assert!(
        p.upper >= all.upper && p.lower <= all.lower,
        "{p:?} {all:?}"
    );
    assert!(p.lower < truth && truth < p.upper);
    // What a tool that drops failures would say misses the truth.
    assert!(p.known.unwrap().upper < truth, "{p:?}");
    let one = weighted_exceedance(&holed, &vec![1.0; holed.len()], 1.0, 0.95).unwrap();
    assert!(one.lower < truth && truth < one.upper && (one.upper - p.upper).abs() < 1e-6);
}

/// Every failure widens, none narrows: against the same samples with one failed.
/// Seen to fail with failed samples left out of the lower rank.
#[test]
fn one_failure_widens_every_interval() {
    let complete = Numbers::of(3).normals(200);
    for at in [0, 57, 199] {
        let mut holed = complete.clone();
        holed[at] = f64::NAN;
        let [all, less] = [&complete, &holed].map(|v| Observed::of(v.iter().copied()));
        for p in [0.05, 0.5, 0.95] {
            let interval = |o: &Observed| quantile_estimate(o, p, 0.95).unwrap().interval;
            assert_encloses(interval(&less), interval(&all));
        }
        for side in [Side::Lower, Side::Upper] {
            let limit = |o: &Observed| tolerance_bound(o, side, 0.95, 0.95).limit;
            match (side, limit(&less).value(), limit(&all).value()) {
                (Side::Lower, Some(less), Some(all)) => assert!(less <= all),
                (Side::Upper, Some(less), Some(all)) => assert!(less >= all),
                (_, less, _) => assert_eq!(less, None),
            }
        }
        let moments = moment_estimate(&less, Interval::UNBOUNDED, 0.95).unwrap();
        assert_eq!(moments.mean, Interval::UNBOUNDED);
        assert_eq!(moments.standard_deviation.upper, Limit::Unbounded);
        let known = moment_estimate(&less, Interval::between(-4.0, 4.0), 0.95).unwrap();
        let exact = moment_estimate(&all, Interval::UNBOUNDED, 0.95).unwrap();
        assert_encloses(known.mean, exact.mean);
        assert!(known.standard_deviation.contains(1.0));
        let weights = vec![1.0; 200];
        let weighted = |v: &[f64]| weighted_quantile(v, &weights, 0.9, 0.95).unwrap().interval;
        assert_encloses(weighted(&holed), weighted(&complete));
    }
}

fn assert_encloses(outer: Interval, inner: Interval) {
    let sides = [inner.lower, inner.upper].map(Limit::value);
    let held = |limit: Option<f64>| limit.is_none_or(|v| outer.contains(v));
    assert!(sides.into_iter().all(held), "{outer:?} {inner:?}");
}

/// More failures than a bound has samples beyond it leave the bound open, not NaN.
/// Seen to fail with the rank limited to the valid samples.
#[test]
fn too_many_failures_leave_the_bound_open() {
    let observed = Observed::with_failed(Observed::of((0..970).map(f64::from)).valid().clone(), 30);
    let q = quantile_estimate(&observed, 0.98, 0.95).unwrap();
    assert_eq!(
        (q.interval.upper, q.failure_bounds.upper),
        (Limit::Unbounded, Limit::Unbounded)
    );
    let bound = tolerance_bound(&observed, Side::Upper, 0.99, 0.95);
    assert_eq!((bound.limit, bound.order), (Limit::Unbounded, 5));
}

/// Joint region: with failures at any place the region is wider than that of the complete pairs.
/// Seen to fail with cuts in turns among the valid pairs only.
#[test]
fn a_joint_region_outlasts_failures() {
    let mut numbers = Numbers::of(8);
    let pairs: Vec<(f64, f64)> = (0..600)
        .map(|_| {
            let x = numbers.normal();
            (x, x + 0.3 * numbers.normal())
        })
        .collect();
    let complete = joint_region(&pairs, 0.9, 0.95);
    for outermost in [0, 1] {
        let mut holed = pairs.clone();
        holed.sort_by(|a, b| match outermost {
            0 => b.1.total_cmp(&a.1),
            _ => a.0.total_cmp(&b.0),
        });
        holed[..5].fill((f64::NAN, 0.0));
        let region = joint_region(&holed, 0.9, 0.95);
        assert_eq!((region.failed, region.cuts), (5, complete.cuts));
        assert_encloses(region.x, complete.x);
        assert_encloses(region.y, complete.y);
    }
    let all_failed = joint_region(&[(f64::NAN, 1.0); 200], 0.95, 0.95);
    assert_eq!(
        (all_failed.x, all_failed.y),
        (Interval::UNBOUNDED, Interval::UNBOUNDED)
    );
}

/// One NaN in a design refuses all indices, with its count; it never gives a 0.
/// Seen to fail without the check.
#[test]
fn one_failed_evaluation_refuses_sobol_indices() {
    let mut numbers = Numbers::of(4);
    let table: Vec<Vec<f64>> = (0..256).map(|_| numbers.uniforms(6)).collect();
    let points = pick_freeze_points(&table);
    let mut results: Vec<f64> = points.iter().map(|p| ishigami(p)).collect();
    let indices = sobol_indices(&results, 3, &BOOTSTRAP).unwrap();
    assert!(indices[1].first.estimate > 0.3);
    results[700] = f64::NAN;
    let refusal = sobol_indices(&results, 3, &BOOTSTRAP).unwrap_err();
    let expected = SensitivityRefusal::Failed {
        failed: 1,
        total: 5 * 256,
    };
    assert_eq!(refusal, expected);
    assert!(
        refusal
            .to_string()
            .starts_with("1 of 1280 evaluations failed")
    );
}

/// An index from given samples survives a failure near its value and says how many it lacks.
/// Seen to fail without the filter of failed samples.
#[test]
fn given_data_counts_failures() {
    let mut numbers = Numbers::of(5);
    let inputs: Vec<Vec<f64>> = (0..1000).map(|_| numbers.uniforms(3)).collect();
    let mut results: Vec<f64> = inputs.iter().map(|u| ishigami(u)).collect();
    let x2: Vec<f64> = inputs.iter().map(|u| u[1]).collect();
    let index = |results: &[f64]| {
        first_order_index(&GivenData {
            inputs: &x2,
            results,
            replicates: None,
            seed: 1,
            confidence: 0.95,
        })
    };
    let complete = index(&results).unwrap();
    results[17] = f64::NAN;
    results[170] = f64::INFINITY;
    let holed = index(&results).unwrap();
    assert_eq!((holed.valid, holed.failed), (998, 2));
    assert!((holed.index.estimate - complete.index.estimate).abs() < 0.02);
    assert!(holed.index.estimate > 0.3);
    let means = conditional_means(&x2, &results, 10, Interval::UNBOUNDED, 0.95);
    assert_eq!(means.iter().map(|m| m.samples).sum::<usize>(), 1000);
    assert_eq!(means.iter().map(|m| m.failed).sum::<usize>(), 2);
    for bin in means {
        let mean = bin.moments.unwrap().mean;
        assert_eq!(mean == Interval::UNBOUNDED, bin.failed > 0);
    }
}

/// Where samples fail: a shift is seen by ranks, failures at both ends by the distance, none by either when at random.
/// Seen to fail with the ranks of the solved samples.
#[test]
fn failures_are_found_in_the_input_space() {
    let mut numbers = Numbers::of(6);
    let inputs = numbers.uniforms(2000);
    let coin = numbers.uniforms(2000);
    let pattern = |fails: &dyn Fn(f64, f64) -> bool| {
        let flags = inputs.iter().zip(&coin).map(|(&x, &c)| fails(x, c));
        failure_pattern(&inputs, &flags.collect::<Vec<_>>(), 10, 0.95).unwrap()
    };
    let high = pattern(&|x, c| x > 0.8 && c < 0.2);
    assert!(high.superiority > 0.85 && high.shift_p_value < 1e-6);
    assert!(
        high.bins[..7]
            .iter()
            .all(|b| b.failed == 0 && b.rate.lower == 0.0)
    );
    assert!(high.bins[9].rate.lower > 0.1 && high.bins[9].rate.upper < 0.35);
    let ends = pattern(&|x, c| !(0.1..0.9).contains(&x) && c < 0.2);
    assert!(
        ends.shift_p_value > 0.01 && ends.distance_p_value < 1e-4,
        "{ends:?}"
    );
    let random = pattern(&|_, c| c < 0.03);
    assert!(
        random.shift_p_value > 0.01 && random.distance_p_value > 0.01,
        "{random:?}"
    );
    let total: usize = random.bins.iter().map(|b| b.samples).sum();
    assert_eq!(total, 2000);
    // By hand: failed {1, 3} against solved {2, 3}: pairs (1,2) lost, (1,3) lost, (3,2) won, (3,3) tied.
    let by_hand = failure_pattern(&[1.0, 2.0, 3.0, 3.0], &[true, false, true, false], 2, 0.95);
    assert_eq!(by_hand.unwrap().superiority, 1.5 / 4.0);
    assert_eq!(failure_pattern(&inputs, &[false; 2000], 10, 0.95), None);
}

/// A pair with a failure is unknown in every answer. Seen to fail with unknown pairs as losses of A.
#[test]
fn a_comparison_keeps_unknown_pairs() {
    let a: Vec<f64> = (0..100).map(f64::from).collect();
    let mut b: Vec<f64> = a.iter().map(|v| v + 1.0).collect();
    b[..10].fill(f64::NAN);
    let c = compare(&exact(&a), &exact(&b), Better::Smaller, 0.95).unwrap();
    assert_eq!(
        (c.a_better.yes, c.a_better.no, c.a_better.unknown),
        (90, 0, 10)
    );
    assert!(c.a_better.lower < 0.9 && c.a_better.upper == 1.0);
    assert!(c.b_better.lower == 0.0 && c.b_better.upper > 0.1);
    let median = c.median_difference.unwrap();
    assert_eq!(
        (median.estimate, median.interval),
        (-1.0, Interval::between(-1.0, -1.0))
    );
    b[10..60].fill(f64::NAN);
    let c = compare(&exact(&a), &exact(&b), Better::Smaller, 0.95).unwrap();
    assert_eq!(c.median_difference.unwrap().interval, Interval::UNBOUNDED);
}
