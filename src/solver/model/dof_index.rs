//! Degrees of freedom of a user's own model by name.

use super::SparseRow;
use crate::setting::{BadSetting, LARGEST, within};
use std::collections::BTreeMap;

/// Names of the degrees of freedom with their indices.
pub(super) struct DofIndex(pub(super) BTreeMap<String, usize>);

impl DofIndex {
    /// The sparse row that a table states. `key` is the table's place in the file.
    pub(super) fn row(
        &self,
        key: &str,
        table: &BTreeMap<String, f64>,
    ) -> Result<SparseRow, BadSetting> {
        let mut row = SparseRow::new();
        for (dof, &weight) in table {
            let key = format!("{key}.{dof}");
            let rule = "must name a degree of freedom of the model";
            let Some(&i) = self.0.get(dof) else {
                return Err(BadSetting::new(key, weight, rule));
            };
            within(&key, weight, [-LARGEST, LARGEST])?;
            // a boundary of a disk has two names
            match row.iter_mut().find(|(known, _)| *known == i) {
                Some((_, sum)) => *sum += weight,
                None => row.push((i, weight)),
            }
        }
        row.retain(|&(_, weight)| weight != 0.0);
        row.sort_by_key(|&(i, _)| i);
        Ok(row)
    }
}
