//! Finite element models of one blade and of the strip, and their contact cells.

use super::TwoBladeSettings;
use crate::fe::{Cuboid, FeError, FeModel, Material, Rectangle, grid_lines, tensor_mesh};
use crate::linalg::{LinalgError, symmetric_eigen};
use crate::units::mm_to_m;
use faer::Mat;
use std::f64::consts::PI;

/// Lengths of the settings in metres, and the contact grid.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    neck: [f64; 3],
    platform: [f64; 3],
    airfoil: [f64; 3],
    airfoil_offset: f64,
    strip: [f64; 3],
    gap: f64,
    /// Distance of the blade's axis from the middle of the gap.
    axis: f64,
    /// Contact grid of blade 1 across the gap, from the neck to the edge of the platform (x < 0).
    across: Vec<Cell>,
    /// Contact grid along the gap.
    along: Vec<Cell>,
    blade_element: [f64; 3],
    strip_element: f64,
    material: Material,
    strip_material: Material,
}

/// One step of the contact grid along one axis, by Gauss' rule: the steps are as wide as its weights, and each has one of
/// its points.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// From and to (m).
    span: [f64; 2],
    /// Part around the point, as far as the nearer end of the span (m).
    patch: [f64; 2],
}

/// One node of the contact grid of blade 1; blade 2 has its mirror image.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactCell {
    /// Where pressure and shear act, and whose mean displacement they see.
    pub(super) patch: Rectangle,
    /// Area that it stands for (m²): the weight of its point in the integral over the interface.
    pub(super) area: f64,
}

impl Layout {
    /// # Errors
    /// [`LinalgError`] if the points of Gauss' rule are not found.
    pub(super) fn new(settings: &TwoBladeSettings) -> Result<Self, LinalgError> {
        let metres = |lengths: [f64; 3]| lengths.map(mm_to_m);
        let (platform, strip) = (metres(settings.platform_mm), metres(settings.strip_mm));
        let gap = mm_to_m(settings.gap_mm);
        let [n_across, n_along] = settings.contact_nodes;
        let material = |gpa: f64, density: f64| Material {
            youngs_modulus: gpa * 1e9,
            poisson_ratio: settings.poisson_ratio,
            density,
        };
        let (strip_modulus, strip_density) = settings.strip_material();
        Ok(Self {
            neck: metres(settings.neck_mm),
            airfoil: metres(settings.airfoil_mm),
            airfoil_offset: mm_to_m(settings.airfoil_offset_mm),
            axis: 0.5 * (gap + platform[0]),
            across: contact_steps(
                [-0.5 * strip[0], -0.5 * gap],
                n_across,
                settings.contact_spacing_at_gap,
            )?,
            along: contact_steps([-0.5 * strip[1], 0.5 * strip[1]], n_along, 1.0)?,
            platform,
            strip,
            gap,
            blade_element: metres(settings.blade_element_mm),
            strip_element: mm_to_m(settings.strip_element_mm),
            material: material(settings.youngs_modulus_gpa, settings.density_kg_m3),
            strip_material: material(strip_modulus, strip_density),
        })
    }

    /// Contact cells of blade 1, those across the gap running fastest.
    pub(super) fn contact_cells(&self) -> Vec<ContactCell> {
        let z = self.contact_height();
        let length = |[from, to]: [f64; 2]| to - from;
        let cell = |x: &Cell, y: &Cell| ContactCell {
            patch: Rectangle {
                x: x.patch,
                y: y.patch,
                z,
            },
            area: length(x.span) * length(y.span),
        };
        let row = |y| self.across.iter().map(move |x| cell(x, y));
        self.along.iter().flat_map(row).collect()
    }

    /// From and to of every contact cell in x and y, in the order of [`Layout::contact_cells`].
    pub(super) fn spans(&self) -> Vec<[[f64; 2]; 2]> {
        let row = |y: &Cell| {
            let y = y.span;
            self.across.iter().map(move |x| [x.span, y])
        };
        self.along.iter().flat_map(row).collect()
    }

    /// Relative deviation of the mean pressure on each contact cell from that of all, under a rigid flat punch as wide as
    /// the contact: its load left of s is 1/2 + asin(2s)/π of the whole.
    pub(super) fn punch_deviation(&self) -> Vec<f64> {
        let (first, last) = (-0.5 * self.strip[0], -0.5 * self.gap);
        let width = last - first;
        let left_of =
            |x: f64| 0.5 + libm::asin((2.0 * ((x - first) / width - 0.5)).clamp(-1.0, 1.0)) / PI;
        let deviation = |cell: &Cell| {
            let [from, to] = cell.span;
            (left_of(to) - left_of(from)) * width / (to - from) - 1.0
        };
        let across: Vec<f64> = self.across.iter().map(deviation).collect();
        across.repeat(self.along.len())
    }

    /// Underside of the platforms, where the strip lies.
    pub(super) fn contact_height(&self) -> f64 {
        self.neck[2]
    }

    /// Point on the outer face of blade 1's airfoil at mid-chord, `fraction` of the way up.
    pub(super) fn airfoil_point(&self, fraction: f64) -> [f64; 3] {
        [
            -self.axis - 0.5 * self.airfoil[0],
            self.airfoil_offset,
            self.neck[2] + self.platform[2] + fraction * self.airfoil[2],
        ]
    }

