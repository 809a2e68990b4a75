//! Random small models on which an earlier program went wrong, with rounded numbers.

use super::{change, microslip, succeed};
use microslip::ensemble::outcome::LevelOutcome;
use microslip::ensemble::store::read_samples;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// A symmetric matrix, row by row.
pub(crate) fn write_matrix(folder: &Path, name: &str, rows: &[impl AsRef<[f64]>]) {
    let n = rows.len();
    let mut text = format!("%%MatrixMarket matrix array real general\n{n} {n}\n");
    for value in rows.iter().flat_map(AsRef::as_ref) {
        text += &format!("{value}\n");
    }
    std::fs::write(folder.join(name), text).unwrap();
}

/// Rows of the matrix with these values on its diagonal.
pub(crate) fn diagonal(values: &[f64]) -> Vec<Vec<f64>> {
    let row = |(i, value): (usize, &f64)| {
        let mut row = vec![0.0; values.len()];
        row[i] = *value;
        row
    };
    values.iter().enumerate().map(row).collect()
}

/// The study `rest` of a model with these masses of the degrees of freedom, and these matrices.
pub(crate) fn model(
    masses: &[f64],
    stiffness: &[impl AsRef<[f64]>],
    damping: &[impl AsRef<[f64]>],
    rest: &str,
) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_matrix(folder.path(), "mass.mtx", &diagonal(masses));
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

