//! A maximum that the searches of the modes miss, in a study.

use microslip::ensemble::store::read_samples;
use microslip::hb::PeakRoute;

use super::small_models::{diagonal, levels_of_run, model, write_matrix};
use super::{change, microslip, succeed};

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

const TWO_MAXIMA: &str = "\
dof_names = [\"a\", \"b\", \"c\", \"d\"]
static_force = { a = 0.2, b = -0.1, c = 0.05, d = 1.0 }
cosine_force = { a = 1.0, d = 0.1 }
sine_force = { b = 0.7, c = 0.05 }
responses = [{ name = \"y\", row = { a = 1.0, b = -0.5, c = 0.2 } }]

[[model.contact]]
name = \"preloaded\"
t1 = { a = 1.0, c = -1.0 }
k_t1 = 2.0
n = { b = -0.5, d = 1.0 }
k_n = 3.0
n_0 = 0.3
mu = 0.4

[[model.contact]]
name = \"gap\"
t1 = { a = 0.3, b = 1.0, c = -1.0, d = 0.2 }
k_t1 = 1.5
n = { a = 0.4, d = 0.7 }
k_n = 2.0
gap = 0.1
mu = 0.3

[design]
kind = \"file\"
path = \"design.csv\"

[solver]
harmonics = 9

[frequency]
band_hz = [0.11, 0.22]

[output]
curve_samples = 0
";

const DESIGN: &str = "\
friction_coefficient,stiffness_scale,excitation_scale
0.330,0.944,1.267
0.315,1.035,1.320
0.233,1.029,1.356
0.389,0.916,1.378
0.202,0.941,1.240
0.286,0.899,1.479
";

/// The last sample starts from others whose maximum near 0.142 Hz is the higher one. Its own is at 0.146 Hz, 3.130 m high; searched alone it is found.
/// Maxima that come near the highest one of their branch are starts, too. Seen to fail with the program before: 3.023 m, `converged`.
#[test]
fn another_maximum_of_the_branch_may_become_the_higher_one() {
    let stiffness: [&[f64]; 4] = [
        &[1.0, -0.3, 0.0, 0.0],
        &[-0.3, 1.5, 0.0, 0.0],
        &[0.0, 0.0, 0.3, 0.0],
        &[0.0, 0.0, 0.0, 0.5],
    ];
    let mass: [&[f64]; 4] = [
        &[1.0, 0.2, 0.0, 0.1],
        &[0.2, 0.8, 0.1, 0.0],
        &[0.0, 0.1, 0.3, 0.05],
        &[0.1, 0.0, 0.05, 0.3],
    ];
    let damping = diagonal(&[0.04, 0.04, 0.06, 0.06]);
    let folder = model(&[1.0; 4], &stiffness, &damping, TWO_MAXIMA);
    write_matrix(folder.path(), "mass.mtx", &mass);
    change(folder.path(), "levels = [0.1]", "levels = [0.3]");
    std::fs::write(folder.path().join("design.csv"), DESIGN).unwrap();
    succeed(folder.path(), &["run", "study.toml", "--quiet"]);
    let found = read_samples(&folder.path().join("results/samples.parquet")).unwrap();
    let last = &found.outcomes[5].levels[0];
    let peak = last.peak.expect("a peak");
    assert!(
        peak.route.is_some_and(PeakRoute::is_from_others),
        "{peak:?}"
    );
    assert!((peak.amplitude_m / 3.1297 - 1.0).abs() < 1e-3, "{peak:?}");
    let other = last.around.others()[0].amplitude_m;
    assert!((other / 3.0234 - 1.0).abs() < 1e-3, "{other}");
}

/// A contact of a study, with its rows t1, t2, n and its constants k_t1, k_t2, k_n, mu, n_0.
fn contact(name: &str, rows: [&str; 3], constants: [f64; 5]) -> String {
    let [t1, t2, n] = rows;
    let [k_t1, k_t2, k_n, mu, n_0] = constants;
    format!(
        "[[model.contact]]\nname = \"{name}\"\nt1 = {{ {t1} }}\nt2 = {{ {t2} }}\nn = {{ {n} }}\n\
         k_t1 = {k_t1:?}\nk_t2 = {k_t2:?}\nk_n = {k_n:?}\nmu = {mu:?}\nn_0 = {n_0:?}\n\n"
    )
}

/// A model of three masses whose branch breaks where a contact that rests at its friction limit begins to creep.
fn broken_branch() -> String {
    let rows = ["b = 1.0, c = -0.139", "a = 1.0", "c = 1.0"];
    let preloaded = contact(
        "preloaded",
        rows,
        [603030.0, 603030.0, 131705.0, 0.179537, 7.8846],
    );
    let rows = ["c = 1.0", "a = 1.0", "b = 1.0"];
    let gap = contact(
        "gap",
        rows,
        [453242.0, 1.23217e6, 38402.6, 0.969179, -0.00269175],
    );
    format!(
        "dof_names = [\"a\", \"b\", \"c\"]\nstatic_force = {{ b = 0.00055124 }}\n\
         cosine_force = {{ a = -1.573, b = 0.191 }}\nsine_force = {{ b = 0.118 }}\n\n\
         {preloaded}{gap}[contact]\nlaw = \"circle\"\n\n[frequency]\nband_hz = [42.0, 354.637]\n"
    )
}

/// Where the branch through the maximum ends within the band, sweeps meet the higher one, also if a sweep with one harmonic has led to the lower. Time
/// integration from rest has the higher one, 2.6128e-6 m at 108.37 Hz. Seen to fail with the program before: 2.5717e-6 m at 194.19 Hz, `converged`.
#[test]
fn sweeps_meet_the_higher_maximum_where_the_branch_ends() {
    let stiffness = [
        [297879.0, -78490.5, -494023.0],
        [-78490.5, 473237.0, 134535.0],
        [-494023.0, 134535.0, 1542210.0],
    ];
    let damping = [
        [10.6356, -1.38185, -9.93072],
        [-1.38185, 17.6853, 1.98571],
        [-9.93072, 1.98571, 49.9598],
    ];
    let masses = [0.630275, 0.905558, 2.54779];
    let folder = model(&masses, &stiffness, &damping, &broken_branch());
    change(folder.path(), "levels = [0.1]", "levels = [0.27003]");
    let peak = levels_of_run(folder.path())[0].peak.expect("a peak");
    assert!((peak.frequency_hz - 108.34).abs() < 0.1, "{peak:?}");
    assert!(
        (peak.amplitude_m / 2.6128e-6 - 1.0).abs() < 1e-3,
        "{peak:?}"
    );
}
