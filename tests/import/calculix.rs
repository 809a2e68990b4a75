//! CalculiX: `.sti`, `.mas` and `.dof`.

use crate::chain::MODELS;
use crate::chain::{ROWS, assert_is, fortran, lower, name, read_as, stiffness};

/// The upper triangle, as CalculiX writes it.
pub(crate) fn matrix(entry: fn(usize, usize) -> f64) -> String {
    let lines = lower(entry).into_iter().map(|(row, column, value)| {
        let number = fortran(value, 14, 'E');
        format!("{:10} {:10} {number}\n", column + 1, row + 1)
    });
    lines.collect()
}

pub(crate) fn names() -> String {
    (0..ROWS).map(|row| format!("{}\n", name(row))).collect()
}

/// Seen to fail with indices from 0.
#[test]
fn a_matrix_and_its_names_are_those_of_the_chain() {
    let reading = read_as("job.sti", matrix(stiffness).as_bytes()).unwrap();
    assert_is(&reading.matrices[0], stiffness, "sti");
    let found = read_as("job.dof", names().as_bytes())
        .unwrap()
        .names
        .unwrap();
    let found: Vec<_> = found.iter().map(ToString::to_string).collect();
    assert_eq!(found, (0..ROWS).map(name).collect::<Vec<_>>());
}

const DAMAGED_MATRICES: &str = "
1 | 0 1 1.0 | :1: row 0: must be a whole number from 1 to 1000000
1 | 1 0 1.0 | :1: column 0: must be
1 | -1 1 1.0 | :1: row -1: must be
1 | 1000001 1 1.0 | :1: row 1000001
1 | 1 1000001 1.0 | :1: column 1000001
1 | 99999999999999999999 1 1.0 | :1: row 99999999999999999999
1 | 1.0 1 1.0 | :1: row 1.0: must be
1 | a 1 1.0 | :1: row a: must be
1 | 1 b 1.0 | :1: column b: must be
1 | 1 1 | :1: must be an entry: row column value
1 | 1 | :1: must be an entry
1 | 1 1 1.0 2.0 | :1: must be an entry
1 | 1 1 NaN | :1: NaN: must be a finite number
1 | 1 1 inf | must be a finite number
1 | 1 1 -1e400 | must be a finite number
1 | 1 1 x | :1: x: must be a number
1 | 1 1 1.0E | must be a number
1 | 1 1 1.0EE3 | must be a number
1 | 1 1 1,0 | :1: must be an entry
2 | 1 1 1.0 | :2: entry (1, 1): must be given once
2 | 4 1 1.0\\n1 4 2.0 | must be symmetric: entry (4, 1) = 1 and entry (1, 4) = 2 differ
2 | 4 1 -1e6\\n1 4 -1e6\\n9 3 1e6 | has no entry on the other side
2 | text of another kind | :2: must be an entry
2 | %%MatrixMarket | :2: must be an entry
2 | ** comment | :2: must be an entry
2 | \\0 | :2: has a null byte
2 | 1 4\\n-1e6 | :2: must be an entry
";

/// Seen to fail without the check of duplicates.
#[test]
fn damaged_matrices_are_refused() {
    let count = MODELS.refuse("job.sti", &matrix(stiffness), DAMAGED_MATRICES);
    let others = [
        (&b""[..], "empty", "has no entry"),
        (b"\n\n  \n", "blank", "has no entry"),
        (b"\xff\xfe1\0", "UTF-16", "is UTF-16 text"),
        (b"1 1 1.0\xfc\n", "Latin-1", "is no UTF-8"),
    ];
    for (bytes, what, fragment) in others {
        MODELS.refuse_bytes("job.sti", bytes, what, fragment);
    }
    assert!(count + others.len() > 30, "{count}");
}

/// Names as `dofs.txt` of an imported model has them, with names and without.
///
/// Seen to fail with the program before: "degree of freedom TEMP: must be a whole number".
#[test]
fn names_that_import_writes_are_read() {
    for text in ["-30.1\n7.TEMP\n9.0\n1.MODE\n", "30\n60\n1.MODE\n2.MODE\n"] {
        let found = read_as("job.dof", text.as_bytes()).unwrap().names.unwrap();
        let found: String = found.iter().map(|dof| format!("{dof}\n")).collect();
        assert_eq!(found, text);
    }
}

const DAMAGED_NAMES: &str = "
1 | 11 | :1: must be a degree of freedom: node.dof
1 | 11.1 2 | :1: degree of freedom 1 2: must be
1 | 11,1 | :1: must be a degree of freedom
2 | 11.1 | :2: degree of freedom 11.1: must be given once
2 | x.2 | :2: node x: must be
2 | 11. | :2: degree of freedom : must be
2 | .2 | :2: node : must be
2 | 99999999999.2 | :2: node 99999999999: must be
2 | 11.99999 | degree of freedom 99999: must be
2 | 11.2.3 | degree of freedom 2.3: must be
1 | 11.-1 | :1: degree of freedom -1: must be
1 | 11:1 | :1: must be a degree of freedom: node.dof
1 | 11 1 | :1: must be a degree of freedom: node.dof
1 | NaN.1 | :1: node NaN: must be
1 | 1e3.1 | :1: node 1e3: must be
1 | 0x11.1 | :1: node 0x11: must be
1 | 11.1e0 | :1: degree of freedom 1e0: must be
1 | 11.x | :1: degree of freedom x: must be
1 | 11.X-Y | :1: degree of freedom X-Y: must be
1 | x.MODE | :1: node x: must be
2 | 11.MODE\\n11.MODE | :3: degree of freedom 11.MODE: must be given once
1 | 11..1 | :1: degree of freedom .1: must be
1 | 11.1. | :1: degree of freedom 1.: must be
1 | 11.10000 | :1: degree of freedom 10000: must be
1 | 2147483648.1 | :1: node 2147483648: must be
1 | -2147483648.1 | :1: node -2147483648: must be
1 | '11.1' | :1: node '11: must be
1 | node.dof | :1: node node: must be
1 | ** comment | :1: must be a degree of freedom
1 | 11.1\\n11.1 | :2: degree of freedom 11.1: must be given once
1 | 11.1 1.0 | :1: degree of freedom 1 1.0: must be
1 | \\0 | :1: has a null byte
4 | 11.1 | :4: degree of freedom 11.1: must be given once
4 | 7,1 | :4: must be a degree of freedom
";

/// Seen to fail with names that may come twice.
#[test]
fn damaged_names_are_refused() {
    assert!(
        MODELS.refuse("job.dof", &names(), DAMAGED_NAMES) > 30,
        "30 damages"
    );
    MODELS.refuse_bytes("job.dof", b"\n", "blank", "has no name");
    let many: String = (1..=1_000_001).map(|node| format!("{node}.1\n")).collect();
    let expected = ":1000001: has more than 1000000 degrees";
    MODELS.refuse_bytes("job.dof", many.as_bytes(), "many", expected);
}
