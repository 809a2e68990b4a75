//! Abaqus and CalculiX: matrices as `node, dof, node, dof, value`, and user elements of substructures.

use crate::chain::MODELS;
use crate::chain::{ROWS, assert_is, dof, fortran, lower, mass, read_as, stiffness};
use microslip::import::matrix::{Content, Rows};

/// `node, dof, node, dof, value` of the given sides.
pub(crate) fn matrix(entry: fn(usize, usize) -> f64, lower_side: bool, upper_side: bool) -> String {
    let mut text = String::from("** written by a test\n");
    for (row, column, value) in lower(entry) {
        let line = |(a, i): (i64, usize), (b, j): (i64, usize)| {
            format!("{a:10},{i:5},{b:10},{j:5}, {}\n", fortran(value, 13, 'E'))
        };
        if lower_side || row == column {
            text.push_str(&line(dof(row), dof(column)));
        }
        if upper_side && row != column {
            text.push_str(&line(dof(column), dof(row)));
        }
    }
    text
}

/// A user element as CalculiX writes it: one component per position.
pub(crate) fn calculix_element() -> String {
    let mut text = format!(
        "**\n** GENERATION OF SUBSTRUCTURE\n*USER ELEMENT NODES={ROWS:11} LINEAR\n** ELEMENT NODES\n"
    );
    for chunk in (0..ROWS).collect::<Vec<_>>().chunks(10) {
        let nodes: Vec<_> = chunk
            .iter()
            .map(|row| format!("{:10}", dof(*row).0))
            .collect();
        text.push_str(&format!("**{} \n", nodes.join(" ")));
    }
    text.push_str("         1\n");
    for row in 1..ROWS {
        text.push_str(&format!("{:10} {:10}\n", row + 1, dof(row).1));
    }
    text.push_str("*MATRIX TYPE=STIFFNESS\n");
    text.push_str(&packed(stiffness, " "));
    text
}

/// A user element as Abaqus writes it: all components of a node together, stiffness, mass, loads.
pub(crate) fn abaqus_element() -> String {
    let mut text = String::from("**\n** ELEMENT NODES\n** 11, 7, 120, 4\n");
    text.push_str(
        "*USER ELEMENT, NODES=4, LINEAR\n** ELEMENT NODES\n** 11, 7,\n** 120, 4\n1, 2, 3\n",
    );
    text.push_str("*MATRIX, TYPE=STIFFNESS\n");
    text.push_str(&packed(stiffness, ", "));
    text.push_str("*MATRIX, TYPE=MASS\n");
    text.push_str(&packed(mass, ", "));
    text.push_str("** CLOAD\n** 120, 2, 1.5\n");
    text
}

/// The lower triangle by rows, four numbers a line.
fn packed(entry: fn(usize, usize) -> f64, between: &str) -> String {
    let mut text = String::new();
    for row in 0..ROWS {
        let numbers: Vec<_> = (0..=row).map(|c| fortran(entry(row, c), 13, 'E')).collect();
        for line in numbers.chunks(4) {
            text.push_str(&format!(" {}\n", line.join(between)));
        }
    }
    text
}

/// Seen to fail with `Storage::Full` in place of `Storage::Unknown`: one triangle alone was refused.
#[test]
fn one_triangle_the_other_or_both_are_the_same_matrix() {
    for (low, up) in [(true, false), (false, true), (true, true)] {
        let reading = read_as("K.mtx", matrix(stiffness, low, up).as_bytes()).unwrap();
        assert_eq!(reading.format, "Abaqus matrix");
        assert_is(&reading.matrices[0], stiffness, &format!("{low} {up}"));
        assert_eq!(reading.matrices[0].digits, 13);
    }
}

