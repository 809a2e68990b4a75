//! Means and probabilities by control variate.

use crate::synthetic::SyntheticStudy;
use microslip::hb::Status;
use microslip::report::asked::ControlVariateSettings;
use microslip::report::numbers::control_variate::LevelControlVariate;
use microslip::report::{Assessment, Summary};

/// Level of 100 N, the only one at which the study states limits of the amplitude.
const LEVEL: usize = 6;

/// The synthetic study with the same samples and more as its control, with amplitudes wrong by a factor and an offset that varies.
fn with_control(samples: u64, all: u64) -> SyntheticStudy {
    let mut study = SyntheticStudy::new(samples);
    let settings: ControlVariateSettings = serde_json::from_str("{}").unwrap();
    study.record.control_variate = Some(settings);
    study.control = SyntheticStudy::new(all).outcomes;
    for (i, outcome) in (0..).zip(&mut study.control) {
        for peak in outcome.levels.iter_mut().filter_map(|l| l.peak.as_mut()) {
            peak.amplitude_m *= 0.9 + 0.01 * f64::from(i % 7);
        }
    }
    study
}

fn of_level(study: &SyntheticStudy) -> LevelControlVariate {
    let assessment = Assessment::of(&study.input(), &Summary::of(&study.input()));
    assessment.levels[LEVEL].control_variate.clone().unwrap()
}

/// The mean comes near that of all samples, which the study has not solved, and its interval is narrower than that of its own samples.
/// Seen to fail with the control of another sample beside each result.
#[test]
fn the_mean_is_nearer_to_that_of_many_samples() {
    let whole = Summary::of(&SyntheticStudy::new(2000).input());
    let truth = whole.levels[LEVEL].amplitude_m.moments.unwrap().mean;
    let found = of_level(&with_control(60, 2000));
    assert_eq!((found.highest_harmonic, found.further), (1, 1940));
    let mean = found.amplitude_m.unwrap();
    assert!(mean.interval.contains(truth), "{mean:?}, truth {truth}");
    assert!(mean.correlation > 0.9, "{mean:?}");
    assert!(mean.variance_ratio.unwrap() < 0.3, "{mean:?}");
}

/// A failed sample of the study opens the upper limit of the mean, one of the control is counted. Seen to fail with failed samples
/// left out of the upper limit.
#[test]
fn failed_samples_are_counted() {
    let mut study = with_control(60, 2000);
    study.control[100].levels[LEVEL].status = Status::MaxIterations;
    let found = of_level(&study);
    assert_eq!(found.failed, 1);
    assert!(found.amplitude_m.unwrap().interval.upper.value().is_some());
    study.outcomes[5].levels[LEVEL].status = Status::MaxIterations;
    let mean = of_level(&study).amplitude_m.unwrap();
    assert_eq!(mean.interval.upper.value(), None);
    assert!(mean.interval.lower.value().is_some() && mean.variance_ratio.is_none());
}

/// The page has the section with what each number is worth, and counts controls without solution; without the table of the study file it
/// has no such section.
#[test]
fn the_page_shows_it() {
    let mut study = with_control(60, 300);
    let counts = |page: &str| page.matches("of the control without solution").count();
    let before = counts(&study.page());
    study.control[100].levels[LEVEL].status = Status::MaxIterations;
    let shown = study.page();
    // beside its frequency and its amplitude; other levels have failed samples of their own
    assert_eq!(counts(&shown), before + 2);
    for words in [
        ">1 of the control without solution",
        "Means by control variate",
        "Probability that the amplitude exceeds a limit, by control variate",
        "300 samples, among them the 60 of this study",
    ] {
        assert!(shown.contains(words), "{words:?} is not in the page");
    }
    assert!(!shown.contains("NaN"));
    assert!(!SyntheticStudy::new(60).page().contains("ontrol variate"));
}
