//! Static loads next to round-off: preloads that balance each other, and a load that the last digit of a large displacement hides.

use super::small_models::{levels_of_run, model};
use super::{change, succeed};
use microslip::ensemble::store::read_samples;
use std::fmt::Write;

/// Blades of a ring, each with a tangential and a normal coordinate, pressed together by their shrouds.
const BLADES: usize = 5;

/// The study of the ring, with a static force (N) on the first blade's normal coordinate.
fn study(force: f64) -> String {
    let names: Vec<String> = (0..BLADES)
        .flat_map(|i| ["t", "n"].map(|axis| format!("\"{axis}{i}\"")))
        .collect();
    let mut text = format!(
        "dof_names = [{}]\ncosine_force = {{ t0 = 1.0 }}\n",
        names.join(", ")
    );
    if force > 0.0 {
        writeln!(text, "static_force = {{ n0 = {force} }}").unwrap();
    }
    for i in 0..BLADES {
        let next = (i + 1) % BLADES;
        writeln!(
            text,
            "[[model.contact]]\nname = \"shroud {i}\"\nt1 = {{ t{i} = 1, t{next} = -1 }}\nn = {{ n{i} = 1, n{next} = -1 }}\n\
             k_t1 = 7e4\nk_n = 9e4\nmu = 0.3\nn_0 = 180"
        )
        .unwrap();
    }
    text + "[frequency]\nband_hz = [45, 65]\n[output]\ncurve_samples = 0\n"
}

/// Nothing but preloads acts at rest, and their sum on each blade is 0. All contacts stick, so that a force of 1 N, a hundredth of what the
/// springs of the shrouds carry, changes nothing. Seen to fail with the program before, whose residual at rest was compared with round-off:
/// `max-iterations`.
#[test]
fn preloads_that_balance_each_other_are_at_rest() {
    let stiffness = 1e5;
    let diagonal = |value: f64| -> Vec<Vec<f64>> {
        let row = |i: usize| {
            (0..2 * BLADES)
                .map(|j| if i == j { value } else { 0.0 })
                .collect()
        };
        (0..2 * BLADES).map(row).collect()
    };
    let (k, c) = (diagonal(stiffness), diagonal(3.0));
    let [k, c] = [&k, &c].map(|rows| rows.iter().map(Vec::as_slice).collect::<Vec<&[f64]>>());
    let peak = |force: f64| {
        let folder = model(&[1.0; 2 * BLADES], &k, &c, &study(force));
        change(folder.path(), "levels = [0.1]", "levels = [1.0]");
        levels_of_run(folder.path())[0].peak.expect("a peak")
    };
    let (balanced, pressed) = (peak(0.0), peak(1.0));
    assert!((balanced.amplitude_m / pressed.amplitude_m - 1.0).abs() < 1e-6);
    assert!((balanced.frequency_hz / pressed.frequency_hz - 1.0).abs() < 1e-6);
    assert_eq!(balanced.stick_fraction, 1.0);
}

/// 60 N press the damper of the shipped study on both blades, so its contacts carry them in every sample. Seen to fail with the program before:
/// samples 5 and 15 had the frequency of the free blade, 320.292 Hz, with all contacts open and a mean displacement of 9e10 m, whose last
/// digit hides the load.
#[test]
fn no_solution_drops_the_static_load() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["study.toml", "mass.mtx", "stiffness.mtx"] {
        let from = std::path::Path::new("studies/own-matrices").join(name);
        std::fs::copy(from, folder.path().join(name)).unwrap();
    }
    change(folder.path(), "samples = 100", "samples = 16");
    change(folder.path(), "curve_samples = 20", "curve_samples = 0");
    let text = std::fs::read_to_string(folder.path().join("study.toml")).unwrap();
    let text = text + "\n[design]\nkind = \"sobol\"\n";
    std::fs::write(folder.path().join("study.toml"), text).unwrap();
    succeed(folder.path(), &["run", "study.toml", "--quiet"]);
    let found = read_samples(&folder.path().join("results/samples.parquet")).unwrap();
    assert_eq!(found.outcomes.len(), 16);
    for outcome in &found.outcomes {
        let peak = outcome.levels[1].peak.expect("a peak");
        assert!(peak.separated_fraction < 1.0, "{}: {peak:?}", outcome.index);
    }
}
