//! Designs compared: failed pairs, margins, outer points, and the page.

use crate::synthetic::{LEVELS, SyntheticStudy};
use microslip::ensemble::outcome::AroundPeak;
use microslip::hb::Status;
use microslip::report::StoredRun;
use microslip::report::compare::comparison::ComparedQuantity;
use microslip::report::compare::{self, Compared, DesignComparison};
use std::collections::BTreeMap;
use std::path::Path;

fn run(study: SyntheticStudy) -> StoredRun {
    StoredRun {
        mixed: Vec::new(),
        control: Vec::new(),
        record: study.record,
        outcomes: study.outcomes,
        changed: Vec::new(),
        folder: "results".to_owned(),
    }
}

/// The synthetic study with amplitudes times a factor.
fn design(samples: u64, factor: f64) -> StoredRun {
    let mut study = SyntheticStudy::new(samples);
    for level in study.outcomes.iter_mut().flat_map(|o| &mut o.levels) {
        if let Some(peak) = &mut level.peak {
            peak.amplitude_m *= factor;
        }
    }
    run(study)
}

fn page(comparison: &DesignComparison, runs: &[StoredRun]) -> String {
    let folder = tempfile::tempdir().unwrap();
    compare::write(folder.path(), comparison, runs).unwrap();
    let page = std::fs::read_to_string(folder.path().join("comparison.html")).unwrap();
    for forbidden in [
        "NaN", ">inf", "-inf", "−inf", "None", "none</", "http:", "https:", "<script",
    ] {
        assert!(!page.contains(forbidden), "the page shows {forbidden}");
    }
    page
}

const FOLDERS: [&str; 3] = ["a", "<b>", "c"];

fn compared(runs: &[StoredRun]) -> DesignComparison {
    let folders: Vec<&Path> = FOLDERS[..runs.len()].iter().map(Path::new).collect();
    DesignComparison::of(&folders, runs)
}

/// Amplitudes 10 % lower everywhere: better in every pair, and the reserve factor too. Seen to fail with the larger
/// amplitude as the better one.
#[test]
fn the_smaller_amplitude_is_better() {
    let runs = [1.0, 0.9, 1.1].map(|factor| {
        let mut run = design(60, factor);
        // each is to be trusted: what is not has a test of its own
        let levels = run.outcomes.iter_mut().flat_map(|o| &mut o.levels);
        let solved = levels.filter(|level| level.status.has_solution());
        solved.for_each(|level| level.status = Status::Converged);
        run
    });
    let found = compared(&runs);
    for level in &found.levels[..7] {
        let quantities: Vec<_> = level.quantities.iter().map(|q| q.quantity).collect();
        assert_eq!(quantities, Compared::ALL);
        for k in [1, 3] {
            let quantity = &level.quantities[k];
            let pair = quantity.pairs[0];
            assert_eq!((pair.a, pair.b), (0, 1));
            let better = pair.comparison.b_better;
            assert_eq!((better.yes, better.no, better.unknown), (60, 0, 0), "{k}");
            let ranking = &quantity.rankings[0].ranking;
            assert_eq!(ranking.order, [1, 0, 2]);
            assert!(ranking.surely > 0.99);
        }
        let frequency = &level.quantities[0];
        assert!(frequency.rankings.is_empty());
        assert_eq!(frequency.pairs[0].comparison.a_better.yes, 0);
    }
    let page = page(&found, &runs);
    assert!(
        page.contains("B &lt; A &lt; C") && page.contains("&lt;b&gt;") && !page.contains("<b>")
    );
    assert!(page.contains("Reserve factor") && page.contains("Frequency margin (%)"));
}

/// Results that the solver does not tell apart are ties: those within 1e-6, and those within their truncation errors, which are 1e-4 and more here.
/// Seen to fail without the resolution, and with the program that knew no errors.
#[test]
fn rounding_wins_for_neither() {
    for factor in [1.0 + 1e-8, 1.0 + 1e-4] {
        let runs = [design(60, 1.0), design(60, factor)];
        let level = &compared(&runs).levels[2];
        for quantity in &level.quantities {
            let pair = quantity.pairs[0].comparison;
            assert_eq!((pair.a_better.yes, pair.b_better.yes), (0, 0), "{factor}");
        }
    }
    let runs = [design(60, 1.0), design(60, 1.05)];
    let level = &compared(&runs).levels[2];
    assert_eq!(level.quantities[1].pairs[0].comparison.a_better.yes, 60);
}

/// A pair is compared by its own two results, whatever other designs stand beside it: A lies within the errors of both B and C.
///
/// Seen to fail with values that tie replaced by those of the first such design: B and C were equal then, too.
#[test]
fn a_pair_does_not_depend_on_other_designs() {
    let (low, middle, high) = (design(60, 0.98), design(60, 1.0), design(60, 1.02));
    let level = 2;
    let pair = |runs: &[StoredRun], a: usize, b: usize| {
        let pairs = &compared(runs).levels[level].quantities[1].pairs;
        let found = pairs.iter().find(|p| (p.a, p.b) == (a, b));
        found.unwrap().comparison.a_better.yes
    };
    let apart = pair(&[low.clone(), high.clone()], 0, 1);
    assert!(apart > pair(&[low.clone(), middle.clone()], 0, 1));
    assert_eq!(pair(&[middle, low, high], 1, 2), apart);
}

