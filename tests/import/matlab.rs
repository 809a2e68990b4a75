//! MATLAB: `.mat` files of level 5, in both byte orders, compressed or not, dense and sparse.

use crate::chain::MODELS;
use crate::chain::{ROWS, assert_is, lower, mass, read_as, stiffness};
use crate::mat_file::*;
use crate::microslip;
use microslip::import::matrix::Content;

/// Type of data in single precision.
const SINGLE: u32 = 7;
/// Classes that only matrices have here.
const SPARSE_CLASS: u32 = 5;
const SINGLE_CLASS: u32 = 7;

impl Form {
    fn dense(self, name: &str, entry: fn(usize, usize) -> f64) -> Vec<u8> {
        let all = (0..ROWS * ROWS).map(|at| entry(at % ROWS, at / ROWS));
        let data = (DOUBLE, self.reals(all));
        self.variable(name, DOUBLE_CLASS, &[ROWS, ROWS], &[data])
    }

    /// Rows, columns and values of a sparse matrix, with `more` places that are not used.
    fn sparse_data(self, entry: fn(usize, usize) -> f64, more: usize) -> [(u32, Vec<u8>); 3] {
        let mut entries: Vec<_> = lower(entry);
        let above: Vec<_> = entries
            .iter()
            .filter(|(i, j, _)| i != j)
            .map(|&(i, j, v)| (j, i, v))
            .collect();
        entries.extend(above);
        entries.sort_by_key(|&(i, j, _)| (j, i));
        let begin = |column: usize| entries.iter().filter(|(_, j, _)| *j < column).count();
        let filled = std::iter::repeat_n((0, 0, 0.0), more);
        let all: Vec<_> = entries.iter().copied().chain(filled).collect();
        [
            (INT32, self.wholes(all.iter().map(|(i, ..)| *i))),
            (INT32, self.wholes((0..=ROWS).map(begin))),
            (DOUBLE, self.reals(all.iter().map(|(.., v)| *v))),
        ]
    }

    fn sparse(self, name: &str, entry: fn(usize, usize) -> f64, more: usize) -> Vec<u8> {
        self.variable(
            name,
            SPARSE_CLASS,
            &[ROWS, ROWS],
            &self.sparse_data(entry, more),
        )
    }

    /// K dense, M sparse, F, and variables that no model has: a text, numbers m and k, a table that is not square.
    pub(crate) fn model(self) -> Vec<u8> {
        let force = (DOUBLE, self.reals((0..ROWS).map(|i| i as f64)));
        let complex = (DOUBLE, self.reals([1.0]));
        let table = (DOUBLE, self.reals([f64::NAN; 6]));
        self.file(&[
            self.variable("note", 4, &[1, 3], &[(4, self.wholes([1, 2]))]),
            self.dense("K", stiffness),
            self.sparse("M", mass, 3),
            self.variable("F", DOUBLE_CLASS, &[ROWS, 1], &[force]),
            self.variable(
                "k",
                DOUBLE_CLASS | COMPLEX,
                &[1, 1],
                &[complex.clone(), complex],
            ),
            self.variable("m", DOUBLE_CLASS, &[1, 1], &[(DOUBLE, self.reals([3.0]))]),
            self.variable("table", DOUBLE_CLASS, &[2, 3], &[table]),
        ])
    }
}

/// Seen to fail with numbers of the other byte order.
#[test]
fn matrices_of_every_form_are_read() {
    for form in forms() {
        let reading = read_as("model.mat", &form.model()).unwrap();
        let what = format!("{form:?}");
        assert_eq!(reading.format, "MATLAB", "{what}");
        let names: Vec<_> = reading.matrices.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["K", "M", "F"], "{what}");
        assert_is(&reading.matrices[0], stiffness, &what);
        assert_is(&reading.matrices[1], mass, &what);
        let Content::Column(force) = &reading.matrices[2].content else {
            panic!("{what}: F is no column");
        };
        assert_eq!(force[ROWS - 1], ROWS as f64 - 1.0, "{what}");
    }
}

/// Of `[V, D] = eig(K, M)` D is no damping matrix.
///
/// Seen to fail with the program before, which wrote it as `damping.mtx`.
#[test]
fn eigenvalues_are_no_damping() {
    let form = Form::default();
    let file = form.file(&[
        form.dense("D", mass),
        form.dense("K", stiffness),
        form.dense("M", mass),
    ]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("model.mat"), file).unwrap();
    let import = ["import", "model.mat", "--units", "SI", "--output", "model"];
    let output = microslip(folder.path(), &import);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("model.mat: matrix D is not used"), "{said}");
    assert!(folder.path().join("model/stiffness.mtx").exists());
    assert!(!folder.path().join("model/damping.mtx").exists());
}

