//! The commands `import` and `pairs` as a user runs them.

use std::path::Path;

use tempfile::TempDir;
use zip::CompressionMethod;

use crate::chain::{K, M, N, NODES, ROWS, dof, frequencies_hz, lower, mass, stiffness, write};
use crate::numpy::{archive, npy, savez};
use crate::op4::Form;
use crate::{abaqus, ansys, assert_refused, calculix, microslip, nastran, op4};

/// A folder with K and M of the chain in a format.
fn folder(files: &[(&str, String)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        write(folder.path(), name, text);
    }
    folder
}

pub(crate) fn abaqus_folder() -> TempDir {
    folder(&[
        ("K.mtx", abaqus::matrix(stiffness, true, false)),
        ("M.mtx", abaqus::matrix(mass, true, false)),
        (
            "pairs.csv",
            "node_a,node_b,nx,ny,nz\n4,ground,0,0,1\n".to_owned(),
        ),
    ])
}

/// Numbers behind a label of the list on the terminal.
fn numbers(list: &str, label: &str) -> Vec<f64> {
    let line = list.lines().find(|line| line.starts_with(label)).unwrap();
    let words = line[label.len()..].split([' ', ',']);
    words.filter_map(|word| word.parse().ok()).collect()
}

fn imported(folder: &Path, arguments: &[&str]) -> String {
    let output = microslip(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Frequencies, mass and sizes of every format are those of the chain in closed form.
///
/// Seen to fail with EXTRN not read, and with one triangle of Abaqus refused.
#[test]
fn every_format_gives_the_numbers_of_the_chain() {
    let dmig = nastran::punch("KAAX", stiffness, false) + &nastran::punch("MAAX", mass, false);
    let output4 = op4::text("KXX", stiffness, Form::Strings) + &op4::text("MXX", mass, Form::Dense);
    let extrn = NODES.map(|node| format!("EXTRN,{node},123\n")).concat();
    let market = |entry| ansys::dense_market(entry);
    let cases: [(&str, Vec<(&str, String)>); 7] = [
        (
            "K.mtx M.mtx",
            vec![
                ("K.mtx", abaqus::matrix(stiffness, true, false)),
                ("M.mtx", abaqus::matrix(mass, true, true)),
            ],
        ),
        ("super.mtx", vec![("super.mtx", abaqus::abaqus_element())]),
        (
            "job.sti job.mas",
            vec![
                ("job.sti", calculix::matrix(stiffness)),
                ("job.mas", calculix::matrix(mass)),
                ("job.dof", calculix::names()),
            ],
        ),
        (
            "KMatrix.matrix MMatrix.matrix",
            vec![
                ("KMatrix.matrix", ansys::harwell_boeing(stiffness, None)),
                ("MMatrix.matrix", ansys::harwell_boeing(mass, None)),
                ("KMatrix.mapping", ansys::mapping()),
            ],
        ),
        ("model.pch", vec![("model.pch", dmig.clone())]),
        (
            "model.op4",
            vec![("model.op4", output4), ("model.asm", extrn)],
        ),
        (
            "K=first.mmf M=second.mmf other.mapping",
            vec![
                ("first.mmf", market(stiffness)),
                ("second.mmf", market(mass)),
                ("other.mapping", ansys::mapping()),
            ],
        ),
    ];
    for (files, written) in cases {
        assert_is_the_chain(files, &written);
    }
}

/// Imports files, and compares what is listed with the closed form.
fn assert_is_the_chain(files: &str, written: &[(&str, String)]) {
    let folder = folder(written);
    let mut arguments = vec!["import"];
    arguments.extend(files.split(' '));
    arguments.extend(["--units", "SI", "--output", "model"]);
    let list = imported(folder.path(), &arguments);
    let frequencies = numbers(&list, "free frequencies");
    assert_eq!(frequencies.len(), 9, "{files}: {list}");
    for (found, expected) in frequencies.iter().zip(frequencies_hz()) {
        assert!((found / expected - 1.0).abs() < 1e-8, "{files}: {list}");
    }
    assert!(
        list.contains("(3 rigid-body modes: translations x, y, z)"),
        "{files}: {list}"
    );
    assert_eq!(numbers(&list, "total mass"), [M * N as f64; 3], "{files}");
    assert_eq!(numbers(&list, "weight")[..3], [9.80665; 3], "{files}");
    let sizes = numbers(&list, "matrix K");
    assert_eq!(sizes[0], ROWS as f64, "{files}");
    assert_eq!(sizes[1], (ROWS + 2 * 3 * (N - 1)) as f64, "{files}");
}

/// The folder can be inspected and solved, whatever the units: they scale the numbers of the file, not those of the result.
///
/// Seen to fail with the unit of time not squared in a mass: 1000 kg.
#[test]
fn an_imported_model_is_solved_in_si_units() {
    let sets = [
        ("SI", [1.0, 1.0], ["1e6", "20", "1.0"]),
        ("mm-t-s", [1e-3, 1e-3], ["1e3", "20", "1.0"]),
        ("mm-kg-ms", [1e-6, 1.0], ["1", "0.02", "0.001"]),
    ];
    let responses = sets.map(|(units, scales, constants)| response(units, scales, constants));
    assert!(responses[0].len() >= 3, "{responses:?}");
    for other in &responses[1..] {
        for (a, b) in responses[0].iter().zip(other) {
            assert!((a - b).abs() <= 1e-6 * a.abs(), "{responses:?}");
        }
    }
}

/// The curve at one frequency: the chain in other units, with stiffness, press and force of its contact.
fn response(units: &str, [of_k, of_m]: [f64; 2], [k, press, force]: [&str; 3]) -> Vec<f64> {
    let folder = abaqus_folder();
    let path = folder.path();
    let scaled = |entry: fn(usize, usize) -> f64, factor: f64| {
        let lines = lower(entry).into_iter().map(|(row, column, value)| {
            let ((a, i), (b, j)) = (dof(row), dof(column));
            format!("{a},{i},{b},{j},{:.12e}\n", value * factor)
        });
        lines.collect::<String>()
    };
    write(path, "K.mtx", &scaled(stiffness, of_k));
    write(path, "M.mtx", &scaled(mass, of_m));
    // the pair is held by a static force
    let forces = format!("dof,cosine,static\n{}.1,{force},\n4.3,,{press}\n", NODES[0]);
    write(path, "forces.csv", &forces);
    let command = format!(
        "import K.mtx M.mtx --units {units} --pairs pairs.csv --k-n {k} --k-t {k} --mu 0.3 \
         --forces forces.csv --response 11.1 --output model"
    );
    let list = imported(path, &command.split(' ').collect::<Vec<_>>());
    assert_eq!(numbers(&list, "total mass"), [M * N as f64; 3], "{units}");
    let model = path.join("model");
    let inspected = imported(&model, &["inspect", "study.toml"]);
    assert_eq!(
        numbers(&inspected, "total mass"),
        [M * N as f64; 3],
        "{units}"
    );
    assert_eq!(numbers(&inspected, "weight")[..3], [9.80665; 3], "{units}");
    assert!(
        inspected.contains("(3 rigid-body modes: translations x, y, z)"),
        "{inspected}"
    );
    let study = model.join("study.toml");
    let text = std::fs::read_to_string(&study).unwrap();
    let quick = "values_hz = [250.0]\n[solver]\nharmonics = 1\ntime_points = 64\nalert = false\n";
    std::fs::write(&study, text + quick).unwrap();
    let solved = imported(&model, &["solve", "study.toml"]);
    assert!(solved.contains("1 of 1 points solved"), "{units}: {solved}");
    let curve = std::fs::read_to_string(model.join("results/curve.csv")).unwrap();
    let words = curve.lines().nth(1).unwrap().split(',');
    words.filter_map(|word| word.parse().ok()).collect()
}

/// A free structure as ANSYS writes it with nine digits has scaled eigenvalues of some -1e-9: it is imported, and the study
/// that is written can be read.
///
/// Seen to fail with one tolerance for all files: "must be positive semidefinite, but has a negative eigenvalue"; and with all
/// digits of the numbers in SI units written in place of nine.
#[test]
fn nine_digits_are_enough_for_a_free_structure() {
    let entry: fn(usize, usize) -> f64 = |row, column| {
        let down = if row == column { 1.0 - 3e-9 } else { 1.0 };
        stiffness(row, column) * down / 7e5
    };
    let folder = folder(&[
        ("K.mmf", ansys::dense_market(entry)),
        ("M.mmf", ansys::dense_market(mass)),
        ("K.mapping", ansys::mapping()),
        (
            "pairs.csv",
            "node_a,node_b,nx,ny,nz\n4,ground,0,0,1\n".to_owned(),
        ),
    ]);
    let arguments = [
        "import",
        "K.mmf",
        "M.mmf",
        "--units",
        "mm-t-s",
        "--pairs",
        "pairs.csv",
        "--k-n",
        "1",
        "--k-t",
        "1",
        "--mu",
        "0.3",
        "--excite",
        "11.1=1",
        "--output",
        "model",
    ];
    let list = imported(folder.path(), &arguments);
    assert!(
        list.contains("(3 rigid-body modes: translations x, y, z)"),
        "{list}"
    );
    imported(&folder.path().join("model"), &["inspect", "study.toml"]);
    write(folder.path(), "K.mmf", &ansys::sparse_market(entry));
    std::fs::remove_dir_all(folder.path().join("model")).unwrap();
    assert_refused(
        folder.path(),
        &arguments,
        &[
            "K.mmf: must be positive semidefinite",
            "eigenvalue -",
            "times what rounding to",
        ],
    );
}

/// What stands behind `import`, and what the message must hold.
const MISFITS: &str = "
K.mtx --units SI | no file has M
K.mtx M.mtx | --units
K.mtx M.mtx --units inches | inches
K.mtx M=K.mtx --units SI | has no mass of its own beside those before it
K.mtx M=other.mtx --units SI | other.mtx: has the degree of freedom 99.1, which K.mtx does not have
K.mtx other.mtx --units SI | other.mtx: is a matrix of which nothing says what it is
K.mtx K=other.mtx --units SI | other.mtx: is a second K beside K.mtx
K.mtx M=zero.mtx --units SI | zero.mtx: degree of freedom 11.1 has no mass: --cut-off HZ condenses it
job.sti job.mas short.dof --units SI | short.dof: has 11 names, but job.sti has 12 rows: it is of another model
K=swapped.mtx M.mtx --units SI | swapped.mtx: must be positive semidefinite
K.mtx job.mas job.dof --units SI | job.mas: has no names, but other matrices have
K=K.mtx#KXX M.mtx --units SI | K.mtx: has no matrix KXX
K.mtx M=absent.mtx --units SI | absent.mtx: No such file
K.mtx F=M.mtx M.mtx --units SI | M.mtx
K.mtx M.mtx --units SI --excite 11.1 | --excite = 11.1: must be DOF=COSINE
K.mtx M.mtx --units SI --excite 99.1=1 | 99.1=1: must be a degree of freedom of the matrices, such as 11.1
K.mtx M.mtx --units SI --excite 11.1=NaN | NaN: must be a finite number
K.mtx M.mtx --units SI --excite 11.1=1,2,3 | must have two numbers at most
K.mtx M.mtx --units SI --excite 11.1=1 --excite 11.1=2 | --excite = 11.1=2: this degree of freedom must be given once
K.mtx M.mtx --units SI --response 5.9 | --response = 5.9: must be a degree of freedom
K.mtx M.mtx --units SI --response 11.1 --response 11.1 | --response = 11.1: must be given once
K.mtx M.mtx far.dof --units SI | far.dof: has no degree of freedom 11.1, which the matrices have: it is of another model
K.mtx M.mtx --units SI --modal-damping-ratio 1.5 | --modal-damping-ratio = 1.5: must be
K.mtx M.mtx --units SI --pairs pairs.csv --k-n=-1 | --k-n = -1: must be a finite number >= 0
";

/// Seen to fail with the folder made before the files are read.
#[test]
fn what_does_not_fit_together_is_refused_and_nothing_is_written() {
    let folder = abaqus_folder();
    let path = folder.path();
    write(path, "other.mtx", "11,1,11,1,1.0\n99,1,99,1,1.0\n");
    let names = calculix::names();
    write(path, "job.dof", &names);
    write(path, "far.dof", &names.replace("11.", "99."));
    write(path, "short.dof", names.split_once('\n').unwrap().1);
    write(path, "job.sti", &calculix::matrix(stiffness));
    write(path, "job.mas", &calculix::matrix(mass));
    let negative = abaqus::matrix(|row, column| -stiffness(row, column), true, false);
    write(path, "swapped.mtx", &negative);
    let zero = abaqus::matrix(mass, true, false).replacen("0.2500000000000E+00", "0.0", 1);
    write(path, "zero.mtx", &zero);
    for line in MISFITS.lines().skip(1) {
        let (options, fragment) = line.split_once(" | ").unwrap();
        let mut arguments = vec!["import", "--output", "model"];
        arguments.extend(options.split(' '));
        assert_refused(path, &arguments, &[fragment]);
    }
}

/// Seen to fail with the check left out: another message.
#[test]
fn a_folder_with_content_is_kept() {
    let folder = abaqus_folder();
    let arguments = [
        "import", "K.mtx", "M.mtx", "--units", "SI", "--output", "mine",
    ];
    imported(folder.path(), &arguments);
    let study = folder.path().join("mine/study.toml");
    std::fs::write(&study, "edited").unwrap();
    assert_refused(folder.path(), &arguments, &["mine: has content already"]);
    assert_eq!(std::fs::read_to_string(&study).unwrap(), "edited");
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 4, "no folder is left behind");
}

/// The load of a file is used as the option says, and only then. Seen to fail with the option ignored.
#[test]
fn loads_of_files_are_used_where_the_option_says_how() {
    let folder = folder(&[
        (
            "KMatrix.matrix",
            ansys::harwell_boeing(stiffness, Some(0.5)),
        ),
        ("MMatrix.matrix", ansys::harwell_boeing(mass, None)),
        ("KMatrix.mapping", ansys::mapping()),
    ]);
    let arguments = |output: &'static str| {
        [
            "import",
            "KMatrix.matrix",
            "MMatrix.matrix",
            "--units",
            "SI",
            "--output",
            output,
        ]
    };
    let output = microslip(folder.path(), &arguments("unused"));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("the load of the files is not used"),
        "{message}"
    );
    for (load, key) in [
        ("static", "static_force = "),
        ("harmonic", "cosine_force = "),
    ] {
        let arguments = [&arguments("model")[..], &["--load", load]].concat();
        imported(folder.path(), &arguments);
        let study = folder.path().join("model/study.toml");
        let study = std::fs::read_to_string(study).unwrap();
        assert!(study.contains(key), "{study}");
        std::fs::remove_dir_all(folder.path().join("model")).unwrap();
    }
}

