//! The components put together: matrices, contact pairs, loads, responses.

use super::components::ContactCell;
use super::placed_strip::{PlacedStrip, names_of};
use super::{Blade, Component, Phase, TwoBladeSettings};
use crate::model::{ContactPair, Mirror, ReducedModel, Response};
use crate::units::hz_to_rad_s;
use faer::{Mat, Scale};

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
        retention: Some(system.strip().retention()),
        contacts: system.contact_pairs(),
        static_force: system.strip().centrifugal_force(),
        loads: Vec::new(),
        cosine_force: system.excitation(),
        sine_force: vec![0.0; system.n_dofs()],
        responses: system.responses(),
        mirror: Some(system.mirror()),
    }
}

/// M Φ diag(2ζω) Φᵀ M: the same damping ratio in every mode of the component.
pub(super) fn modal_damping(blade: &Blade, ratio: f64) -> Mat<f64> {
    let momenta = &blade.component.reduced.mass * &blade.shapes;
    let n = momenta.nrows();
    let scaled = Mat::from_fn(n, n, |i, j| {
        momenta[(i, j)] * 2.0 * ratio * blade.lambda[j].max(0.0).sqrt()
    });
    scaled * momenta.transpose()
}

/// β of C = β K with the given ratio at 1 kHz: ζ = βω/2.
pub(super) fn strip_damping_time(settings: &TwoBladeSettings) -> f64 {
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

    fn strip(&self) -> PlacedStrip<'_> {
        PlacedStrip {
            settings: self.settings,
            contact: self.contact,
            strip: self.strip,
            first: 2 * self.n_blade(),
            n_dofs: self.n_dofs(),
        }
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
        [
            names_of("blade1", self.blade),
            names_of("blade2", self.blade),
            names_of("strip", self.strip),
        ]
        .concat()
    }

    /// Pairs of blade 1, then of blade 2, each in the order of the contact nodes. t1 = x, t2 = y, n = z.
    fn contact_pairs(&self) -> Vec<ContactPair> {
        let strip = self.strip();
        (0..2)
            .flat_map(|blade| (0..self.contact.len()).map(move |node| (blade, node)))
            .map(|(blade, node)| {
                let name = format!("blade{}.contact{node}", blade + 1);
                strip.pair(name, blade, node, self.blade_node(blade, node))
            })
            .collect()
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
}
