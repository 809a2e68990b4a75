//! Nastran: DMIG entries, and the names of rows in bulk data.

use crate::chain::MODELS;
use crate::chain::{ROWS, assert_is, dof, lower, mass, read_as, stiffness};
use microslip::import::matrix::{Content, Rows};

/// A number as Nastran writes it in 16 columns.
fn sixteen(value: f64) -> String {
    let text = format!("{value:.9e}");
    let (mantissa, exponent) = text.split_once('e').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>16}", format!("{mantissa}D{sign}{:02}", exponent.abs()))
}

/// Large fields, as PARAM,EXTOUT,DMIGPCH punches them: form 6, one triangle.
pub(crate) fn punch(name: &str, entry: fn(usize, usize) -> f64, upper: bool) -> String {
    let mut text = format!(
        "DMIG    {name:8}{:8}{:8}{:8}{:8}{:24}{ROWS:8}\n",
        0, 6, 2, 0, ""
    );
    let mut entries = lower(entry);
    if upper {
        entries = entries
            .iter()
            .map(|&(row, column, value)| (column, row, value))
            .collect();
        entries.sort_by_key(|&(row, column, _)| (column, row));
    }
    let mut last = None;
    for (row, column, value) in entries {
        let ((point, component), (at, of)) = (dof(column), dof(row));
        if last != Some(column) {
            text.push_str(&format!("DMIG*   {name:16}{point:16}{component:16}\n"));
            last = Some(column);
        }
        text.push_str(&format!("*       {at:16}{of:16}{}\n", sixteen(value)));
    }
    text
}

/// Small fields, form 1: all entries, two to a continuation.
fn small(name: &str, entry: fn(usize, usize) -> f64) -> String {
    let mut text = format!(
        "$ written by a test\nDMIG    {name:8}{:8}{:8}{:8}{:8}\n",
        0, 1, 1, 0
    );
    for column in 0..ROWS {
        let rows: Vec<_> = (0..ROWS).filter(|row| entry(*row, column) != 0.0).collect();
        let (point, component) = dof(column);
        text.push_str(&format!("DMIG    {name:8}{point:8}{component:8}{:8}", ""));
        for (at, row) in rows.iter().enumerate() {
            let (point, component) = dof(*row);
            let mantissa = entry(*row, column) / 1e3;
            if at % 2 == 1 {
                text.push_str("\n        ");
            }
            text.push_str(&format!(
                "{point:8}{component:8}{:>8}{:8}",
                format!("{mantissa}+3"),
                ""
            ));
        }
        text.push('\n');
    }
    text
}

/// Free fields.
fn free(name: &str, entry: fn(usize, usize) -> f64) -> String {
    let mut text = format!("DMIG,{name},0,6,2,0\n");
    for (row, column, value) in lower(entry) {
        let ((a, i), (b, j)) = (dof(column), dof(row));
        text.push_str(&format!("DMIG,{name},{a},{i},,{b},{j},{value:e}\n"));
    }
    text
}

/// Small fields with tabs between them, form 6; rows stand in lines of continuation, which begin with a tab.
fn tabs(name: &str, entry: fn(usize, usize) -> f64) -> String {
    let mut text = format!("DMIG\t{name}\t0\t6\t1\t0\n");
    let mut last = None;
    for (row, column, value) in lower(entry) {
        let ((point, component), (at, of)) = (dof(column), dof(row));
        if last != Some(column) {
            text.push_str(&format!("DMIG\t{name}\t{point}\t{component}\n"));
            last = Some(column);
        }
        text.push_str(&format!("\t{at}\t{of}\t{}+3\n", value / 1e3));
    }
    text
}