/// Internal nodes of Abaqus are negative. Seen to fail with lines of three words refused.
#[test]
fn internal_nodes_and_loads_are_read() {
    let text = "-3,1,-3,1,2.0D0\n7,2,7,2,1.\n7,2,-3,1,-0.5d+00\n";
    let reading = read_as("K.mtx", text.as_bytes()).unwrap();
    let Rows::Named(names) = &reading.matrices[0].rows else {
        panic!("has names");
    };
    let names: Vec<_> = names.iter().map(ToString::to_string).collect();
    assert_eq!(names, ["-3.1", "7.2"]);
    let reading = read_as("load.mtx", b"*CLOAD\n7, 2, 1.5\n9, 1, -2\n").unwrap();
    let Content::Column(column) = &reading.matrices[0].content else {
        panic!("is a load");
    };
    assert_eq!(*column, [1.5, -2.0]);
}

/// A second load case and an imaginary part are no part of one force.
///
/// Seen to fail with the program before, which read one force of all of them.
#[test]
fn a_file_has_one_load() {
    let two = "*CLOAD, LOAD CASE=1\n7,2,1.5\n*CLOAD, LOAD CASE=2\n9,1,-2\n";
    let imaginary = "*CLOAD, REAL\n7,2,1.5\n*cload, imaginary\n9,1,-2\n";
    let only = "*CLOAD, IMAGINARY\n9,1,-2\n";
    for (text, rule) in [
        (two, ":3: is a second load: a file must have one"),
        (imaginary, ":3: is the imaginary part of a load"),
        (only, ":1: is the imaginary part of a load"),
    ] {
        MODELS.refuse_bytes("load.mtx", text.as_bytes(), text, rule);
    }
    let element = abaqus_element();
    let line = element.lines().count() + 1;
    for (more, rule) in [
        ("** CLOAD\n** 7, 1, 2.5\n", "is a second load"),
        ("*CLOAD, IMAGINARY\n7, 1, 2.5\n", "is the imaginary part"),
    ] {
        let text = format!("{element}{more}");
        let expected = format!(":{line}: {rule}");
        MODELS.refuse_bytes("super.mtx", text.as_bytes(), more, &expected);
    }
}

/// Seen to fail with the components of the first position for all.
#[test]
fn both_forms_of_a_user_element_are_the_chain() {
    let reading = read_as("super.dat", calculix_element().as_bytes()).unwrap();
    assert_eq!(reading.format, "Abaqus substructure");
    assert_is(&reading.matrices[0], stiffness, "CalculiX");
    let reading = read_as("super.mtx", abaqus_element().as_bytes()).unwrap();
    assert_is(&reading.matrices[0], stiffness, "Abaqus K");
    assert_is(&reading.matrices[1], mass, "Abaqus M");
    let Content::Column(load) = &reading.matrices[2].content else {
        panic!("is a load");
    };
    assert_eq!(load.iter().position(|f| *f == 1.5), Some(7));
}

const DAMAGED_MATRICES: &str = "
2 | 11,1,11,1,1.0\\n11,1,11,1,1.0 | :3: entry (1, 1): must be given once
4 |  | has no entry on the other side
3 | 7,1,11,1,-1000001 | must be symmetric: entry (2, 1) = -1000001
3 | 7,1,11,1,-1000000.1 | and entry (1, 2) = -1000000 differ
3 | 7,1,11,1,NaN | NaN: must be a finite number
3 | 7,1,11,1,inf | :3: value inf: must be a finite number
3 | 7,1,11,1,1e999 | 1e999: must be a finite number
3 | 7,1,11,1, | :3: must be an entry: node, dof, node, dof, value
3 | 7,1,11,1,eight | :3: value eight: must be a number
3 | 7,1,11,1,0x10 | 0x10: must be a number
3 | 7,1,11,1,1.0.0 | must be a number
3 | 7,1,11,1,1.0 2.0 | :3: must be an entry
3 | 7,1,11,1,1e+ | must be a number
3 | 7,1,11,1,--1 | must be a number
2 | 99999999999,1,11,1,1.0 | :2: node 99999999999: must be a whole number
2 | -99999999999,1,11,1,1.0 | must be a whole number from -2147483647
2 | 11,-1,11,1,1.0 | :2: degree of freedom -1: must be
2 | 11,10000,11,1,1.0 | degree of freedom 10000: must be
2 | 11.5,1,11,1,1.0 | :2: node 11.5: must be a whole number
2 | a,1,11,1,1.0 | :2: node a: must be
2 | 11,b,11,1,1.0 | degree of freedom b
2 | 11,1,1.0 | :3: must be an entry
2 | 11,1,11,1 | is of no format that is read
2 | 11 | is of no format that is read
2 | 11,1,11,1,1.0,5 | is of no format that is read
5 | 11,1,11,1,1.0,5 | :5: must be an entry
6 | 1 2 | :6: must be an entry
7 | \\0 | :7: has a null byte
8 | K = 5 | :8: must be an entry
9 | 11,1,3000000000,1,1.0 | :9: node 3000000000
9 | 11,1,999,1,1.0 | has no entry on the other side
";

