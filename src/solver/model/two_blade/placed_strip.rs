//! The strip in the degrees of freedom of a whole: its load, what holds its mean position, and its contact pairs.

use super::components::ContactCell;
use super::{Component, TwoBladeSettings};
use crate::model::{ContactPair, SparseRow};
use faer::{Mat, Scale};

const AXES: [&str; 3] = ["x", "y", "z"];

/// The strip as a part of a whole.
pub(super) struct PlacedStrip<'a> {
    pub(super) settings: &'a TwoBladeSettings,
    /// Contact cells of one side.
    pub(super) contact: &'a [ContactCell],
    pub(super) strip: &'a Component,
    /// Its first degree of freedom in the whole.
    pub(super) first: usize,
    /// Those of the whole.
    pub(super) n_dofs: usize,
}

/// Names of the degrees of freedom of a component.
pub(super) fn names_of(body: &str, component: &Component) -> Vec<String> {
    let b = component.reduced.n_masters;
    let name = |q: usize| match q < b {
        true => format!("{body}.node{}.{}", q / 3, AXES[q % 3]),
        false => format!("{body}.mode{}", q - b),
    };
    (0..component.reduced.n_dofs()).map(name).collect()
}

impl PlacedStrip<'_> {
    /// First degree of freedom under contact node `node` of side `side`, 0 at x < 0.
    fn node(&self, side: usize, node: usize) -> usize {
        self.first + self.strip.nodes[side * self.contact.len() + node]
    }

    /// The pair of a contact node of one side with a platform whose node has the first degree of freedom `platform`. t1 = x,
    /// t2 = y, n = z.
    pub(super) fn pair(
        &self,
        name: String,
        side: usize,
        node: usize,
        platform: usize,
    ) -> ContactPair {
        let row = |axis: usize| -> SparseRow {
            vec![(self.node(side, node) + axis, 1.0), (platform + axis, -1.0)]
        };
        ContactPair {
            name,
            t1: row(0),
            t2: row(1),
            n: row(2),
            area: self.contact[node].area,
            interface: side,
        }
    }

    /// Load on the strip towards +z: nodal shares if given, otherwise F M r / rᵀMr with r the unit translation in z.
    pub(super) fn centrifugal_force(&self) -> Vec<f64> {
        let load = self.settings.centrifugal_load_n;
        let mut force = vec![0.0; self.n_dofs];
        if let Some(weights) = &self.settings.pressure_weights {
            let total: f64 = weights.iter().sum();
            for (pair, weight) in weights.iter().enumerate() {
                let (side, node) = (pair / self.contact.len(), pair % self.contact.len());
                force[self.node(side, node) + 2] = load * weight / total;
            }
            return force;
        }
        // Constraint modes hold rigid-body motion exactly, so r has no modal part.
        let masters = self.strip.reduced.n_masters;
        let along_z = Mat::from_fn(self.strip.reduced.n_dofs(), 1, |q, _| {
            if q < masters && q % 3 == 2 { 1.0 } else { 0.0 }
        });
        let momentum = &self.strip.reduced.mass * &along_z;
        let mass = (along_z.transpose() * &momentum)[(0, 0)];
        for q in 0..momentum.nrows() {
            force[self.first + q] = load * momentum[(q, 0)] / mass;
        }
        force
    }

    /// k Σ w wᵀ with w the mean displacement of the strip's contact cells in x and y, weighed by area, and their mean
    /// rotation about z times the radius of gyration.
    pub(super) fn retention(&self) -> Mat<f64> {
        let whole: f64 = 2.0 * self.contact.iter().map(|cell| cell.area).sum::<f64>();
        let mut places = Vec::new();
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            places.extend(self.contact.iter().enumerate().map(|(node, cell)| {
                let [x, y] = cell.patch.centre();
                (self.node(side, node), [sign * x, y], cell.area / whole)
            }));
        }
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        let gyration: f64 = places.iter().map(|(_, at, part)| part * square(*at)).sum();
        let radius = gyration.sqrt();
        let mut w = Mat::zeros(self.n_dofs, 3);
        for (dof, [x, y], part) in places {
            w[(dof, 0)] = part;
            w[(dof + 1, 1)] = part;
            w[(dof, 2)] = -y * part / radius;
            w[(dof + 1, 2)] = x * part / radius;
        }
        Scale(self.settings.retention_n_per_m) * (&w * w.transpose())
    }
}
