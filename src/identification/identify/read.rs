//! Reads `identified.json` and checks it as a joint distribution.

use std::path::Path;

use super::found::identified::{FORMAT, Identified};
use crate::file::{FileError, read_bytes, text_of};
use crate::sampling::Distribution;
use crate::sampling::correlation::Copula;
use crate::setting::BadSetting;

/// Longest file that is read (bytes): a thousand tests of a hundred cycles each take less.
const LONGEST: u64 = 64 << 20;

impl Identified {
    /// Reads `path` and checks it.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be read, is longer than 64 MiB or no such file; with the line where it is no JSON, else with key,
    /// value and rule.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let content = text_of(path, read_bytes(path, LONGEST)?)?;
        let identified: Self = serde_json::from_str(&content).map_err(|error| {
            let rule = format!("is no file of `microslip identify`: {error}");
            FileError::content(path, Some(error.line() as u64), rule)
        })?;
        let checked = identified.validate();
        checked.map_err(|bad| FileError::content(path, None, bad.to_string()))?;
        Ok(identified)
    }

    /// Checks that it is a joint distribution: each parameter once and with a distribution, correlations that go together.
    ///
    /// # Errors
    /// [`BadSetting`] with the key in the file.
    pub fn validate(&self) -> Result<(), BadSetting> {
        let rule = format!("must be {FORMAT}: another version of microslip wrote the file");
        BadSetting::unless(self.format == FORMAT, "format", self.format, &rule)?;
        let n = self.inputs.len();
        BadSetting::unless(n > 0, "inputs", "[]", "must have a parameter")?;
        for (i, input) in self.inputs.iter().enumerate() {
            let key = format!("inputs[{i}]");
            let before = &self.inputs[..i];
            let once = before
                .iter()
                .all(|other| other.parameter != input.parameter);
            let (parameter, rule) = (format!("{key}.parameter"), "must be there once");
            BadSetting::unless(once, &parameter, input.parameter.name(), rule)?;
            let shape = Distribution::new(input.shape, None);
            shape.map_err(|bad| bad.under(&format!("{key}.shape.{}", input.shape.name())))?;
        }
        self.validate_correlation()
    }

    fn validate_correlation(&self) -> Result<(), BadSetting> {
        let (key, n) = ("correlation", self.inputs.len());
        let square = self.correlation.len() == n && self.correlation.iter().all(|r| r.len() == n);
        let written = format!("({} rows)", self.correlation.len());
        let rule = format!("must have {n} rows of {n} numbers, in the order of inputs");
        BadSetting::unless(square, key, written, &rule)?;
        for i in 0..n {
            for j in 0..=i {
                let (value, other) = (self.correlation[i][j], self.correlation[j][i]);
                let at = format!("{key}[{i}][{j}]");
                let rule = "must be 1 on the diagonal";
                BadSetting::unless(i != j || value == 1.0, &at, value, rule)?;
                let rule = format!("must be the number of {key}[{j}][{i}], which is {other}");
                BadSetting::unless(value == other, &at, value, &rule)?;
                let inside = i == j || value.abs() < 1.0;
                BadSetting::unless(inside, &at, value, "must be between -1 and 1")?;
                let fixed = [i, j]
                    .iter()
                    .any(|k| self.inputs[*k].shape.name() == "fixed");
                let rule = "must be 0: one of the two is fixed";
                BadSetting::unless(i == j || !fixed || value == 0.0, &at, value, rule)?;
            }
        }
        let definite = Copula::new(&self.correlation).is_some();
        let rule = "must be positive definite: these correlations contradict each other";
        BadSetting::unless(definite, key, "(matrix)", rule)
    }
}

#[cfg(test)]
mod tests {
    use super::super::found::identified::ContactParameter;
    use super::*;

    const GOOD: &str = r#"{
  "format": 1,
  "inputs": [
    { "parameter": "friction_coefficient", "shape": { "normal": { "mean": 0.6, "standard_deviation": 0.05 } } },
    { "parameter": "tangential_stiffness_n_per_um",
      "shape": { "lognormal": { "median": 50.0, "log_standard_deviation": 0.3 } } }
  ],
  "correlation": [[1.0, -0.4], [-0.4, 1.0]]
}"#;

    fn message(old: &str, new: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("identified.json");
        assert!(GOOD.contains(old), "{old}");
        std::fs::write(&path, GOOD.replacen(old, new, 1)).unwrap();
        match Identified::read(&path) {
            Ok(identified) => format!("{} inputs", identified.inputs.len()),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn a_file_that_is_no_joint_distribution_is_refused_with_key_and_rule() {
        assert_eq!(message("format", "format"), "2 inputs", "the good file");
        // seen to fail with the mark kept: "expected value at line 1 column 1"
        let marked = message("{", "\u{feff}{");
        assert_eq!(marked, "2 inputs", "with a byte order mark");
        for (old, new, expected) in [
            ("\"format\": 1", "\"format\": 2", "format = 2: must be 1"),
            (
                "friction_coefficient",
                "tangential_stiffness_n_per_um",
                "inputs[1].parameter = tangential_stiffness_n_per_um: must be there once",
            ),
            ("\"mean\": 0.6", "\"mean\" 0.6", "identified.json:4: is no"),
            ("lognormal", "lognormol", "identified.json:6: is no"),
            (
                "friction_coefficient",
                "friction",
                "unknown variant `friction`",
            ),
            (
                "0.3",
                "-0.3",
                "inputs[1].shape.lognormal.log_standard_deviation = -0.3: must be from",
            ),
            ("-0.4], [-0.4", "-0.4], [0.4", "correlation[1][0] = 0.4"),
            ("-0.4], [-0.4", "-1.4], [-1.4", "must be between -1 and 1"),
            ("[1.0, -0.4]", "[2.0, -0.4]", "must be 1 on the diagonal"),
            ("[1.0, -0.4], ", "", "must have 2 rows of 2 numbers"),
            (
                "\"normal\": { \"mean\": 0.6, \"standard_deviation\": 0.05 }",
                "\"fixed\": { \"value\": 0.6 }",
                "must be 0: one of the two is fixed",
            ),
        ] {
            let found = message(old, new);
            assert!(found.contains(expected), "{new}: {found}");
        }
    }

    /// Three correlations, each possible alone, that no three numbers can have together.
    #[test]
    fn correlations_that_contradict_each_other_are_refused() {
        let mut identified: Identified = serde_json::from_str(GOOD).unwrap();
        let mut normal = identified.inputs[1];
        normal.parameter = ContactParameter::NormalStiffnessNPerUm;
        identified.inputs.push(normal);
        let (a, b) = (0.9, -0.9);
        identified.correlation = vec![vec![1.0, a, a], vec![a, 1.0, b], vec![a, b, 1.0]];
        let error = identified.validate().unwrap_err().to_string();
        assert!(error.contains("positive definite"), "{error}");
    }
}