/// K and M of so many free chains of `length` masses of 1 kg; the springs of chain i have i + 1 kN/m.
fn chains(count: usize, length: usize) -> Vec<u8> {
    let n = count * length;
    let square = |entry: &dyn Fn(usize, usize) -> f64| {
        let values = (0..n * n).flat_map(|k| entry(k / n, k % n).to_le_bytes());
        npy(
            "<f8",
            false,
            &format!("({n}, {n})"),
            &values.collect::<Vec<u8>>(),
        )
    };
    let spring = |a: usize, b: usize| a / length == b / length && b == a + 1;
    let stiffness = |i: usize, j: usize| {
        let size = 1e3 * (i / length + 1) as f64;
        match i == j {
            true => {
                let place = i % length;
                let ends = [place > 0, place + 1 < length];
                size * ends.iter().filter(|spring| **spring).count() as f64
            }
            false if spring(i, j) || spring(j, i) => -size,
            false => 0.0,
        }
    };
    let mass = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    let arrays = [("K", square(&stiffness)), ("M", square(&mass))];
    archive(&arrays, CompressionMethod::Deflated)
}

/// All rigid-body modes are known, and ten flexible ones, however many bodies there are: of a model whose modes are all computed, and of a
/// large one. Seen to fail with the lowest 24 modes alone, which showed frequencies of 0, or none.
#[test]
fn many_bodies_have_their_frequencies() {
    for (count, length) in [(30, 2), (30, 14)] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("chains.npz"), chains(count, length)).unwrap();
        let arguments = ["import", "chains.npz", "--units", "SI", "--output", "model"];
        let list = imported(folder.path(), &arguments);
        assert!(list.contains("30 rigid-body modes"), "{list}");
        let shown = numbers(&list, "free frequencies");
        // 2 √(k/m) sin(π j/2n) of every chain and mode
        let exact = |i: usize, j: usize| {
            let turn = std::f64::consts::PI * j as f64 / (2 * length) as f64;
            2.0 * (1e3 * (i + 1) as f64).sqrt() * turn.sin() / std::f64::consts::TAU
        };
        let all = (0..count).flat_map(|i| (1..length).map(move |j| (i, j)));
        let mut expected: Vec<f64> = all.map(|(i, j)| exact(i, j)).collect();
        expected.sort_by(f64::total_cmp);
        for (at, expected) in expected.iter().take(10).enumerate() {
            assert!((shown[at] / expected - 1.0).abs() < 1e-4, "{at}: {list}");
        }
    }
}