/// Seen to fail with form 6 taken for a matrix that states all entries; and with the program before, which knew no tabs: "has no
/// DMIG entry".
#[test]
fn all_forms_of_dmig_are_the_chain() {
    let cases = [
        ("large, lower", punch("KAAX", stiffness, false)),
        ("large, upper", punch("KAAX", stiffness, true)),
        ("small, square", small("KAAX", stiffness)),
        ("free", free("KAAX", stiffness)),
        ("tabs", tabs("KAAX", stiffness)),
    ];
    for (what, text) in cases {
        let reading = read_as("model.pch", text.as_bytes()).unwrap();
        assert_eq!(reading.format, "Nastran bulk data");
        assert_is(&reading.matrices[0], stiffness, what);
    }
    let both = punch("KAAX", stiffness, false) + &punch("MAAX", mass, false);
    let reading = read_as("model.pch", both.as_bytes()).unwrap();
    assert_is(&reading.matrices[1], mass, "MAAX");
    assert_eq!(reading.matrices[1].name, "MAAX");
}

/// A scalar point has the component 0; a load has a column number. Seen to fail with 1 for a blank component.
#[test]
fn scalar_points_and_loads_are_read() {
    let text = "DMIG,KAAX,0,6,2,0\nDMIG,KAAX,2001,0,,2001,,5.+3\n\
                DMIG,PAX,0,9,2,0,,,1\nDMIG,PAX,1,0,,11,2,1.5\n*,2001,0,2.5\n";
    let reading = read_as("model.pch", text.as_bytes()).unwrap();
    let Rows::Named(names) = &reading.matrices[0].rows else {
        panic!("has names");
    };
    assert_eq!(names.len(), 1);
    assert_eq!(names[0].to_string(), "2001.0");
    let Content::Column(load) = &reading.matrices[1].content else {
        panic!("is a load");
    };
    assert_eq!(*load, [1.5, 2.5]);
}

/// A line has eight fields, or four large ones, and the marker of a continuation: in fixed columns 73 to 80 whatever stands there.
///
/// Seen to fail with the program before, which read K without what stands behind the fields.
#[test]
fn nothing_stands_behind_the_fields_of_a_line() {
    let column = |line: &str| format!("DMIG,KAAX,0,6,2,0\n{line}\n");
    let fixed = |marker: &str| {
        let fields = ["DMIG", "KAAX", "11", "1", "", "11", "1", "1.0+4", ""];
        let fields: String = fields.iter().map(|field| format!("{field:8}")).collect();
        column(&format!("{fields}{marker:8}"))
    };
    for (text, field) in [
        (column("DMIG,KAAX,11,1,,11,1,1.0E4,0.0,12,1,-2.0E3"), "12"),
        (column("DMIG,KAAX,11,1,,11,1,1.0E4,,+,12"), "12"),
        (column("DMIG*,KAAX,11,1,,11"), "11"),
        (fixed("+A      -2.0+3"), "-2.0+3"),
    ] {
        let many = if text.contains('*') { 4 } else { 8 };
        let fragment = format!(":2: {field}: stands behind the {many} fields of a line: must be");
        MODELS.refuse_bytes("model.pch", text.as_bytes(), &text, &fragment);
    }
    for text in [
        column("DMIG,KAAX,11,1,,11,1,1.0E4,,+\n+,12,1,-2.0E3"),
        column("DMIG*,KAAX,11,1,,*A\n*A,11,1,1.0E4,,*B\n*B,12,1,-2.0E3"),
        fixed("A1") + "+A1     12      1       -2.0+3\n",
    ] {
        let reading = read_as("model.pch", text.as_bytes()).unwrap();
        let Content::Symmetric(found) = &reading.matrices[0].content else {
            panic!("{text}: is no matrix");
        };
        assert_eq!(found.lower, [(0, 0, 1e4), (1, 0, -2e3)], "{text}");
    }
}

