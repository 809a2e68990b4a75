//! Random small models on which an earlier program went wrong, with rounded numbers.

use super::{change, microslip, succeed};
use microslip::ensemble::store::read_samples;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// A symmetric matrix, row by row.
fn write_matrix(folder: &Path, name: &str, rows: &[&[f64]]) {
    let n = rows.len();
    let mut text = format!("%%MatrixMarket matrix array real general\n{n} {n}\n");
    for value in rows.iter().copied().flatten() {
        text += &format!("{value}\n");
    }
    std::fs::write(folder.join(name), text).unwrap();
}

/// The study `rest` of a model with these masses of the degrees of freedom, and these matrices.
fn model(masses: &[f64], stiffness: &[&[f64]], damping: &[&[f64]], rest: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let row = |(i, mass): (usize, &f64)| -> Vec<f64> {
        let on_diagonal = |j: usize| if i == j { *mass } else { 0.0 };
        (0..masses.len()).map(on_diagonal).collect()
    };
    let mass: Vec<Vec<f64>> = masses.iter().enumerate().map(row).collect();
    let mass: Vec<&[f64]> = mass.iter().map(Vec::as_slice).collect();
    write_matrix(folder.path(), "mass.mtx", &mass);
    write_matrix(folder.path(), "stiffness.mtx", stiffness);
    write_matrix(folder.path(), "damping.mtx", damping);
    let head = "\
name = \"small model\"
levels = [0.1]
[model]
kind = \"matrices\"
mass = \"mass.mtx\"
stiffness = \"stiffness.mtx\"
damping = \"damping.mtx\"
";
    std::fs::write(folder.path().join("study.toml"), format!("{head}{rest}")).unwrap();
    folder
}

