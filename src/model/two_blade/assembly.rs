//! The components put together: matrices, contact pairs, loads, responses.

use super::components::ContactCell;
use super::{Blade, Component, Phase, TwoBladeSettings};
use crate::model::{ContactPair, Mirror, ReducedModel, Response, SparseRow};
use crate::units::hz_to_rad_s;
use faer::{Mat, Scale};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Places of the components in the system's degrees of freedom: blade 1, blade 2, strip.
struct System<'a> {
    settings: &'a TwoBladeSettings,
    contact: &'a [ContactCell],
    blade: &'a Component,
    strip: &'a Component,
    /// Maps blade 1 to blade 2.
    mirror: &'a [f64],
}

/// The reduced model of the rig, without loads of inputs.
pub(super) fn reduced_model(
    settings: &TwoBladeSettings,
    contact: &[ContactCell],
    blade: &Blade,
    strip: &Component,
) -> ReducedModel {
    let system = System {
        settings,
        contact,
        blade: &blade.component,
        strip,
        mirror: &blade.mirror,
    };
    let strip_damping = Scale(strip_damping_time(settings)) * &strip.reduced.stiffness;
    ReducedModel {
        name: "two blades with strip damper".to_owned(),
        dof_names: system.dof_names(),
        mass: system.block_diagonal(&system.blade.reduced.mass, &strip.reduced.mass),
        damping: system.block_diagonal(
            &modal_damping(blade, settings.blade_damping_ratio),
            &strip_damping,
        ),
        stiffness: system.block_diagonal(&system.blade.reduced.stiffness, &strip.reduced.stiffness),
        retention: Some(system.retention()),
        contacts: system.contact_pairs(),
        static_force: system.centrifugal_force(),
        loads: Vec::new(),
        cosine_force: system.excitation(),
        sine_force: vec![0.0; system.n_dofs()],
        responses: system.responses(),
        mirror: Some(system.mirror()),
    }
}

/// M Φ diag(2ζω) Φᵀ M: the same damping ratio in every mode of the component.
fn modal_damping(blade: &Blade, ratio: f64) -> Mat<f64> {
    let momenta = &blade.component.reduced.mass * &blade.shapes;
    let n = momenta.nrows();
    let scaled = Mat::from_fn(n, n, |i, j| {
        momenta[(i, j)] * 2.0 * ratio * blade.lambda[j].max(0.0).sqrt()
    });
    scaled * momenta.transpose()
}

/// β of C = β K with the given ratio at 1 kHz: ζ = βω/2.
fn strip_damping_time(settings: &TwoBladeSettings) -> f64 {
    2.0 * settings.strip_damping_ratio / hz_to_rad_s(1e3)
}

