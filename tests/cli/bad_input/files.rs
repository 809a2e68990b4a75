//! Files that are no study, no matrix or no table: one message with the file, and the line where there is one.

use super::{assert_refused, refuse_all};
use crate::{MASS, STUDY, folder, microslip};

/// Numbers of a Matrix Market file that no integer of the machine holds, and sizes that no memory does.
const NO_SIZE: &str = "18446744073709551617";

/// Not seen to fail: it holds what the reader of files does, and no other reader was built.
#[test]
fn integers_beyond_64_bits_are_refused() {
    let entries = format!("2 2 {NO_SIZE}");
    let sizes = format!("{NO_SIZE} {NO_SIZE} 2");
    let [row, column] = [format!("{NO_SIZE} 2 1.5"), format!("2 {NO_SIZE} 1.5")];
    let rule = |words: &str| format!("{NO_SIZE}{words}");
    refuse_all(
        "mass.mtx",
        &[
            (
                "2 2 2",
                &sizes,
                &[":2: size ", &rule(": must be an integer from 1 to ")],
            ),
            (
                "2 2 2",
                &entries,
                &[":2: ", &rule(" entries: must be an integer")],
            ),
            ("2 2 2", "2 2 -2", &[":2: -2 entries: must be an integer"]),
            (
                "2 2 2",
                "2 2 1000000000000000",
                &[":2: ", "entries: must be an integer"],
            ),
            (
                "2 2 1.5",
                &row,
                &[":4: row ", &rule(": must be an integer from 1 to 2")],
            ),
            (
                "2 2 1.5",
                &column,
                &[":4: column ", &rule(": must be an integer from 1 to 2")],
            ),
            (
                "2 2 1.5",
                "1 1 1.5",
                &[":4: entry (1, 1): must be given once"],
            ),
            (
                "2 2 1.5",
                "2 2 1e400",
                &[":4: entry (2, 2) = 1e400: must be a finite number"],
            ),
        ],
    );
}

/// Seen to fail with the definiteness checks taken out of `checked`.
#[test]
fn bad_stiffnesses_name_file_and_rule() {
    refuse_all(
        "stiffness.mtx",
        &[
            (
                "%%MatrixMarket",
                "%MatrixMarket",
                &[":1: must start with a Matrix Market header"],
            ),
            (
                "real general",
                "real hermitean",
                &[":1: must start with a Matrix Market header"],
            ),
            (
                "real general",
                "complex general",
                &[":1: must be a real or integer matrix"],
            ),
            ("2 2\n", "3 3\n", &["9 entries required"]),
            (
                "2 2\n",
                "2 2000000000000000000\n",
                &[":2: size 2000000000000000000: must be"],
            ),
            ("2 2\n", "1 4\n", &["is 1 x 4: must be square"]),
            (
                "-2e5\n-2e5",
                "-2e5\n-3e5",
                &["must be symmetric: entries (2, 1) = -200000 and (1, 2)"],
            ),
            (
                "8e5",
                "NaN",
                &["entry (2, 2) = NaN: must be a finite number"],
            ),
            ("8e5", "-8e5", &["must be positive semidefinite"]),
            (
                "8e5",
                "eight",
                &[":6: entry (2, 2) = eight: must be a number"],
            ),
        ],
    );
}

#[test]
fn bad_masses_name_file_and_rule() {
    let folder = folder("mass.mtx", "2 2 2\n1 1 1.0\n2 2 1.5", "1 1 1\n1 1 1.0");
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    assert_refused(
        "sizes",
        &output,
        &["stiffness.mtx: is 2 x 2: must be 1 x 1, the size of mass.mtx"],
    );
    refuse_all(
        "mass.mtx",
        &[
            (
                "2 2 1.5",
                "2 2 0.0",
                &["must be positive definite, but diagonal entry 2 is 0"],
            ),
            ("2 2 1.5", "2 3 1.5", &["mass.mtx"]),
            ("2 2 1.5", "0 2 1.5", &["indices start at 1"]),
            (MASS, "", &["the file is empty"]),
        ],
    );
}

#[test]
fn missing_files_are_named() {
    let folder = folder("study.toml", "stiffness.mtx", "stiff.mtx");
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    assert_refused(
        "missing matrix",
        &output,
        &["study.toml:9: model.stiffness = \"stiff.mtx\": must name a file: there is no stiff.mtx"],
    );
    let output = microslip(folder.path(), &["run", "studi.toml"]);
    assert_refused("missing study", &output, &["studi.toml: No such file"]);
    let output = microslip(folder.path(), &["inspect", "."]);
    assert_refused(
        "a folder as study",
        &output,
        &[".: is a folder, not a file"],
    );
}