/// Seen to fail without the check of duplicates.
#[test]
fn damaged_matrices_are_refused() {
    let both = matrix(stiffness, true, true);
    assert!(MODELS.refuse("K.mtx", &both, DAMAGED_MATRICES) > 30);
    MODELS.refuse_bytes("K.mtx", b"", "empty", "is of no format");
    MODELS.refuse_bytes(
        "K.mtx",
        b"** nothing\n*HEADING\n",
        "no entry",
        "is of no format",
    );
    MODELS.refuse_bytes("K.mtx", b"\xff\xfe1\0", "UTF-16", "is UTF-16 text");
}

const DAMAGED_ELEMENTS: &str = "
NODES=4 | NODES=5 | needs the 5 nodes that *USER ELEMENT states
NODES=4 | NODES=3 | needs the 3 nodes
NODES=4 | NODES=0 | :4: NODES 0: must be a whole number from 1 to 1000000
NODES=4 | NODES=-4 | NODES -4: must be
NODES=4 | NODES=99999999999999999999 | must be a whole number from 1 to 1000000
NODES=4 | NODES=1000001 | must be a whole number
NODES=4 | NODES=four | NODES FOUR: must be
NODES=4 | TYPE=U1 | NODES : must be
NODES=4, | NODES=4, UNSYMM, | :4: is unsymmetric
6 | ** 11, 7.5, | :6: node 7.5: must be
6 | ** 11, seven, | :6: node seven: must be
6 | ** 11, | 3 are there
6 | ** 11, 7, 8, | 5 are there
6 | ** | 2 are there
6 | ** 11, 11, | degree of freedom 11.1: must be given once
8 | 1, 2 | more than the 8 rows
8 | 1, 2, 3, 4 | ends in row 13; 16 rows
8 | 1, 2, 0 | degree of freedom 0: must be a whole number from 1
8 | 1, 2, 2 | must be given once
8 |  | needs the degrees of freedom of its nodes
8 | 1, 2, 3\\n9, 1 | :9: node position 9: must be a whole number from 2 to 4
8 | 1, 2, 3\\n1, 1 | :9: node position 1: must be
8 | 1, 2, x | degree of freedom x: must be
10 | NaN | :10: NaN: must be a finite number
10 | 1e999 | must be a finite number
10 | word | :10: word: must be a number
10 |  | ends in row
10 | 1.0, 2.0 | more than the 12 rows
*MATRIX, TYPE=MASS |  | more than the 12 rows
4 |  | has no *USER ELEMENT before it
9 | *USER ELEMENT, NODES=4 | :9: is a second user element
";

/// Seen to fail without the check of `close`.
#[test]
fn damaged_user_elements_are_refused() {
    let text = abaqus_element();
    let whole = &text[..text.find("** CLOAD").unwrap()];
    assert!(MODELS.refuse("super.mtx", whole, DAMAGED_ELEMENTS) > 30);
    let bytes = whole.as_bytes();
    MODELS.refuse_cuts("super.mtx", bytes, &[0.3, 0.5, 0.9, 0.97], "ends in row");
    MODELS.refuse_cuts("super.mtx", bytes, &[0.02, 0.05], "");
    let wrong = text.replace("** 120, 2, 1.5", "** 121, 2, 1.5");
    let expected = "load on 121.2: must be a degree of freedom";
    MODELS.refuse_bytes("super.mtx", wrong.as_bytes(), "load", expected);
}
