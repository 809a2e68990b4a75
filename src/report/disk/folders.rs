//! Whether the folders of the engine orders of a disk are those of their orders.

use super::write::DISK_NUMBERS;
use crate::file::{FileError, read_text};
use crate::report::run::{engine_order, order_folder};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// What is wrong with `orders`, the folders of engine orders in `folder`, beside their files: one with the run of another order, and an
/// order of `disk.json` without a folder. Nothing where there are none: the runs of a `disk.json` may lie elsewhere.
///
/// # Errors
/// [`FileError`] if `disk.json` cannot be read.
pub fn order_faults(folder: &Path, orders: &[PathBuf]) -> Result<Vec<String>, FileError> {
    let mut faults: Vec<String> = orders.iter().filter_map(|path| misplaced(path)).collect();
    let numbers = folder.join(DISK_NUMBERS);
    if orders.is_empty() || !numbers.exists() {
        return Ok(faults);
    }
    let json: Value = serde_json::from_str(&read_text(&numbers)?).unwrap_or_default();
    let order = |order: &Value| u32::try_from(order["engine_order"].as_u64()?).ok();
    let listed = json["orders"].as_array();
    let listed = listed.and_then(|all| all.iter().map(order).collect::<Option<Vec<u32>>>());
    let Some(listed) = listed else {
        faults.push(format!("{DISK_NUMBERS} is not what `disk` writes"));
        return Ok(faults);
    };
    for order in listed {
        let name = order_folder(order);
        if !folder.join(&name).is_dir() {
            faults.push(format!(
                "{name} does not exist: {DISK_NUMBERS} has engine order {order}"
            ));
        }
    }
    Ok(faults)
}

/// What is wrong with the folder of an engine order if its run has another one.
fn misplaced(path: &Path) -> Option<String> {
    // what is not solved yet has no record, and a damaged one is a fault of its own
    let order = engine_order(path).ok()?;
    if order.is_some_and(|order| path.ends_with(order_folder(order))) {
        return None;
    }
    let of = order.map_or_else(
        || "no engine order".to_owned(),
        |n| format!("engine order {n}"),
    );
    let name = path.file_name().unwrap_or_default().display();
    Some(format!("{name} has the results of {of}"))
}
