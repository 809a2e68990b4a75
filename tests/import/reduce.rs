//! Models reduced by Craig-Bampton while they are imported.

use std::path::Path;

use crate::chain::{K, M, write};
use crate::{assert_refused, microslip};

/// A chain of `n` masses along x on a spring to the ground, as Matrix Market files with names; the masses of `massless` are 0.
fn chain(folder: &Path, n: usize, ground: f64, massless: &[usize]) {
    let header = "%%MatrixMarket matrix coordinate real symmetric\n";
    let mut stiffness = format!("{header}{n} {n} {}\n", 2 * n - 1);
    let mut mass = format!("{header}{n} {n} {n}\n");
    for i in 0..n {
        let before = if i == 0 { ground } else { K };
        let after = if i + 1 < n { K } else { 0.0 };
        stiffness += &format!("{0} {0} {1:.15e}\n", i + 1, before + after);
        if i > 0 {
            stiffness += &format!("{} {i} {:.15e}\n", i + 1, -K);
        }
        let m = if massless.contains(&i) { 0.0 } else { M };
        mass += &format!("{0} {0} {m:.15e}\n", i + 1);
    }
    write(folder, "K.mtx", &stiffness);
    write(folder, "M.mtx", &mass);
    let names: String = (1..=n).map(|node| format!("{node}.1\n")).collect();
    write(folder, "K.dof", &names);
}

/// The list that the program prints.
fn imported(folder: &Path, options: &[&str]) -> String {
    let fixed = [
        "import", "K.mtx", "M.mtx", "--units", "SI", "--output", "model",
    ];
    let arguments: Vec<&str> = fixed.iter().chain(options).copied().collect();
    let output = microslip(folder, &arguments);
    let (list, message) = (output.stdout, output.stderr);
    let message = String::from_utf8(message).unwrap();
    assert!(output.status.success(), "{message}");
    String::from_utf8(list).unwrap()
}

/// Words behind the heading of a line.
fn numbers(list: &str, heading: &str) -> Vec<f64> {
    let line = list.lines().find(|line| line.starts_with(heading));
    let line = line.unwrap_or_else(|| panic!("{list} lacks {heading}"));
    let words = line[heading.len()..].split_whitespace();
    words.map_while(|word| word.parse().ok()).collect()
}

/// f_j of a chain of `n` masses that is fixed at one end: √(K/M)/π · sin((2j − 1)π/(2(2n + 1))).
fn fixed_free(n: usize, j: usize) -> f64 {
    let angle = (2 * j - 1) as f64 * std::f64::consts::PI / (2 * (2 * n + 1)) as f64;
    (K / M).sqrt() / std::f64::consts::PI * angle.sin()
}

/// A chain of 6000 masses is too large to be solved as it is. Kept are one mass that is excited and one that is named, with
/// the modes below a cut-off; the reduced frequencies are those of the closed form, never below, and the stated errors are
/// those against it.
///
/// Seen to fail with the cut-off in rad/s.
#[test]
fn a_large_chain_keeps_its_lowest_frequencies() {
    let (folder, n) = (tempfile::tempdir().unwrap(), 6000);
    chain(folder.path(), n, K, &[]);
    let large = [
        "import", "K.mtx", "M.mtx", "--units", "SI", "--output", "model",
    ];
    assert_refused(
        folder.path(),
        &large,
        &["M.mtx: has 6000 rows: at most 5000; --cut-off HZ reduces"],
    );
    let options = ["--cut-off", "3", "--keep", "6000", "--excite", "3000.1=1"];
    let list = imported(folder.path(), &options);
    let free = numbers(&list, "free frequencies");
    let errors = numbers(&list, "error of these");
    assert_eq!((free.len(), errors.len()), (10, 10), "{list}");
    for (j, (f, error)) in (1..).zip(free.iter().zip(&errors)) {
        let exact = fixed_free(n, j);
        assert!((f / exact - 1.0).abs() < 1e-5, "{f} against {exact}");
        assert!((-1e-9..1e-2).contains(error), "mode {j}: {error}");
    }
    let names = std::fs::read_to_string(folder.path().join("model/dofs.txt")).unwrap();
    let names: Vec<&str> = names.lines().collect();
    assert_eq!(names[..3], ["3000.1", "6000.1", "1.MODE"], "{names:?}");
    let inspect = microslip(folder.path(), &["inspect", "model/study.toml"]);
    assert_eq!(inspect.status.code(), Some(2), "no contact pair yet");
}

