//! Pressure maps of a contact: tables of pressures and areas.

use microslip::file::FileError;
use microslip::record::{PressureCell, PressureMap, read_pressure_map, write_pressure_map};

use crate::damage::{Reader, message};

fn read_as(text: &str) -> Result<PressureMap, FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.csv");
    std::fs::write(&path, text).unwrap();
    read_pressure_map(&path)
}

const MAPS: Reader = Reader(|_, bytes| message(read_as(std::str::from_utf8(bytes).unwrap())));

fn map() -> PressureMap {
    let cell = |i: u8| PressureCell {
        pressure_pa: 0.28e6 / f64::from(1 + i),
        area_m2: 1.1e-6 * f64::from(3 + i),
    };
    PressureMap {
        cells: (0..5).map(cell).collect(),
    }
}

fn written(map: &PressureMap) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.csv");
    write_pressure_map(&path, map, &["film 3"]).unwrap();
    std::fs::read_to_string(path).unwrap()
}

fn pressures(text: &str) -> Vec<f64> {
    let cells = read_as(text).unwrap().cells.into_iter();
    cells.map(|cell| cell.pressure_pa).collect()
}

/// Seen to fail with areas written as if they were pressures.
#[test]
fn what_is_written_is_read_back_to_the_bit() {
    let text = written(&map());
    assert!(
        text.starts_with("# film 3\npressure [MPa],area [mm2]\n"),
        "{text}"
    );
    assert_eq!(read_as(&text).unwrap(), map(), "{text}");
}

/// Seen to fail with cells without pressure kept.
#[test]
fn units_are_read_and_cells_without_pressure_left_out() {
    let expected = [1.0, 2.0, 2.5, 3.0].map(|mpa| 1e6 * mpa);
    for text in [
        "pressure [MPa]\n1\n2\n0\n2.5\n3\n",
        "_x [mm],Contact Pressure (kPa)\n9,1000\n9,2000\n9,2500\n9,3000\n",
        "pressure_Pa;_row\n1000000;1\n2000000;2\n2500000,0;3\n3e6;4\n",
    ] {
        assert_eq!(pressures(text), expected, "{text}");
    }
    let text = "pressure [MPa],area [cm2]\n1,1\n1,1\n1,2\n1,1\n";
    let areas = read_as(text).unwrap().cells.into_iter();
    let areas: Vec<f64> = areas.map(|cell| cell.area_m2).collect();
    assert_eq!(areas, [1e-4, 1e-4, 2e-4, 1e-4]);
    let even = read_as("pressure [MPa]\n1\n1\n1\n1\n").unwrap().cells;
    assert!(even.iter().all(|cell| cell.area_m2 == 1.0), "{even:?}");
}

/// Line 2 names the columns, line 5 is the third cell.
const DAMAGES: &str = "
2 | area [mm2]                   | :2: must have a column pressure [Pa]
2 | pressure,area [mm2]          | :2: pressure: has no unit: must have one in brackets, as pressure [Pa]
2 | pressure [bar],area [mm2]    | :2: pressure [bar]: must be in a unit of pressure: Pa, kPa, MPa
2 | pressure [N],area [mm2]      | :2: pressure [N]: must be in a unit of pressure
2 | pressure [MPa],area          | :2: area: has no unit
2 | pressure [MPa],area [mm]     | :2: area [mm]: must be in a unit of area: m2, cm2, mm2
2 | pressure [MPa],x [mm]        | :2: column x [mm]: the first line without # must name columns among pressure, area
2 | pressure [MPa],pressure [Pa] | :2: column pressure [Pa]: must be given once
5 | -0.1,5                       | :5: pressure = -0.1 MPa: must be from 0 to 1000000 MPa
5 | 1e7,5                        | :5: pressure = 10000000 MPa: must be from
5 | NaN,5                        | :5: pressure = NaN: must be a finite number
5 | inf,5                        | :5: pressure = inf: must be a finite number
5 | ,5                           | :5: pressure = (empty): must be a number
5 | high,5                       | :5: pressure = high: must be a number
5 | 0.1,0                        | :5: area = 0 mm2: must be from
5 | 0.1,-1                       | :5: area = -1 mm2: must be from
5 | 0.1,                         | :5: area = (empty): must be a number
5 | 0.1                          | :5: has 1 fields: must have 2
";

/// Seen to fail with areas of any size taken.
#[test]
fn damaged_maps_are_refused() {
    let count = MAPS.refuse("map.csv", &written(&map()), DAMAGES);
    assert!(count >= 18, "{count} damages");
    for (rows, count) in [("", 0), ("0\n0\n0\n0\n0\n", 0), ("1\n0\n1\n1\n", 3)] {
        let message = read_as(&format!("pressure [MPa]\n{rows}")).unwrap_err();
        let message = message.to_string();
        let rule = format!(":1: has {count} cells with a pressure above 0: must have 4 to 1000000");
        assert!(message.contains(&rule), "{message}");
    }
}