    /// The patches of the other platform edge of a blade in a disk, where the strip of the gap before it lies.
    pub(super) fn other_patches(&self, contact: &[ContactCell]) -> Vec<Rectangle> {
        let mirrored = |x: f64| -2.0 * self.axis - x;
        (contact.iter())
            .map(|cell| Rectangle {
                x: [mirrored(cell.patch.x[1]), mirrored(cell.patch.x[0])],
                ..cell.patch
            })
            .collect()
    }

    /// Blade 1, clamped at z = 0, with grid lines through edges and middles of the contact `patches` and the airfoil points
    /// at `heights`.
    pub(super) fn blade(&self, patches: &[Rectangle], heights: &[f64]) -> Result<FeModel, FeError> {
        let levels = [
            0.0,
            self.neck[2],
            self.neck[2] + self.platform[2],
            self.neck[2] + self.platform[2] + self.airfoil[2],
        ];
        let prism = |size: [f64; 3], y: f64, level: usize| Cuboid {
            min: [-self.axis - 0.5 * size[0], y - 0.5 * size[1], levels[level]],
            max: [
                -self.axis + 0.5 * size[0],
                y + 0.5 * size[1],
                levels[level + 1],
            ],
        };
        let boxes = [
            prism(self.neck, 0.0, 0),
            prism(self.platform, 0.0, 1),
            prism(self.airfoil, self.airfoil_offset, 2),
        ];
        let faces = |axis: usize| boxes.iter().flat_map(move |b| [b.min[axis], b.max[axis]]);
        let lines = |[from, to]: [f64; 2]| [from, 0.5 * (from + to), to];
        let across = patches.iter().flat_map(|patch| lines(patch.x));
        let along = patches.iter().flat_map(|patch| lines(patch.y));
        let x: Vec<f64> = faces(0).chain(across).collect();
        let y: Vec<f64> = faces(1).chain(along).chain([self.airfoil_offset]).collect();
        let z: Vec<f64> = faces(2)
            .chain(heights.iter().map(|&h| self.airfoil_point(h)[2]))
            .collect();
        let required = [&x, &y, &z];
        let lines =
            std::array::from_fn(|axis| grid_lines(required[axis], self.blade_element[axis]));
        FeModel::new(tensor_mesh(&lines, &boxes), &self.material, |p| {
            p[2].abs() < 1e-9
        })
    }

    /// The free strip, its upper face at the contact height.
    pub(super) fn strip(&self) -> Result<FeModel, FeError> {
        let top = self.contact_height();
        let body = Cuboid {
            min: [
                -0.5 * self.strip[0],
                -0.5 * self.strip[1],
                top - self.strip[2],
            ],
            max: [0.5 * self.strip[0], 0.5 * self.strip[1], top],
        };
        let across = patch_lines(&self.across).into_iter();
        let across = across.chain([body.max[0], 0.5 * self.gap]);
        let mirrored = across.flat_map(|x| [x, -x]);
        let ends = [body.min[1], body.max[1]];
        let along: Vec<f64> = ends.into_iter().chain(patch_lines(&self.along)).collect();
        let lines = [
            grid_lines(&mirrored.collect::<Vec<_>>(), self.strip_element),
            grid_lines(&along, self.strip_element),
            vec![body.min[2], body.max[2]],
        ];
        FeModel::new(tensor_mesh(&lines, &[body]), &self.strip_material, |_| {
            false
        })
    }
}

/// Steps of Gauss' rule with `n` points over `span`, mapped so that their distance at its end is `spacing` times that of the
/// rule, and between there and its beginning grows in proportion: x = u + (1 − spacing) u (1 − u) of the rule's u in 0 .. 1. Exact for
/// polynomials up to degree n − 1, and up to 2n − 1 with a `spacing` of 1.
///
/// Points and weights of the rule are the eigenvalues and squared first components of the eigenvectors of the Jacobi matrix of
/// Legendre's polynomials. Source: Golub & Welsch 1969, Math. Comp. 23, 221.
fn contact_steps(span: [f64; 2], n: usize, spacing: f64) -> Result<Vec<Cell>, LinalgError> {
    let beside = |k: usize| k as f64 / (4.0 * (k * k) as f64 - 1.0).sqrt();
    let jacobi = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
        1 => beside(i.max(j)),
        _ => 0.0,
    });
    let (points, vectors) = symmetric_eigen(jacobi.as_ref())?;
    let length = span[1] - span[0];
    let mut from = span[0];
    let closer = 1.0 - spacing;
    let cells = (0..n).map(|i| {
        let u = 0.5 * (1.0 + points[i]);
        let point = span[0] + (u + closer * u * (1.0 - u)) * length;
        let stretch = 1.0 + closer * (1.0 - 2.0 * u);
        let to = match i + 1 < n {
            true => from + vectors[(0, i)].powi(2) * stretch * length,
            false => span[1],
        };
        let reach = (point - from).min(to - point);
        let cell = Cell {
            span: [from, to],
            patch: [point - reach, point + reach],
        };
        from = to;
        cell
    });
    Ok(cells.collect())
}

/// Edges and middles of the patches: each of them gets a node that is its own.
fn patch_lines(cells: &[Cell]) -> Vec<f64> {
    let lines = |cell: &Cell| {
        let [from, to] = cell.patch;
        [from, 0.5 * (from + to), to]
    };
    cells.iter().flat_map(lines).collect()
}
