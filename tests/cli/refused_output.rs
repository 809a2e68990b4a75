//! A command that is refused leaves no folder behind, also none above that of `--output`.

use super::{folder, microslip};

/// A rig whose tests are made before the study of its resonances is found missing.
const RIG: &str = "name = \"rig\"\n[loading]\nkind = \"air\"\n[excitation]\ncycles = 1\nrun_in_cycles = 1\n\
    [response]\nstudy = \"none.toml\"\n";
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
