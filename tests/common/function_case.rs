//! A calibration of a function in place of the solver: study, matrices and measured response.

use std::path::Path;

use tempfile::TempDir;

/// The truth that the response is simulated from: resistance and load of the function 100 + load − resistance.
pub(crate) const TRUTH: [f64; 2] = [190.0, 160.0];

/// Two normal inputs in place of those of the study.
const INPUTS: &str = r#"[inputs.stiffness_scale]
distribution = "normal"
mean = 200
standard_deviation = 10
truncation = [100, 300]

[inputs.static_load_scale]
distribution = "normal"
mean = 150
standard_deviation = 5
truncation = [100, 200]

"#;

/// A study of a function in place of the solver, and the response of the truth at two levels with three repetitions each.
pub(crate) fn case() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let own = Path::new("studies/own-matrices");
    for name in ["mass.mtx", "stiffness.mtx"] {
        std::fs::copy(own.join(name), folder.path().join(name)).unwrap();
    }
    let text = std::fs::read_to_string(own.join("study.toml")).unwrap();
    let head = text.split("[inputs.").next().unwrap();
    let head = head.replacen(
        "samples = 100",
        "samples = 48\ntest_function = \"limit-state\"",
        1,
    );
    let study = format!("{head}{INPUTS}[frequency]\nband_hz = [300, 400]\n");
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let exact = 100.0 + TRUTH[1] - TRUTH[0];
    let mut table = "level [N],resonance frequency [Hz],amplitude [um]\n".to_owned();
    for level in [1.0, 20.0] {
        for (df, da) in [(0.5, 1.012), (-0.4, 0.994), (-0.1, 0.994)] {
            let (frequency, amplitude) = (exact + df, exact * da);
            table.push_str(&format!("{level},{frequency},{amplitude}\n"));
        }
    }
    std::fs::write(folder.path().join("response.csv"), table).unwrap();
    folder
}
