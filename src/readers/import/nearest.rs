//! Pairs proposed from coordinates: each node of one surface with the nearest node of the other.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use super::direction::{dot, unit};
use super::table::{TextTable, read_nodes};
use crate::file::{self, FileError};

/// Distance, relative to the tolerance, below which two nodes count as at one place: then it gives no normal.
const SAME_PLACE: f64 = 1e-3;

/// Pairs of nearest nodes, and who is left.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Pairs in the order of surface A.
    pub pairs: Vec<ProposedPair>,
    /// Nodes of A without a node of B within the tolerance, or whose node another one is nearer to.
    pub left_a: Vec<i64>,
    /// Nodes of B that no pair has.
    pub left_b: Vec<i64>,
}

/// Two nodes that may touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProposedPair {
    /// Node of surface A.
    pub a: i64,
    /// Node of surface B.
    pub b: i64,
    /// Their distance, in the unit of the coordinates.
    pub distance: f64,
    /// From A to B; nothing where both are at one place.
    pub normal: Option<[f64; 3]>,
}

/// Proposes pairs of the nodes that the tables `a` and `b` list (column `node`), with the coordinates of the table `nodes`. A
/// node that both surfaces list makes no pair with itself.
///
/// # Errors
/// [`FileError`] if a table cannot be read, names a node without coordinates, or no two nodes are within the tolerance.
pub fn propose(
    nodes: &Path,
    a: &Path,
    b: &Path,
    tolerance: f64,
    normal: Option<[f64; 3]>,
) -> Result<Proposal, FileError> {
    let positions = read_nodes(nodes)?;
    let [surface_a, surface_b] = [listed(a, &positions)?, listed(b, &positions)?];
    let mut along_x: Vec<(i64, [f64; 3])> = surface_b.clone();
    along_x.sort_by(|(_, p), (_, q)| p[0].total_cmp(&q[0]));
    // node of B -> its nearest node of A so far
    let mut taken: BTreeMap<i64, (f64, usize)> = BTreeMap::new();
    for (at, from) in surface_a.iter().enumerate() {
        let Some((b, distance)) = nearest(*from, &along_x, tolerance) else {
            continue;
        };
        let best = taken.entry(b).or_insert((distance, at));
        if distance < best.0 {
            *best = (distance, at);
        }
    }
    if taken.is_empty() {
        let without = nothing_within(&surface_a, &along_x, tolerance);
        return Err(FileError::content(b, None, without));
    }
    let by_a: BTreeMap<usize, (i64, f64)> =
        taken.iter().map(|(b, (d, at))| (*at, (*b, *d))).collect();
    let pair = |(at, (b, distance)): (&usize, &(i64, f64))| {
        let (a, from) = surface_a[*at];
        let to = positions[b];
        let apart = *distance > SAME_PLACE * tolerance;
        let between = unit([0, 1, 2].map(|i| to[i] - from[i])).filter(|_| apart);
        ProposedPair {
            a,
            b: *b,
            distance: *distance,
            normal: normal.and_then(unit).or(between),
        }
    };
    let left = |surface: &[(i64, [f64; 3])], has: &dyn Fn(usize, i64) -> bool| {
        let nodes = surface.iter().enumerate();
        let without = nodes.filter(|(at, (node, _))| !has(*at, *node));
        without.map(|(_, (node, _))| *node).collect()
    };
    Ok(Proposal {
        left_a: left(&surface_a, &|at, _| by_a.contains_key(&at)),
        left_b: left(&surface_b, &|_, node| taken.contains_key(&node)),
        pairs: by_a.iter().map(pair).collect(),
    })
}

/// The nodes of a surface with their places.
fn listed(
    path: &Path,
    positions: &BTreeMap<i64, [f64; 3]>,
) -> Result<Vec<(i64, [f64; 3])>, FileError> {
    let table = TextTable::read(path, &["node"], &["x", "y", "z"])?;
    let mut nodes = BTreeMap::new();
    for row in table.rows() {
        let node = row.node("node")?;
        let Some(position) = positions.get(&node) else {
            return Err(row.fault(format!("node {node}: has no coordinates")));
        };
        if nodes.insert(node, *position).is_some() {
            return Err(row.fault(format!("node {node}: must be given once")));
        }
    }
    Ok(nodes.into_iter().collect())
}

/// The nearest other node within the tolerance, among nodes in the order of x.
fn nearest(
    (node, from): (i64, [f64; 3]),
    along_x: &[(i64, [f64; 3])],
    tolerance: f64,
) -> Option<(i64, f64)> {
    let first = along_x.partition_point(|(_, p)| p[0] < from[0] - tolerance);
    let near = along_x[first..].iter();
    let near = near.take_while(|(_, p)| p[0] <= from[0] + tolerance);
    let others = near.filter(|(other, _)| *other != node);
    let with_distance = others.map(|(other, p)| (*other, distance(from, *p)));
    let within = with_distance.filter(|(_, distance)| *distance <= tolerance);
    within.min_by(|(_, d), (_, e)| d.total_cmp(e))
}

/// Distance of two places.
fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    let d = [0, 1, 2].map(|i| p[i] - q[i]);
    dot(d, d).sqrt()
}

/// Why there is no pair: how far apart the surfaces are.
fn nothing_within(
    surface_a: &[(i64, [f64; 3])],
    surface_b: &[(i64, [f64; 3])],
    tolerance: f64,
) -> String {
    let of_a = surface_a.iter().filter_map(|(a, from)| {
        let others = surface_b.iter().filter(|(b, _)| b != a);
        let distances = others.map(|(_, to)| distance(*from, *to));
        distances.min_by(f64::total_cmp)
    });
    match of_a.min_by(f64::total_cmp) {
        Some(least) => format!(
            "has no node within the tolerance {tolerance} of a node of surface A: the nearest two are {least:.3e} apart"
        ),
        None => "has no node that surface A does not have".to_owned(),
    }
}

impl Proposal {
    /// Writes the pairs as a table that `import --pairs` reads.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        let written = file::replace(path, |out| {
            writeln!(out, "node_a,node_b,nx,ny,nz,distance")?;
            for pair in &self.pairs {
                let normal = pair
                    .normal
                    .map_or(",,".to_owned(), |[x, y, z]| format!("{x},{y},{z}"));
                writeln!(out, "{},{},{normal},{}", pair.a, pair.b, pair.distance)?;
            }
            Ok(())
        });
        written.map(|_| ())
    }
}
