//! Contact pairs from a table: relative displacements by the names of the degrees of freedom, constants in SI units.
//!
//! The normal points from node A into the body of node B. The normal approach is n · (u_A − u_B): positive where A moves
//! towards B, in compression. The tangential displacements are those of A relative to B.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::direction::directions;
use super::dof::Dof;
use super::systems::{System, read_systems};
use super::table::{TextRow, TextTable, read_nodes};
use super::units::Units;
use crate::file::FileError;
use crate::model::matrix_contacts::ContactTable;
use crate::setting::friction_coefficient;

/// Word for a side that does not move.
const GROUND: &str = "ground";
/// Largest number of an interface.
const MOST_INTERFACES: f64 = 1000.0;

/// Constants of pairs whose rows do not state them, in the units of the model.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PairConstants {
    /// Normal stiffness.
    pub k_n: Option<f64>,
    /// Tangential stiffness.
    pub k_t: Option<f64>,
    /// Friction coefficient.
    pub mu: Option<f64>,
    /// Normal force at zero approach.
    pub n_0: Option<f64>,
}

/// One contact pair of the study, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedPair {
    /// Name: the numbers of both nodes.
    pub name: String,
    /// First tangential displacement: name of the degree of freedom and weight.
    pub t1: Vec<(String, f64)>,
    /// Second tangential displacement; empty where the model has none.
    pub t2: Vec<(String, f64)>,
    /// Normal approach.
    pub n: Vec<(String, f64)>,
    /// Normal stiffness (N/m).
    pub k_n: f64,
    /// Tangential stiffness (N/m).
    pub k_t: f64,
    /// Friction coefficient.
    pub mu: f64,
    /// Preload (N) or gap (m).
    pub preload: Preload,
    /// Interface.
    pub interface: u32,
}

/// What presses a pair, or keeps it open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Preload {
    /// Normal force at zero approach (N).
    Force(f64),
    /// Gap at zero approach (m).
    Gap(f64),
}

impl ImportedPair {
    /// The pair as a table of the study file.
    #[must_use]
    pub fn table(&self) -> ContactTable {
        let row = |weights: &[(String, f64)]| {
            let row: BTreeMap<String, f64> = weights.iter().cloned().collect();
            Some(row).filter(|row| !row.is_empty())
        };
        let (t1, t2, n) = (row(&self.t1), row(&self.t2), row(&self.n));
        let (n_0, gap) = match self.preload {
            Preload::Force(n_0) => (Some(n_0), None),
            Preload::Gap(gap) => (None, Some(gap)),
        };
        ContactTable {
            name: self.name.clone(),
            k_t1: t1.as_ref().map(|_| self.k_t),
            k_t2: t2.as_ref().map(|_| self.k_t),
            k_n: n.as_ref().map(|_| self.k_n),
            t1,
            t2,
            n,
            mu: self.mu,
            n_0,
            gap,
            interface: self.interface as usize,
        }
    }
}

/// What rows of a table of pairs are read with.
struct PairReader<'r> {
    dofs: BTreeSet<&'r Dof>,
    nodes: BTreeSet<i64>,
    positions: BTreeMap<i64, [f64; 3]>,
    systems: BTreeMap<String, System>,
    units: Units,
    constants: PairConstants,
}

