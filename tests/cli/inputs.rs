//! Inputs beyond stiffness and friction of all contacts, from study file to results.

use microslip::ensemble::outcome::PeakRecord;
use std::path::Path;

use super::{STUDY, folder, microslip};

/// Peaks of a run over the rows of `csv`: sample × level.
fn peaks(study: &str, csv: &str) -> Vec<Vec<PeakRecord>> {
    let folder = tempfile::tempdir().unwrap();
    let matrices = super::folder("study.toml", "samples = 10", "samples = 10");
    for name in ["mass.mtx", "stiffness.mtx"] {
        std::fs::copy(matrices.path().join(name), folder.path().join(name)).unwrap();
    }
    let text = format!("{study}\n[design]\nkind = \"file\"\npath = \"rows.csv\"\n");
    std::fs::write(folder.path().join("study.toml"), text).unwrap();
    std::fs::write(folder.path().join("rows.csv"), csv).unwrap();
    read_peaks(folder.path())
}

fn read_peaks(folder: &Path) -> Vec<Vec<PeakRecord>> {
    let output = microslip(folder, &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let path = folder.join("results/samples.parquet");
    let stored = microslip::ensemble::store::read_samples(&path).unwrap();
    let levels = stored.outcomes.into_iter().map(|outcome| outcome.levels);
    levels
        .map(|levels| {
            levels
                .into_iter()
                .map(|level| level.peak.unwrap())
                .collect()
        })
        .collect()
}

/// The two masses without the sections of inputs and samples.
fn two_masses() -> String {
    let (head, tail) = STUDY.split_once("[inputs.friction_coefficient]").unwrap();
    let (_, tail) = tail.split_once("[solver]").unwrap();
    format!("{head}[solver]{tail}").replace("samples = 10\n", "")
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * b.abs()
}

/// Twice the excitation at level 1 is level 2; twice the damping and twice the excitation, stuck, is the amplitude of once.
/// Seen to fail with the excitation left as it is.
#[test]
fn excitation_and_damping_are_scaled() {
    let study = two_masses();
    let found = peaks(&study, "excitation_scale\n1\n2\n0.5\n");
    let (one, two, half) = (&found[0], &found[1], &found[2]);
    assert!(close(two[0].amplitude_m, one[1].amplitude_m), "{found:?}");
    assert!(close(half[1].amplitude_m, one[0].amplitude_m), "{found:?}");
    assert!(!close(two[1].amplitude_m / one[1].amplitude_m, 2.0) || one[1].slip_fraction == 0.0);
    let gentle = study.replace("[1.0, 2.0]", "[0.001]");
    let found = peaks(
        &gentle,
        "excitation_scale,damping_scale\n1,0.1\n2,0.2\n1,0.4\n",
    );
    let amplitude = |i: usize| found[i][0].amplitude_m;
    assert_eq!(found[0][0].stick_fraction, 1.0);
    // the other mode adds in proportion to the damping: 1 % of the amplitude for each step of 1 in the factor
    assert!(
        (amplitude(1) / amplitude(0) - 1.0).abs() < 3e-3,
        "{found:?}"
    );
    assert!(
        (4.0 * amplitude(2) / amplitude(0) - 1.0).abs() < 1e-2,
        "{found:?}"
    );
}

/// The one contact of the two masses is on the left; a right one is refused, and so is a friction coefficient beside that of the only
/// interface. Seen to fail with the pairs of the other side, and with the program before.
#[test]
fn inputs_of_a_side_need_that_side() {
    let study = two_masses();
    let common = peaks(&study, "friction_coefficient,stiffness_scale\n0.2,1.5\n");
    let left = peaks(
        &study,
        "left_friction_coefficient,left_stiffness_scale\n0.2,1.5\n",
    );
    assert_eq!(common, left);
    let fixed = |name: &str| format!("[inputs.{name}]\ndistribution = \"fixed\"\nvalue = 0.3\n");
    let refused = |inputs: &str, expected: &str| {
        let folder = folder("study.toml", "[solver]", &format!("{inputs}[solver]"));
        for command in ["inspect", "run"] {
            let output = microslip(folder.path(), &[command, "study.toml"]);
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{message}");
            assert!(message.contains(expected), "{message}");
        }
    };
    refused(
        &fixed("right_stiffness_scale"),
        ":32: inputs.right_stiffness_scale = (given): must be absent: no contact pair has interface = 1",
    );
    // the study has a common one
    refused(
        &fixed("left_friction_coefficient"),
        "inputs.friction_coefficient = (given): must be absent: it would act on nothing",
    );
}

const RIG: &str = r#"name = "rig"
levels = [LEVELS]
[model]
kind = "two-blade-strip"
[contact]
law = "box"
[solver]
harmonics = 1
alert = false
[frequency]
band_hz = [2605, 2635]
[output]
curve_samples = 0
"#;

/// The same factor on both sides is a factor on both, solved on all contacts instead of one half; `inspect` says so.
/// Seen to fail with the right side's stiffness put into the left pairs.
#[test]
fn equal_sides_are_the_folded_model() {
    let rig = RIG.replace("LEVELS", "0.1");
    let folded = peaks(&rig, "stiffness_scale\n2\n");
    let found = peaks(
        &rig,
        "left_stiffness_scale,right_stiffness_scale\n2,2\n2,0.5\n0.5,2\n",
    );
    assert!(close(found[0][0].frequency_hz, folded[0][0].frequency_hz));
    assert!(close(found[0][0].amplitude_m, folded[0][0].amplitude_m));
    // The first blade answers differently to the stiffer side. The resonance is that of one mode; the other mode of the two
    // blades, close by, shifts the maximum of the first blade by 1e-5.
    let [stiff_left, stiff_right] = [1, 2].map(|sample| found[sample][0].frequency_hz);
    assert!((stiff_left - stiff_right).abs() < 2e-5 * stiff_right);
    assert!(!close(found[1][0].frequency_hz, found[0][0].frequency_hz));
}

/// Even weights and `edge_pressure` = 1 are the weights of a rigid punch: its load left of s is 1/2 + asin(2s)/π.
/// Seen to fail with the load left as it is.
#[test]
fn edge_pressure_is_that_of_a_punch() {
    let weighted = |row: [f64; 5]| {
        let interface: Vec<f64> = [5.0, 8.0, 5.0]
            .iter()
            .flat_map(|w| row.map(|x| w * x))
            .collect();
        let weights = format!("{:?}", [interface.clone(), interface].concat());
        let model = format!("kind = \"two-blade-strip\"\npressure_weights = {weights}");
        let rig = RIG.replace("LEVELS", "20.0");
        rig.replace("kind = \"two-blade-strip\"", &model)
    };
    // weights of Gauss' rule with five points, and the punch's load between the ends of their cells
    let gauss: [f64; 5] = [
        0.236_926_885_056_189_1,
        0.478_628_670_499_366_5,
        0.568_888_888_888_888_9,
        0.478_628_670_499_366_5,
        0.236_926_885_056_189_1,
    ];
    let end = |cells: usize| gauss[..cells].iter().sum::<f64>() - 1.0;
    let left_of = |cells: usize| end(cells).clamp(-1.0, 1.0).asin();
    let punch = std::array::from_fn(|i| match i {
        4 => std::f64::consts::FRAC_PI_2 - left_of(4),
        _ => left_of(i + 1) - left_of(i),
    });
    let even = peaks(&weighted(gauss), "edge_pressure\n0\n0.5\n1\n");
    let punch = peaks(&weighted(punch), "stiffness_scale\n1\n");
    let [none, half, full] = [0, 1, 2].map(|i| even[i][0].amplitude_m);
    assert!(close(full, punch[0][0].amplitude_m), "{even:?} {punch:?}");
    assert!(close(even[2][0].frequency_hz, punch[0][0].frequency_hz));
    assert!(!close(none, full) && !close(none, half), "{even:?}");
}

/// With an edge pressure the model stays folded. A model without positions of its contacts refuses the input, and no value is
/// above 1.
#[test]
fn edge_pressure_needs_positions_and_is_at_most_1() {
    let input = |high: f64| {
        format!("[inputs.edge_pressure]\ndistribution = \"uniform\"\nlow = 0\nhigh = {high}\n")
    };
    let inspect = |study: &str, input: &str| {
        let folder = folder("study.toml", "samples = 10", "samples = 2");
        std::fs::write(
            folder.path().join("study.toml"),
            format!("{study}\n{input}"),
        )
        .unwrap();
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        let text = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(text).unwrap())
    };
    let rig = format!("samples = 2\n{}", RIG.replace("LEVELS", "20.0"));
    let (code, text) = inspect(&rig, &input(1.0));
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("edge_pressure") && !text.contains("solved on all contacts"),
        "{text}"
    );
    for (study, high, expected) in [
        (
            STUDY,
            1.0,
            "inputs.edge_pressure = (given): must be absent: a model of kind \"matrices\"",
        ),
        (
            &rig,
            1.5,
            "inputs.edge_pressure.distribution = uniform on (..., 1.5): must not give values above 1",
        ),
    ] {
        let (code, text) = inspect(study, &input(high));
        assert_eq!(code, Some(2), "{text}");
        assert!(text.contains(expected), "{text}");
    }
}

