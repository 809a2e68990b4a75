//! ANSYS: Harwell-Boeing files of HBMAT with their mapping, and the Matrix Market files of *EXPORT,,MMF.

use crate::chain::MODELS;
use crate::chain::{ROWS, assert_is, dof, fortran, lower, mass, read_as, stiffness};
use microslip::import::matrix::Content;

/// A symmetric file with one number a line, as HBMAT writes it; `load` is the right-hand side.
pub(crate) fn harwell_boeing(entry: fn(usize, usize) -> f64, load: Option<f64>) -> String {
    let entries = lower(entry);
    let mut pointers = vec![1];
    for column in 0..ROWS {
        let many = entries.iter().filter(|e| e.1 == column).count();
        pointers.push(pointers[column] + many);
    }
    let n = entries.len();
    let of_load = load.map_or(0, |_| ROWS);
    let total = pointers.len() + 2 * n + of_load;
    let mut text = format!(
        "{:72}\n{total:14}{:14}{n:14}{n:14}{of_load:14}\nRSA           {ROWS:14}{ROWS:14}{n:14}             0\n",
        "Stiffness matrix from ANSYS FULL file",
        pointers.len()
    );
    text.push_str("(I14)           (I14)           (d25.15)            (d25.15)\n");
    if load.is_some() {
        text.push_str(&format!("F             {:14}{ROWS:14}\n", 1));
    }
    let number = |value: f64| format!("{:>25}\n", fortran(value, 15, 'D'));
    for pointer in pointers {
        text.push_str(&format!("{pointer:14}\n"));
    }
    for (row, ..) in &entries {
        text.push_str(&format!("{:14}\n", row + 1));
    }
    text.extend(entries.iter().map(|(.., value)| number(*value)));
    if let Some(load) = load {
        text.extend((0..ROWS).map(|row| number(load * row as f64)));
    }
    text
}

/// An unsymmetric file (all entries), several numbers a line, without blanks between them.
fn harwell_boeing_full(entry: fn(usize, usize) -> f64) -> String {
    let places = (0..ROWS).flat_map(|column| (0..ROWS).map(move |row| (row, column)));
    let entries: Vec<_> = places.filter(|(r, c)| entry(*r, *c) != 0.0).collect();
    let mut pointers = vec![1];
    for column in 0..ROWS {
        let many = entries.iter().filter(|e| e.1 == column).count();
        pointers.push(pointers[column] + many);
    }
    let lines = |words: Vec<String>, per_line: usize| {
        let lines: Vec<_> = words.chunks(per_line).map(<[String]>::concat).collect();
        (lines.len(), lines.join("\n") + "\n")
    };
    let (a, of_pointers) = lines(pointers.iter().map(|p| format!("{p:8}")).collect(), 10);
    let (b, of_rows) = lines(
        entries
            .iter()
            .map(|(r, _)| format!("{:8}", r + 1))
            .collect(),
        10,
    );
    let numbers = entries.iter().map(|(r, c)| fortran(entry(*r, *c), 12, 'E'));
    let (c, of_values) = lines(numbers.map(|word| format!("{word:>20}")).collect(), 4);
    format!(
        "title\n{:14}{a:14}{b:14}{c:14}\nRUA           {ROWS:14}{ROWS:14}{:14}\n(10I8)          (10I8)          (1P,4E20.12)\n{of_pointers}{of_rows}{of_values}",
        a + b + c,
        entries.len()
    )
}

pub(crate) fn mapping() -> String {
    let mut text = String::from("    Matrix Eqn          Node    DOF     \n");
    for row in 0..ROWS {
        let (node, component) = dof(row);
        let label = ["UX", "UY", "UZ"][component - 1];
        text.push_str(&format!("{:14}{node:14}      {label}\n", row + 1));
    }
    text
}

/// `*DMAT` and `*EXPORT,,MMF`: the dense lower triangle with nine digits and exponents of three.
pub(crate) fn dense_market(entry: fn(usize, usize) -> f64) -> String {
    let mut text = format!("%%MatrixMarket matrix array real symmetric\n{ROWS} {ROWS}\n");
    for column in 0..ROWS {
        for row in column..ROWS {
            text.push_str(&format!("{}\n", nine_digits(entry(row, column))));
        }
    }
    text
}

/// `2.61306980E+010`.
fn nine_digits(value: f64) -> String {
    let text = format!("{value:.8e}");
    let (mantissa, exponent) = text.split_once('e').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{mantissa}E{sign}{:03}", exponent.abs())
}

/// `*SMAT` and `*EXPORT,,MMF`.
pub(crate) fn sparse_market(entry: fn(usize, usize) -> f64) -> String {
    let entries = lower(entry);
    let mut text = format!(
        "%%MatrixMarket matrix coordinate real symmetric\n% from *SMAT\n{ROWS} {ROWS} {}\n",
        entries.len()
    );
    for (row, column, value) in entries {
        text.push_str(&format!("{} {} {value:.15e}\n", row + 1, column + 1));
    }
    text
}

