//! What the sentence of a verdict says: numbers as they were stated, and all that is needed to decide.

use crate::synthetic::SyntheticStudy;
use crate::verdicts::{LEVEL, judged, only_level, study};
use microslip::ensemble::outcome::LevelOutcome;
use microslip::hb::Status;
use microslip::statistics::{Judgement, Remedy};

/// Takes the solution of a sample at level `i`.
fn fail(level: &mut LevelOutcome) {
    (level.status, level.peak) = (Status::MaxIterations, None);
}

/// Sixteen samples keep the limit at every level, so that 59 would pass, but for 11 without a solution at 1 N, where the amplitude is
/// small: no number of samples decides there. Seen to fail with the program before, which named 59 samples alone.
#[test]
fn the_level_that_takes_most_is_named_too() {
    let mut study = study(16, 5000.0);
    study.record.requirements.criteria[0].level = None;
    for outcome in &mut study.outcomes {
        // some have no solution at the highest level
        outcome.levels[7] = outcome.levels[6].clone();
    }
    let before = judged(&study);
    assert_eq!(before.judgement, Judgement::Undecided);
    assert!(before.hardest.is_none() && !before.sentence.contains(" At "));
    for outcome in &mut study.outcomes[..11] {
        fail(&mut outcome.levels[1]);
    }
    let result = judged(&study);
    let deciding = result.deciding().unwrap();
    assert_eq!(deciding.remedy, Some(Remedy::Samples(59)));
    let words = "Undecided: 59 samples needed";
    assert!(result.sentence.contains(words), "{}", result.sentence);
    let words = ". At 1 N: 11 of 16 samples are unknown (11 failed), and no number of samples decides as long as so large a share is.";
    assert!(result.sentence.ends_with(words), "{}", result.sentence);
    let hardest = result.hardest.unwrap();
    let found = (hardest.level, hardest.remedy);
    assert_eq!(found, (1.0, Some(Remedy::FewerUnknown)));
}

/// The same of an outer point whose estimate is not the worst one. Seen to fail with the program before, which dropped it.
#[test]
fn the_outer_point_that_takes_most_is_named_too() {
    let mut study = study(60, 250.0);
    study.record.design.outer_points = 3;
    for (k, outcome) in study.outcomes.iter_mut().enumerate() {
        outcome.group.outer = Some(k as u32 % 3);
        outcome.inputs[0] = (k % 3) as f64;
        let level = &mut outcome.levels[LEVEL];
        level.peak.as_mut().unwrap().amplitude_m = [1e-6, 2e-6, 1e-6][k % 3];
        if k % 3 == 2 && k < 24 {
            fail(level);
        }
    }
    let result = judged(&study);
    let level = only_level(&result);
    let found = (level.outer, level.remedy);
    assert_eq!(found, (Some(1), Some(Remedy::Samples(59))));
    let words = " At 20 N and outer point 2: 8 of 20 samples are unknown (8 failed), and no number";
    assert!(result.sentence.contains(words), "{}", result.sentence);
}

/// Without any solution there is no number, but a limit, a remedy and a box all the same. Seen to fail with the program before, which
/// said the first half of the sentence.
#[test]
fn a_verdict_without_an_estimate_says_what_is_asked() {
    let mut study = study(20, 500.0);
    study.fail_level(LEVEL);
    let start = "No sample has a solution to be trusted at 20 N (at most 500 µm is allowed). Undecided: 20 of 20 samples \
                 are unknown (20 failed), and no number of samples decides";
    let sentence = judged(&study).sentence;
    assert!(sentence.starts_with(start), "{sentence}");
    study.record.design.outer_points = 2;
    for (k, outcome) in study.outcomes.iter_mut().enumerate() {
        outcome.group.outer = Some(k as u32 % 2);
        outcome.inputs[0] = (k % 2) as f64;
    }
    let sentence = judged(&study).sentence;
    let end = " Over the box: is undecided at 2 points (contact stiffness scale 0 … 1). Shown at 2 points, not between them.";
    assert!(sentence.ends_with(end), "{sentence}");
}

/// Share, confidence and limit are quoted as the study states them. Seen to fail with the program before: 98 %, 885.7 µm, 12 %.
#[test]
fn demands_are_quoted_as_they_were_written() {
    let mut study = study(200, 885.6501);
    let criterion = &mut study.record.requirements.criteria[0];
    (criterion.share, criterion.confidence) = (Some(0.975), Some(0.9625));
    let result = judged(&study);
    for words in ["97.5 % of the assumed prior", "at most 885.6501 µm is"] {
        assert!(result.sentence.contains(words), "{}", result.sentence);
    }
    let page = study.page();
    for words in [
        "amplitude ≤ 885.6501 µm",
        "for 97.5 % of the assumed prior",
        "96.25 %",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let mut study = SyntheticStudy::new(50);
    let criteria = &mut study.record.requirements.criteria;
    criteria.retain(|c| c.name == "risk");
    criteria[0].limit = 0.1249;
    let sentence = judged(&study).sentence;
    assert!(
        sentence.contains("at most 12.49 % is allowed"),
        "{sentence}"
    );
}

/// What keeps a limit is shown below it, and what breaks it above. Seen to fail with the program before: PASS with 885.7 µm in all
/// places.
#[test]
fn numbers_are_shown_on_their_side_of_the_limit() {
    for (um, judgement, shown) in [
        (885.67, Judgement::Pass, "885.67 µm"),
        (885.69, Judgement::Fail, "885.7 µm"),
    ] {
        let mut study = study(200, 885.6801);
        for outcome in &mut study.outcomes {
            outcome.levels[LEVEL].peak.as_mut().unwrap().amplitude_m = 1e-6 * um;
        }
        let result = judged(&study);
        assert_eq!(result.judgement, judgement);
        let words = format!("{shown} at 20 N ({shown} to {shown}; at most 885.6801 µm is allowed)");
        assert!(result.sentence.contains(&words), "{}", result.sentence);
    }
}

/// The share of the power is told from the whole: half of what may break a limit does. Seen to fail with the program before: "if 100 %
/// kept the limit".
#[test]
fn the_share_of_the_power_is_not_the_whole() {
    let mut study = study(20, 500.0);
    study.record.requirements.criteria[0].share = Some(0.9998);
    assert!(study.page().contains("if 99.99 % kept the limit"));
}
