//! Configuration b of the virtual rig: the resonances of two blades, as a user measures them.

use super::command::{RIG, run};
use microslip::model::two_blade::TwoBladeSettings;
use microslip::record::read_response;
use microslip::rig::Rig;

/// Studies that no virtual rig has, by name; the narrow one is refused when its model is built.
const NO_STUDIES: [(&str, &str); 2] = [
    (
        "disk.toml",
        "[model]\nkind = \"cyclic\"\nsector = \"blade-strip\"\nsectors = 12\n[operation]\nspeed_rpm = [1000, 2000]\n\
         engine_orders = [3]\n",
    ),
    (
        "narrow.toml",
        "[model]\nkind = \"two-blade-strip\"\ncontact_nodes = [50, 2]\ngap_mm = 9.98\nblade_element_mm = [15, 25, 25]\n\
         [contact]\nfriction_coefficient = 3\n",
    ),
];

/// What `rig` says on standard error with a study of `[response]` that it refuses.
fn refused_response(study: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    for (name, sections) in NO_STUDIES {
        let head = "name = \"no rig\"\nlevels = [1.0]\n";
        let text = format!("{head}{sections}[frequency]\nband_hz = [2605, 2635]\n");
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let shown = RIG.replace("samples_per_cycle = 100", "samples_per_cycle = 250");
    let text = format!("{shown}[response]\nstudy = \"{study}\"\n");
    let output = run(folder.path(), &text, &[]);
    assert_eq!(output.status.code(), Some(2), "{study}: {output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// No test is simulated before: there is no progress. A disk is called so, and unusual values are warned of. Seen to fail with the
/// study read after the tests, with `kind = "matrices"` for a disk, and without the warning.
#[test]
fn a_wrong_response_study_costs_no_simulation() {
    for (study, expected) in [
        (
            "none.toml",
            &[
                "error: rig.toml:17: response.study = \"none.toml\": must name a file: there is no none.toml",
            ][..],
        ),
        (
            "disk.toml",
            &["error: disk.toml:4: model.kind = cyclic: must be \"two-blade-strip\""],
        ),
        (
            "narrow.toml",
            &[
                "warning: narrow.toml:9: contact.friction_coefficient = 3: is unusual",
                "error: narrow.toml:5: model.contact_nodes = [50, 2]: must be fewer",
            ],
        ),
    ] {
        let said = refused_response(study);
        assert_eq!(said.lines().count(), expected.len(), "{study}: {said}");
        for (line, expected) in said.lines().zip(expected) {
            assert!(line.starts_with(expected), "{study}: {said}");
        }
    }
}

/// The study of two blades with a coarse contact, at one level.
pub(crate) fn coarse_study() -> String {
    let study = std::fs::read_to_string("studies/two-blade-strip/study.toml").unwrap();
    let study = study.replace("levels = [0.1, 5.0, 20.0]", "levels = [20.0]");
    let coarse = "kind = \"two-blade-strip\"\ncontact_nodes = [2, 2]";
    study.replace("kind = \"two-blade-strip\"", coarse)
}

/// A frequency that is measured below 0 is none. Seen to fail without the limit.
#[test]
fn a_frequency_deviation_leaves_a_frequency() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), coarse_study()).unwrap();
    let keys = "study = \"study.toml\"\nfrequency_deviation_hz = 300";
    let output = run(folder.path(), &format!("{RIG}[response]\n{keys}\n"), &[]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    let expected = "rig.toml:18: response.frequency_deviation_hz = 300: must be at most a tenth of the frequency at which the band of the \
                    study begins: 260.5 Hz";
    assert!(error.contains(expected), "{error}");
}

/// Nothing is stated of a frequency that is measured exactly, so that the file can be read. Seen to fail with a column of zeros.
#[test]
fn a_response_states_no_deviation_of_zero() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), coarse_study()).unwrap();
    let keys = "study = \"study.toml\"\nfrequency_deviation_hz = 0";
    let rig = RIG.replace("specimens = 2", "specimens = 1");
    let output = run(folder.path(), &format!("{rig}[response]\n{keys}\n"), &[]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{error}");
    let read = read_response(&folder.path().join("out/response-0001.csv")).unwrap();
    let [point] = read.points[..] else {
        panic!("{read:?}");
    };
    assert_eq!(point.frequency_deviation_hz, None);
    let relative = point.amplitude_deviation_m.unwrap() / point.amplitude_m;
    assert!((relative / 0.01 - 1.0).abs() < 0.1, "{relative}");
}

