//! A sector whose matrices are reduced for each nodal diameter, against the same sector with its boundaries.

use faer::prelude::*;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{LinearModel, Problem};
use microslip::study::Study;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

/// A blade on a disk; springs of blade and strip meet the disk of the next sector, so that no phase of a coordinate makes the matrices
/// real. A strip towards the next blade.
fn study(n_sectors: usize, matrices: &str) -> String {
    format!(
        "name = \"disk\"\nlevels = [0.5, 4.0, 12.0]\n\n[model]\nkind = \"cyclic\"\nsector = \"matrices\"\nsectors = {n_sectors}\n{matrices}\n\
         modal_damping_ratio = 0.01\nstatic_force = {{ \"strip.z\" = 5.0 }}\n\
         cosine_force = {{ \"blade.x\" = 1.0 }}\nsine_force = {{ \"blade.x\" = 0.4 }}\nresponses = [\"blade.x\"]\n\n\
         [[model.contact]]\nname = \"own\"\nt1 = {{ \"strip.x\" = 1.0, \"blade.x\" = -1.0 }}\n\
         n = {{ \"strip.z\" = 1.0 }}\nk_t1 = 2e5\nk_n = 1e6\nmu = 0.3\n\n\
         [[model.contact]]\nname = \"next\"\nt1 = {{ \"strip.x\" = 1.0, \"next:blade.x\" = -1.0 }}\n\
         n = {{ \"strip.z\" = 1.0 }}\nk_t1 = 3e5\nk_n = 1e6\nmu = 0.3\n\n\
         [operation]\nspeed_rpm = [1000, 2000]\nengine_orders = [2]\n\n[solver]\nharmonics = 3\nalert = false\n\n\
         [frequency]\nband_hz = [150, 350]\n"
    )
}

