//! What was measured as the likelihood takes it, and the checks of a posterior against it, by closed forms.

use super::{normal_prior, observed, surrogates};
use microslip::calibrate::observation::Observations;
use microslip::calibrate::predictive::{below_measured, misfit};
use microslip::calibrate::settings::Discrepancy;
use microslip::calibrate::{ObservedQuantity, Posterior};
use microslip::record::{ResponsePoint, ResponseRecord};

fn near(found: f64, expected: f64, what: &str) {
    let error = (found / expected - 1.0).abs();
    assert!(error < 1e-9, "{what}: {found}, not {expected}");
}

/// Frequencies at levels 1 and 2 with their stated deviations, if any; amplitudes of 1 um with 1 %.
fn record(frequencies: [[f64; 3]; 2], deviations: Option<[f64; 3]>) -> ResponseRecord {
    let point = |(level, k): (usize, usize)| ResponsePoint {
        level_n: 1.0 + level as f64,
        frequency_hz: frequencies[level][k],
        amplitude_m: 1e-6,
        frequency_deviation_hz: deviations.map(|d| d[k]),
        amplitude_deviation_m: Some(1e-8),
    };
    let places = (0..2).flat_map(|level| (0..3).map(move |k| (level, k)));
    ResponseRecord {
        name: "measured".to_owned(),
        points: places.map(point).collect(),
        lines: Vec::new(),
    }
}

/// Without stated deviations the scatter of all levels together, with Student's variance for its four degrees of freedom.
///
/// Seen to fail without Student's factor, and with the repetitions counted as degrees of freedom.
#[test]
fn repetitions_tell_their_scatter() {
    let record = record([[100.0, 101.0, 102.0], [200.0, 203.0, 206.0]], None);
    let found = Observations::of(&record, &[1.0, 2.0]).unwrap();
    let scatter = found.scatter[0].unwrap();
    assert_eq!(scatter.degrees_of_freedom, 4);
    // (1 + 0 + 1 + 9 + 0 + 9) / 4
    near(scatter.standard_deviation, 5.0_f64.sqrt(), "scatter");
    let second = found.means[2];
    assert_eq!(
        (second.level, second.quantity),
        (1, ObservedQuantity::Frequency)
    );
    near(second.mean, 203.0, "mean");
    near(
        second.variance,
        5.0 * 4.0 / 2.0 / 3.0,
        "variance of the mean",
    );
    assert!(found.scatter[1].is_none(), "amplitudes state theirs");
    near(found.means[1].variance, 1e-4 / 3.0, "amplitude");
}

/// Seen to fail with the mean of all repetitions, whatever they state.
#[test]
fn stated_deviations_weigh() {
    let record = record([[100.0, 101.0, 104.0], [200.0; 3]], Some([1.0, 0.5, 1.0]));
    let found = Observations::of(&record, &[1.0, 2.0]).unwrap();
    let first = found.means[0];
    near(first.mean, (100.0 + 4.0 * 101.0 + 104.0) / 6.0, "mean");
    near(first.variance, 1.0 / 6.0, "variance");
}

/// χ² of the repetitions about the weighted means of their levels. Closed forms of its tail with an even number n of degrees of freedom:
/// exp(−x/2) Σ (x/2)^k/k! up to k = n/2 − 1.
#[test]
fn repetitions_are_held_against_stated_deviations() {
    let levels = [1.0, 2.0];
    let frequencies = [[100.0, 101.0, 104.0], [200.0; 3]];
    let of_record = record(frequencies, Some([1.0, 0.5, 1.0]));
    let found = Observations::of(&of_record, &levels).unwrap();
    let check = found.stated[0].unwrap();
    // about 304/3: (16 + 4 · 1 + 64)/9, four degrees of freedom
    let square = 84.0 / 9.0;
    near(check.factor, (square / 4.0_f64).sqrt(), "factor");
    let expected = (-0.5 * square).exp() * (1.0 + 0.5 * square);
    near(check.probability, expected, "probability");
    let equal = found.stated[1].unwrap();
    near(equal.probability, 1.0, "amplitudes that do not scatter");
    let unstated = Observations::of(&record([[100.0, 101.0, 102.0]; 2], None), &levels).unwrap();
    assert!(unstated.stated[0].is_none(), "nothing stated");
    let single = ResponseRecord {
        points: of_record.points.into_iter().step_by(3).collect(),
        name: of_record.name,
        lines: Vec::new(),
    };
    let single = Observations::of(&single, &levels).unwrap();
    assert_eq!(single.stated, [None; 2], "nothing repeated");
}

/// One position of a linear response, 1.2 deviations above and half of one below what is measured.
///
/// Seen to fail with the variance in place of the deviation, and without the error of the surrogate.
#[test]
fn checks_of_a_position_have_closed_forms() {
    let (prior, design) = normal_prior(0.0);
    let mut fitted = surrogates(&prior, &design, |x| [100.0 + 3.0 * x[0], x[1]]);
    fitted.all[0].deviation = 0.3;
    fitted.all[1].deviation = 0.0;
    // the means of the inputs are 1 and 2; 0.3 and 0.4 together are 0.5
    let measured = observed([103.0 + 1.2 * 0.5, 2.0 - 0.5 * 0.1], [0.4, 0.1]);
    let posterior = Posterior::new(&prior, &fitted, &measured, Discrepancy::default());
    let positions = [vec![0.0, 0.0]];
    let [frequency, amplitude] = posterior.predictions(&positions[0])[..] else {
        panic!("two predictions");
    };
    assert!((frequency[0] - 103.0).abs() < 1e-6, "{frequency:?}");
    assert!((frequency[1] - 0.25).abs() < 1e-9, "{frequency:?}");
    assert!((amplitude[1] - 0.01).abs() < 1e-9, "{amplitude:?}");
    let below = below_measured(&posterior, &positions);
    // Φ(1.2) and Φ(−0.5)
    assert!((below[0] - 0.884_930_33).abs() < 1e-5, "{below:?}");
    assert!((below[1] - 0.308_537_54).abs() < 1e-5, "{below:?}");
    // χ² with two degrees of freedom: exp(−x/2)
    let expected = (-0.5 * (1.44 + 0.25_f64)).exp();
    let found = misfit(&posterior, &positions);
    assert!((found - expected).abs() < 1e-5, "{found} {expected}");
}