/// Seen to fail with a whole line taken for one number.
#[test]
fn all_forms_are_the_chain() {
    let forms = [
        ("K.matrix", harwell_boeing(stiffness, None), 15),
        ("K.hb", harwell_boeing_full(stiffness), 12),
        ("K.mmf", dense_market(stiffness), 9),
        ("K.mmf", sparse_market(stiffness), 16),
    ];
    for (name, text, digits) in forms {
        let reading = read_as(name, text.as_bytes()).unwrap();
        assert_is(&reading.matrices[0], stiffness, name);
        assert_eq!(reading.matrices[0].digits, digits, "{name}");
    }
    let reading = read_as("M.matrix", harwell_boeing(mass, None).as_bytes()).unwrap();
    assert_is(&reading.matrices[0], mass, "mass");
}

/// Seen to fail with the lines of the values counted as those of the right-hand side, too.
#[test]
fn a_right_hand_side_is_a_load() {
    let reading = read_as("K.matrix", harwell_boeing(stiffness, Some(0.5)).as_bytes()).unwrap();
    let Content::Column(load) = &reading.matrices[1].content else {
        panic!("is a load");
    };
    assert_eq!(load[..3], [0.0, 0.5, 1.0]);
}

/// Seen to fail with RX in place of ROTX.
#[test]
fn a_mapping_names_the_rows() {
    let names = read_as("K.mapping", mapping().as_bytes())
        .unwrap()
        .names
        .unwrap();
    assert_eq!(names[3].to_string(), "7.1");
    let labels = "1 5 ROTZ\n2 5 TEMP\n";
    let names = read_as("K.mapping", labels.as_bytes())
        .unwrap()
        .names
        .unwrap();
    assert_eq!(
        [names[0].to_string(), names[1].to_string()],
        ["5.6", "5.TEMP"]
    );
}

