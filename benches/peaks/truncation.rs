//! Peaks whose truncation error is bounded, against the same peaks on 31 harmonics.

use crate::clock::processor_time;
use crate::rates::describe;
use crate::rig::{Rig, design, search, settings};
use microslip::ensemble::atlas::{Anchor, AtlasPrediction, ModePeaks};
use microslip::ensemble::outcome::{LevelOutcome, SampleOutcome};
use microslip::harmonics::HarmonicSet;
use microslip::hb::equations::balance::balance_on;
use microslip::hb::peak::predicted::maximum_near;
use microslip::hb::{AlertSettings, HbSettings, Status};
use rayon::prelude::*;
use std::collections::BTreeMap;

pub(crate) const CERTIFIED: AlertSettings = AlertSettings {
    threshold: 1e-3,
    highest_harmonic: 21,
    compared_with: 20,
};

/// Samples solved, and those of them that are compared with 31 harmonics.
const CERTIFIED_SAMPLES: u64 = 256;
const COMPARED: usize = 50;

/// Peaks whose truncation error is below 1e-3 by the alert, the first of them against the same peaks on 31 harmonics.
pub(crate) fn certified() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(17), settings(5, Some(CERTIFIED)));
    let levels = [1.0, 5.0, 20.0, 100.0];
    let ensemble = rig.ensemble(&design, &levels, &settings);
    let (seconds, solved) = processor_time(|| ensemble.solved(CERTIFIED_SAMPLES, || {}));
    let n_peaks = solved.outcomes.len() * levels.len();
    println!("{:.2} peaks per processor second", n_peaks as f64 / seconds);
    for (i, level) in levels.iter().enumerate() {
        let peaks: Vec<&LevelOutcome> = solved.outcomes.iter().map(|o| &o.levels[i]).collect();
        describe(&format!("{level} N"), &peaks);
        let mut fates: BTreeMap<(&str, u32), usize> = BTreeMap::new();
        for peak in &peaks {
            let highest = peak.peak.map_or(0, |p| p.highest_harmonic);
            *fates.entry((peak.status.name(), highest)).or_default() += 1;
        }
        println!("  {fates:?}");
    }
    let compared = solved.outcomes.par_iter().zip(&solved.anchors);
    let mut errors: Vec<f64> = compared
        .take(COMPARED)
        .flat_map_iter(|(outcome, anchor)| on_31_harmonics(&rig, &settings, outcome, anchor))
        .collect();
    errors.sort_by(f64::total_cmp);
    let above = errors.iter().filter(|e| **e > CERTIFIED.threshold).count();
    println!(
        "{} certified peaks against 31 harmonics: median {:.1e}, most {:.1e}, {above} above {:.0e}",
        errors.len(),
        errors[errors.len() / 2],
        errors[errors.len() - 1],
        CERTIFIED.threshold
    );
}

/// Relative changes of the certified amplitudes of one sample on 31 harmonics.
fn on_31_harmonics(
    rig: &Rig,
    settings: &HbSettings,
    outcome: &SampleOutcome,
    anchor: &Anchor,
) -> Vec<f64> {
    let problem = rig.problem(outcome.inputs[0], outcome.inputs[1]);
    let balance = balance_on(&problem, HarmonicSet::up_to(31), settings);
    let change = |(level, peaks): (&LevelOutcome, &ModePeaks)| {
        let mut peaks = peaks.iter();
        let peak = peaks.next().filter(|_| level.status == Status::Converged)?;
        let AtlasPrediction {
            harmonics,
            mut peak,
            amplitude,
        } = peak.as_prediction();
        let n_relative = balance.layout.n_relative();
        peak.point.r = harmonics.convert(&peak.point.r, n_relative, &balance.harmonics);
        match maximum_near(&balance, peak, search(), settings.newton) {
            Ok(best) => Some((best.iterate.response(&balance).norm() / amplitude - 1.0).abs()),
            Err(status) => {
                println!("{} N: {status:?} on 31 harmonics", level.level);
                None
            }
        }
    };
    let peaks = outcome.levels.iter().zip(&anchor.peaks);
    peaks.filter_map(change).collect()
}