/// MATLAB stores whole numbers in fewer bytes than their class has. Seen to fail without the signs of the smallest ones.
#[test]
fn numbers_in_fewer_bytes_are_read() {
    let form = Form::default();
    let kinds: [(u32, Vec<u8>); 7] = [
        (1, vec![2, 255, 255, 2]),
        (3, [2_i16, -1, -1, 2].map(i16::to_le_bytes).concat()),
        (5, [2_i32, -1, -1, 2].map(i32::to_le_bytes).concat()),
        (12, [2_i64, -1, -1, 2].map(i64::to_le_bytes).concat()),
        (
            SINGLE,
            [2.0_f32, -1.0, -1.0, 2.0].map(f32::to_le_bytes).concat(),
        ),
        (2, vec![2, 1, 1, 2]),
        (13, [2_u64, 1, 1, 2].map(u64::to_le_bytes).concat()),
    ];
    for (kind, data) in kinds {
        let class = if kind == SINGLE {
            SINGLE_CLASS
        } else {
            DOUBLE_CLASS
        };
        let off = if matches!(kind, 2 | 13) { 1.0 } else { -1.0 };
        let file = form.file(&[form.variable("K", class, &[2, 2], &[(kind, data)])]);
        let reading = read_as("K.mat", &file).unwrap();
        let Content::Symmetric(found) = &reading.matrices[0].content else {
            panic!("type {kind}: no matrix");
        };
        assert_eq!(
            found.lower,
            [(0, 0, 2.0), (1, 0, off), (1, 1, 2.0)],
            "type {kind}"
        );
        let digits = if kind == SINGLE { 8 } else { 17 };
        assert_eq!(reading.matrices[0].digits, digits, "type {kind}");
    }
}

/// A word at a place of a file with K alone, dense and uncompressed, and what the message must hold.
const DAMAGED_WORDS: [(usize, u32, &str); 26] = [
    (124, 0x4d49_0300, "is no MATLAB file of level 5"),
    (124, 0x4d49_0200, "is a MATLAB file of version 7.3"),
    (124, 0, "is no MATLAB file of level 5"),
    (128, 13, "variable 1: is of type 13: must be 14"),
    (128, 15, "variable 1: is damaged"),
    (
        128,
        0x0005_000e,
        "variable 1: has an element of 5 bytes in a word of four",
    ),
    (
        132,
        u32::MAX,
        "variable 1: states 4294967295 bytes, but only 1200 are left",
    ),
    (132, 4, "variable 1: ends early"),
    (132, 40, "variable 1: K: ends early"),
    (136, 5, "variable 1: must begin with its flags"),
    (140, 0, "variable 1: must begin with its flags"),
    (140, 5000, "variable 1: states 5000 bytes"),
    (144, 0, "K: has the class 0, which is none"),
    (144, 19, "K: has the class 19, which is none"),
    (
        144,
        1,
        "array K: is no array of numbers: must be real numbers",
    ),
    (144, 5, "K: rows: must be whole numbers >= 0"),
    (144, 0x806, "array K: is complex: must be real numbers"),
    (152, 9, "dimensions: must be whole numbers >= 0"),
    (156, 4, "has 1 dimensions: must have 2 to 32"),
    (152, 99, "has data of type 99: must be numbers"),
    (156, 5, "has 5 bytes: must be numbers of 4 bytes"),
    (160, u32::MAX, "dimensions: must be whole numbers >= 0"),
    (160, 13, "K: has 144 numbers, which do not fill [13, 12]"),
    (160, 0x7fff_ffff, "K: has 144 numbers, which do not fill"),
    (168, 0x0001_0009, "has no name of at most 128 bytes"),
    (176, 8, "K: has data of type 8: must be numbers"),
];

/// Seen to fail without the check of classes.
#[test]
fn damaged_words_are_refused() {
    let form = Form {
        small: true,
        ..Form::default()
    };
    let whole = form.file(&[form.dense("K", stiffness)]);
    assert_is(
        &read_as("K.mat", &whole).unwrap().matrices[0],
        stiffness,
        "whole",
    );
    for (at, word, fragment) in DAMAGED_WORDS {
        let mut damaged = whole.clone();
        damaged[at..at + 4].copy_from_slice(&word.to_le_bytes());
        MODELS.refuse_bytes("K.mat", &damaged, &format!("{at}: {word}"), fragment);
    }
    MODELS.refuse_cuts(
        "K.mat",
        &whole,
        &[0.005, 0.05, 0.09, 0.095, 0.1, 0.15, 0.5, 0.99],
        "",
    );
    MODELS.refuse_bytes(
        "K.mat",
        b"\0\0\0\0\x0c\0\0\0",
        "level 4",
        "is no MATLAB file",
    );
    MODELS.refuse_bytes("K.mat", b"\x89HDF\r\n\x1a\n", "HDF5", "version 7.3");
    let packed = Form {
        compressed: true,
        ..form
    };
    let whole = packed.file(&[packed.dense("K", stiffness)]);
    MODELS.refuse_cuts("K.mat", &whole, &[0.65, 0.8, 0.99], "variable 1: ");
    for at in [136, 137, 150, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[at] ^= 0xff;
        MODELS.refuse_bytes("K.mat", &damaged, &format!("byte {at}"), "variable 1: ");
    }
}