/// Nastran orders grid and scalar points together by their numbers.
///
/// Seen to fail with the a-set before EXTRN; and with the program before, which took points in the order of the file, and scalar points
/// last.
#[test]
fn names_come_from_the_best_list() {
    let names = |text: &str| {
        let names = read_as("model.asm", text.as_bytes())
            .unwrap()
            .names
            .unwrap();
        let names: Vec<_> = names.iter().map(ToString::to_string).collect();
        names.join(" ")
    };
    let grids = "GRID*                  3               0 0.600000000E+03 0.000000000E+00\n*        0.300000000E+03\n\
                 SPOINT   2995001    THRU 2995002\n";
    assert_eq!(names(grids), "3.1 3.2 3.3 3.4 3.5 3.6 2995001.0 2995002.0");
    let mixed = "GRID    21\nSPOINT  15\nGRID    11\n";
    assert_eq!(
        names(mixed),
        "11.1 11.2 11.3 11.4 11.5 11.6 15.0 21.1 21.2 21.3 21.4 21.5 21.6"
    );
    let a_set = "ASET1   13      7       3\nQSET1   0       90      91\n";
    assert_eq!(
        names(&format!("{grids}{a_set}")),
        "3.1 3.3 7.1 7.3 90.0 91.0"
    );
    let extrn = "EXTRN   7       12      3       3       90      0\n";
    assert_eq!(names(&format!("{a_set}{extrn}")), "7.1 7.2 3.3 90.0");
}

/// Of free fields: line 1 is the header, line 2 the first column.
const DAMAGED_DMIG: &str = "
1 | DMIG,KAAX,0,6,3,0 | has complex matrices only: must have real ones
1 | DMIG,KAAX,0,6,4,0 | has complex matrices only
1 | DMIG,KAAX,0,6,9,0 | :1: matrix KAAX: type 9: must be 1 or 2
1 | DMIG,KAAX,0,6,,0 | type : must be
1 | DMIG,KAAX,0,5,2,0 | :1: matrix KAAX: form 5: must be 1 (square)
1 | DMIG,KAAX,0,,2,0 | form : must be
1 | DMIG,,0,6,2,0 | :1: must have a name
1 | DMIG,KAAXKAAXK,0,6,2,0 | :1: must have a name of at most 8 letters
1 |  | :2: matrix KAAX: has no header
1 | DMIG,MAAX,0,6,2,0 | :2: matrix KAAX: has no header
1 | DMIG,KAAX,0,6,2,0\\nDMIG,KAAX,0,6,2,0 | :2: matrix KAAX: has a second header
1 | DMIG,KAAX,0,1,2,0 | must be symmetric
1 | DMIG,KAAX,0,6,2,0\\nDMIG,MAAX,0,6,2,0 | matrix MAAX: has no column
2 | DMIG,KAAX,0.5,1,,11,1,1.0 | :2: grid point 0.5: must be a whole number
2 | DMIG,KAAX,-1,1,,11,1,1.0 | :2: grid point -1
2 | DMIG,KAAX,99999999999,1,,11,1,1.0 | :2: grid point 99999999999
2 | DMIG,KAAX,x,1,,11,1,1.0 | :2: grid point x
2 | DMIG,KAAX,11,7,,11,1,1.0 | :2: component 7: must be 0 to 6
2 | DMIG,KAAX,11,12,,11,1,1.0 | :2: component 12: must be
2 | DMIG,KAAX,11,1,,x,1,1.0 | :2: grid point x
2 | DMIG,KAAX,11,1,,11,9,1.0 | :2: component 9
2 | DMIG,KAAX,11,1,,11,1,NaN | :2: value NaN: must be a finite number
2 | DMIG,KAAX,11,1,,11,1,1.+999 | must be a finite number
2 | DMIG,KAAX,11,1,,11,1,one | :2: value one: must be a number
2 | DMIG,KAAX,11,1,,11,1, | :2: value : must be a number
2 | DMIG,KAAX,11,1,,,,1.0 | :2: grid point : must be
2 | DMIG,KAAX,11,1,,11,1,1.0,0.5 | :2: imaginary part 0.5: must be absent
2 | DMIG,KAAX,11,1,,11,1,1.0\\n*,11,1,2.0 | :3: entry (1, 1): must be given once
2 | DMIG,KAAX,11,1,,7,1,-2.0e6\\nDMIG,KAAX,7,1,,11,1,-3.0e6 | must be given once
2 | DMIG,KAAX,11,1,,12,1,-2.0e6\\nDMIG,KAAX,12,1,,11,1,-3.0e6 | must be symmetric
2 | DMIG,KAAX,11,1,,11,1,1.0,x | imaginary part x
2 | \\0 | :2: has a null byte
";