/// Configuration b: the peaks are those of `solve` with the contact of the specimen, plus errors of the stated size. Seen to fail with the
/// friction coefficient of the study in place of the specimen's.
#[test]
fn resonances_are_those_of_the_study_with_the_true_contact() {
    let study = coarse_study();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), &study).unwrap();
    let text = RIG.replace("specimens = 2", "friction_coefficient = 0.3");
    let text = format!("{text}\n[response]\nstudy = \"study.toml\"");
    let path = folder.path().join("rig.toml");
    let rig = Rig::parse(&path, &text).unwrap();
    let found = rig.resonances().unwrap();
    assert_eq!(found.len(), 1);
    let peak = found[0].peak.unwrap();
    let mu = rig.specimen(0).friction_coefficient;
    let direct = study.replace(
        "friction_coefficient = 0.6",
        &format!("friction_coefficient = {mu}"),
    );
    let direct = microslip::study::Study::parse(&path, &direct).unwrap();
    let prepared = direct.prepared().unwrap();
    let ensemble = prepared.ensemble(None);
    let names: Vec<_> = (direct.design.inputs().iter().map(|(input, _)| input.name())).collect();
    assert_eq!(names, ["stiffness_scale", "friction_coefficient"]);
    let levels = ensemble.levels(&[1.0, mu], &microslip::ensemble::atlas::Atlas::default());
    let expected = levels[0].peak.unwrap();
    let ratio = peak.true_frequency_hz / expected.frequency_hz;
    assert!((ratio - 1.0).abs() < 1e-8, "{ratio}");
    let ratio = 1e-6 * peak.true_amplitude_um / expected.amplitude_m;
    assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    assert!(
        peak.frequency_hz != peak.true_frequency_hz,
        "no measuring error"
    );
    assert!(
        (peak.frequency_hz - peak.true_frequency_hz).abs() < 5.0 * 0.05,
        "{peak:?}"
    );
}

/// In configuration b the strip is pressed as the file says: by the load of the study, or by that of `[loading]`, which is then the same as if the
/// study had it. Seen to fail with the load of the study in both.
#[test]
fn what_presses_the_strip_of_two_blades_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.toml");
    let write = |study: &str| std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let study = coarse_study();
    write(&study);
    let rig = |kind: &str, more: &str| {
        let text = RIG.replace("specimens = 2", "specimens = 1");
        let text = text.replace("\"air\"", kind);
        let text = format!("{text}\n[response]\nstudy = \"study.toml\"\n{more}");
        Rig::parse(&path, &text).unwrap()
    };
    let peak = |rig: &Rig, load: f64| {
        let resonance = &rig.resonances().unwrap()[0];
        assert!(
            (resonance.strip_load_n / load - 1.0).abs() < 0.03,
            "{resonance:?}"
        );
        let peak = resonance.peak.unwrap();
        [peak.true_frequency_hz, peak.true_amplitude_um]
    };
    let by_study = peak(&rig("\"air\"", ""), 180.0);
    let [air, punch] = ["\"air\"", "\"punch\""].map(|kind| rig(kind, "pressed_by = \"loading\""));
    let (by_air, by_punch) = (peak(&air, 131.6), peak(&punch, 196.1));
    println!("{by_study:?} {by_air:?} {by_punch:?}");
    let apart = |a: [f64; 2], b: [f64; 2]| (a[1] / b[1] - 1.0).abs();
    assert!(apart(by_study, by_air) > 0.01 && apart(by_air, by_punch) > 0.01);
    let blades = TwoBladeSettings {
        contact_nodes: [2, 2],
        ..TwoBladeSettings::default()
    };
    let pressed = air.loading.pressed(&blades).unwrap();
    let load = format!(
        "contact_nodes = [2, 2]\ncentrifugal_load_n = {}\npressure_weights = {:?}",
        pressed.centrifugal_load_n,
        pressed.pressure_weights.unwrap()
    );
    write(&study.replace("contact_nodes = [2, 2]", &load));
    let by_study = peak(&rig("\"air\"", ""), 131.6);
    for (ours, theirs) in by_study.iter().zip(by_air) {
        assert!((ours / theirs - 1.0).abs() < 1e-9, "{ours} {theirs}");
    }
}

/// A load that the strip of the study cannot take is refused where it is asked for. Seen to fail without the check.
#[test]
fn a_load_that_does_not_fit_the_strip_of_the_study_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let narrow = "contact_nodes = [2, 2]\nstrip_mm = [2.0, 50.0, 0.4]";
    let study = coarse_study().replace("contact_nodes = [2, 2]", narrow);
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let keys = "study = \"study.toml\"\npressed_by = \"loading\"";
    let output = run(folder.path(), &format!("{RIG}[response]\n{keys}\n"), &[]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        error.contains("rig.toml:8: loading.margin_mm = 1: must be below"),
        "{error}"
    );
}