/// Masses of zero follow their neighbours: two springs in series. The frequencies are those of the half chain with springs of
/// K/2, whose first spring to the ground is K in series with nothing.
///
/// Seen to fail with the limit of the dense routine at 400 rows whatever the mass is.
#[test]
fn degrees_of_freedom_without_mass_follow_statically() {
    for n in [20, 800] {
        let folder = tempfile::tempdir().unwrap();
        let massless: Vec<usize> = (0..n).step_by(2).collect();
        chain(folder.path(), n, K, &massless);
        let plain = [
            "import", "K.mtx", "M.mtx", "--units", "SI", "--output", "model",
        ];
        let rule = "M.mtx: degree of freedom 1.1 has no mass: --cut-off HZ condenses it";
        assert_refused(folder.path(), &plain, &[rule]);
        let last = format!("{n}.1");
        let list = imported(
            folder.path(),
            &["--cut-off", "100", "--keep", &last, "--keep", "2"],
        );
        assert!(
            list.contains(&format!("without mass        {} degrees", n / 2)),
            "{list}"
        );
        let free = numbers(&list, "free frequencies");
        for (j, f) in (1..).zip(&free) {
            let exact = fixed_free(n / 2, j) / 2.0_f64.sqrt();
            assert!((f / exact - 1.0).abs() < 1e-6, "{n}: {f} against {exact}");
        }
    }
}

/// Two masses that only count together have no mass of their own: refused as they are, reduced where one of them is condensed, and
/// refused again where both are kept.
///
/// Seen to fail with the dense routine alone for models of up to 400 rows: "mass is not positive definite".
#[test]
fn a_mass_that_is_singular_without_a_zero_is_reduced() {
    let folder = tempfile::tempdir().unwrap();
    chain(folder.path(), 20, K, &[]);
    let text = std::fs::read_to_string(folder.path().join("M.mtx")).unwrap();
    let joint = format!("4 4 {M:.15e}\n5 4 {M:.15e}\n");
    let text = text.replace("20 20 20\n", "20 20 21\n");
    let text = text.replace(&format!("4 4 {M:.15e}\n"), &joint);
    write(folder.path(), "M.mtx", &text);
    let fixed = "import K.mtx M.mtx --units SI --output model".split(' ');
    let fixed: Vec<&str> = fixed.collect();
    let rule = "degree of freedom 5.1 has no mass of its own beside those before it: --cut-off";
    assert_refused(folder.path(), &fixed, &[rule]);
    let kept: Vec<&str> = (fixed.iter().copied())
        .chain("--cut-off 1 --keep 3 --keep 4 --keep 5 --keep 6".split(' '))
        .collect();
    let rule = "degree of freedom 5.1 has no mass of its own beside those before it: nothing with mass moves with it";
    assert_refused(folder.path(), &kept, &["M.mtx", rule]);
    let list = imported(folder.path(), &["--cut-off", "1e5", "--keep", "20"]);
    let errors = numbers(&list, "error of these");
    assert!(errors.iter().all(|error| error.abs() < 1e-8), "{list}");
}

/// A force of 1 N on each of 300 masses. Moving one kept mass while the other is held moves the masses between them along a
/// line, so 150 N act on the first one and 75.5 N on the last one.
///
/// Seen to fail with the masses between them moving the other way.
#[test]
fn a_load_on_all_masses_acts_on_the_kept_ones() {
    let (folder, n) = (tempfile::tempdir().unwrap(), 300);
    chain(folder.path(), n, K, &[]);
    let twice = "%%MatrixMarket matrix coordinate real general\n300 1 2\n2 1 1.0\n2 1 2.0\n";
    write(folder.path(), "F.mtx", twice);
    let arguments = [
        "import", "K.mtx", "M.mtx", "F.mtx", "--units", "SI", "--output", "model",
    ];
    let rule = "F.mtx:4: entry (2, 1): must be given once";
    assert_refused(folder.path(), &arguments, &[rule]);
    let ones = "1\n".repeat(n);
    write(
        folder.path(),
        "F.mtx",
        &format!("%%MatrixMarket matrix array real general\n{n} 1\n{ones}"),
    );
    let keep = ["F.mtx", "--cut-off", "10", "--keep", "150", "--keep", "300"];
    imported(folder.path(), &keep);
    let text = std::fs::read_to_string(folder.path().join("model/cosine_force.mtx")).unwrap();
    let forces: Vec<f64> = (text.lines().skip(2))
        .map(|word| word.parse().unwrap())
        .collect();
    for (force, expected) in forces.iter().zip([150.0, 75.5]) {
        assert!(
            (force / expected - 1.0).abs() < 1e-9,
            "{force} N, not {expected} N"
        );
    }
}