impl System<'_> {
    fn n_blade(&self) -> usize {
        self.blade.reduced.n_dofs()
    }

    fn n_dofs(&self) -> usize {
        2 * self.n_blade() + self.strip.reduced.n_dofs()
    }

    /// First degree of freedom of node `node` of blade `blade`.
    fn blade_node(&self, blade: usize, node: usize) -> usize {
        blade * self.n_blade() + self.blade.nodes[node]
    }

    /// First degree of freedom of the strip under contact node `node` of blade `blade`.
    fn strip_node(&self, blade: usize, node: usize) -> usize {
        2 * self.n_blade() + self.strip.nodes[blade * self.contact.len() + node]
    }

    fn block_diagonal(&self, blade: &Mat<f64>, strip: &Mat<f64>) -> Mat<f64> {
        let nb = self.n_blade();
        let mut system = Mat::zeros(self.n_dofs(), self.n_dofs());
        system.submatrix_mut(0, 0, nb, nb).copy_from(blade);
        for j in 0..nb {
            for i in 0..nb {
                system[(nb + i, nb + j)] = self.mirror[i] * blade[(i, j)] * self.mirror[j];
            }
        }
        let ns = strip.nrows();
        system
            .submatrix_mut(2 * nb, 2 * nb, ns, ns)
            .copy_from(strip);
        system
    }

    fn dof_names(&self) -> Vec<String> {
        let names = |body: &str, component: &Component| -> Vec<String> {
            let b = component.reduced.n_masters;
            let name = |q: usize| match q < b {
                true => format!("{body}.node{}.{}", q / 3, AXES[q % 3]),
                false => format!("{body}.mode{}", q - b),
            };
            (0..component.reduced.n_dofs()).map(name).collect()
        };
        [
            names("blade1", self.blade),
            names("blade2", self.blade),
            names("strip", self.strip),
        ]
        .concat()
    }

    /// Pairs of blade 1, then of blade 2, each in the order of the contact nodes. t1 = x, t2 = y, n = z.
    fn contact_pairs(&self) -> Vec<ContactPair> {
        let pair = |blade: usize, node: usize| {
            let row = |axis: usize| -> SparseRow {
                vec![
                    (self.strip_node(blade, node) + axis, 1.0),
                    (self.blade_node(blade, node) + axis, -1.0),
                ]
            };
            ContactPair {
                name: format!("blade{}.contact{node}", blade + 1),
                t1: row(0),
                t2: row(1),
                n: row(2),
                area: self.contact[node].area,
                interface: blade,
            }
        };
        (0..2)
            .flat_map(|blade| (0..self.contact.len()).map(move |node| (blade, node)))
            .map(|(blade, node)| pair(blade, node))
            .collect()
    }

    /// Load on the strip towards +z: nodal shares if given, otherwise F M r / rᵀMr with r the unit translation in z.
    fn centrifugal_force(&self) -> Vec<f64> {
        let load = self.settings.centrifugal_load_n;
        let mut force = vec![0.0; self.n_dofs()];
        if let Some(weights) = &self.settings.pressure_weights {
            let total: f64 = weights.iter().sum();
            for (pair, weight) in weights.iter().enumerate() {
                let (blade, node) = (pair / self.contact.len(), pair % self.contact.len());
                force[self.strip_node(blade, node) + 2] = load * weight / total;
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
            force[2 * self.n_blade() + q] = load * momentum[(q, 0)] / mass;
        }
        force
    }

    /// Unit force on each blade.
    fn excitation(&self) -> Vec<f64> {
        let direction = self.settings.excitation_direction;
        let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        let sign = match self.settings.excitation_phase {
            Phase::InPhase => -1.0,
            Phase::OutOfPhase => 1.0,
        };
        let mut force = vec![0.0; self.n_dofs()];
        for (axis, d) in direction.iter().enumerate() {
            let at = self.blade_node(0, self.contact.len()) + axis;
            let mirrored = self.blade_node(1, self.contact.len()) + axis;
            force[at] = d / norm;
            force[mirrored] = sign * self.mirror[axis] * d / norm;
        }
        force
    }

    fn responses(&self) -> Vec<Response> {
        (0..2)
            .map(|blade| Response {
                name: format!("blade{}.airfoil.x", blade + 1),
                row: vec![(self.blade_node(blade, self.contact.len() + 1), 1.0)],
            })
            .collect()
    }

    /// x → −x: exchanges the blades and the halves of the strip.
    fn mirror(&self) -> Mirror {
        let nb = self.n_blade();
        let blades = (0..2 * nb).map(|q| ((q + nb) % (2 * nb), self.mirror[q % nb]));
        let strip = self.strip_mirror().into_iter();
        Mirror {
            image: blades
                .chain(strip.map(|(q, sign)| (2 * nb + q, sign)))
                .collect(),
        }
    }

    /// The same within the strip. A fixed-interface mode has the parity of the inertia forces that it puts on the masters.
    fn strip_mirror(&self) -> Vec<(usize, f64)> {
        let strip = &self.strip.reduced;
        let n = self.contact.len();
        let mut image: Vec<(usize, f64)> = (0..strip.n_dofs()).map(|q| (q, 1.0)).collect();
        for node in 0..2 * n {
            let (from, to) = (
                self.strip.nodes[node],
                self.strip.nodes[(node + n) % (2 * n)],
            );
            for (axis, sign) in [-1.0, 1.0, 1.0].into_iter().enumerate() {
                image[from + axis] = (to + axis, sign);
            }
        }
        for mode in strip.n_masters..strip.n_dofs() {
            let correlation: f64 = (image[..strip.n_masters].iter().enumerate())
                .map(|(q, &(j, sign))| strip.mass[(q, mode)] * sign * strip.mass[(j, mode)])
                .sum();
            image[mode].1 = correlation.signum();
        }
        image
    }

    /// k Σ w wᵀ with w the mean displacement of the strip's contact cells in x and y, weighed by area, and their mean
    /// rotation about z times the radius of gyration.
    fn retention(&self) -> Mat<f64> {
        let whole: f64 = 2.0 * self.contact.iter().map(|cell| cell.area).sum::<f64>();
        let mut places = Vec::new();
        for (blade, side) in [(0, 1.0), (1, -1.0)] {
            places.extend(self.contact.iter().enumerate().map(|(node, cell)| {
                let [x, y] = cell.patch.centre();
                let dof = self.strip_node(blade, node);
                (dof, [side * x, y], cell.area / whole)
            }));
        }
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        let gyration: f64 = places.iter().map(|(_, at, part)| part * square(*at)).sum();
        let radius = gyration.sqrt();
        let mut w = Mat::zeros(self.n_dofs(), 3);
        for (dof, [x, y], part) in places {
            w[(dof, 0)] = part;
            w[(dof + 1, 1)] = part;
            w[(dof, 2)] = -y * part / radius;
            w[(dof + 1, 2)] = x * part / radius;
        }
        Scale(self.settings.retention_n_per_m) * (&w * w.transpose())
    }
}