/// Reads a table of pairs; `nodes` is a table of coordinates, for normals that are not given, `systems` one of the coordinate
/// systems that pairs name.
///
/// # Errors
/// [`FileError`] with the line and the rule that it breaks.
pub fn read_pairs(
    path: &Path,
    nodes: Option<&Path>,
    systems: Option<&Path>,
    dofs: &[Dof],
    units: Units,
    constants: PairConstants,
) -> Result<Vec<ImportedPair>, FileError> {
    let optional = [
        "system",
        "nx",
        "ny",
        "nz",
        "tx",
        "ty",
        "tz",
        "area",
        "interface",
        "k_n",
        "k_t",
        "mu",
        "n_0",
        "gap",
        "distance",
    ];
    let table = TextTable::read(path, &["node_a", "node_b"], &optional)?;
    let reader = PairReader {
        dofs: dofs.iter().collect(),
        nodes: dofs.iter().map(|dof| dof.node).collect(),
        positions: nodes.map(read_nodes).transpose()?.unwrap_or_default(),
        systems: systems.map(read_systems).transpose()?.unwrap_or_default(),
        units,
        constants,
    };
    let mut pairs = Vec::new();
    let mut names = BTreeSet::new();
    for row in table.rows() {
        let pair = reader.pair(&row)?;
        let mut ends = [reader.node(&row, "node_a")?, reader.node(&row, "node_b")?];
        ends.sort_unstable();
        if !names.insert(ends) {
            return Err(row.fault(format!("pair {}: must be given once", pair.name)));
        }
        pairs.push(pair);
    }
    match pairs.is_empty() {
        true => Err(FileError::content(path, None, "has no pair")),
        false => Ok(pairs),
    }
}