/// A free chain of springs of 2/3 MN/m as a file of nine digits states it: twice a spring is rounded down, so each mass hangs on
/// −4 mN/m. The reduced chain has lost digits, and its rigid-body motion a negative stiffness, which is set to zero.
///
/// Seen to fail with the reduced stiffness as it is: the study is refused for its negative eigenvalue.
#[test]
fn rounding_of_the_file_leaves_no_negative_stiffness() {
    let (folder, n) = (tempfile::tempdir().unwrap(), 300);
    chain(folder.path(), n, 0.0, &[]);
    let text = std::fs::read_to_string(folder.path().join("K.mtx")).unwrap();
    let nine = |value: f64| format!("{:.8e}", 2.0 / 3.0 * value);
    let [one, two, off] = [K, 2.0 * K, -K].map(|value| (format!("{value:.15e}"), nine(value)));
    let text = [one, off, two]
        .iter()
        .fold(text, |text, (old, new)| text.replace(old, new));
    write(folder.path(), "K.mtx", &text);
    let keep = [
        "--cut-off",
        "10",
        "--keep",
        "1",
        "--keep",
        "300",
        "--excite",
        "1.1=1",
    ];
    let list = imported(folder.path(), &keep);
    assert!(
        list.contains("made semidefinite   eigenvalues down to -"),
        "{list}"
    );
    let written = std::fs::read_to_string(folder.path().join("model/stiffness.mtx")).unwrap();
    let entry = |place: &str| {
        let line = written.lines().find(|line| line.starts_with(place));
        let value = line.and_then(|line| line.split(' ').nth(2));
        value.and_then(|value| value.parse::<f64>().ok()).unwrap()
    };
    let [a, b, c] = ["1 1 ", "2 1 ", "2 2 "].map(entry);
    // one rigid-body motion, held by nothing
    assert!((a * c - b * b).abs() < 1e-12 * a * c, "{a} {b} {c}");
    assert!((a + b).abs() < 1e-6 * a, "{a} and {b}");
}

/// What a reduction writes is imported again, with its names.
///
/// Seen to fail with the program before: "degree of freedom MODE: must be a whole number".
#[test]
fn a_reduced_model_is_imported_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    chain(path, 20, K, &[]);
    let list = imported(path, &["--cut-off", "300", "--keep", "20"]);
    let reduced = numbers(&list, "free frequencies");
    for (from, to) in [
        ("stiffness.mtx", "K.mtx"),
        ("mass.mtx", "M.mtx"),
        ("dofs.txt", "K.dof"),
    ] {
        std::fs::rename(path.join("model").join(from), path.join(to)).unwrap();
    }
    std::fs::remove_dir_all(path.join("model")).unwrap();
    let list = imported(path, &[]);
    assert!(list.contains("20.1, 1.MODE, 2.MODE"), "{list}");
    let again = numbers(&list, "free frequencies");
    // those far below the cut-off, whose error by the reduction is 4e-5 and 4e-4
    for (again, before) in again[..2].iter().zip(&reduced) {
        assert!((again / before - 1.0).abs() < 1e-3, "{list}");
    }
}

/// Each rule of a reduction by its message; nothing is written.
#[test]
fn what_cannot_be_reduced_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    chain(folder.path(), 300, 0.0, &[]);
    let fixed = [
        "import", "K.mtx", "M.mtx", "--units", "SI", "--output", "model",
    ];
    let cases: [(&[&str], &str); 7] = [
        (
            &["--cut-off", "10"],
            "--cut-off = 10: needs degrees of freedom that are kept",
        ),
        (
            &["--cut-off", "0"],
            "--cut-off = 0: must be a finite number > 0",
        ),
        (&["--cut-off", "nan"], "--cut-off"),
        (&["--keep", "1"], "--cut-off"),
        (
            &["--cut-off", "10", "--keep", "301"],
            "--keep = 301: must be a node or a degree of freedom",
        ),
        (
            &["--cut-off", "10", "--keep", "1.2"],
            "--keep = 1.2: must be a node",
        ),
        (
            &["--cut-off", "1e6", "--keep", "1"],
            "--cut-off = 1000000: must leave at most 200 fixed-interface modes below it",
        ),
    ];
    for (options, rule) in cases {
        let arguments: Vec<&str> = fixed.iter().chain(options).copied().collect();
        assert_refused(folder.path(), &arguments, &[rule]);
    }
}

/// A spring is cut: the second half is free, whatever is kept of the first one. A negative mass keeps its own message.
///
/// Seen to fail without the search for the part that is not held.
#[test]
fn a_part_that_is_not_held_is_named() {
    let folder = tempfile::tempdir().unwrap();
    chain(folder.path(), 300, 0.0, &[]);
    let text = std::fs::read_to_string(folder.path().join("K.mtx")).unwrap();
    let cut = format!("151 150 {:.15e}", -K);
    let both = |at: usize| format!("{at} {at} {:.15e}", 2.0 * K);
    let one = |at: usize| format!("{at} {at} {:.15e}", K);
    let text = text
        .replace(&cut, "151 150 0.0")
        .replace(&both(150), &one(150))
        .replace(&both(151), &one(151));
    write(folder.path(), "K.mtx", &text);
    let arguments = "import K.mtx M.mtx --units SI --output model --cut-off 10 --keep 1";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let rule = "no degree of freedom is kept of the part with 151.1";
    assert_refused(folder.path(), &arguments, &["K.mtx", rule]);
    let text = std::fs::read_to_string(folder.path().join("M.mtx")).unwrap();
    let negative = text.replace("\n7 7 2.", "\n7 7 -2.");
    assert_ne!(text, negative);
    write(folder.path(), "M.mtx", &negative);
    assert_refused(
        folder.path(),
        &arguments,
        &["M.mtx", "negative eigenvalue -"],
    );
}