/// What `solve` says of its only level.
fn curve(folder: &Path) -> Value {
    succeed(
        folder,
        &["solve", "study.toml", "--quiet", "--output", "curve"],
    );
    let text = std::fs::read_to_string(folder.join("curve/solution.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["levels"][0].clone()
}

const CORNER: &str = "\
dof_names = [\"a\", \"b\", \"c\"]
cosine_force = { a = 1.0 }
[[model.contact]]
name = \"one\"
t1 = { a = -1.28, c = -0.94, b = -1.03 }
k_t1 = 0.95
n = { a = 0.94, b = 0.05, c = 0.47 }
k_n = 0.69
n_0 = 0.14
mu = 0.1
[[model.contact]]
name = \"two\"
t1 = { c = 1.2 }
k_t1 = 0.66
n = { a = -0.17 }
k_n = 4.56
n_0 = 0.5
mu = 0.8
[contact]
law = \"box\"
[solver]
harmonics = 5
alert = false
[frequency]
band_rad_s = [0.5, 4.5]
";

/// At 1.747 and 1.768 rad/s the branch turns back at once where a contact changes its state, closer to the last solution than a step over a
/// corner is long. Seen to fail with the program before: STOPPED at both, and no peak.
#[test]
fn a_branch_is_followed_around_corners() {
    let stiffness: [&[f64]; 3] = [
        &[1.31, 0.3, -1.37],
        &[0.3, 4.72, -1.75],
        &[-1.37, -1.75, 3.37],
    ];
    let damping: [&[f64]; 3] = [
        &[0.0041, 0.0001, -0.002],
        &[0.0001, 0.0085, -0.0018],
        &[-0.002, -0.0018, 0.0068],
    ];
    let folder = model(&[1.0; 3], &stiffness, &damping, CORNER);
    let curve = curve(folder.path());
    assert!(curve["gap"].is_null(), "{}", curve["gap"]);
    assert_eq!(curve["largest_amplitude"]["is"], "maximum");
}

const SIDE_BY_SIDE: &str = "\
dof_names = [\"a\", \"b\", \"c\", \"d\"]
cosine_force = { a = 1.0 }
responses = [\"a\"]
[[model.contact]]
name = \"one\"
t1 = { a = 1.444, d = 0.322 }
k_t1 = 0.345
t2 = { c = 0.243 }
k_t2 = 3.134
n = { b = 1.945 }
k_n = 1.222
n_0 = 0.209
mu = 0.3
[[model.contact]]
name = \"two\"
t1 = { a = 0.864, d = -1.487 }
k_t1 = 1.133
t2 = { a = 0.265, d = 0.631, b = 0.508 }
k_t2 = 2.793
n = { c = 2.059 }
k_n = 4.735
n_0 = 0.374
mu = 0.8
[[model.contact]]
name = \"three\"
t1 = { a = 0.462, b = 0.994 }
k_t1 = 0.542
t2 = { b = 0.979 }
k_t2 = 0.773
n = { b = -0.122, d = -0.547 }
k_n = 0.63
n_0 = 0.623
mu = 0.8
[[model.contact]]
name = \"four\"
t1 = { b = -0.373, d = 2.686, c = 1.865 }
k_t1 = 3.635
t2 = { a = 0.42, b = -1.242 }
k_t2 = 1.268
n = { a = 2.397 }
k_n = 1.151
n_0 = 0.33
mu = 0.8
[contact]
law = \"box\"
[solver]
harmonics = 5
alert = false
[frequency]
band_rad_s = [0.5, 4.5]
";

/// Two maxima, 0.7 % apart in frequency and 6.8 % in height. Seen to fail with the program before: `run` has the lower one, 0.254 m.
#[test]
fn of_two_maxima_side_by_side_the_higher_one_is_the_peak() {
    let stiffness: [&[f64]; 4] = [
        &[6.703, -0.481, 0.645, 1.525],
        &[-0.481, 4.088, -1.148, 0.042],
        &[0.645, -1.148, 5.524, 1.45],
        &[1.525, 0.042, 1.45, 3.967],
    ];
    let damping: [&[f64]; 4] = [
        &[0.05127, -0.00205, 0.00208, 0.00664],
        &[-0.00205, 0.04002, -0.00534, 0.00084],
        &[0.00208, -0.00534, 0.04617, 0.00672],
        &[0.00664, 0.00084, 0.00672, 0.03869],
    ];
    let folder = model(&[1.0; 4], &stiffness, &damping, SIDE_BY_SIDE);
    let run = microslip(folder.path(), &["run", "study.toml", "--quiet"]);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let found = read_samples(&folder.path().join("results/samples.parquet")).unwrap();
    let peak = found.outcomes[0].levels[0].peak.expect("a peak");
    assert!(peak.amplitude_m > 0.27, "{}", peak.amplitude_m);
    let curve = curve(folder.path());
    let largest = &curve["largest_amplitude"];
    assert_eq!(largest["is"], "maximum", "{largest}");
    let largest = largest["amplitude"].as_f64().unwrap();
    let apart = peak.amplitude_m / largest - 1.0;
    assert!(apart.abs() < 1e-6, "{} and {largest}", peak.amplitude_m);
}

const TWO_MODES: &str = "\
dof_names = [\"x\", \"y\", \"strip\", \"lift\"]
static_force = { lift = 1 }
cosine_force = { x = 1, y = 1.2362 }
responses = [\"x\"]
[[model.contact]]
name = \"own\"
t1 = { strip = 1, x = -1 }
k_t1 = 0.6503
n = { lift = 1, y = -0.1876 }
k_n = 1.3977
mu = 0.2906
[[model.contact]]
name = \"next\"
t1 = { strip = 1 }
k_t1 = 0.6503
n = { lift = 1 }
k_n = 1.3977
mu = 0.2906
[solver]
harmonics = 3
alert = false
stability = \"off\"
[frequency]
band_hz = [0.065, 0.407]
peak = 2
";

/// The second mode, 0.339 Hz with stuck contacts, loses its track at this level; a sweep through the band finds the higher maximum of the first,
/// 0.641 m at 0.183 Hz. That is not the answer: it is 0.472 m at 0.3386 Hz (`solve`), or not known. Seen to fail with the program before.
#[test]
fn a_named_mode_does_not_get_the_maximum_of_another() {
    let stiffness: [&[f64]; 4] = [
        &[1.1313, 0.2524, 0.0, 0.0],
        &[0.2524, 4.2033, 0.0, 0.0],
        &[0.0, 0.0, 0.0179, 0.0],
        &[0.0, 0.0, 0.0, 0.0129],
    ];
    let damping: [&[f64]; 4] = [
        &[0.004117, 0.000308, 0.0, 0.0],
        &[0.000308, 0.007697, 0.0, 0.0],
        &[0.0, 0.0, 0.000101, 0.0],
        &[0.0, 0.0, 0.0, 0.000086],
    ];
    let masses = [1.0, 0.9365, 0.0378, 0.0378];
    let folder = model(&masses, &stiffness, &damping, TWO_MODES);
    change(folder.path(), "levels = [0.1]", "levels = [0.02, 0.08]");
    succeed(folder.path(), &["run", "study.toml", "--quiet"]);
    let found = read_samples(&folder.path().join("results/samples.parquet")).unwrap();
    let [low, high] = [0, 1].map(|level| found.outcomes[0].levels[level].peak);
    let is_second = |frequency: f64| (0.33..0.345).contains(&frequency);
    assert!(is_second(low.expect("tracked").frequency_hz));
    if let Some(peak) = high {
        assert!(is_second(peak.frequency_hz), "{peak:?}");
    }
}

const LIGHTLY_DAMPED: &str = "\
dof_names = [\"x\", \"y\"]
cosine_force = { x = 1.0, y = 1.0 }
responses = [\"x\"]
[[model.contact]]
name = \"stuck\"
t1 = { x = 1.0 }
k_t1 = 5e4
mu = 0.5
n_0 = 1e8
[frequency]
band_hz = [200, 1400]
peak = \"all\"
[operation]
speed_rpm = [3630, 3670]
engine_orders = [6]
";

/// Two masses that hardly move each other, at 334 Hz and 366 Hz with a damping ratio of 2e-4. The stored curves of the linear limits show their
/// half-power width. The lower maximum of the second mass lies on engine order 6 (363 to 367 Hz), of which the margin of the higher one says
/// nothing: the page does. Seen to fail with the program before: one point above the half power, and so no width.
#[test]
fn narrow_resonances_and_lower_maxima_are_shown() {
    let stiffness: [&[f64]; 2] = [&[1.7e6, -1e5], &[-1e5, 2.1e6]];
    let folder = model(&[0.4, 0.4], &stiffness, &stiffness, LIGHTLY_DAMPED);
    change(
        folder.path(),
        "damping = \"damping.mtx\"",
        "modal_damping_ratio = 2e-4",
    );
    succeed(folder.path(), &["run", "study.toml", "--quiet"]);
    let text =
        |name: &str| std::fs::read_to_string(folder.path().join("results").join(name)).unwrap();
    let record: Value = serde_json::from_str(&text("run.json")).unwrap();
    for limit in ["free", "stuck"] {
        let curve = record[limit]["curve"].as_array().unwrap();
        let points = curve
            .iter()
            .map(|point| ["frequency_hz", "amplitude_m"].map(|key| point[key].as_f64().unwrap()));
        let points: Vec<[f64; 2]> = points.collect();
        let top = points.iter().fold(
            [0.0; 2],
            |top, point| if point[1] > top[1] { *point } else { top },
        );
        let above = points
            .iter()
            .filter(|point| point[1] > top[1] / 2.0_f64.sqrt());
        let ends = above.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], point| {
            [a.min(point[0]), b.max(point[0])]
        });
        let quality = top[0] / (ends[1] - ends[0]);
        println!("{limit}: {quality}");
        assert!((2300.0..3100.0).contains(&quality), "{quality}");
    }
    let page = text("report.html");
    assert!(page.contains("lies on an engine order in 1 of 1 samples"));
}