const BOUNDARIES: &str = "mass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"\n\
    dof_names = [\"left.x\", \"blade.x\", \"strip.x\", \"strip.z\", \"right.x\"]\nleft = [\"left.x\"]\nright = [\"right.x\"]";
const NODAL: &str = "mass = \"mass-{nd}.mtx\"\nstiffness = \"stiffness-{nd}.mtx\"\n\
    dof_names = [\"blade.x\", \"strip.x\", \"strip.z\"]";

/// Mass and stiffness of the sector with its boundaries: left, blade, strip x, strip z, right.
fn with_boundaries(folder: &Path) {
    let files = [
        (
            "mass.mtx",
            "5 5 4\n1 1 1.0\n2 2 0.4\n3 3 0.001\n4 4 0.001\n",
        ),
        (
            "stiffness.mtx",
            "5 5 8\n1 1 4e6\n2 1 -1e6\n2 2 1.3e6\n5 1 -2e6\n5 2 -3e5\n5 5 2.4e6\n3 3 1e5\n5 3 -1e5\n",
        ),
    ];
    for (name, text) in files {
        let text = format!("%%MatrixMarket matrix coordinate real symmetric\n{text}");
        std::fs::write(folder.join(name), text).expect("written");
    }
}

/// Mass and stiffness of a wave with the phase `theta`, in the displacements of blade and strip and one mode of the disk with
/// these held.
fn reduced(theta: f64) -> [Mat<c64>; 2] {
    let turn = c64::new(theta.cos(), -theta.sin());
    // blade, strip x, strip z, disk
    let diagonal =
        |d: [f64; 4]| Mat::from_fn(4, 4, |i, j| c64::from(if i == j { d[i] } else { 0.0 }));
    let mass = diagonal([0.4, 0.001, 0.001, 1.0]);
    let mut stiffness = diagonal([1.3e6, 1e5, 0.0, 6.4e6 - 4e6 * theta.cos()]);
    stiffness[(0, 3)] = c64::from(-1e6) + turn * -3e5;
    stiffness[(3, 0)] = stiffness[(0, 3)].conj();
    stiffness[(1, 3)] = turn * -1e5;
    stiffness[(3, 1)] = stiffness[(1, 3)].conj();
    let disk = stiffness[(3, 3)];
    let mut to = Mat::<c64>::identity(4, 4);
    to[(3, 0)] = -stiffness[(3, 0)] / disk;
    to[(3, 1)] = -stiffness[(3, 1)] / disk;
    // a mode has any phase and size
    to[(3, 3)] = c64::new(0.6, 0.8 * theta.sin());
    [mass, stiffness].map(|a| to.adjoint() * a * &to)
}

/// How the matrices of a nodal diameter between 0 and N/2 are written.
#[derive(Debug, Clone, Copy)]
enum Form {
    Hermitian,
    General,
    Pairs,
}

fn written(a: &Mat<c64>, form: Option<Form>) -> String {
    let n = a.nrows();
    let mut text = String::new();
    let mut line = |words: std::fmt::Arguments<'_>| writeln!(text, "{words}").expect("a string");
    match form {
        None => {
            line(format_args!(
                "%%MatrixMarket matrix array real general\n{n} {n}"
            ));
            (0..n * n).for_each(|k| line(format_args!("{:e}", a[(k % n, k / n)].re)));
        }
        Some(Form::General) => {
            line(format_args!(
                "%%MatrixMarket matrix array complex general\n{n} {n}"
            ));
            for k in 0..n * n {
                let z = a[(k % n, k / n)];
                line(format_args!("{:e} {:e}", z.re, z.im));
            }
        }
        Some(Form::Hermitian) => {
            let entries = n * (n + 1) / 2;
            line(format_args!(
                "%%MatrixMarket matrix coordinate complex hermitian\n{n} {n} {entries}"
            ));
            for (i, j) in (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                // what a product leaves on the diagonal
                let round_off = -1e-16 * a[(i, j)].re;
                let imaginary = if i == j { round_off } else { a[(i, j)].im };
                line(format_args!(
                    "{} {} {:e} {imaginary:e}",
                    i + 1,
                    j + 1,
                    a[(i, j)].re
                ));
            }
        }
        Some(Form::Pairs) => {
            let m = 2 * n;
            line(format_args!(
                "%%MatrixMarket matrix array real general\n{m} {m}"
            ));
            for (j, i) in (0..m).flat_map(|j| (0..m).map(move |i| (j, i))) {
                let z = a[(i % n, j % n)];
                let value = match (i < n, j < n) {
                    (true, false) => -z.im,
                    (false, true) => z.im,
                    _ => z.re,
                };
                line(format_args!("{value:e}"));
            }
        }
    }
    text
}

/// Frequencies of all waves with stuck contacts, and peaks with friction, of the study `name` in `folder`.
fn answers(folder: &Path, name: &str) -> (Vec<Vec<f64>>, Vec<[f64; 3]>) {
    let study = Study::read(&folder.join(name)).expect("a study");
    let model = study.build_model().expect("a model");
    let of = model.disk.expect("a disk");
    let waves = 0..of.disk.n_sectors;
    let frequencies = waves.map(|wave| of.disk.frequencies(wave, Some(&model.contacts)));
    let frequencies = frequencies.collect::<Result<_, _>>().expect("definite");
    let linear = LinearModel::travelling_wave(&of.disk, of.engine_order).expect("definite");
    let problem = Problem::new(&linear, model.contacts, 1.0, study.solver.anchor).expect("held");
    let band = Band {
        low: 150.0 * TAU,
        high: 350.0 * TAU,
    };
    let search = PeakSettings {
        band,
        frequency_tolerance: 1e-9,
    };
    let peaks = track_peaks(&problem, &study.solver, search, &study.levels).expect("modes");
    let peaks = peaks.iter().map(|peak| {
        let peak = peak.solution.as_ref().expect("a peak");
        [peak.omega, peak.amplitude(0), peak.contact.slip]
    });
    (frequencies, peaks.collect())
}

/// Stuck frequencies of every nodal diameter and peaks with slip, for even and odd N and every form of the files. Seen to fail with
/// the conjugate matrices, and with round-off on the diagonal of Hermitian ones refused.
#[test]
fn matrices_of_nodal_diameters_are_those_of_the_sector() {
    for n_sectors in [8, 5] {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        with_boundaries(folder);
        std::fs::write(folder.join("whole.toml"), study(n_sectors, BOUNDARIES)).expect("written");
        std::fs::write(folder.join("nodal.toml"), study(n_sectors, NODAL)).expect("written");
        let whole = answers(folder, "whole.toml");
        assert!(
            whole.1.iter().any(|[.., slip]| *slip > 0.05),
            "{:?}",
            whole.1
        );
        for form in [Form::Hermitian, Form::General, Form::Pairs] {
            for diameter in 0..=n_sectors / 2 {
                let stands = 2 * diameter % n_sectors == 0;
                let matrices = reduced(TAU * diameter as f64 / n_sectors as f64);
                for (name, matrix) in ["mass", "stiffness"].into_iter().zip(&matrices) {
                    let text = written(matrix, Some(form).filter(|_| !stands));
                    std::fs::write(folder.join(format!("{name}-{diameter}.mtx")), text)
                        .expect("written");
                }
            }
            let nodal = answers(folder, "nodal.toml");
            for (wave, (ours, theirs)) in nodal.0.iter().zip(&whole.0).enumerate() {
                let largest = theirs.iter().fold(0.0, |a: f64, b| a.max(*b));
                for (a, b) in ours.iter().zip(theirs) {
                    assert!(
                        (a - b).abs() < 1e-9 * largest,
                        "{form:?}, wave {wave}: {a} {b}"
                    );
                }
                assert_eq!(ours.len(), theirs.len());
            }
            for (ours, theirs) in nodal.1.iter().zip(&whole.1) {
                let errors = [0, 1].map(|i| (ours[i] / theirs[i] - 1.0).abs());
                println!("{form:?}, {n_sectors} sectors: {errors:?} {ours:?}");
                assert!(errors[0] < 1e-8 && errors[1] < 1e-7, "{form:?}: {errors:?}");
            }
        }
    }
}

/// Files that are none of a nodal diameter of five sectors, and what is said of them.
fn refused_files() -> Vec<(&'static str, String, &'static str)> {
    let [k, _] = reduced(TAU / 5.0);
    let mut askew = k.clone();
    askew[(0, 3)] = askew[(0, 3)].conj();
    let complex = written(&k, Some(Form::General));
    let pairs = written(&k, Some(Form::Pairs));
    vec![
        ("mass-0.mtx", complex, "must be real: nodal diameter 0 of model.sectors = 5 stands still"),
        ("mass-1.mtx", written(&askew, Some(Form::General)), "must be Hermitian: entry (4, 1)"),
        (
            "stiffness-2.mtx",
            "%%MatrixMarket matrix coordinate complex general\n3 3 1\n1 1 1.0 0.0\n".to_owned(),
            "is 3 x 3: must be 4 x 4, or real and 8 x 8",
        ),
        (
            "mass-1.mtx",
            format!("{}\n7e6\n", pairs.trim_end().rsplit_once('\n').expect("lines").0),
            "must be [A, -B; B, A] for the cosine and the sine part",
        ),
        (
            "mass-1.mtx",
            "%%MatrixMarket matrix coordinate complex hermitian\n4 4 1\n1 1 1.0 2.0\n".to_owned(),
            "entry (1, 1)",
        ),
        (
            "mass-1.mtx",
            "%%MatrixMarket matrix array complex general\n4 4\n1.0\n".to_owned(),
            "mass-1.mtx:3: must be an entry: real imaginary",
        ),
        (
            "mass-2.mtx",
            "%%MatrixMarket matrix coordinate complex hermitian\n4 4 4\n1 1 1.0 0.0\n2 1 0.0 0.1\n2 2 1.0 0.0\n3 3 1.0 0.0\n".to_owned(),
            "nodal diameter 2 row 4",
        ),
    ]
}

/// Files of a disk of `n_sectors`.
fn files_of(folder: &Path, n_sectors: usize) {
    for diameter in 0..=n_sectors / 2 {
        let matrices = reduced(TAU * diameter as f64 / n_sectors as f64);
        let form = Some(Form::General).filter(|_| 2 * diameter % n_sectors > 0);
        for (name, matrix) in ["mass", "stiffness"].into_iter().zip(&matrices) {
            let file = folder.join(format!("{name}-{diameter}.mtx"));
            std::fs::write(file, written(matrix, form)).expect("written");
        }
    }
}

/// Files of another number of sectors name it. Seen to fail without each of the rules: the first two were read as another disk.
#[test]
fn files_of_another_number_of_sectors_are_refused() {
    for (of_files, stated, expected) in [
        (
            7,
            5,
            "mass-3.mtx: is of nodal diameter 3, which is above N/2 = 2 of model.sectors = 5",
        ),
        (
            6,
            7,
            "mass-3.mtx: is real, as that of nodal diameter N/2 of an even number of sectors, and lower ones are not: model.sectors = 7 is odd",
        ),
        (
            5,
            4,
            "mass-2.mtx: must be real: nodal diameter 2 of model.sectors = 4 stands still",
        ),
        (
            5,
            8,
            "mass-3.mtx: must exist: there must be a file for each nodal diameter from 0 to N/2 = 4 of model.sectors = 8",
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        files_of(folder.path(), of_files);
        std::fs::write(folder.path().join("nodal.toml"), study(stated, NODAL)).expect("written");
        let found = Study::read(&folder.path().join("nodal.toml")).map(|study| study.build_model());
        let error = match found {
            Ok(Ok(_)) => panic!("{of_files} files, {stated} sectors: read"),
            Ok(Err(error)) => error.to_string(),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(expected), "{error}: {expected}");
        assert!(!error.contains('\n'), "{error}");
    }
}

/// One line for each rule. Seen to fail with a matrix taken that is not Hermitian.
#[test]
fn what_is_no_matrix_of_a_nodal_diameter_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("nodal.toml"), study(5, NODAL)).expect("written");
    let good = |diameter: usize| {
        for (name, matrix) in ["mass", "stiffness"]
            .into_iter()
            .zip(&reduced(TAU * diameter as f64 / 5.0))
        {
            let form = Some(Form::General).filter(|_| diameter > 0);
            let text = written(matrix, form);
            std::fs::write(folder.join(format!("{name}-{diameter}.mtx")), text).expect("written");
        }
    };
    (0..3).for_each(good);
    let refused = |file: &str, text: String| {
        std::fs::write(folder.join(file), text).expect("written");
        let study = Study::read(&folder.join("nodal.toml")).expect("a study");
        let error = study.build_model().expect_err(file).to_string();
        (0..3).for_each(good);
        assert!(!error.contains('\n'), "{error}");
        error
    };
    for (file, text, fragment) in refused_files() {
        let error = refused(file, text);
        println!("{error}");
        assert!(error.contains(fragment), "{error}: {fragment}");
    }
    std::fs::remove_file(folder.join("mass-1.mtx")).expect("removed");
    let study = Study::read(&folder.join("nodal.toml")).expect("a study");
    let error = study
        .build_model()
        .expect_err("a file is missing")
        .to_string();
    assert!(error.contains("mass-1.mtx"), "{error}");
}
