//! Linear elastic solids: block meshes of hexahedra, their stiffness and mass.
//!
//! Answers: given boxes, a material and clamped nodes, what are K and M of M q̈ + K q = f? Knows no contact, no
//! damping and no reduction. Start at [`FeModel::new`]; the element is [`hex8`]. A clamped bar of two elements:
//!
//! ```
//! # use microslip_solver as microslip;
//! use microslip::fe::{Cuboid, FeModel, Material, tensor_mesh};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//!
//! let bar = Cuboid { min: [0.0; 3], max: [0.2, 0.02, 0.01] }; // m
//! let lines = [vec![0.0, 0.1, 0.2], vec![0.0, 0.02], vec![0.0, 0.01]];
//! let steel = Material { youngs_modulus: 210e9, poisson_ratio: 0.3, density: 7800.0 };
//! let model = FeModel::new(tensor_mesh(&lines, &[bar]), &steel, |x| x[0] == 0.0)?;
//! assert_eq!(model.n_dofs(), 24); // three for each of eight nodes that are free
//! # Ok(())
//! # }
//! ```

pub mod hex8;
mod mesh;

pub use mesh::{Cuboid, HexMesh, Rectangle, grid_lines, tensor_mesh};

use faer::sparse::{SparseColMat, Triplet};

/// Isotropic linear elastic material. Units: Pa, –, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus E > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio ν, −1 < ν < 1/2.
    pub poisson_ratio: f64,
    /// Density ρ > 0.
    pub density: f64,
}

/// Why a mesh is no model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FeError {
    /// The mapping of an element is not one to one.
    #[error("element {element} is inverted or flat")]
    InvertedElement {
        /// Index of the element.
        element: usize,
    },
    /// Every node is clamped, or there is no element.
    #[error("the mesh has no free node")]
    NothingFree,
}

/// Stiffness and mass of a meshed solid with clamped nodes removed.
///
/// Degrees of freedom: three per free node, x, y, z, in the order of the nodes. Both matrices hold both triangles.
#[derive(Debug, Clone)]
pub struct FeModel {
    /// The mesh, clamped nodes included.
    pub mesh: HexMesh,
    /// First degree of freedom of every node; `None` if clamped. Shape: `[n_nodes]`.
    pub first_dof: Vec<Option<usize>>,
    /// K in N/m.
    pub stiffness: SparseColMat<usize, f64>,
    /// M in kg, consistent.
    pub mass: SparseColMat<usize, f64>,
}

impl FeModel {
    /// Assembles all elements; nodes for which `clamped` holds are removed.
    ///
    /// # Errors
    /// [`FeError`] if an element is inverted or nothing is free.
    pub fn new(
        mesh: HexMesh,
        material: &Material,
        clamped: impl Fn([f64; 3]) -> bool,
    ) -> Result<Self, FeError> {
        let mut n_dofs = 0;
        let first_dof: Vec<Option<usize>> = mesh
            .nodes
            .iter()
            .map(|&x| {
                (!clamped(x)).then(|| {
                    n_dofs += 3;
                    n_dofs - 3
                })
            })
            .collect();
        let mut stiffness = Vec::new();
        let mut mass = Vec::new();
        for (element, nodes) in mesh.elements.iter().enumerate() {
            let corners = nodes.map(|node| mesh.nodes[node]);
            let matrices = hex8::element_matrices(&corners, material)
                .ok_or(FeError::InvertedElement { element })?;
            let starts = nodes.map(|node| first_dof[node]);
            scatter(&mut stiffness, &matrices.stiffness, &starts);
            scatter(&mut mass, &matrices.mass, &starts);
        }
        let sparse = |entries: &[Triplet<usize, usize, f64>]| {
            SparseColMat::try_new_from_triplets(n_dofs, n_dofs, entries)
                .map_err(|_| FeError::NothingFree)
        };
        if n_dofs == 0 || mesh.elements.is_empty() {
            return Err(FeError::NothingFree);
        }
        Ok(Self {
            stiffness: sparse(&stiffness)?,
            mass: sparse(&mass)?,
            mesh,
            first_dof,
        })
    }

    /// Number of degrees of freedom.
    #[must_use]
    pub fn n_dofs(&self) -> usize {
        self.stiffness.nrows()
    }

    /// The three degrees of freedom of the free node at `position`, within a millionth of the mesh's extent.
    #[must_use]
    pub fn dofs_at(&self, position: [f64; 3]) -> Option<[usize; 3]> {
        let first = self.first_dof[self.mesh.node_at(position)?]?;
        Some([first, first + 1, first + 2])
    }

    /// Mean displacement over a rectangle in x, y and z, as linear forms on the degrees of freedom; `None` as
    /// [`HexMesh::mean_over`] or where a node is clamped.
    #[must_use]
    pub fn mean_over(&self, rectangle: &Rectangle) -> Option<[Vec<(usize, f64)>; 3]> {
        let nodes = self.mesh.mean_over(rectangle)?;
        let first = |&(node, weight): &(usize, f64)| Some((self.first_dof[node]?, weight));
        let first: Vec<(usize, f64)> = nodes.iter().map(first).collect::<Option<_>>()?;
        let along = |axis| {
            first
                .iter()
                .map(|&(dof, weight)| (dof + axis, weight))
                .collect()
        };
        Some([0, 1, 2].map(along))
    }
}

/// Adds the entries of an element matrix between free nodes.
fn scatter(
    entries: &mut Vec<Triplet<usize, usize, f64>>,
    matrix: &hex8::Matrix24,
    starts: &[Option<usize>; 8],
) {
    for (a, start_a) in starts.iter().enumerate() {
        for (b, start_b) in starts.iter().enumerate() {
            let (Some(row), Some(col)) = (start_a, start_b) else {
                continue;
            };
            for i in 0..3 {
                for j in 0..3 {
                    entries.push(Triplet {
                        row: row + i,
                        col: col + j,
                        val: matrix[(3 * a + i, 3 * b + j)],
                    });
                }
            }
        }
    }
}