/// Of a file with 21 entries, 13 pointers and 12 loads.
const DAMAGED_HEADERS: &str = "
2 | 1 2 3 | :2: must state how many lines follow
2 | a b c d | :2: count of lines a: must be
2 | 1 99999999999999999999 3 4 | count of lines 99999999999999999999
2 | 1 -1 3 4 | :2: count of lines -1
2 | 67 12 21 21 12 | column pointers: the header states 12 lines, but 13 numbers fill 13
2 | 67 13 20 21 12 | row indices: the header states 20
2 | 67 13 21 22 12 | values: the header states 22
2 | 67 13 21 21 11 | right-hand side: the header states 11
2 | 67 13 21 21 0 | pointers
3 | CSA 12 12 21 | :3: type must be RSA or RUA
3 | PSA 12 12 21 | :3: type must be RSA or RUA
3 | RZA 12 12 21 | :3: type must be RSA or RUA
3 | RSE 12 12 21 | :3: type must be RSA or RUA
3 | RRA 12 12 21 | :3: type must be RSA or RUA
3 | RSA 12 11 21 | :3: 11 columns: must be 12, the rows
3 | RSA 0 0 21 | :3: rows 0: must be
3 | RSA 1000001 1000001 21 | must be a whole number
3 | RSA 13 13 21 | column pointers: the header states 13
3 | RSA 12 12 79 | :3: entries 79: must be a whole number from 1 to 78
3 | RSA 12 12 20 | pointers
3 | RSA 12 12 0 | :3: entries 0
3 | RSA 12 | :3: must state type, rows, columns, entries
3 | RSA 99999999999999999999 12 21 | :3: rows 99999999999999999999
4 | (I14) (I14) | format  of the values: must be such as
4 | (I14) (I14) (A25) (d25.15) | format (A25) of the values
4 | (I0) (I14) (d25.15) (d25.15) | format (I0) of the column pointers
4 | (I999) (I14) (d25.15) (d25.15) | format (I999)
4 | (99999I14) (I14) (d25.15) (d25.15) | format (99999I14)
4 | (I14 (I14) (d25.15) (d25.15) | format (I14
4 | (I7) (I14) (d25.15) (d25.15) | is missing
4 | (I14) (I14) (d10.5) (d25.15) |
5 | G 1 | :5: right-hand side must be full (F) and one column
5 | F 2 | :5: right-hand side must be
";

/// Seen to fail without `Block::holds`.
#[test]
fn damaged_headers_are_refused() {
    let text = harwell_boeing(stiffness, Some(0.5));
    assert!(MODELS.refuse("K.matrix", &text, DAMAGED_HEADERS) > 30);
}

/// Of a file without loads: pointers from line 5 on, rows from 18 on, values from 39 on.
const DAMAGED_NUMBERS: &str = "
5 |             2 | column pointers must ascend from 1
7 |             1 | column pointers must ascend
6 |             0 | :6: column pointers 0: must be
6 |            99 | :6: column pointers 99: must be
6 |             x | :6: column pointers x: must be
6 |               | :6: number 2 of the column pointers is missing
18 |             0 | :18: row indices 0: must be
18 |            13 | :18: row indices 13: must be a whole number from 1 to 12
18 |           1.5 | :18: row indices 1.5: must be
19 |             1 | entry (1, 1): must be given once
39 | NaN | :39: NaN: must be a finite number
39 | inf | must be a finite number
39 | 1.0D+999 | 1.0D+999: must be a finite number
39 | one | :39: one: must be a number
39 |  | :39: number 1 of the values is missing
39 | 0.1D+01 0.2D+01 | must be a number
39 | 0.100000000000000000D+07  0.100000000000000D+07 | more numbers than the values need
39 | 0.10000000000000000000D+ü7 | must be plain text
RSA | RUA | must be symmetric
";

/// Seen to fail without the order of the pointers, and without `nothing_left`.
#[test]
fn damaged_numbers_are_refused() {
    let text = harwell_boeing(stiffness, None);
    MODELS.refuse("K.matrix", &text, DAMAGED_NUMBERS);
    let longer = format!("{text}0.1D+01\n");
    let expected = "must be the end of the file by its header";
    MODELS.refuse_bytes("K.matrix", longer.as_bytes(), "longer", expected);
    let bytes = text.as_bytes();
    MODELS.refuse_cuts("K.matrix", bytes, &[0.2, 0.4, 0.5, 0.7, 0.9, 0.97], "");
    MODELS.refuse_cuts("K.matrix", bytes, &[0.0, 0.05], "is of no format");
}

const DAMAGED_MAPPINGS: &str = "
3 | 1 11 UY | :3: equation 1: must be 2, the next one
3 | 3 11 UY | :3: equation 3: must be 2
3 | x 11 UY | :3: equation x: must be 2
3 | 2 0 UY | :3: node 0: must be
3 | 2 -4 UY | :3: node -4: must be
3 | 2 99999999999 UY | :3: node 99999999999
3 | 2 11 UX | :3: degree of freedom 11.1: must be given once
3 | 2 11 | :3: must be a row of the mapping
3 | 2 11 UY UZ | :3: must be a row of the mapping
3 | 2 11 A_LABEL_THAT_IS_LONG | :3: label must be such as UX
3 | 2 11 \" | :3: label must be such as UX
3 | 2.0 11 UY | :3: equation 2.0: must be 2
3 | -2 11 UY | :3: equation -2: must be 2
3 | 22 11 UY | :3: equation 22: must be 2
3 | NaN 11 UY | :3: equation NaN: must be 2
3 | 1e0 11 UY | :3: equation 1e0: must be 2
3 | 2 x UY | :3: node x: must be
3 | 2 1.5 UY | :3: node 1.5: must be
3 | 2 NaN UY | :3: node NaN: must be
3 | 2 2147483648 UY | :3: node 2147483648: must be
3 | 2 11 ux | :3: degree of freedom 11.1: must be given once
3 | 2 11 1 | :3: degree of freedom 11.1: must be given once
3 | 2,11,UY | :3: must be a row of the mapping
3 | 2;11;UY | :3: must be a row of the mapping
3 | 2 | :3: must be a row of the mapping
3 | 2 11 U-Y | :3: label must be such as UX
3 | 2 11 ÜY | :3: label must be such as UX
3 | 2 11 UY # comment | :3: must be a row of the mapping
3 | 2 11 UY\\n2 11 UZ | :4: equation 2: must be 3
3 | \\0 | :3: has a null byte
2 | 2 11 UX | :2: equation 2: must be 1
";

/// Seen to fail without the order of the equations.
#[test]
fn damaged_mappings_are_refused() {
    assert!(
        MODELS.refuse("K.mapping", &mapping(), DAMAGED_MAPPINGS) > 30,
        "30 damages"
    );
    MODELS.refuse_bytes(
        "K.mapping",
        b"Matrix Eqn Node DOF\n",
        "no row",
        "has no row",
    );
}

/// The reader of Matrix Market files has its own list in `src/solver/model/matrix_market.rs`; here what the import adds.
///
/// Seen to fail with one side of a general matrix accepted.
#[test]
fn damaged_markets_are_refused() {
    let text = sparse_market(stiffness).replace("symmetric", "general");
    MODELS.refuse_bytes(
        "K.mmf",
        text.as_bytes(),
        "one side",
        "has no entry on the other side",
    );
    let rectangle = "%%MatrixMarket matrix array real general\n2 3\n1\n2\n3\n4\n5\n6\n";
    MODELS.refuse_bytes(
        "K.mmf",
        rectangle.as_bytes(),
        "2 x 3",
        "is 2 x 3: must be square",
    );
}
