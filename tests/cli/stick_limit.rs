//! At a small excitation every contact of the built-in rig sticks: the resonance frequency is then a function of the
//! stiffness alone, and whatever a study says of its scatter can be checked against linear algebra.

use std::path::Path;

use microslip::ensemble::store::read_samples;
use microslip::hb::Problem;
use microslip::hb::structure::resonance::{linear_resonance, linear_response};
use microslip::statistics::{Observed, quantile_estimate};
use microslip::study::Study;
use microslip::units::rad_s_to_hz;
use serde_json::Value;

use super::microslip;

const STUDY: &str = r#"name = "stick limit"
seed = 11
samples = 256
levels = [0.1]

[model]
kind = "two-blade-strip"

[inputs.stiffness_scale]
distribution = "log-uniform"
low = 0.1
high = 10.0

[inputs.friction_coefficient]
distribution = "uniform"
low = 0.3
high = 0.8

[design]
kind = "pick-freeze"

[frequency]
band_hz = [2605, 2635]

[output]
curve_samples = 0
"#;
/// Relative accuracy of a peak.
const ACCURACY: f64 = 1e-6;

/// Frequency (Hz) of the largest response of the rig with all contacts stuck and `scale` times their stiffness.
struct StuckRig<'a> {
    study: &'a Study,
}

impl StuckRig<'_> {
    fn frequencies(&self, scales: &[f64]) -> Vec<f64> {
        let prepared = self.study.prepared().unwrap();
        let anchor = self.study.solver.anchor;
        let problem =
            Problem::new(&prepared.linear, prepared.contacts.clone(), 1.0, anchor).unwrap();
        let frequency = |scale: &f64| {
            let k: Vec<f64> = problem.stuck_stiffness.iter().map(|k| k * scale).collect();
            let at = linear_resonance(&prepared.linear, &k, prepared.band())
                .unwrap()
                .unwrap();
            let response = |omega: f64| linear_response(&prepared.linear, &k, omega).norm();
            // largest response within a tenth of the half bandwidth of the undamped frequency
            let (mut low, mut high) = (
                at.omega - 0.1 * at.half_bandwidth,
                at.omega + 0.1 * at.half_bandwidth,
            );
            while high - low > 1e-7 * at.omega {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                match response(a) < response(b) {
                    true => low = a,
                    false => high = b,
                }
            }
            rad_s_to_hz(0.5 * (low + high))
        };
        scales.iter().map(frequency).collect()
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Seen to fail with mixed samples counted in the population, and with A and B exchanged in the rows of the indices.
#[test]
fn the_stick_limit_is_exact() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, STUDY).unwrap();
    let output = microslip(folder.path(), &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let results = folder.path().join("results");
    let stored = read_samples(&results.join("samples.parquet")).unwrap();
    let study = Study::read(&path).unwrap();
    let rig = StuckRig { study: &study };
    // every sample, mixed ones too
    let scales: Vec<f64> = stored.outcomes.iter().map(|o| o.inputs[0]).collect();
    let linear = rig.frequencies(&scales);
    for (outcome, expected) in stored.outcomes.iter().zip(&linear) {
        let found = outcome.levels[0].peak.unwrap().frequency_hz;
        assert!(
            (found / expected - 1.0).abs() < ACCURACY,
            "{found} {expected}: {outcome:?}"
        );
    }
    // quantiles: those of the stiffness, mapped; and the exact ones lie in the intervals
    let level = &json(&results.join("summary.json"))["levels"][0];
    let population = stored.outcomes.iter().filter(|o| o.group.of_population());
    let drawn = Observed::of(population.map(|o| o.inputs[0]));
    for (k, p) in [0.05, 0.5, 0.95].into_iter().enumerate() {
        let found = &level["frequency_hz"]["quantiles"][k];
        let scale = quantile_estimate(&drawn, p, 0.95).unwrap().estimate;
        let exact_scale = 10_f64.powf(2.0 * p - 1.0);
        let mapped = rig.frequencies(&[scale, exact_scale]);
        let estimate = found["estimate"].as_f64().unwrap();
        assert!(
            (estimate / mapped[0] - 1.0).abs() < ACCURACY,
            "{p}: {found} {mapped:?}"
        );
        let side = |name: &str| found["interval"][name].as_f64();
        let below = side("lower").is_none_or(|lower| lower <= mapped[1]);
        let above = side("upper").is_none_or(|upper| mapped[1] <= upper);
        assert!(below && above, "{p}: {} is not in {found}", mapped[1]);
    }
    // the stiffness is all
    let influences = &json(&results.join("report.json"))["levels"][0]["influences"];
    for (j, exact, words) in [(0, 1.0, "distinct"), (1, 0.0, "not_distinguishable")] {
        for kind in ["first", "total"] {
            let index = &influences[j]["frequency"]["pick_freeze"][kind];
            let [lower, upper] = ["lower", "upper"].map(|side| index[side].as_f64().unwrap());
            let holds = lower - ACCURACY <= exact && exact <= upper + ACCURACY;
            assert!(holds, "{kind} of input {j}: {index}");
            assert_eq!(index["influence"], words, "{kind} of input {j}: {index}");
        }
    }
}