/// A force of the files that an option takes the place of is named, and a load that no file has is refused. Seen to fail with the program
/// before, which said nothing.
#[test]
fn forces_that_are_not_used_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let archive = savez(CompressionMethod::Stored);
    std::fs::write(folder.path().join("model.npz"), archive).unwrap();
    let with = |more: &[&'static str]| {
        let import = ["import", "model.npz", "--units", "SI", "--output", "model"];
        let output = microslip(folder.path(), &[&import[..], more].concat());
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let (code, said) = with(&["--load", "static"]);
    let rule = "--load = static: must be absent: no file has a load";
    assert!(code == Some(2) && said.contains(rule), "{said}");
    let (code, said) = with(&["--excite", "1=1"]);
    let warning =
        "the harmonic force of the files is not used: --excite or --forces states another";
    assert!(code == Some(0) && said.contains(warning), "{said}");
}

/// A study that `inspect` would refuse is written with a warning that says why.
///
/// Seen to fail with the program before, which said nothing.
#[test]
fn what_the_study_still_lacks_is_a_warning() {
    let folder = abaqus_folder();
    let said = |more: &str| {
        let given = "import K.mtx M.mtx --units SI --quiet --output model --excite 11.1=1 --pairs pairs.csv --k-n 1e3";
        let arguments: Vec<&str> = given.split(' ').chain(more.split_whitespace()).collect();
        let output = microslip(folder.path(), &arguments);
        assert!(output.status.success(), "{more}");
        std::fs::remove_dir_all(folder.path().join("model")).unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    assert_eq!(said("--k-t 1e3 --mu 0.3 --n-0 1"), "");
    let large = said("--k-t 1e200 --mu 0.3 --n-0 1");
    let rule = "warning: what is written cannot be run yet: model/study.toml";
    assert!(large.starts_with(rule) && large.contains("k_t1"), "{large}");
}

/// Seen to fail with the shortest form of each number.
#[test]
fn the_written_matrix_has_the_digits_of_its_file() {
    let folder = abaqus_folder();
    imported(
        folder.path(),
        &[
            "import", "K.mtx", "M.mtx", "--units", "SI", "--output", "model",
        ],
    );
    let text = std::fs::read_to_string(folder.path().join("model/stiffness.mtx")).unwrap();
    assert!(text.contains(&format!("1 1 {K:.12e}\n")), "{text}");
}
