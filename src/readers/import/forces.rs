//! Excitation and responses by the names of degrees of freedom: words of the command line, or a table.

use std::collections::BTreeMap;
use std::path::Path;

use super::dof::Dof;
use super::lines::number;
use super::table::TextTable;
use super::units::Units;
use crate::file::FileError;
use crate::setting::BadSetting;

/// Forces by the name of their degree of freedom, in SI units.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Forces {
    /// Cosine part of the excitation.
    pub cosine: BTreeMap<String, f64>,
    /// Sine part.
    pub sine: BTreeMap<String, f64>,
    /// Static force.
    pub fixed: BTreeMap<String, f64>,
}

impl Forces {
    /// Adds `DOF=COSINE` or `DOF=COSINE,SINE`.
    ///
    /// # Errors
    /// [`BadSetting`] if the word is none, or names no degree of freedom.
    pub fn add_word(
        &mut self,
        word: &str,
        names: &Names<'_>,
        units: Units,
    ) -> Result<(), BadSetting> {
        let bad = |rule: String| BadSetting::new("--excite", word, rule);
        let (name, values) = word.split_once('=').ok_or_else(|| {
            bad("must be DOF=COSINE or DOF=COSINE,SINE, such as 12.1=1.0".to_owned())
        })?;
        let dof = names.dof(name.trim()).map_err(bad)?;
        let mut values = values.split(',').map(|value| number(value.trim()));
        let cosine = values.next().unwrap_or(Ok(0.0)).map_err(bad)?;
        let sine = values.next().unwrap_or(Ok(0.0)).map_err(bad)?;
        if values.next().is_some() {
            return Err(bad("must have two numbers at most: cosine, sine".to_owned()));
        }
        let factor = units.load(dof.kind());
        let again = self
            .cosine
            .insert(dof.to_string(), cosine * factor)
            .is_some()
            || sine != 0.0 && self.sine.insert(dof.to_string(), sine * factor).is_some();
        match again {
            true => Err(bad("this degree of freedom must be given once".to_owned())),
            false => Ok(()),
        }
    }

    /// Adds the rows of a table: dof, and cosine, sine, static.
    ///
    /// # Errors
    /// [`FileError`] with the line and the rule that it breaks.
    pub fn add_table(
        &mut self,
        path: &Path,
        names: &Names<'_>,
        units: Units,
    ) -> Result<(), FileError> {
        let table = TextTable::read(path, &["dof"], &["cosine", "sine", "static"])?;
        for row in table.rows() {
            let name = row.text("dof").unwrap_or_default();
            let dof = names
                .dof(name)
                .map_err(|rule| row.fault(format!("dof {name}: {rule}")))?;
            let factor = units.load(dof.kind());
            let parts = [
                ("cosine", &mut self.cosine),
                ("sine", &mut self.sine),
                ("static", &mut self.fixed),
            ];
            for (column, part) in parts {
                let Some(value) = row.number(column)? else {
                    continue;
                };
                if part.insert(dof.to_string(), value * factor).is_some() {
                    return Err(row.fault(format!("dof {name}: must be given once")));
                }
            }
        }
        Ok(())
    }
}

/// Degrees of freedom by their names.
#[derive(Debug)]
pub struct Names<'d> {
    dofs: &'d [Dof],
    index: BTreeMap<String, usize>,
}

impl<'d> Names<'d> {
    /// Of the rows of a model.
    #[must_use]
    pub fn of(dofs: &'d [Dof]) -> Self {
        let names = dofs.iter().map(Dof::to_string);
        Self {
            dofs,
            index: names.zip(0..).collect(),
        }
    }

    /// The row of this name.
    ///
    /// # Errors
    /// The rule if there is none.
    pub fn row(&self, name: &str) -> Result<usize, String> {
        self.index.get(name).copied().ok_or_else(|| {
            let first: Vec<_> = self.dofs.iter().take(3).map(Dof::to_string).collect();
            format!(
                "must be a degree of freedom of the matrices, such as {}",
                first.join(", ")
            )
        })
    }

    /// The degree of freedom of this name.
    ///
    /// # Errors
    /// The rule if there is none.
    pub fn dof(&self, name: &str) -> Result<&'d Dof, String> {
        self.row(name).map(|row| &self.dofs[row])
    }
}
