//! Scatter and correlation between contacts are found from many tests.

use crate::population::{CORRELATION, MEDIANS, SCATTER, deviations};
use crate::synthetic::{Bench, normal};
use microslip::identify::{
    ContactParameter, Identified, IdentifySettings, TestResult, identify, identify_test, pool,
};
use microslip::sampling::Shape;

/// A contact drawn from the population.
fn contact(seed: u64) -> Bench {
    let normals = [0, 1].map(|k| normal(99, seed, 20 + k));
    let [friction, stiffness] = deviations(normals, SCATTER).map(f64::exp);
    Bench {
        friction: MEDIANS[0] * friction,
        stiffness: [1e6 * MEDIANS[1] * stiffness; 2],
        amplitude: 8e-6,
        per_cycle: 200.0,
        cycles: 6,
        noise: [0.0, 0.5, 0.5],
        seed,
        ..Bench::default()
    }
}

fn tests(count: u64) -> Vec<TestResult> {
    let test = |seed| identify_test(&contact(seed).record(), &IdentifySettings::default());
    (0..count).map(test).collect()
}

/// Seen to fail with the correlation left out.
#[test]
fn scatter_and_correlation_of_a_population() {
    let pooled = pool(&tests(80), &IdentifySettings::default());
    assert_eq!(
        pooled.specimens, 80,
        "a test without specimen is one of its own"
    );
    let expected = MEDIANS.into_iter().zip(SCATTER);
    for (found, (median, scatter)) in pooled.parameters.iter().zip(expected) {
        let u = found.median;
        assert!(u.lower < median && median < u.upper, "{found:?}");
        let ratio = found.log_scatter.unwrap() / scatter;
        // four standard deviations of a standard deviation from 80 values
        assert!((ratio - 1.0).abs() < 0.32, "{ratio}: {found:?}");
        assert!((found.few_tests_factor - 1.0).abs() < 0.02, "{found:?}");
    }
    let correlation = pooled.correlation[0][1];
    assert!((correlation - CORRELATION).abs() < 0.28, "{correlation}");
}

/// Seen to fail with tests without errors.
#[test]
fn noise_of_the_tests_is_no_scatter() {
    let test = |seed| {
        let bench = Bench {
            seed,
            per_cycle: 120.0,
            cycles: 12,
            noise: [0.0, 5.0, 2.0],
            ..Bench::default()
        };
        identify_test(&bench.record(), &IdentifySettings::default())
    };
    let tests: Vec<TestResult> = (0..20).map(test).collect();
    let pooled = pool(&tests, &IdentifySettings::default());
    let of_values = |value: fn(&TestResult) -> f64| {
        let logs: Vec<f64> = tests.iter().map(|t| value(t).ln()).collect();
        let mean = logs.iter().sum::<f64>() / 20.0;
        (logs.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 19.0).sqrt()
    };
    let raw = of_values(|t| {
        t.estimate
            .as_ref()
            .unwrap()
            .tangential
            .stiffness_n_per_um
            .value
    });
    let scatter = pooled.parameters[1].log_scatter.unwrap();
    assert!(
        scatter < 0.75 * raw,
        "scatter {scatter} between contacts, {raw} of the values"
    );
}

/// Seen to fail with a factor of 1, and with the correlation of few tests as it is.
#[test]
fn few_tests_widen_the_distribution() {
    let settings = IdentifySettings::default();
    let all = tests(3);
    let pooled = pool(&all, &settings);
    // Student's factor with two degrees of freedom is 4.30, the normal one 1.96
    let factor = pooled.parameters[0].few_tests_factor;
    assert!((factor - 4.3027 / 1.95996).abs() < 1e-3, "{factor}");
    let scatter = pooled.between_tests[0][0] + pooled.of_mean[0][0];
    let stated = pooled.parameters[0].predictive_log_standard_deviation;
    assert!(
        (stated / (factor * scatter.sqrt()) - 1.0).abs() < 1e-6,
        "{stated} is not the scatter {scatter} with the factor {factor}"
    );
    let one = pool(&all[..1], &settings);
    assert!(
        one.parameters[0].log_scatter.is_none(),
        "one test has no scatter between contacts"
    );
    assert!(
        pooled.correlation[0][1].abs() <= 2.0 / 3.0 + 1e-9,
        "{:?}",
        pooled.correlation
    );
}