/// Seen to fail with `read_to_string` of the standard library: "stream did not contain valid UTF-8".
#[test]
fn other_encodings_name_line_and_cure() {
    let folder = folder("study.toml", "two masses", "two masses");
    let utf16 = |text: &str, mark: bool| -> Vec<u8> {
        let mark = mark.then_some([0xff, 0xfe]).into_iter().flatten();
        mark.chain(text.encode_utf16().flat_map(u16::to_le_bytes))
            .collect()
    };
    let latin = STUDY.replacen("samples = 10", "samples = 10 # gr\u{fc}n", 1);
    let latin: Vec<u8> = latin.chars().map(|c| u32::from(c) as u8).collect();
    let cases: [(&str, Vec<u8>, &[&str]); 4] = [
        (
            "utf16.toml",
            utf16(STUDY, true),
            &["utf16.toml:1: is UTF-16 text: save the file as UTF-8"],
        ),
        (
            "bare.toml",
            utf16(STUDY, false),
            &["bare.toml:1: has a null byte", "UTF-16"],
        ),
        (
            "latin.toml",
            latin,
            &["latin.toml:3: byte 0xFC is no UTF-8: save the file as UTF-8"],
        ),
        (
            "binary.toml",
            vec![b'\n', 0xc3, 0x28],
            &["binary.toml:2: ", "UTF-8"],
        ),
    ];
    for (name, bytes, fragments) in cases {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let output = microslip(folder.path(), &["inspect", name]);
        assert_refused(name, &output, fragments);
    }
    std::fs::write(folder.path().join("mass.mtx"), utf16(MASS, true)).unwrap();
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    assert_refused("matrix", &output, &["mass.mtx:1: is UTF-16 text"]);
}

/// A pipe that nobody writes to.
#[cfg(unix)]
fn make_pipe(path: &std::path::Path) {
    let made = std::process::Command::new("mkfifo").arg(path).status();
    assert!(made.unwrap().success(), "mkfifo");
}

/// A device that never ends and a pipe that nobody writes to are refused at once, wherever a file is named.
///
/// Seen to fail with `std::fs::read_to_string`: 4 GB of memory, and a wait without end.
#[test]
#[cfg(unix)]
fn pipes_and_devices_are_refused() {
    let folder = folder("study.toml", "two masses", "two masses");
    let path = folder.path();
    let refused = |what: &str, arguments: &[&str], file: &str| {
        let expected = format!("{file}: is a pipe or a device: must be a regular file");
        assert_refused(what, &microslip(path, arguments), &[&expected]);
    };
    refused("device", &["inspect", "/dev/zero"], "/dev/zero");
    make_pipe(&path.join("pipe"));
    refused("study", &["run", "pipe"], "pipe");
    let write = |text: String| std::fs::write(path.join("study.toml"), text).unwrap();
    write(STUDY.replace("mass.mtx", "pipe"));
    refused("matrix", &["inspect", "study.toml"], "pipe");
    write(STUDY.replace("[\"x1\", \"x2\"]", "\"pipe\""));
    refused("names", &["inspect", "study.toml"], "pipe");
    for name in ["pipe.csv", "pipe.parquet"] {
        std::fs::rename(path.join("pipe"), path.join(name)).unwrap();
        write(format!(
            "{STUDY}\n[design]\nkind = \"file\"\npath = \"{name}\"\n"
        ));
        refused(name, &["inspect", "study.toml"], name);
        std::fs::rename(path.join(name), path.join("pipe")).unwrap();
    }
    std::fs::write(path.join("sound.toml"), STUDY).unwrap();
    let out = ["--output", "out"];
    for (arguments, file) in [
        (&["rig", "pipe"][..], "pipe"),
        (&["solve", "pipe"], "pipe"),
        (&["export", "pipe"], "pipe"),
        (&["identify", "pipe.csv"], "pipe.csv"),
        (&["identify", "pipe.tdms"], "pipe.tdms"),
        (&["identify", "pipe.mat"], "pipe.mat"),
        (&["identify", "pipe.unv"], "pipe.unv"),
        (&["import", "K=pipe.mtx", "--units", "SI"], "pipe.mtx"),
        (&["import", "pipe.inp", "--units", "SI"], "pipe.inp"),
        (
            &["calibrate", "sound.toml", "--measured", "pipe.csv"],
            "pipe.csv",
        ),
    ] {
        std::fs::rename(path.join("pipe"), path.join(file)).unwrap();
        refused(arguments[0], &[arguments, &out].concat(), file);
        std::fs::rename(path.join(file), path.join("pipe")).unwrap();
    }
    std::fs::create_dir(path.join("results")).unwrap();
    std::fs::rename(path.join("pipe"), path.join("results/run.json")).unwrap();
    refused("record", &["report", "results"], "results/run.json");
}

/// `verify` compares the report with what it should be, and does not wait for one that is a pipe.
///
/// Seen to fail with `std::fs::read`: a wait without end.
#[test]
#[cfg(unix)]
fn verify_does_not_wait_for_a_report() {
    let folder = folder("study.toml", "[output]\n", "[output]\ncurve_samples = 0\n");
    let path = folder.path();
    crate::succeed(path, &["run", "study.toml", "--output", "results"]);
    let page = path.join("results/report.html");
    std::fs::remove_file(&page).unwrap();
    make_pipe(&page);
    let verified = microslip(path, &["verify", "results"]);
    let rule = "report.html is not what this program makes";
    assert_refused("page", &verified, &[rule]);
}