impl PairReader<'_> {
    fn pair(&self, row: &TextRow<'_>) -> Result<ImportedPair, FileError> {
        let a = self.node(row, "node_a")?;
        let b = self.node(row, "node_b")?;
        if a == b {
            return Err(row.fault("node_a and node_b: must be two nodes"));
        }
        let (normal, tangent) = match self.system(row)? {
            Some(system) => (system.normal, system.tangent),
            None => {
                let normal = row.vector(["nx", "ny", "nz"])?;
                let between = || self.direction_between(row, a, b);
                (
                    normal.map_or_else(between, Ok)?,
                    row.vector(["tx", "ty", "tz"])?,
                )
            }
        };
        let [normal, t1, t2] = directions(normal, tangent).map_err(|rule| row.fault(rule))?;
        let relative = |d| self.row_of(d, a, b).map_err(|rule| row.fault(rule));
        // of a plane model, neither node moves along one of the tangents
        let plane = |d| tangent.is_none() && self.is_out_of_plane(d, a, b);
        let (first, second) = match (plane(t1), plane(t2)) {
            (true, false) => (relative(t2)?, Vec::new()),
            (false, true) => (relative(t1)?, Vec::new()),
            _ => (relative(t1)?, relative(t2)?),
        };
        let named = |node: Option<i64>| node.map_or(GROUND.to_owned(), |node| node.to_string());
        let interface = row.not_negative("interface")?.unwrap_or(0.0);
        if interface.fract() != 0.0 || interface > MOST_INTERFACES {
            return Err(row.fault(format!(
                "interface = {interface}: must be a whole number from 0 to {MOST_INTERFACES}"
            )));
        }
        let mut pair = ImportedPair {
            name: format!("{}-{}", named(a), named(b)),
            t1: first,
            t2: second,
            n: relative(normal)?,
            k_n: 0.0,
            k_t: 0.0,
            mu: 0.0,
            preload: Preload::Force(0.0),
            interface: interface as u32,
        };
        self.constants(row, &mut pair)?;
        Ok(pair)
    }

    /// A node of the model; nothing for the ground.
    fn node(&self, row: &TextRow<'_>, column: &str) -> Result<Option<i64>, FileError> {
        if row
            .text(column)
            .is_some_and(|text| text.eq_ignore_ascii_case(GROUND))
        {
            return Ok(None);
        }
        let node = row.node(column)?;
        match self.nodes.contains(&node) {
            true => Ok(Some(node)),
            false => Err(row.fault(format!(
                "{column} {node}: must be a node of the matrices (or \"{GROUND}\")"
            ))),
        }
    }

    /// The coordinate system that a row names in place of vectors.
    fn system(&self, row: &TextRow<'_>) -> Result<Option<System>, FileError> {
        let Some(name) = row.text("system") else {
            return Ok(None);
        };
        let vectors = ["nx", "ny", "nz", "tx", "ty", "tz"];
        if let Some(given) = vectors.iter().find(|column| row.text(column).is_some()) {
            let rule = format!("{given}: must be absent, since system {name:.40} is given");
            return Err(row.fault(rule));
        }
        let system = self.systems.get(name).copied();
        let unknown = || row.fault(format!("system {name:.40}: must be a row of --systems"));
        system.ok_or_else(unknown).map(Some)
    }

    /// The direction from A to B.
    fn direction_between(
        &self,
        row: &TextRow<'_>,
        a: Option<i64>,
        b: Option<i64>,
    ) -> Result<[f64; 3], FileError> {
        let at = |node: Option<i64>| node.and_then(|node| self.positions.get(&node));
        match (at(a), at(b)) {
            (Some(a), Some(b)) if a != b => Ok([0, 1, 2].map(|i| b[i] - a[i])),
            _ => Err(row.fault(
                "nx, ny, nz: must be given, from A into B; or both nodes must be at different places in --nodes",
            )),
        }
    }

    /// d · (u_A − u_B).
    fn row_of(
        &self,
        d: [f64; 3],
        a: Option<i64>,
        b: Option<i64>,
    ) -> Result<Vec<(String, f64)>, String> {
        let mut weights = Vec::new();
        for (node, sign) in [(a, 1.0), (b, -1.0)] {
            let Some(node) = node else { continue };
            for (component, weight) in (1..).zip(d).filter(|(_, weight)| *weight != 0.0) {
                let dof = Dof::new(node, component);
                if !self.dofs.contains(&dof) {
                    return Err(format!(
                        "node {node}: the matrices must have its degree of freedom {dof} (a fixed one is the \"{GROUND}\")"
                    ));
                }
                weights.push((dof.to_string(), sign * weight));
            }
        }
        match weights.is_empty() {
            true => Err("node_a and node_b: one must be a node".to_owned()),
            false => Ok(weights),
        }
    }

    /// Whether no node has a displacement that the direction needs.
    fn is_out_of_plane(&self, d: [f64; 3], a: Option<i64>, b: Option<i64>) -> bool {
        let has = |component| {
            let of = |node: &i64| self.dofs.contains(&Dof::new(*node, component));
            [a, b].iter().flatten().any(of)
        };
        let needed = (1..).zip(d).filter(|(_, weight)| *weight != 0.0);
        needed.map(|(component, _)| component).all(|c| !has(c))
    }

    /// Stiffness, friction and preload in SI units. With an area they are per area.
    fn constants(&self, row: &TextRow<'_>, pair: &mut ImportedPair) -> Result<(), FileError> {
        let (force, length) = (self.units.force(), self.units.length());
        let area = row.not_negative("area")?;
        if area == Some(0.0) {
            return Err(row.fault("area = 0: must be a number > 0"));
        }
        let share = area.unwrap_or(1.0);
        let missing = |name: &str, option: &str| {
            row.fault(format!("{name}: must be given, or {option} for all pairs"))
        };
        let k_n = row.not_negative("k_n")?.or(self.constants.k_n);
        let k_t = row.not_negative("k_t")?.or(self.constants.k_t);
        let mu = row.not_negative("mu")?.or(self.constants.mu);
        pair.k_n = k_n.ok_or_else(|| missing("k_n", "--k-n"))? * share * force / length;
        pair.k_t = k_t.ok_or_else(|| missing("k_t", "--k-t"))? * share * force / length;
        pair.mu = mu.ok_or_else(|| missing("mu", "--mu"))?;
        friction_coefficient("mu", pair.mu).map_err(|bad| row.fault(bad.to_string()))?;
        let gap = row.not_negative("gap")?;
        pair.preload = match (row.number("n_0")?, gap) {
            (Some(_), Some(_)) => return Err(row.fault("gap: must be absent if n_0 is given")),
            (None, Some(gap)) => Preload::Gap(gap * length),
            (n_0, None) => {
                let n_0 = n_0.or(self.constants.n_0).unwrap_or(0.0);
                Preload::Force(n_0 * share * force)
            }
        };
        Ok(())
    }
}
