//! `Evaluator`: its results against those of samples, and what it refuses.

use super::super::{folder, microslip};
use super::{bits, model, quick};
use microslip::ensemble::stop::Stop;
use microslip::study::{EvaluationError, Evaluator, Study};

/// A sample starts from the generations before its own: the first five from nothing, the next two from these. With as many anchors a
/// point has the bits of the sample at its inputs, whether the anchors are solved or read.
///
/// Seen to fail with one anchor more.
#[test]
fn a_point_is_the_sample_at_its_inputs() {
    let study = quick(8);
    let prepared = Study::read(&study.path().join("study.toml")).unwrap();
    let prepared = prepared.into_prepared().unwrap();
    let outcomes = prepared.ensemble(None).run(8, || {});
    let run = microslip(study.path(), &["run", "study.toml", "--quiet"]);
    assert!(run.status.success(), "{run:?}");
    let results = study.path().join("results");
    for (anchors, samples) in [(0, 0..2), (5, 5..7), (7, 7..8)] {
        let stored = Evaluator::stored(prepared.clone(), &results, anchors).unwrap();
        let solved = model(study.path(), anchors);
        for model in [solved, stored] {
            assert_eq!(model.anchors() as u64, anchors);
            for outcome in &outcomes[samples.clone()] {
                let found = model.evaluate(&[&outcome.inputs], &Stop::default());
                let found = found.unwrap().remove(0);
                assert_eq!(bits(&found), bits(&outcome.levels), "{anchors} anchors");
            }
        }
    }
}

/// Seen to fail with the points of one thread after those of another.
#[test]
fn threads_and_other_points_change_no_bit() {
    let study = quick(8);
    let model = model(study.path(), 3);
    let points: Vec<_> = (1..=5).map(|i| [0.15 * f64::from(i)]).collect();
    let solved = |points: &[[f64; 1]]| -> Vec<_> {
        let found = model.evaluate(points, &Stop::default()).unwrap();
        found.iter().map(|levels| bits(levels)).collect()
    };
    let together = solved(&points);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let mut backwards = points.clone();
    backwards.reverse();
    let mut on_one = pool.build().unwrap().install(|| solved(&backwards));
    on_one.reverse();
    let alone: Vec<_> = points.iter().flat_map(|point| solved(&[*point])).collect();
    assert_eq!(together, on_one);
    assert_eq!(together, alone);
    assert_ne!(together[0], together[1]);
}

/// Seen to fail without the check of the number of values, and with the last point unchecked.
#[test]
fn values_that_cannot_be_meant_are_refused() {
    let study = folder("study.toml", "", "");
    let model = model(study.path(), 0);
    let refused = |points: &[Vec<f64>], expected: &str| {
        let error = model.evaluate(points, &Stop::default()).unwrap_err();
        assert_eq!(error.to_string(), expected);
    };
    let number = "row 1: inputs = (2 values): must be one value for each of: friction_coefficient";
    refused(&[vec![0.3], vec![0.3, 0.4]], number);
    let negative = "row 0: friction_coefficient = -0.1: must be >= 0";
    refused(&[vec![-0.1]], negative);
    refused(
        &[vec![0.3], vec![f64::NAN]],
        "row 1: friction_coefficient = NaN: must be >= 0",
    );
    for value in [f64::INFINITY, 11.0] {
        let rule = "must be at most 10: a friction coefficient, no percentage";
        let expected = format!("row 0: friction_coefficient = {value}: {rule}");
        refused(&[vec![value]], &expected);
    }
    let stop = Stop::default();
    stop.ask();
    let stopped = model.evaluate(&[[0.3]], &stop);
    assert_eq!(stopped.unwrap_err(), EvaluationError::Stopped);
    assert!(model.evaluate::<[f64; 1]>(&[], &stop).unwrap().is_empty());
}

/// Coefficients of the pressure may be negative, a strip must fit the blades. Seen to fail with the rule of factors for all inputs, and
/// without the check of the strip.
#[test]
fn values_of_the_strip_have_its_rules() {
    let path = "studies/two-blade-strip/study.toml";
    let text = std::fs::read_to_string(path).unwrap();
    let thickness =
        "\n[inputs.strip_thickness_mm]\ndistribution = \"uniform\"\nlow = 0.9\nhigh = 1.1\n";
    let field =
        "\n[pressure_field]\nstandard_deviation = 0.1\ncorrelation_length_mm = 3.0\nmodes = 1\n";
    let study = Study::parse(path.as_ref(), &format!("{text}{thickness}{field}")).unwrap();
    let inputs = study.design.inputs().iter();
    let names: Vec<_> = inputs.map(|(input, _)| input.name()).collect();
    let with = |name: &str, value: f64| {
        let mut values = vec![1.0; names.len()];
        values[names.iter().position(|n| *n == name).unwrap()] = value;
        study.check_values(&values).map_err(|bad| bad.to_string())
    };
    assert_eq!(with("pressure_mode_1", -3.0), Ok(()));
    let far = "pressure_mode_2 = -41: must be from -40 to 40: a standard normal number";
    assert_eq!(with("pressure_mode_2", -41.0), Err(far.to_owned()));
    let thick = with("strip_thickness_mm", 50.0).unwrap_err();
    assert!(thick.starts_with("strip_thickness_mm = 50: "), "{thick}");
    assert_eq!(with("strip_thickness_mm", 1.05), Ok(()));
}

/// Where the band holds no resonance the status says so and there is no number. Seen to fail with a band that holds one.
#[test]
fn what_is_not_found_is_data() {
    let study = folder("study.toml", "[100, 200]", "[100, 110]");
    let model = model(study.path(), 0);
    let found = model.evaluate(&[[0.3]], &Stop::default()).unwrap();
    assert_eq!(found[0].len(), 2);
    for level in &found[0] {
        assert_eq!(level.status.name(), "no-peak-in-band");
        assert!(level.peak.is_none(), "{level:?}");
    }
}

/// Seen to fail without the comparison of the studies.
#[test]
fn anchors_of_another_study_are_refused() {
    let study = quick(1);
    let run = microslip(study.path(), &["run", "study.toml", "--quiet"]);
    assert!(run.status.success(), "{run:?}");
    let path = study.path().join("study.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let other = Study::parse(&path, &text.replace("mu = 0.3", "mu = 0.4")).unwrap();
    let results = study.path().join("results");
    let refused = Evaluator::stored(other.into_prepared().unwrap(), &results, 5).unwrap_err();
    let message = refused.to_string();
    assert!(
        message.contains("another study (-22: mu = 0.3; +22: mu = 0.4)"),
        "{message}"
    );
}