/// The pressure field shows in `inspect`, is a set of inputs, and moves the peak where contacts slip.
/// Seen to fail with the load left as it is.
#[test]
fn a_pressure_field_is_a_set_of_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let rig = RIG.replace("LEVELS", "20.0");
    let field =
        "[pressure_field]\nstandard_deviation = 0.1\ncorrelation_length_mm = 10\nmodes = 2\n";
    let write = |text: String| std::fs::write(folder.path().join("study.toml"), text).unwrap();
    write(format!("samples = 2\n{rig}{field}"));
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    let text = String::from_utf8_lossy(&output.stdout);
    for line in [
        "random inputs       pressure_mode_1, pressure_mode_2, pressure_mode_3, pressure_mode_4",
        "pressure field      2 modes per interface hold ",
    ] {
        assert!(text.contains(line), "{line:?} is not in: {text}");
    }
    let warnings = String::from_utf8_lossy(&output.stderr);
    let unfolded = "warning: solved on all contacts, not on one half of them: the sides differ by pressure_mode_1";
    assert!(warnings.contains(unfolded), "{warnings}");
    let found = read_peaks(folder.path());
    assert!(
        !close(found[0][0].amplitude_m, found[1][0].amplitude_m),
        "{found:?}"
    );
    for (old, new, expected) in [
        (
            "= 0.1",
            "= 0.5",
            ":16: pressure_field.standard_deviation = 0.5: must be at most 0.3",
        ),
        (
            "modes = 2",
            "modes = 9",
            ":18: pressure_field.modes = 9: must be from 1 to 8",
        ),
        (
            "mm = 10",
            "mm = 0",
            ":17: pressure_field.correlation_length_mm = 0: must be",
        ),
    ] {
        write(format!("samples = 2\n{rig}{}", field.replace(old, new)));
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(expected), "{message}");
    }
}