/// Name, shape and equal numbers of a dense variable, and what the message must hold.
const DAMAGED_DENSE: [(&str, &[usize], f64, &str); 8] = [
    (
        "K",
        &[1, 1],
        f64::NAN,
        "array K: number 1 = NaN: must be a finite number",
    ),
    (
        "K",
        &[1, 2, 1, 2],
        0.0,
        "array K: is 1 x 2 x 1 x 2: must be square",
    ),
    ("K", &[2, 3], 0.0, "array K: is 2 x 3: must be square"),
    (
        "F",
        &[1_000_001, 1],
        0.0,
        "array F: is 1000001 x 1: must be square or a vector",
    ),
    ("K", &[0, 0], 0.0, "array K: is 0 x 0"),
    ("other", &[2, 3], 0.0, "has no square matrix and no vector"),
    (
        "other",
        &[2, 2],
        f64::INFINITY,
        "has no square matrix and no vector",
    ),
    ("m", &[1, 1], 1.0, "has no square matrix and no vector"),
];

/// Values and shapes that do not fit. Seen to fail with a number m taken for the mass.
#[test]
fn impossible_arrays_are_refused() {
    let form = Form::default();
    for (name, shape, value, fragment) in DAMAGED_DENSE {
        let values = vec![value; shape.iter().product()];
        let data = (DOUBLE, form.reals(values));
        let file = form.file(&[form.variable(name, DOUBLE_CLASS, shape, &[data])]);
        MODELS.refuse_bytes("model.mat", &file, fragment, fragment);
    }
    let data = (DOUBLE, form.reals([1.0, 2.0, 3.0, 1.0]));
    let file = form.file(&[form.variable("K", DOUBLE_CLASS, &[2, 2], &[data])]);
    MODELS.refuse_bytes("model.mat", &file, "2, 3", "must be symmetric");
    let name = "K".repeat(129);
    let file = form.file(&[form.dense(&name, stiffness)]);
    MODELS.refuse_bytes(
        "model.mat",
        &file,
        "name",
        "has no name of at most 128 bytes",
    );
}

/// Which list of a sparse variable is another (rows, columns, values), how long it is, its equal numbers, and what the message
/// must hold.
const DAMAGED_LISTS: [(usize, usize, f64, &str); 7] = [
    (0, 3, 7.0, "K: has 30 entries, but 3 rows and 30 numbers"),
    (2, 1, 1.0, "K: has 30 entries, but 30 rows and 1 numbers"),
    (
        1,
        3,
        7.0,
        "K: columns: must ascend from 0 to 7 in 13 numbers",
    ),
    (0, 30, 12.0, "must be finite and inside 12 rows"),
    (0, 30, 0.0, "must be given once"),
    (0, 30, -1.0, "K: rows: must be whole numbers >= 0"),
    (2, 30, f64::NAN, "must be finite and inside 12 rows"),
];

/// Lists that do not fit. Seen to fail without the check of how many entries there are.
#[test]
fn impossible_lists_are_refused() {
    let form = Form::default();
    let refused = |shape: [usize; 2], data: &[(u32, Vec<u8>)], fragment: &str| {
        let file = form.file(&[form.variable("K", SPARSE_CLASS, &shape, data)]);
        MODELS.refuse_bytes("model.mat", &file, fragment, fragment);
    };
    for (at, count, value, fragment) in DAMAGED_LISTS {
        let mut data = form.sparse_data(stiffness, 0);
        data[at] = (DOUBLE, form.reals(vec![value; count]));
        refused([ROWS, ROWS], &data, fragment);
    }
    let data = form.sparse_data(stiffness, 0);
    let long = "K: columns: must ascend from 0 to 30 in 14 numbers";
    refused([ROWS, 13], &data, long);
    refused([13, ROWS], &data, "array K: is 13 x 12: must be square");
}

/// Seen to fail with the entry one row higher.
#[test]
fn a_sparse_vector_is_read() {
    let form = Form::default();
    let lists = |row: usize| {
        let [rows, columns] = [vec![row], vec![0, 1]].map(|list| (INT32, form.wholes(list)));
        [rows, columns, (DOUBLE, form.reals([2.0]))]
    };
    let file = |row: usize| form.file(&[form.variable("F", SPARSE_CLASS, &[3, 1], &lists(row))]);
    let reading = read_as("F.mat", &file(2)).unwrap();
    let Content::Column(force) = &reading.matrices[0].content else {
        panic!("no column");
    };
    assert_eq!(force[..], [0.0, 0.0, 2.0]);
    MODELS.refuse_bytes(
        "F.mat",
        &file(3),
        "row 3",
        "array F: entry 3 = 2: must be finite and inside 3 rows",
    );
}
