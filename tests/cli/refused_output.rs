//! A command that is refused leaves no folder behind, also none above that of `--output`; and one that would replace what it reads is
//! refused.

use std::path::Path;

use super::{STUDY, folder, microslip};

/// A rig whose folder is made before the model of its resonances is refused.
const RIG: &str = "name = \"rig\"\n[loading]\nkind = \"air\"\n[excitation]\ncycles = 1\nrun_in_cycles = 1\n\
    [response]\nstudy = \"blades.toml\"\n";
/// No mesh resolves the patches of this contact grid.
const BLADES: &str = "name = \"blades\"\nlevels = [1.0]\n[model]\nkind = \"two-blade-strip\"\ngap_mm = 9.98\n\
    contact_nodes = [50, 2]\n[frequency]\nband_hz = [2605, 2635]\n";
/// A test whose normal force pulls.
const LOOP: &str = "time [s],displacement [um],tangential [N],normal [N]\n0,0,1,-5\n0.1,1,2,-5\n";

/// Seen to fail with folders that are made and stay: `run`, `solve`, `calibrate`, `disk`, `compare`,
/// `merge` and `rig` left one.
#[test]
fn a_refused_command_leaves_no_folder() {
    let folder = folder("study.toml", "", "");
    let at = folder.path();
    for (name, text) in [
        ("rig.toml", RIG),
        ("blades.toml", BLADES),
        ("loop.csv", LOOP),
        ("K.mtx", "no matrix\n"),
    ] {
        std::fs::write(at.join(name), text).unwrap();
    }
    let lost = std::fs::read_to_string(at.join("study.toml")).unwrap();
    let lost = lost.replace("mass.mtx", "none.mtx");
    std::fs::write(at.join("lost.toml"), lost).unwrap();
    let commands: [&[&str]; 10] = [
        &["run", "lost.toml"],
        &["solve", "lost.toml"],
        &["identify", "loop.csv"],
        &["calibrate", "study.toml", "--measured", "none.csv"],
        &["rig", "rig.toml"],
        &["disk", "none"],
        &["import", "K=K.mtx", "--units", "SI"],
        &["compare", "none", "other"],
        &["merge", "none", "other"],
        &["reweight", "none", "study.toml"],
    ];
    for command in commands {
        let output = microslip(at, &[command, &["--output", "made/above/out"]].concat());
        assert_eq!(output.status.code(), Some(2), "{command:?}: {output:?}");
        assert!(!at.join("made").exists(), "{command:?}: a folder is left");
    }
}

/// A folder that was there stays, empty as it is.
#[test]
fn a_folder_of_the_user_stays() {
    let folder = folder("study.toml", "", "");
    let own = folder.path().join("own");
    std::fs::create_dir(&own).unwrap();
    let output = microslip(folder.path(), &["disk", "none", "--output", "own"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(own.exists(), "the folder of the user is gone");
}

/// Five periods of a contact of 10 N/um that slips at 30 N, as a table.
fn measured_loops() -> String {
    let mut table = "time [s],displacement [um],tangential [N],normal [N]\n".to_owned();
    let mut slider: f64 = 0.0;
    for k in 0..=1000 {
        let motion = 20.0 * (std::f64::consts::TAU * f64::from(k) / 200.0).sin();
        let force = (10.0 * (motion - slider)).clamp(-30.0, 30.0);
        slider = motion - force / 10.0;
        let time = 0.0005 * f64::from(k);
        table += &format!("{time},{motion:.6},{force:.6},100\n");
    }
    table
}

/// Refuses the command with the name of `input`, which keeps its bytes, and writes nothing.
fn refused_as_input(folder: &Path, command: &[&str], input: &str) {
    let content = || std::fs::read(folder.join(input)).unwrap();
    let files = || std::fs::read_dir(folder).unwrap().count();
    let before = (content(), files());
    let output = microslip(folder, command);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{command:?}: {message}");
    let expected = format!("{input}: is an input of this command, which would replace it");
    let named = message.contains(&expected);
    assert!(named, "{command:?}: {expected:?} is not in: {message}");
    assert!((content(), files()) == before, "{command:?} wrote");
}

/// An output under the name of a file that is read, by whatever path, is refused before anything is written. Seen to fail with a program
/// that looks at no input: `identify`, `pairs`, `run` and `solve` replaced theirs, with exit code 0.
#[test]
fn no_command_replaces_its_input() {
    let folder = folder("study.toml", "samples = 10", "samples = 2");
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).unwrap();
    write("loops.csv", &measured_loops());
    write("nodes.csv", "node,x,y,z\n1,0,0,0\n2,0,0,0\n");
    write("a.csv", "node\n1\n");
    write("b.csv", "node\n2\n");
    for (matrix, study) in [("run.json", "run.toml"), ("curve.csv", "solve.toml")] {
        write(matrix, super::MASS);
        write(study, &STUDY.replace("mass.mtx", matrix));
    }
    write("posterior.csv", "level [N],frequency [Hz]\n1,150\n");
    write("reweighted.json", "");
    let inside = format!("../{}", at.file_name().unwrap().to_string_lossy());
    refused_as_input(at, &["identify", "loops.csv", "--output", "."], "loops.csv");
    let around = ["identify", "loops.csv", "--output", &inside];
    refused_as_input(at, &around, "loops.csv");
    for input in ["nodes.csv", "a.csv", "b.csv"] {
        let pairs = ["pairs", "nodes.csv", "a.csv", "b.csv", "--tolerance", "0.1"];
        let pairs = [&pairs[..], &["--output", input]].concat();
        refused_as_input(at, &pairs, input);
    }
    refused_as_input(at, &["run", "run.toml", "--output", "."], "run.json");
    refused_as_input(at, &["solve", "solve.toml", "--output", "."], "curve.csv");
    let calibrate = ["calibrate", "study.toml", "--measured", "posterior.csv"];
    let calibrate = [&calibrate[..], &["--output", "."]].concat();
    refused_as_input(at, &calibrate, "posterior.csv");
    let reweight = ["reweight", ".", "--prior", "reweighted.json"];
    refused_as_input(at, &reweight, "reweighted.json");
}
