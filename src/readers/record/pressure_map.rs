//! Pressure maps of a contact: the pressure on each cell of its area, from a pressure film or a model.

use std::io::Write;
use std::path::Path;

use super::quantity::{Quantity, written_unit as unit};
use super::read::LONGEST_FILE;
use super::table::{self, Expected};
use super::write::write_notes;
use crate::file::{self, FileError, FileRecord, replace, shortest_decimal};

/// Cells with pressure of a map, at least and at most.
const CELLS: [usize; 2] = [4, 1_000_000];
/// Largest pressure that can be meant (Pa).
const LARGEST_PA: f64 = 1e12;
/// Areas of a cell that can be meant (m²).
const AREAS_M2: [f64; 2] = [1e-18, 1e6];

/// Pressure on the area of a contact. Cells without pressure do not touch, and are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureMap {
    /// Cells, in the order of the file.
    pub cells: Vec<PressureCell>,
}

/// Part of the area under one pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressureCell {
    /// Pressure (Pa), above 0.
    pub pressure_pa: f64,
    /// Area (m²). Where a file states none each cell has 1: only ratios of areas count.
    pub area_m2: f64,
}

/// Reads a table: pressure, and area where cells are not equally large.
///
/// # Errors
/// [`FileError`] with the line and the rule that it breaks.
pub fn read_pressure_map(path: &Path) -> Result<PressureMap, FileError> {
    let text = file::text_of(path, file::read_bytes(path, LONGEST_FILE)?)?;
    let expected = Expected {
        needed: &[Quantity::Pressure],
        optional: &[Quantity::Area],
        labels: &[],
    };
    let table = table::read(path, &text, expected)?;
    table.require_within(path, Quantity::Pressure, [0.0, LARGEST_PA])?;
    table.require_within(path, Quantity::Area, AREAS_M2)?;
    let pressures = table.numbers.get(&Quantity::Pressure).into_iter().flatten();
    let areas = table.numbers.get(&Quantity::Area);
    let cells = pressures.enumerate().map(|(row, pressure)| PressureCell {
        pressure_pa: *pressure,
        area_m2: areas.map_or(1.0, |areas| areas[row]),
    });
    let cells: Vec<PressureCell> = cells.filter(|cell| cell.pressure_pa > 0.0).collect();
    let (count, [fewest, most]) = (cells.len(), CELLS);
    if !(fewest..=most).contains(&count) {
        let rule =
            format!("has {count} cells with a pressure above 0: must have {fewest} to {most}");
        return Err(FileError::content(path, Some(table.heading), rule));
    }
    Ok(PressureMap { cells })
}

/// Writes the table that [`read_pressure_map`] reads. `notes` become comments at the beginning.
///
/// # Errors
/// [`FileError`] if the file cannot be written.
pub fn write_pressure_map(
    path: &Path,
    map: &PressureMap,
    notes: &[&str],
) -> Result<FileRecord, FileError> {
    replace(path, |file| {
        let mut file = std::io::BufWriter::new(file);
        write_notes(&mut file, notes)?;
        let columns = [Quantity::Pressure, Quantity::Area];
        let [pressure, area] = columns.map(|q| format!("{} [{}]", q.name(), unit(q).0));
        writeln!(file, "{pressure},{area}")?;
        let powers = columns.map(|q| unit(q).1);
        for cell in &map.cells {
            let pressure = shortest_decimal(cell.pressure_pa, powers[0]);
            let area = shortest_decimal(cell.area_m2, powers[1]);
            writeln!(file, "{pressure},{area}")?;
        }
        file.flush()
    })
}
