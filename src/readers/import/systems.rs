//! Coordinate systems of contacts by name: normal and first tangent, from a table.

use std::collections::BTreeMap;
use std::path::Path;

use super::direction::directions;
use super::table::TextTable;
use crate::file::FileError;

/// Directions that pairs may share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct System {
    /// From A into B.
    pub(super) normal: [f64; 3],
    /// First tangent, if the table states it.
    pub(super) tangent: Option<[f64; 3]>,
}

/// Reads the columns name, nx, ny, nz, and tx, ty, tz.
///
/// # Errors
/// [`FileError`] with the line and the rule that it breaks.
pub(super) fn read_systems(path: &Path) -> Result<BTreeMap<String, System>, FileError> {
    let table = TextTable::read(path, &["name", "nx", "ny", "nz"], &["tx", "ty", "tz"])?;
    let mut systems = BTreeMap::new();
    for row in table.rows() {
        let name = row
            .text("name")
            .ok_or_else(|| row.fault("name: must be given"))?;
        let normal = row.vector(["nx", "ny", "nz"])?;
        let system = System {
            normal: normal.ok_or_else(|| row.fault("nx, ny, nz: must be given, from A into B"))?,
            tangent: row.vector(["tx", "ty", "tz"])?,
        };
        let checked = directions(system.normal, system.tangent);
        checked.map_err(|rule| row.fault(format!("system {name:.40}: {rule}")))?;
        if systems.insert(name.to_owned(), system).is_some() {
            return Err(row.fault(format!("system {name:.40}: must be given once")));
        }
    }
    Ok(systems)
}
