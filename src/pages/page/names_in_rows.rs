//! Names at the upper edge of a figure, as those of the engine orders in a Campbell diagram.

use super::axis::Axis;
use super::figure::{Panel, Size};

/// A name in the figure: class, x and y (px).
fn places(svg: &str) -> Vec<(String, f64, f64)> {
    let attribute = |text: &str, name: &str| -> String {
        let (_, rest) = text.split_once(&format!("{name}=\"")).expect("attribute");
        rest.split('"').next().unwrap_or_default().to_owned()
    };
    let texts = svg.split("<text").filter(|text| text.contains(">EO "));
    texts
        .map(|text| {
            let number = |name: &str| attribute(text, name).parse().expect("a number");
            (attribute(text, "class"), number("x"), number("y"))
        })
        .collect()
}

/// Names close to each other stand in rows below each other, with space for five letters of at least 4 px in each row; names far apart
/// stay in the first row; one at the right edge ends at its place.
///
/// Seen to fail with every name in the first row.
#[test]
fn names_close_to_each_other_stand_in_rows() {
    let axis = |title: &str| Axis::linear(title, 0.0, 100.0);
    let mut panel = Panel::new(
        Size::Large,
        "Campbell diagram",
        axis("Speed"),
        axis("Frequency"),
    );
    let name = |(x, order): (f64, u32)| (x, format!("EO {order}"));
    panel.names_above(&[(5.0, 12), (50.0, 9), (52.0, 8), (99.9, 3)].map(name));
    let found = places(&panel.svg());
    assert_eq!(found.len(), 4, "{found:?}");
    let rows: Vec<f64> = found.iter().map(|(_, _, y)| *y).collect();
    assert!(rows[0] == rows[1] && rows[2] > rows[1], "{found:?}");
    for (i, (_, x, y)) in found[..3].iter().enumerate() {
        let struck = |(_, other, row): &(String, f64, f64)| row == y && (other - x).abs() < 20.0;
        assert!(!found[i + 1..].iter().any(struck), "{found:?}");
    }
    assert!(
        found[3].0.contains("end") && !found[2].0.contains("end"),
        "{found:?}"
    );
}
