//! Verdicts at points where nothing is random, and over the points of a box.

use crate::synthetic::SyntheticStudy;
use crate::verdicts::{LEVEL, judged, only_level, study};
use microslip::hb::Status;
use microslip::statistics::Judgement;

/// Without a random input every sample has the same result: one passes or fails, and where the limit lies inside its numerical error or it
/// failed, no further ones are asked for. Seen to fail with quantiles of the samples, which bound nothing of one.
#[test]
fn one_sample_decides_where_no_input_is_random() {
    use Judgement::{Fail, Pass, Undecided};
    let (fine, high) = (Some(50.0), Some(150.0));
    let cases: [(&[Option<f64>], f64, Judgement, &str); 6] = [
        (
            &[fine],
            0.0,
            Pass,
            "50.00 µm at 20 N (50.00 µm to 50.00 µm; at most 100 µm is allowed).",
        ),
        (&[fine; 3], 0.04, Pass, "(48.00 µm to 52.00 µm;"),
        (&[high], 0.0, Fail, "(150.0 µm to 150.0 µm;"),
        (&[high, None], 0.0, Fail, "(150.0 µm or more;"),
        (
            &[fine, None],
            0.0,
            Undecided,
            "Undecided: 1 of 2 samples is unknown (1 failed), and further samples would be the same, since no input is random.",
        ),
        (
            &[Some(99.0)],
            0.04,
            Undecided,
            "1 of 1 samples is unknown (1 with the limit inside their numerical error), and further samples would be",
        ),
    ];
    for (samples, error, judgement, words) in cases {
        let study = not_random(samples, error);
        let result = judged(&study);
        let sentence = &result.sentence;
        assert_eq!(result.judgement, judgement, "{sentence}");
        let start = "No input is random: the amplitude is ";
        assert!(sentence.starts_with(start), "{sentence}");
        assert!(sentence.contains(words), "{sentence}");
        assert!(only_level(&result).power.is_none());
        assert!(!study.page().contains("of all studies"));
    }
}

/// Samples of these amplitudes (µm), the others failed, of a study without a random input; the limit is 100 µm.
fn not_random(amplitudes_um: &[Option<f64>], error: f64) -> SyntheticStudy {
    let mut study = study(amplitudes_um.len() as u64, 100.0);
    for input in &mut study.record.inputs {
        input.distribution = None;
    }
    for (outcome, amplitude) in study.outcomes.iter_mut().zip(amplitudes_um) {
        let level = &mut outcome.levels[LEVEL];
        match (amplitude, &mut level.peak) {
            (Some(um), Some(peak)) => {
                peak.amplitude_m = 1e-6 * um;
                peak.truncation_error = Some(error).into();
            }
            _ => (level.status, level.peak) = (Status::MaxIterations, None),
        }
    }
    study
}

/// With several inputs the ranges of points with one judgement are named where no other point lies within all of them, and their number
/// alone where one does. Seen to fail with ranges of 8 points that hold the ninth.
#[test]
fn ranges_over_a_box_hold_points_of_one_judgement() {
    let mut study = study(900, 250.0);
    study.record.design.outer_points = 9;
    for (k, outcome) in study.outcomes.iter_mut().enumerate() {
        let point = k % 9;
        outcome.group.outer = Some(point as u32);
        outcome.inputs = [(point / 3) as f64, (point % 3) as f64].into();
        outcome.levels[LEVEL].peak.as_mut().unwrap().amplitude_m = 200e-6;
    }
    let fail_at = |study: &mut SyntheticStudy, point: usize| {
        for outcome in study.outcomes.iter_mut().skip(point).step_by(9) {
            outcome.levels[LEVEL].peak.as_mut().unwrap().amplitude_m = 300e-6;
        }
        judged(study).sentence
    };
    // the middle one
    let sentence = fail_at(&mut study, 4);
    let expected = "fails at 1 point (contact stiffness scale 1, mu 1); passes at 8 points. Shown";
    assert!(sentence.contains(expected), "{sentence}");
    // and the whole row of it
    fail_at(&mut study, 3);
    fail_at(&mut study, 5);
    for point in 0..3 {
        fail_at(&mut study, point);
    }
    let sentence = judged(&study).sentence;
    let expected = "fails at 6 points (contact stiffness scale 0 … 1, mu 0 … 2); \
                    passes at 3 points (contact stiffness scale 2, mu 0 … 2). Shown";
    assert!(sentence.contains(expected), "{sentence}");
}