/// A complex matrix beside real ones is passed over.
///
/// Seen to fail with complex types read as real.
#[test]
fn a_complex_matrix_is_passed_over() {
    let complex = "DMIG,K4AAX,0,6,3,0\nDMIG,K4AAX,11,1,,11,1,1.0,0.5\n";
    let text = format!("{complex}{}", free("KAAX", stiffness));
    let reading = read_as("model.pch", text.as_bytes()).unwrap();
    let names: Vec<_> = reading.matrices.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["KAAX"], "{names:?}");
}

/// Seen to fail with complex types read as real.
#[test]
fn damaged_dmig_is_refused() {
    let text = free("KAAX", stiffness);
    assert!(MODELS.refuse("model.pch", &text, DAMAGED_DMIG) > 30);
    MODELS.refuse_bytes("model.pch", b"", "empty", "has no DMIG entry");
    MODELS.refuse_bytes(
        "model.pch",
        b"$ nothing\nPARAM,POST,-1\n",
        "other",
        "has no DMIG entry",
    );
}

const DAMAGED_NAMES: &str = "
1 | SEQGP,11,5 | :1: SEQGP: must be absent: it gives points another order
1 | EXTRN,11,17 | :1: components 17: must be digits from 1 to 6
1 | EXTRN,11,x | :1: components x
1 | EXTRN,x,1 | :1: grid point x
1 | EXTRN,0,1 | :1: grid point 0
1 | EXTRN,11,11 | :1: degree of freedom 11.1: must be given once
1 | EXTRN,11,1,11,1 | :1: degree of freedom 11.1: must be given once
1 | EXTRN,11,THRU,12 | :1: components THRU
1 | SPOINT,10,THRU,5 | :1: 10 THRU 5: must ascend
1 | SPOINT,1,THRU,2000000000 | must ascend, by less than 1000000
1 | SPOINT,1,1 | :1: degree of freedom 1.0: must be given once
1 | ASET1,19,5 | :1: components 19
1 | ASET1,1,x | :1: point x
1 | GRID,x | :1: grid point x
1 | GRID,3\\nGRID,3 | :2: degree of freedom 3.1: must be given once
1 | GRID, | :1: grid point : must be
1 | GRID,-3 | :1: grid point -3: must be
1 | GRID,2147483648 | :1: grid point 2147483648: must be
1 | GRID,3.0 | :1: grid point 3.0: must be
1 | SPOINT,x | :1: point x: must be
1 | SPOINT,0 | :1: point 0: must be
1 | SPOINT,1,THRU,x | :1: point x: must be
1 | SPOINT,1,THRU | :1: point : must be
1 | SPOINT,1.5 | :1: point 1.5: must be
1 | ASET,11,7 | :1: components 7
1 | ASET,x,1 | :1: grid point x: must be
1 | ASET,11,1-2 | :1: components 1-2
1 | ASET1,x,5 | :1: components x
1 | ASET1,1,0 | :1: point 0: must be
1 | ASET1,1,5,THRU,2 | :1: 5 THRU 2: must ascend
1 | QSET1,8,5 | :1: components 8
1 | EXTRN,11,123,11,3 | :1: degree of freedom 11.3: must be given once
1 | EXTRN,99999999999,1 | :1: grid point 99999999999: must be
1 | EXTRN,11,1.0 | :1: components 1.0
1 | EXTRN,,1 | :1: grid point : must be
1 | \\0 | :1: has a null byte
";

/// Seen to fail without the check of THRU.
#[test]
fn damaged_names_are_refused() {
    let count = MODELS.refuse("model.asm", "EXTRN,11,123456\n", DAMAGED_NAMES);
    assert!(count > 30, "{count}");
}
