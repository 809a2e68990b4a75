//! Finite element models of one blade and of the strip, and where their contact nodes are.

use super::TwoBladeSettings;
use crate::fe::{Cuboid, FeError, FeModel, Material, grid_lines, tensor_mesh};
use crate::units::mm_to_m;
use std::f64::consts::PI;

/// Lengths of the settings in metres, and the contact grid.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    neck: [f64; 3],
    platform: [f64; 3],
    airfoil: [f64; 3],
    airfoil_offset: f64,
    strip: [f64; 3],
    /// Distance of the blade's axis from the middle of the gap.
    axis: f64,
    /// Contact lines of blade 1 across the gap, from the neck to the edge of the platform (x < 0).
    across: Vec<f64>,
    /// Contact lines along the gap.
    along: Vec<f64>,
    blade_element: [f64; 3],
    strip_element: f64,
    material: Material,
}

/// One node of the contact grid of blade 1; blade 2 has its mirror image.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactNode {
    pub(super) x: f64,
    pub(super) y: f64,
    /// Tributary area (m²).
    pub(super) area: f64,
}

impl Layout {
    pub(super) fn new(settings: &TwoBladeSettings) -> Self {
        let metres = |lengths: [f64; 3]| lengths.map(mm_to_m);
        let (platform, strip) = (metres(settings.platform_mm), metres(settings.strip_mm));
        let gap = mm_to_m(settings.gap_mm);
        let [n_across, n_along] = settings.contact_nodes;
        Self {
            neck: metres(settings.neck_mm),
            airfoil: metres(settings.airfoil_mm),
            airfoil_offset: mm_to_m(settings.airfoil_offset_mm),
            axis: 0.5 * (gap + platform[0]),
            across: equal_steps(-0.5 * strip[0], -0.5 * gap, n_across),
            along: equal_steps(-0.5 * strip[1], 0.5 * strip[1], n_along),
            platform,
            strip,
            blade_element: metres(settings.blade_element_mm),
            strip_element: mm_to_m(settings.strip_element_mm),
            material: Material {
                youngs_modulus: settings.youngs_modulus_gpa * 1e9,
                poisson_ratio: settings.poisson_ratio,
                density: settings.density_kg_m3,
            },
        }
    }

    /// Contact nodes of blade 1, those across the gap running fastest.
    pub(super) fn contact_nodes(&self) -> Vec<ContactNode> {
        let (width_x, width_y) = (tributary(&self.across), tributary(&self.along));
        let row = |(j, &y): (usize, &f64)| {
            let area = |i: usize| width_x[i] * width_y[j];
            let nodes = self.across.iter().enumerate();
            nodes
                .map(|(i, &x)| ContactNode {
                    x,
                    y,
                    area: area(i),
                })
                .collect::<Vec<_>>()
        };
        self.along.iter().enumerate().flat_map(row).collect()
    }

    /// Relative deviation of the mean pressure on each contact node's part of the width from that of all, under a rigid flat
    /// punch as wide as the contact: its load left of s is 1/2 + asin(2s)/π of the whole.
    pub(super) fn punch_deviation(&self) -> Vec<f64> {
        let (first, last) = (self.across[0], self.across[self.across.len() - 1]);
        let width = last - first;
        let left_of =
            |x: f64| 0.5 + (2.0 * ((x - first) / width - 0.5)).clamp(-1.0, 1.0).asin() / PI;
        // the ends to the bit: close to them the asin sees round-off under its root
        let n = self.across.len();
        let edge = |i: usize| match i {
            0 => first,
            i if i == n => last,
            i => 0.5 * (self.across[i - 1] + self.across[i]),
        };
        let deviation: Vec<f64> = (0..n)
            .map(|i| {
                let (start, end) = (edge(i), edge(i + 1));
                (left_of(end) - left_of(start)) * width / (end - start) - 1.0
            })
            .collect();
        self.along.iter().flat_map(|_| deviation.clone()).collect()
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

    /// Blade 1, clamped at z = 0, with grid lines through the contact nodes and the airfoil points at `heights`.
    pub(super) fn blade(&self, heights: &[f64]) -> Result<FeModel, FeError> {
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
        let x: Vec<f64> = faces(0).chain(self.across.iter().copied()).collect();
        let y: Vec<f64> = faces(1)
            .chain(self.along.iter().copied())
            .chain([self.airfoil_offset])
            .collect();
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
        let mirrored = self.across.iter().flat_map(|&x| [x, -x]);
        let lines = [
            grid_lines(&mirrored.collect::<Vec<_>>(), self.strip_element),
            grid_lines(&self.along, self.strip_element),
            vec![body.min[2], body.max[2]],
        ];
        FeModel::new(tensor_mesh(&lines, &[body]), &self.material, |_| false)
    }
}

/// `n` points from `first` to `last`.
fn equal_steps(first: f64, last: f64, n: usize) -> Vec<f64> {
    (0..n)
        .map(|i| first + (last - first) * i as f64 / (n - 1) as f64)
        .collect()
}

/// Half the distance to both neighbours.
fn tributary(lines: &[f64]) -> Vec<f64> {
    let n = lines.len();
    (0..n)
        .map(|i| 0.5 * (lines[(i + 1).min(n - 1)] - lines[i.saturating_sub(1)]))
        .collect()
}
