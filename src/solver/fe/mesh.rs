//! Meshes of hexahedra on a tensor grid.

/// Axis-parallel box (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    /// Corner with the smallest coordinates.
    pub min: [f64; 3],
    /// Corner with the largest coordinates.
    pub max: [f64; 3],
}

impl Cuboid {
    fn contains(&self, point: [f64; 3]) -> bool {
        (0..3).all(|i| self.min[i] < point[i] && point[i] < self.max[i])
    }
}

/// Hexahedral mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct HexMesh {
    /// Node positions (m).
    pub nodes: Vec<[f64; 3]>,
    /// Corner nodes of every element in the order of [`super::hex8::CORNERS`].
    pub elements: Vec<[usize; 8]>,
}

/// Rectangle across z (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// From and to along x.
    pub x: [f64; 2],
    /// From and to along y.
    pub y: [f64; 2],
    /// Height.
    pub z: f64,
}

impl Rectangle {
    /// Area (m²).
    #[must_use]
    pub fn area(&self) -> f64 {
        (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])
    }

    /// Middle in x and y.
    #[must_use]
    pub fn centre(&self) -> [f64; 2] {
        [self.x, self.y].map(|[from, to]| 0.5 * (from + to))
    }
}

impl HexMesh {
    /// Nodes with the weights of the mean displacement over a rectangle of a tensor mesh, ∫ N_a dA / ∫ dA with the bilinear
    /// shape functions N_a of the faces in it; in the order of the nodes, the weights add up to 1.
    ///
    /// `None` unless the rectangle has grid lines at its edges and nodes at all their crossings.
    #[must_use]
    pub fn mean_over(&self, rectangle: &Rectangle) -> Option<Vec<(usize, f64)>> {
        let height = self.tolerance();
        let in_plane = |node: &usize| (self.nodes[*node][2] - rectangle.z).abs() <= height;
        let plane: Vec<usize> = (0..self.nodes.len()).filter(in_plane).collect();
        let lines_of = |axis: usize, edges: [f64; 2]| {
            let lines = plane.iter().map(|&node| self.nodes[node][axis]);
            lines_between(lines.collect(), edges).map(line_means)
        };
        let (x, y) = (lines_of(0, rectangle.x)?, lines_of(1, rectangle.y)?);
        let on = |lines: &[(f64, f64)], at: f64| {
            let line = lines.iter().find(|(line, _)| *line == at);
            line.map(|(_, weight)| *weight)
        };
        let weighted = |&node: &usize| {
            let at = self.nodes[node];
            Some((node, on(&x, at[0])? * on(&y, at[1])?))
        };
        let weights: Vec<_> = plane.iter().filter_map(weighted).collect();
        (weights.len() == x.len() * y.len()).then_some(weights)
    }

    /// A millionth of the mesh's extent.
    fn tolerance(&self) -> f64 {
        let reach = |x: &[f64; 3]| x.iter().fold(0.0, |r: f64, c| r.max(c.abs()));
        1e-6 * self.nodes.iter().map(reach).fold(0.0, f64::max)
    }

    /// The node at `position`, within a millionth of the mesh's extent.
    #[must_use]
    pub fn node_at(&self, position: [f64; 3]) -> Option<usize> {
        let tolerance = self.tolerance();
        self.nodes
            .iter()
            .position(|x| (0..3).all(|i| (x[i] - position[i]).abs() <= tolerance))
    }
}

/// The grid lines from one edge to the other; `None` where an edge is on no line, or both are on one.
///
/// An edge is on the nearest line, as far away as [`grid_lines`] may have moved it: two lines may be hardly further apart.
fn lines_between(mut lines: Vec<f64>, [from, to]: [f64; 2]) -> Option<Vec<f64>> {
    lines.sort_by(f64::total_cmp);
    lines.dedup();
    let moved = closest(lines.last()? - lines.first()?);
    let line_at = |edge: f64| {
        let distance = |line: &f64| (line - edge).abs();
        let nearest = lines.iter().copied();
        let nearest = nearest.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.filter(|line| distance(line) <= moved)
    };
    let (first, last) = (line_at(from)?, line_at(to)?);
    lines.retain(|line| (first..=last).contains(line));
    (lines.len() > 1).then_some(lines)
}

/// Distance up to which required lines are one: a millionth of their span.
fn closest(span: f64) -> f64 {
    1e-6 * span
}

/// Lines with the weights of the mean of a function that is linear between them.
fn line_means(lines: Vec<f64>) -> Vec<(f64, f64)> {
    let n = lines.len();
    let length = lines[n - 1] - lines[0];
    let weight = |i: usize| 0.5 * (lines[(i + 1).min(n - 1)] - lines[i.saturating_sub(1)]) / length;
    lines
        .iter()
        .enumerate()
        .map(|(i, &line)| (line, weight(i)))
        .collect()
}

/// Grid lines through all of `required`, further divided into equal steps of at most `step`.
///
/// Required lines closer than a millionth of their span are one line.
#[must_use]
pub fn grid_lines(required: &[f64], step: f64) -> Vec<f64> {
    let mut sorted = required.to_vec();
    sorted.sort_by(f64::total_cmp);
    let span = sorted.last().unwrap_or(&0.0) - sorted.first().unwrap_or(&0.0);
    sorted.dedup_by(|b, a| *b - *a <= closest(span));
    let mut lines = Vec::new();
    for pair in sorted.windows(2) {
        // The small allowance keeps a length of exactly n steps at n steps despite round-off.
        let n = ((pair[1] - pair[0]) / step - 1e-9).ceil().max(1.0);
        let n_steps = n as usize;
        lines.extend((0..n_steps).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / n));
    }
    lines.extend(sorted.last());
    lines
}

/// Mesh of the grid cells whose centre lies in one of the boxes; boxes that touch share their nodes.
///
/// The grid must have lines at all faces of the boxes.
#[must_use]
pub fn tensor_mesh(lines: &[Vec<f64>; 3], boxes: &[Cuboid]) -> HexMesh {
    let n = [lines[0].len(), lines[1].len(), lines[2].len()];
    let mut number = vec![usize::MAX; n[0] * n[1] * n[2]];
    let mut mesh = HexMesh {
        nodes: Vec::new(),
        elements: Vec::new(),
    };
    let cells = |axis: usize| 0..n[axis].saturating_sub(1);
    for k in cells(2) {
        for j in cells(1) {
            for i in cells(0) {
                let middle = |axis: usize, c: usize| 0.5 * (lines[axis][c] + lines[axis][c + 1]);
                let centre = [middle(0, i), middle(1, j), middle(2, k)];
                if !boxes.iter().any(|b| b.contains(centre)) {
                    continue;
                }
                mesh.elements.push(super::hex8::CORNERS.map(|corner| {
                    let up = |axis: usize| usize::from(corner[axis] > 0.0);
                    let at = [i + up(0), j + up(1), k + up(2)];
                    let slot = &mut number[at[0] + n[0] * (at[1] + n[1] * at[2])];
                    if *slot == usize::MAX {
                        *slot = mesh.nodes.len();
                        mesh.nodes
                            .push(std::array::from_fn(|axis| lines[axis][at[axis]]));
                    }
                    *slot
                }));
            }
        }
    }
    mesh
}