/// Seen to fail with every test as a specimen of its own.
#[test]
fn tests_of_one_specimen_are_no_further_contacts() {
    let mut all = tests(12);
    for (i, test) in all.iter_mut().enumerate() {
        // four tests of each of three specimens, with the same contact
        let first = contact((i / 4) as u64);
        *test = identify_test(
            &Bench {
                seed: i as u64,
                ..first
            }
            .record(),
            &IdentifySettings::default(),
        );
        test.conditions.specimen = Some(format!("pair {}", i / 4));
    }
    let pooled = pool(&all, &IdentifySettings::default());
    assert_eq!(pooled.specimens, 3, "specimens");
    let [between, within] =
        [&pooled.between_specimens, &pooled.between_tests].map(|m| m[1][1].sqrt());
    assert!(
        between > 10.0 * within,
        "between specimens {between}, between their tests {within}"
    );
    let factor = pooled.parameters[1].few_tests_factor;
    assert!(
        (factor - 4.3027 / 1.95996).abs() < 1e-3,
        "degrees of freedom are those of specimens: {factor}"
    );
}

/// Seen to fail with the gain of one force alone in the covariance.
#[test]
fn the_measuring_chain_is_the_same_for_all_tests() {
    let settings = IdentifySettings {
        force_error_percent: 2.0,
        displacement_error_percent: 1.0,
        ..IdentifySettings::default()
    };
    let few: Vec<TestResult> = (0..40)
        .map(|seed| identify_test(&contact(seed).record(), &settings))
        .collect();
    let pooled = pool(&few, &settings);
    let [friction, stiffness] =
        [0, 1].map(|k| pooled.parameters[k].median.systematic / pooled.parameters[k].median.value);
    assert!((friction - 0.02 * 2_f64.sqrt()).abs() < 1e-6, "{friction}");
    assert!(
        (stiffness - 0.02_f64.hypot(0.01)).abs() < 1e-6,
        "{stiffness}"
    );
}

fn identified(records: &[Bench], settings: &IdentifySettings) -> Identified {
    let records: Vec<_> = records.iter().map(Bench::record).collect();
    identify(&records, settings).unwrap()
}

/// Seen to fail with a bound above the swing, and with a greatest coefficient below it.
#[test]
fn no_slip_gives_no_number() {
    let stuck = |seed| Bench {
        seed,
        amplitude: 1e-6,
        noise: [0.0, 0.2, 0.2],
        ..Bench::default()
    };
    let settings = IdentifySettings::default();
    let found = identified(&[stuck(1), stuck(2)], &settings);
    assert!(
        found
            .inputs
            .iter()
            .all(|i| i.parameter != ContactParameter::FrictionCoefficient),
        "{:?}",
        found.inputs
    );
    assert!(
        found.notes.iter().any(|n| n.contains("no test slips")),
        "{:?}",
        found.notes
    );
    let settings = IdentifySettings {
        friction_at_most: Some(1.2),
        ..settings
    };
    let found = identified(&[stuck(1), stuck(2)], &settings);
    let Shape::Uniform { low, high } = found.inputs[0].shape else {
        panic!("{:?}", found.inputs);
    };
    assert!((0.49..0.501).contains(&low) && high == 1.2, "{low} {high}");
    assert_eq!(found.correlation.len(), 2, "rows of the correlation");
    assert_eq!(
        found.correlation[0],
        [1.0, 0.0],
        "nothing is known of the correlation"
    );
    let settings = IdentifySettings {
        friction_at_most: Some(0.3),
        ..settings
    };
    let records = [stuck(1).record()];
    let refused = identify(&records, &settings).unwrap_err().to_string();
    assert!(
        refused.contains("friction_at_most") && refused.contains("0.4"),
        "{refused}"
    );
}

/// Seen to fail with the ratio on the friction coefficient, too.
#[test]
fn the_area_ratio_scales_stiffness_alone() {
    let benches = [contact(1), contact(2), contact(3)];
    let settings = IdentifySettings::default();
    let one = identified(&benches, &settings);
    let ten = identified(
        &benches,
        &IdentifySettings {
            interface_area_ratio: 10.0,
            ..settings
        },
    );
    let median = |found: &Identified, k: usize| match found.inputs[k].shape {
        Shape::Lognormal { median, .. } => median,
        other => panic!("{other:?}"),
    };
    assert_eq!(median(&one, 0), median(&ten, 0), "friction coefficient");
    assert!(
        (median(&ten, 1) / median(&one, 1) - 10.0).abs() < 1e-12,
        "stiffness"
    );
}

/// Seen to fail with a covariance that is symmetric up to rounding alone.
#[test]
fn the_file_is_read_as_it_was_written_for_any_number_of_threads() {
    let records: Vec<_> = (0..8).map(|seed| contact(seed).record()).collect();
    let settings = IdentifySettings::default();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| identify(&records, &settings).unwrap())
    };
    let text = serde_json::to_string(&run(1)).unwrap();
    assert_eq!(
        text,
        serde_json::to_string(&run(3)).unwrap(),
        "bits depend on threads"
    );
    let again: Identified = serde_json::from_str(&text).unwrap();
    assert_eq!(again, run(1), "the file loses something");
    let valid = again.validate();
    assert!(valid.is_ok(), "a study refuses it: {valid:?}");
}
