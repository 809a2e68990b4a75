//! Damaged measurements; see the shared file.

use super::shared_damage as shared;
use crate::contact::read_as;

fn read(name: &str, bytes: &[u8]) -> Result<(), String> {
    let found = read_as(name, bytes);
    found.map(drop).map_err(|error| error.to_string())
}

pub(crate) fn refuse(name: &str, text: &str, table: &str) -> usize {
    shared::refuse(read, name, text, table)
}

pub(crate) fn refuse_bytes(name: &str, bytes: &[u8], what: &str, fragment: &str) {
    shared::refuse_bytes(read, name, bytes, what, fragment);
}

pub(crate) fn refuse_cuts(name: &str, bytes: &[u8], cuts: &[f64], fragment: &str) {
    shared::refuse_cuts(read, name, bytes, cuts, fragment);
}
