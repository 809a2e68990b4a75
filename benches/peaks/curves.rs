//! What the curve of a sample costs beside its peak.

use crate::clock::processor_time;
use crate::rig::{Rig, design, settings};
use microslip::ensemble::Ensemble;
use microslip::ensemble::outcome::SampleOutcome;

const SAMPLES: u64 = 16;
const CURVE_LEVELS: [f64; 3] = [0.1, 5.0, 20.0];

/// Factorisations of the curves and of the peaks of each level, and their processor time: the same samples with and without curves.
pub(crate) fn curves() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(2026), settings(5, None));
    let peaks = rig.ensemble(&design, &CURVE_LEVELS, &settings);
    let with_curves = Ensemble {
        curve_samples: SAMPLES,
        ..rig.ensemble(&design, &CURVE_LEVELS, &settings)
    };
    let run = |ensemble: &Ensemble<'_>| processor_time(|| ensemble.run(SAMPLES, || {}));
    let (alone, outcomes) = run(&peaks);
    let (together, with) = run(&with_curves);
    let mean = |outcomes: &[SampleOutcome], i: usize| {
        let of_level = outcomes
            .iter()
            .map(|o| f64::from(o.levels[i].factorizations));
        of_level.sum::<f64>() / SAMPLES as f64
    };
    for (i, level) in CURVE_LEVELS.iter().enumerate() {
        let (peak, both) = (mean(&outcomes, i), mean(&with, i));
        println!(
            "{level} N: factorisations per peak {peak:.1}, per curve {:.1}",
            both - peak
        );
    }
    println!(
        "{SAMPLES} samples: peaks {alone:.2} s of processor time, curves {:.2} s: {:.1} times",
        together - alone,
        (together - alone) / alone
    );
}