/// A pair of which one is not to be trusted is unknown, as in verdicts. Seen to fail with the program before.
#[test]
fn pairs_that_are_not_to_be_trusted_are_unknown() {
    let mut unstable = design(60, 0.5);
    for outcome in &mut unstable.outcomes[..6] {
        outcome.levels[1].status = Status::Unstable;
    }
    let runs = [design(60, 1.0), unstable];
    let found = compared(&runs);
    let better = found.levels[1].quantities[1].pairs[0].comparison.b_better;
    assert_eq!((better.yes, better.unknown), (54, 6));
}

/// A pair of which one failed is unknown in every share. Seen to fail with failed pairs left out.
#[test]
fn failed_pairs_stay_unknown() {
    let mut holed = design(60, 0.9);
    for outcome in &mut holed.outcomes[..6] {
        outcome.levels[1].status = Status::MaxIterations;
        outcome.levels[1].peak = None;
    }
    let runs = [design(60, 1.0), holed];
    let found = compared(&runs);
    let pair = found.levels[1].quantities[1].pairs[0].comparison;
    assert_eq!((pair.b_better.yes, pair.b_better.unknown), (54, 6));
    assert!(pair.b_better.lower < 0.9 && pair.b_better.upper > 0.95);
    assert!(page(&found, &runs).contains("1 N: up to 6 pairs are unknown"));
}

/// A level without a solution and a study with a single sample still give a page.
#[test]
fn empty_comparisons_render() {
    let mut lost = SyntheticStudy::new(12);
    (0..LEVELS.len()).for_each(|i| lost.fail_level(i));
    let runs = [run(lost), design(12, 1.0)];
    let found = compared(&runs);
    assert!(
        found.levels[0].quantities[1].pairs[0]
            .comparison
            .median_difference
            .is_none()
    );
    assert!(page(&found, &runs).contains("no pair has two solutions"));
    let runs = [design(1, 1.0), design(1, 2.0)];
    page(&compared(&runs), &runs);
}

/// Performance curves of every design, beside each other and on common axes; values show under the pointer. Seen to fail without them.
#[test]
fn performance_curves_stand_beside_each_other() {
    let runs = [design(60, 1.0), design(60, 3.0)];
    let page = page(&compared(&runs), &runs);
    for measure in ["frequency", "amplitude", "q-factor", "damping-ratio"] {
        for k in 0..2 {
            let file = format!("download=\"performance-{measure}-{k}.svg\"");
            let end = page.find(&file).unwrap_or_else(|| panic!("{file}"));
            let figure = &page[page[..end].rfind("<figure>").unwrap()..end];
            assert!(figure.contains("class=\"readout"), "{file} has no values");
        }
    }
    let ticks = |name: &str| -> Vec<&str> {
        let start = page.find(&format!("aria-label=\"{name}")).unwrap();
        let end = start + page[start..].find("</figure>").unwrap();
        let ticks = page[start..end].split("class=\"tick y\"").skip(1);
        ticks
            .map(|tick| tick.split("</text>").next().unwrap())
            .collect()
    };
    let [a, b] =
        ["A", "B"].map(|label| ticks(&format!("Amplitude per excitation, design {label}")));
    assert!(a.len() > 1 && a == b, "{a:?} {b:?}");
}

/// Beside every difference of margins and reserves stands on how many curves of both designs there are several answers; the synthetic ones fold
/// at one level, and half of the samples of the second design have none. Seen to fail with the counts of the first level beside all.
#[test]
fn differences_of_margins_say_how_often_there_are_several_answers() {
    let mut runs = [design(60, 1.0), design(60, 0.9)];
    for level in runs[1].outcomes[..30]
        .iter_mut()
        .flat_map(|o| &mut o.levels)
    {
        level.around = AroundPeak::new(level.around.others().to_vec(), Vec::new(), None);
    }
    let found = compared(&runs);
    let page = page(&found, &runs);
    let mut expected = BTreeMap::new();
    for (i, level) in found.levels.iter().enumerate() {
        let of_margin = |q: &&ComparedQuantity| q.quantity.is_margin();
        let rows: usize = (level.quantities.iter().filter(of_margin))
            .map(|q| q.pairs.len())
            .sum();
        let words = ["A", "B"].iter().zip(&runs).map(|(design, run)| {
            let sweeps = run
                .outcomes
                .iter()
                .filter_map(|o| o.levels[i].around.sweeps());
            let (curves, several) = (
                sweeps.clone().count(),
                sweeps.filter(|s| s.several_hz.is_some()).count(),
            );
            format!("{design}: several answers on {several} of {curves} curves")
        });
        *expected
            .entry(words.collect::<Vec<_>>().join("; "))
            .or_insert(0) += rows;
    }
    println!("{expected:?}");
    assert!(expected.len() > 1, "levels differ");
    for (words, rows) in expected {
        assert_eq!(page.matches(&words).count(), rows, "{words}");
    }
}
