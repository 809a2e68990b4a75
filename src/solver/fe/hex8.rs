//! Eight-node hexahedron with incompatible bending modes.
//!
//! Displacement: trilinear plus three internal modes 1 − ξ², 1 − η², 1 − ζ² per direction, condensed out. The
//! gradients of the internal modes use the Jacobian of the centre scaled by |J₀|/|J|, so that they do no work in a
//! state of constant stress and the element passes the patch test on distorted meshes.
//! Source: Wilson, Taylor, Doherty & Ghaboussi 1973; Taylor, Beresford & Wilson 1976, IJNME 10, 1211 (QM6).

use super::Material;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Element matrix; row 3a + i is direction i of node a.
pub type Matrix24 = SMatrix<f64, 24, 24>;
type Matrix6 = SMatrix<f64, 6, 6>;
type Strain<const N: usize> = SMatrix<f64, 6, N>;

/// Corner signs in the element's coordinates ξ, η, ζ: the order of the nodes.
pub const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Stiffness (N/m) and consistent mass (kg) of one element.
#[derive(Debug, Clone)]
pub struct ElementMatrices {
    /// K, symmetric, six zero eigenvalues.
    pub stiffness: Matrix24,
    /// M, symmetric positive definite.
    pub mass: Matrix24,
}

/// K and M of the hexahedron with these corners (m); `None` if |J| ≤ 0 at a quadrature point.
///
/// Quadrature: 2 × 2 × 2 points, exact for the mass of a parallelepiped.
#[must_use]
pub fn element_matrices(corners: &[[f64; 3]; 8], material: &Material) -> Option<ElementMatrices> {
    let elasticity = elasticity(material);
    let centre = jacobian(corners, &[0.0; 3]);
    let centre_inverse = centre.try_inverse()?;
    let mut k_uu = Matrix24::zeros();
    let mut k_ua = SMatrix::<f64, 24, 9>::zeros();
    let mut k_aa = SMatrix::<f64, 9, 9>::zeros();
    let mut mass = Matrix24::zeros();
    let point = 1.0 / 3f64.sqrt();
    for signs in &CORNERS {
        let xi = signs.map(|s| s * point);
        let jacobian = jacobian(corners, &xi);
        let volume = jacobian.determinant();
        if volume.is_nan() || volume <= 0.0 {
            return None;
        }
        let inverse = jacobian.try_inverse()?;
        let b = strain_of::<8, 24>(&local_gradients(&xi).map(|g| inverse * g));
        let correction = centre.determinant() / volume;
        let bubbles: [Vector3<f64>; 3] =
            std::array::from_fn(|i| centre_inverse.column(i) * (-2.0 * xi[i] * correction));
        let g = strain_of::<3, 9>(&bubbles);
        let stress_b = elasticity * b * volume;
        k_uu += b.transpose() * stress_b;
        k_ua += stress_b.transpose() * g;
        k_aa += g.transpose() * elasticity * g * volume;
        add_mass(&mut mass, &xi, material.density * volume);
    }
    let condensed = k_uu - k_ua * k_aa.try_inverse()? * k_ua.transpose();
    Some(ElementMatrices {
        stiffness: 0.5 * (condensed + condensed.transpose()),
        mass,
    })
}

/// Shape functions N_a(ξ, η, ζ) = (1 ± ξ)(1 ± η)(1 ± ζ)/8.
fn shape_functions(xi: &[f64; 3]) -> SVector<f64, 8> {
    SVector::from_fn(|a, _| {
        (0..3)
            .map(|i| 0.5 * (1.0 + CORNERS[a][i] * xi[i]))
            .product()
    })
}

/// ∂N_a/∂(ξ, η, ζ).
fn local_gradients(xi: &[f64; 3]) -> [Vector3<f64>; 8] {
    CORNERS.map(|corner| {
        Vector3::from_fn(|i, _| {
            let others: f64 = (0..3)
                .filter(|&j| j != i)
                .map(|j| 0.5 * (1.0 + corner[j] * xi[j]))
                .product();
            0.5 * corner[i] * others
        })
    })
}

/// J_ij = ∂x_j/∂ξ_i.
fn jacobian(corners: &[[f64; 3]; 8], xi: &[f64; 3]) -> Matrix3<f64> {
    let gradients = local_gradients(xi);
    let mut jacobian = Matrix3::zeros();
    for (gradient, corner) in gradients.iter().zip(corners) {
        jacobian += gradient * Vector3::from(*corner).transpose();
    }
    jacobian
}

/// Strain (xx, yy, zz, xy, yz, zx; engineering shear) of N displacement fields per direction with these gradients.
fn strain_of<const N: usize, const COLUMNS: usize>(
    gradients: &[Vector3<f64>; N],
) -> Strain<COLUMNS> {
    let mut b = Strain::<COLUMNS>::zeros();
    for (a, g) in gradients.iter().enumerate() {
        for i in 0..3 {
            b[(i, 3 * a + i)] = g[i];
            let next = (i + 1) % 3;
            b[(3 + i, 3 * a + i)] = g[next];
            b[(3 + i, 3 * a + next)] = g[i];
        }
    }
    b
}

/// Isotropic elasticity matrix for engineering shear strains.
fn elasticity(material: &Material) -> Matrix6 {
    let (e, nu) = (material.youngs_modulus, material.poisson_ratio);
    let shear = 0.5 * e / (1.0 + nu);
    let lame = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    Matrix6::from_fn(|i, j| match (i == j, i < 3 && j < 3) {
        (true, true) => lame + 2.0 * shear,
        (true, false) => shear,
        (false, true) => lame,
        (false, false) => 0.0,
    })
}

/// Adds weight · N_a N_b in each direction.
fn add_mass(mass: &mut Matrix24, xi: &[f64; 3], weight: f64) {
    let shape = shape_functions(xi);
    for a in 0..8 {
        for b in 0..8 {
            let entry = weight * shape[a] * shape[b];
            for i in 0..3 {
                mass[(3 * a + i, 3 * b + i)] += entry;
            }
        }
    }
}
