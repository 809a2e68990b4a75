//! A maximum that the searches of the modes miss, in a study.

use microslip::ensemble::store::read_samples;
use microslip::hb::PeakRoute;

use super::microslip;

const STUDY: &str = "\
name = \"contact that closes late\"
samples = 24
levels = [2.0]

[model]
kind = \"matrices\"
mass = \"mass.mtx\"
damping = \"damping.mtx\"
stiffness = \"stiffness.mtx\"
dof_names = [\"a\", \"b\"]
cosine_force = { a = 1.0 }

[[model.contact]]
name = \"late\"
n = { a = -0.4, b = -0.7 }
k_n = 0.7
n_0 = -0.2
mu = 0.3

[inputs.damping_scale]
distribution = \"uniform\"
low = 0.95
high = 1.05

[frequency]
band_rad_s = [0.5, 3.5]

[output]
curve_samples = 0
";

/// The search of the first mode ends at the maximum of the second, 34 m. By time integration from rest the vibration at nominal damping is 59 m
/// (`verification`, `the_peak_is_the_top_of_its_branch`). The first samples look along the branch, and those that start from them find the higher
/// maximum, too. Seen to fail with the program before: 33 to 36 m in all samples, each `converged`.
#[test]
fn samples_go_to_the_top_of_the_branch() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, [a, b, c]: [f64; 3]| {
        let head = "%%MatrixMarket matrix coordinate real symmetric";
        let text = format!("{head}\n2 2 3\n1 1 {a}\n2 1 {b}\n2 2 {c}\n");
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    file("mass.mtx", [1.0, 0.0, 1.0]);
    file("damping.mtx", [0.02, 0.0, 0.02]);
    file("stiffness.mtx", [1.2, -0.5, 1.2]);
    std::fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    let run = microslip(folder.path(), &["run", "study.toml", "--quiet"]);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let found = read_samples(&folder.path().join("results/samples.parquet")).unwrap();
    let mut predicted = 0;
    for outcome in &found.outcomes {
        let peak = outcome.levels[0].peak.expect("a peak");
        assert!((55.0..65.0).contains(&peak.amplitude_m), "{peak:?}");
        predicted += usize::from(peak.route == Some(PeakRoute::Predicted));
    }
    assert!(predicted > 12, "{predicted}");
}
