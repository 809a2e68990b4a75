//! The maxima of all modes: stored, counted and shown.

use crate::synthetic::SyntheticStudy;
use microslip::ensemble::outcome::{AroundPeak, FollowedModes, Maximum, MaybeReal, ModeOfMaximum};
use microslip::ensemble::store::{FollowedMode, read_samples, write_samples};
use microslip::report::{self, Summary};

/// Of 20 samples at the first level: mode 2 is the peak, mode 5 the lower maximum of the even ones, of the sample 0 twice, and was not found
/// in sample 1. All other maxima are of mode 2.
fn study() -> SyntheticStudy {
    let mut study = SyntheticStudy::new(20);
    study.be_exact();
    let followed = |mode, stuck_frequency_hz| FollowedMode {
        mode,
        stuck_frequency_hz,
    };
    study.record.provenance.followed_modes = vec![
        followed(2, 2973.95),
        followed(5, 3100.0),
        followed(7, 3200.0),
    ];
    let of = |number, share| ModeOfMaximum { number, share };
    for outcome in &mut study.outcomes {
        let index = outcome.index;
        for (i, level) in outcome.levels.iter_mut().enumerate() {
            let second = Maximum {
                frequency_hz: 3100.0 + index as f64,
                amplitude_m: 1e-9,
            };
            let lower = Maximum {
                frequency_hz: 1.0,
                amplitude_m: 1e-12,
            };
            let others = match (i, index) {
                (0, 0) => vec![second, lower],
                (0, i) if i % 2 == 0 => vec![second],
                _ => Vec::new(),
            };
            let mut of_maxima = vec![of(2, 0.9)];
            of_maxima.extend(others.iter().map(|_| of(5, 0.6 + 0.01 * index as f64)));
            level.around = AroundPeak::new(others, Vec::new(), None);
            level.around.set_modes(FollowedModes {
                of_maxima: if level.peak.is_some() {
                    of_maxima
                } else {
                    Vec::new()
                },
                unfinished: u32::from(i == 0 && index == 1),
            });
        }
    }
    study
}

/// What is written of modes comes back, also of a sample that failed. Seen to fail with the modes of the others one place further.
#[test]
fn modes_survive_the_round_trip() {
    let mut study = study();
    study.outcomes[4].levels[0].peak = None;
    study.outcomes[4].levels[0].status = microslip::hb::Status::MaxIterations;
    study.outcomes[4].levels[0].around = AroundPeak::default();
    study.outcomes[4].levels[0].around.set_modes(FollowedModes {
        of_maxima: Vec::new(),
        unfinished: 2,
    });
    study.outcomes[6].levels[0].around = AroundPeak::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.parquet");
    let names = study.input_names();
    write_samples(&path, &study.record.provenance, &names, &study.outcomes).unwrap();
    let stored = read_samples(&path).unwrap();
    for (read, written) in stored.outcomes.iter().zip(&study.outcomes) {
        for (read, written) in read.levels.iter().zip(&written.levels) {
            assert_eq!(read.around.modes(), written.around.modes());
            assert_eq!(read.around.others(), written.around.others());
        }
    }
}

/// Samples with a maximum of a mode, those that may have one, and those without; quantiles are of the first, bounds allow for the second. Seen
/// to fail with samples of unfinished searches counted as without, and with the lowest maximum of a mode in place of the highest.
#[test]
fn maxima_are_counted_by_mode() {
    let study = study();
    let summary = Summary::of(&study.input());
    let modes = summary.levels[0].modes.as_ref().unwrap();
    let counts: Vec<_> = (modes.iter())
        .map(|m| (m.mode, m.present.yes, m.present.unknown, m.present.no))
        .collect();
    assert_eq!(counts, [(2, 20, 0, 0), (5, 10, 1, 9), (7, 0, 1, 19)]);
    let of_peak: Vec<_> = modes.iter().map(|m| (m.highest, m.further)).collect();
    assert_eq!(of_peak, [(20, 0), (0, 1), (0, 0)]);
    let second = &modes[1];
    assert_eq!(second.stuck_frequency_hz, Some(3100.0));
    let moments = second.frequency_hz.moments.unwrap();
    assert_eq!((moments.minimum, moments.maximum), (3100.0, 3118.0));
    assert_eq!(second.clearness.map(|[_, lowest]| lowest), Some(0.6));
    let highest = &second.frequency_hz.quantiles[2];
    assert_eq!(
        highest.failure_bounds.upper.value(),
        None,
        "one may be higher"
    );
    let unfollowed = SyntheticStudy::new(20);
    assert!(Summary::of(&unfollowed.input()).levels[0].modes.is_none());
}

/// The page has a row for each level and mode, also for one without a maximum. Seen to fail without the
/// section, and with the clearness as a number beside a percentage.
#[test]
fn the_page_shows_every_mode() {
    let mut study = study();
    // no error of the amplitude is known
    for peak in study
        .outcomes
        .iter_mut()
        .filter_map(|o| o.levels[1].peak.as_mut())
    {
        peak.truncation_error = MaybeReal::NONE;
    }
    let folder = tempfile::tempdir().unwrap();
    report::write(folder.path(), &study.input()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    for words in [
        "Resonances of all modes",
        "mode 5",
        "stuck 3100.00 Hz",
        "mode 7",
        ">90 %<small>at least 90 %</small>",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("NaN"));
}
