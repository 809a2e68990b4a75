//! The engine orders of a tuned disk on one page.

use super::bad_input::assert_refused;
use super::bad_input::disk_cases::{DISK, DISK_FILES};
use super::disk::{solve_study, solved};
use crate::microslip;
use serde_json::Value;

/// Each order has its nodal diameter and its resonance; order 9 of 12 sectors is 3 backwards. Seen to fail with nodal diameter 9 for it.
#[test]
fn engine_orders_of_a_disk_come_to_one_page() {
    let folder = tempfile::tempdir().unwrap();
    solved(folder.path(), &[3, 5, 9]);
    let disk = ["disk", "order-9", "order-3", "order-5", "--output", "disk"];
    let output = microslip(folder.path(), &disk);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("engine order 9, nodal diameter 3"), "{text}");
    let json = std::fs::read_to_string(folder.path().join("disk/disk.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let orders = json["orders"].as_array().unwrap();
    let numbers: Vec<_> = (orders.iter())
        .map(|order| {
            (
                order["engine_order"].as_u64(),
                order["nodal_diameter"].as_u64(),
            )
        })
        .collect();
    assert_eq!(
        numbers,
        [(Some(3), Some(3)), (Some(5), Some(5)), (Some(9), Some(3))]
    );
    let frequency = |order: usize| {
        orders[order]["levels"][0]["frequency_hz"][1]
            .as_f64()
            .unwrap()
    };
    // the springs to the neighbours are softer in nodal diameter 3; order 9 excites it backwards
    assert!(
        frequency(1) > 1.02 * frequency(0),
        "{} {}",
        frequency(1),
        frequency(0)
    );
    assert_eq!(json["nodal_diameters"].as_array().unwrap().len(), 7);
    let page = std::fs::read_to_string(folder.path().join("disk/disk.html")).unwrap();
    for title in [
        "Campbell diagram",
        "SAFE diagram",
        "Amplitude over the nodal diameter",
        "EO 9",
    ] {
        assert!(page.contains(title), "{title}");
    }
    let twice = microslip(folder.path(), &["disk", "order-3", "order-3"]);
    assert_refused(
        "twice",
        &twice,
        &["order-3: has the engine order of order-3"],
    );
    let solve = microslip(folder.path(), &["solve", "order-3.toml", "--quiet"]);
    assert_eq!(solve.status.code(), Some(0), "{solve:?}");
}

/// The figure of this title, or of one that begins so.
pub(crate) fn figure<'a>(page: &'a str, title: &str) -> &'a str {
    let start = page.find(&format!("aria-label=\"{title}")).unwrap();
    &page[start..start + page[start..].find("</figure>").unwrap()]
}

/// Order 15 of 12 sectors is nodal diameter 3 for the third time: the excitation at both speeds is drawn over orders 0 to 6, 6 to 12 and
/// 12 to 18. Seen to fail with the program before, which drew orders up to 12.
#[test]
fn the_excitation_is_folded_up_to_the_highest_order() {
    let folder = tempfile::tempdir().unwrap();
    solved(folder.path(), &[15]);
    let disk = ["disk", "order-15", "--output", "disk", "--quiet"];
    let output = microslip(folder.path(), &disk);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let page = std::fs::read_to_string(folder.path().join("disk/disk.html")).unwrap();
    let lines = figure(&page, "SAFE diagram").matches("class=\"line order\"");
    assert_eq!(lines.count(), 2 * 3);
}

/// Hubs and blades that nothing but contacts hold move as rigid bodies in nodal diameter 0 alone, where the lowest family has no point and
/// the next one goes on. Seen to fail with the program before, which joined the second mode of nodal diameter 0 to the first of nodal
/// diameter 1.
#[test]
fn rigid_body_modes_of_one_nodal_diameter_shift_no_family() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (name, text) in DISK_FILES {
        std::fs::write(path.join(name), text.replace("1 1 4e6", "1 1 3e6")).unwrap();
    }
    let to_ground = "k_t1 = 2e5\nt2 = { \"blade.x\" = 1.0 }\nk_t2 = 1e5";
    let study = DISK
        .replace("engine_orders = [3]", "engine_orders = [1, 5]")
        .replace("levels = [1.0]", "levels = [1e-3]\nsamples = 1")
        .replace("k_t1 = 2e5", to_ground)
        .replace("[100, 400]", "[50, 700]");
    solve_study(path, "disk", &study);
    let page = std::fs::read_to_string(path.join("disk/disk.html")).unwrap();
    let lines = figure(&page, "SAFE diagram").split("class=\"line free\" d=\"");
    let points: Vec<usize> = (lines.skip(1))
        .map(|line| line.split('"').next().unwrap().matches(['M', 'L']).count())
        .collect();
    assert_eq!(points, [6, 7], "nodal diameters 1 to 6 and 0 to 6");
}

/// An engine order whose nodal diameter has no mode in the band is refused before the other orders are solved, not after them. Seen to fail
/// with the program before, which solved order 3 first and named no order.
#[test]
fn orders_without_a_mode_in_the_band_are_refused_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (name, text) in DISK_FILES {
        std::fs::write(path.join(name), text).unwrap();
    }
    let study = DISK
        .replace("engine_orders = [3]", "engine_orders = [3, 5]")
        .replace("[100, 400]", "[210, 225]");
    std::fs::write(path.join("study.toml"), study).unwrap();
    let run = microslip(path, &["run", "study.toml", "--output", "out"]);
    let rule = "the band 210 Hz to 225 Hz holds no natural frequency of the structure with stuck or with open contacts in nodal \
                diameter 5, which engine order 5 excites";
    assert_refused("order 5", &run, &[rule]);
    assert!(!path.join("out/order-3/samples.parquet").exists());
}

/// Heights of the band of each engine order in the Campbell diagram.
fn bands(page: &str) -> Vec<[f64; 2]> {
    let figure = figure(page, "Campbell diagram");
    let paths = figure.split("class=\"band range\"").skip(1);
    let heights = paths.map(|path| {
        let data = path.split("d=\"").nth(1).unwrap();
        let data = data.split('"').next().unwrap();
        let numbers = data.split(|c: char| !(c.is_ascii_digit() || c == '.'));
        let numbers = numbers.filter_map(|number| number.parse::<f64>().ok());
        // x and y by turns
        let heights: Vec<f64> = numbers.skip(1).step_by(2).collect();
        let from = heights.iter().copied().fold(f64::INFINITY, f64::min);
        [from, heights.iter().copied().fold(0.0, f64::max)]
    });
    heights.collect()
}

/// Orders 3 and 9 of 12 sectors excite one family, which has one band: that of all their samples. Seen to fail with a band of each order.
#[test]
fn a_family_of_nodal_diameter_has_one_band() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    solved(path, &[3, 9]);
    let page = |orders: &[&str]| {
        let output = microslip(
            path,
            &[&["disk", "--output", "disk", "--quiet"], orders].concat(),
        );
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        std::fs::read_to_string(path.join("disk/disk.html")).unwrap()
    };
    let text = std::fs::read_to_string(path.join("order-9.toml")).unwrap();
    solve_study(
        path,
        "others",
        &(text.replace("samples = 6", "samples = 6\nseed = 2")),
    );
    let alike = bands(&page(&["order-3", "order-9"]));
    assert_eq!(alike.len(), 2, "{alike:?}");
    // other samples scatter otherwise
    let [three, nine] = bands(&page(&["order-3", "others"]))[..] else {
        panic!("two bands");
    };
    assert_eq!(three, nine);
    let alone = bands(&page(&["order-3"]));
    assert_ne!(alone, [three]);
}