/// The levels of the only sample of a run.
pub(crate) fn levels_of_run(folder: &Path) -> Box<[LevelOutcome]> {
    succeed(folder, &["run", "study.toml", "--quiet"]);
    let found = read_samples(&folder.join("results/samples.parquet")).unwrap();
    let [outcome] = <[_; 1]>::try_from(found.outcomes).unwrap();
    outcome.levels
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
    let levels = levels_of_run(folder.path());
    let [low, high] = [0, 1].map(|level| levels[level].peak);
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

const KINKED: &str = "\
dof_names = [\"a\", \"b\"]
static_force = { a = -0.69, b = 0.58 }
cosine_force = { b = -0.7 }
[[model.contact]]
name = \"first\"
t1 = { b = 0.7 }
t2 = { a = -1.0, b = 0.5 }
n = { a = 1.0 }
k_t1 = 2.45
k_t2 = 0.125
k_n = 1.61
mu = 1.0
n_0 = 1.0
[[model.contact]]
name = \"second\"
t1 = { b = -1.0 }
t2 = { a = 0.7 }
k_t1 = 2.56
k_t2 = 0.27
mu = 0.3
n_0 = 0.99
[contact]
law = \"circle\"
[frequency]
band_rad_s = [0.65, 2.4]
";

/// At 0.2 the slope of the amplitude jumps at the maximum of the first mode, 0.259 m at 1.6745 rad/s: by time integration from rest it is 0.25908 m
/// there. Seen to fail with the program before, whose secants did not come to the jump: 0.0935 m at 1.915 rad/s, `converged`.
#[test]
fn a_maximum_at_a_corner_is_the_peak() {
    let stiffness: [&[f64]; 2] = [&[2.77, -0.81], &[-0.81, 1.63]];
    let damping: [&[f64]; 2] = [&[0.154, -0.045], &[-0.045, 0.0905]];
    let folder = model(&[1.55, 1.35], &stiffness, &damping, KINKED);
    change(folder.path(), "levels = [0.1]", "levels = [0.2, 0.25, 0.3]");
    let marched = [0.25908, 0.28148, 0.30173];
    for (level, marched) in levels_of_run(folder.path()).iter().zip(marched) {
        let peak = level.peak.expect("a peak");
        println!("{peak:?}");
        assert!((peak.amplitude_m / marched - 1.0).abs() < 3e-3, "{peak:?}");
    }
}

const STICKS_AT_THE_OTHER: &str = "\
dof_names = [\"a\", \"b\"]
static_force = { a = 0.134, b = 0.199 }
cosine_force = { a = -0.0144 }
[[model.contact]]
name = \"both\"
t1 = { a = -1.0 }
t2 = { b = 1.0 }
k_t1 = 0.121
k_t2 = 1.816
mu = 0.1
n_0 = 0.89
[contact]
law = \"circle\"
[frequency]
band_rad_s = [0.586, 1.996]
[output]
curve_samples = 0
";

/// The same where the contact sticks at the lower maximum, 1.658 rad/s, and Newton's method does not come close to the corner. By time integration
/// from rest the higher one is 0.05888 m at 0.356 and 0.06008 m at 0.432. Seen to fail with the program before: 0.0205 to 0.0249 m at these levels,
/// `converged`.
#[test]
fn a_corner_that_is_hard_to_solve_is_the_peak() {
    let stiffness: [&[f64]; 2] = [&[2.61, -0.81], &[-0.81, 1.54]];
    let damping: [&[f64]; 2] = [&[0.069, -0.021], &[-0.021, 0.041]];
    let folder = model(&[1.29, 1.52], &stiffness, &damping, STICKS_AT_THE_OTHER);
    let levels = "levels = [0.356, 0.364, 0.38, 0.384, 0.424, 0.432]";
    change(folder.path(), "levels = [0.1]", levels);
    let levels = levels_of_run(folder.path());
    let peaks = levels.iter().map(|level| level.peak.expect("a peak"));
    let amplitudes: Vec<f64> = peaks.map(|peak| peak.amplitude_m).collect();
    println!("{amplitudes:?}");
    assert!(amplitudes.windows(2).all(|pair| pair[0] < pair[1]));
    let ends = [amplitudes[0] / 0.058_88, amplitudes[5] / 0.060_08];
    assert!(
        ends.iter().all(|share| (share - 1.0).abs() < 1e-3),
        "{ends:?}"
    );
}

const TWO_MODES_OF_ONE_SLIDER: &str = "\
dof_names = [\"a\", \"b\", \"c\"]
cosine_force = { c = 0.918 }
[[model.contact]]
name = \"slider\"
t1 = { a = 0.7 }
t2 = { c = -1.0 }
k_t1 = 3.93
k_t2 = 1.137
mu = 0.3
n_0 = 2.51
[contact]
law = \"circle\"
[frequency]
band_rad_s = [0.694, 2.366]
[output]
curve_samples = 1
";

/// The contact sticks at the peak, 2.056 rad/s, and slips around the first mode, at 1.22 rad/s, where the response is 0.110 m at 0.08 (`solve`).
/// Seen to fail with the program before, whose curve had the stuck structure there: 0.373 m.
#[test]
fn a_curve_of_sticking_contacts_ends_where_another_mode_makes_them_slip() {
    let stiffness: [&[f64]; 3] = [
        &[1.637, -0.555, 0.0],
        &[-0.555, 2.96, -1.4185],
        &[0.0, -1.4185, 2.938],
    ];
    let damping: [&[f64]; 3] = [
        &[0.01675, -0.00568, 0.0],
        &[-0.00568, 0.03028, -0.01451],
        &[0.0, -0.01451, 0.03006],
    ];
    let masses = [0.526, 0.761, 1.936];
    let folder = model(&masses, &stiffness, &damping, TWO_MODES_OF_ONE_SLIDER);
    change(folder.path(), "levels = [0.1]", "levels = [0.08]");
    let level = &levels_of_run(folder.path())[0];
    let peak = level.peak.expect("a peak").amplitude_m;
    let sweeps = level.around.sweeps().expect("a curve through the band");
    for amplitude in [sweeps.upward.amplitude_m, sweeps.downward.amplitude_m] {
        assert!((amplitude / peak - 1.0).abs() < 3e-3, "{amplitude} {peak}");
    }
}

const BY_DAMPING: &str = "\
dof_names = [\"a\", \"b\"]
cosine_force = { b = 1.0 }
[[model.contact]]
name = \"slider\"
t1 = { b = 1.0 }
k_t1 = 1.0
mu = 0.3
n_0 = 1.0
[frequency]
band_rad_s = [0.5, 3.0]
[output]
curve_samples = 0
";

/// Nothing but the damping matrix leads from the force on b to the response of a. By time integration from rest it is 0.03335 m. Seen to fail
/// with the program before: `no-peak-in-band`.
#[test]
fn a_response_that_only_damping_moves_has_its_peak() {
    let stiffness: [&[f64]; 2] = [&[2.0, 0.0], &[0.0, 2.5]];
    let damping: [&[f64]; 2] = [&[0.04, -0.02], &[-0.02, 0.05]];
    let folder = model(&[1.0, 1.0], &stiffness, &damping, BY_DAMPING);
    let peak = levels_of_run(folder.path())[0].peak.expect("a peak");
    assert!(
        (peak.amplitude_m / 0.033_347 - 1.0).abs() < 1e-3,
        "{peak:?}"
    );
}
