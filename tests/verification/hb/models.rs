//! Small models with contacts: a Jenkins oscillator, two lumped blades with a rigid strip in the plane and in space.

use faer::Mat;
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::hb::{LinearModel, Problem, SliderAnchor};
use microslip::model::{ContactPair, ReducedModel, Response, SparseRow};

/// A model and its nominal contact parameters.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub(super) model: ReducedModel,
    pub(super) contacts: Vec<ContactParameters<f64>>,
}

/// Centrifugal load on the strip of both lumped models (N).
pub(super) const LOAD: f64 = 180.0;

impl Case {
    /// Contact stiffness times `scale`, friction coefficient `mu`.
    pub(super) fn with_contacts(mut self, scale: f64, mu: f64) -> Self {
        for c in &mut self.contacts {
            c.k_n *= scale;
            c.k_t = c.k_t.map(|k| scale * k);
            c.mu = mu;
        }
        self
    }
}

/// The equations of a case at its own loads.
pub(super) fn with_problem<T>(case: &Case, visit: impl FnOnce(&Problem<'_>) -> T) -> T {
    let linear = LinearModel::new(&case.model).expect("definite");
    let anchor = SliderAnchor::Unloaded;
    let problem = Problem::new(&linear, case.contacts.clone(), 1.0, anchor).expect("held");
    visit(&problem)
}

/// Closing instant interpolated, periodic sliders.
pub(super) fn aft(n_time: usize, law: FrictionLaw) -> AftSettings {
    AftSettings {
        n_time,
        law,
        events: Events::Interpolated,
        laps: Laps::Periodic,
    }
}

fn assembled(
    diagonals: [&[f64]; 3],
    static_dof: Option<usize>,
    contacts: Vec<ContactPair>,
) -> ReducedModel {
    let [mass, damping, stiffness] = diagonals.map(diagonal);
    let n = mass.nrows();
    let zero = vec![0.0; n];
    let mut static_force = zero.clone();
    if let Some(dof) = static_dof {
        static_force[dof] = LOAD;
    }
    ReducedModel {
        name: "lumped".to_owned(),
        dof_names: (0..n).map(|i| i.to_string()).collect(),
        mass,
        damping,
        stiffness,
        retention: None,
        contacts,
        static_force,
        loads: Vec::new(),
        cosine_force: zero.clone(),
        sine_force: zero,
        responses: (0..n)
            .map(|i| Response {
                name: i.to_string(),
                row: vec![(i, 1.0)],
            })
            .collect(),
        mirror: None,
    }
}

fn pair(index: usize, rows: [SparseRow; 3], interface: usize) -> ContactPair {
    let [t1, t2, n] = rows;
    ContactPair {
        name: index.to_string(),
        t1,
        t2,
        n,
        area: 1.0,
        interface,
    }
}

pub(super) fn diagonal(d: &[f64]) -> Mat<f64> {
    Mat::from_fn(d.len(), d.len(), |i, j| if i == j { d[i] } else { 0.0 })
}

/// Oscillator of mass 1 and stiffness 1 with a Jenkins element of constant normal load 1 to ground, force cos ωt.
pub(super) fn jenkins(damping: f64, k_t: f64, limit: f64) -> Case {
    let row = pair(0, [vec![(0, 1.0)], vec![], vec![]], 0);
    let mut model = assembled([&[1.0], &[damping], &[1.0]], None, vec![row]);
    model.cosine_force[0] = 1.0;
    let contact = ContactParameters {
        k_n: 0.0,
        k_t: [k_t, 0.0],
        mu: limit,
        n_0: 1.0,
        anchor: [0.0; 2],
    };
    Case {
        model,
        contacts: vec![contact],
    }
}

/// Two masses 1 with a contact, force cos ωt on the first; stiffness of each against the ground and the coupling, as in the matrix.
fn two_masses(
    stiffness: [f64; 2],
    coupling: f64,
    rows: [SparseRow; 3],
    contact: ContactParameters<f64>,
) -> Case {
    let diagonals: [&[f64]; 3] = [&[1.0; 2], &[0.02; 2], &stiffness];
    let mut model = assembled(diagonals, None, vec![pair(0, rows, 0)]);
    (model.stiffness[(0, 1)], model.stiffness[(1, 0)]) = (coupling, coupling);
    model.cosine_force[0] = 1.0;
    let contacts = vec![contact];
    Case { model, contacts }
}

/// Two masses on springs of about the same stiffness, with a contact that sticks.
pub(super) fn stuck_masses() -> Case {
    let rows = [vec![(0, 1.0), (1, 0.4)], vec![], vec![]];
    let contact = ContactParameters {
        k_n: 0.0,
        k_t: [0.5, 0.0],
        mu: 1.0,
        n_0: 1e6,
        anchor: [0.0; 2],
    };
    two_masses([1.2, 1.5], -0.1, rows, contact)
}

/// Two masses with a contact that closes only where both move far in the negative direction.
pub(super) fn open_contact() -> Case {
    let rows = [vec![], vec![], vec![(1, -0.7), (0, -0.4)]];
    let contact = ContactParameters {
        k_n: 0.7,
        k_t: [0.0; 2],
        mu: 0.3,
        n_0: -0.2,
        anchor: [0.0; 2],
    };
    two_masses([1.2, 1.2], -0.5, rows, contact)
}

/// Four coupled masses with two contacts, one preloaded, one with a gap, which open for most of the period at their resonance; the contact
/// stiffnesses times `stiffness`.
pub(super) fn four_masses(friction: f64, stiffness: f64) -> Case {
    let rows = [
        [vec![(0, 1.0), (2, -1.0)], vec![], vec![(1, -0.5), (3, 1.0)]],
        [
            vec![(0, 0.3), (1, 1.0), (2, -1.0), (3, 0.2)],
            vec![],
            vec![(0, 0.4), (3, 0.7)],
        ],
    ];
    let contacts = [(3.0, 2.0, 0.3), (2.0, 1.5, -0.2 * stiffness)];
    let contacts = contacts.map(|(k_n, k_t, n_0)| ContactParameters {
        k_n: stiffness * k_n,
        k_t: [stiffness * k_t, 0.0],
        mu: friction,
        n_0,
        anchor: [0.0; 2],
    });
    let rows = rows.into_iter().enumerate();
    let mut model = assembled(
        [
            &[1.0, 0.8, 0.3, 0.3],
            &[0.04, 0.04, 0.06, 0.06],
            &[1.0, 1.5, 0.3, 0.5],
        ],
        None,
        rows.map(|(i, rows)| pair(i, rows, 0)).collect(),
    );
    for (i, j, mass) in [(0, 1, 0.2), (0, 3, 0.1), (1, 2, 0.1), (2, 3, 0.05)] {
        (model.mass[(i, j)], model.mass[(j, i)]) = (mass, mass);
    }
    (model.stiffness[(0, 1)], model.stiffness[(1, 0)]) = (-0.3, -0.3);
    model.static_force = vec![0.2, -0.1, 0.05, 1.0];
    model.cosine_force = vec![1.0, 0.0, 0.0, 0.1];
    model.sine_force = vec![0.0, 0.7, 0.05, 0.0];
    model.responses[0].row = vec![(0, 1.0), (1, -0.5), (2, 0.2)];
    Case {
        model,
        contacts: contacts.into(),
    }
}

/// Place a (m) of a node along the strip's width, blade (0 or 1), and motion of the platform there in the normal
/// direction per motion of the blade in the tangential one.
const NODES: [(f64, usize, f64); 4] = [
    (-4e-3, 0, 0.05),
    (-1e-3, 0, 0.35),
    (1e-3, 1, -0.35),
    (4e-3, 1, -0.05),
];

/// Two blades with one translation x₁, x₂ each, and a rigid strip: X along, Y normal, rotation θ; 180 N on Y.
/// Order of the degrees of freedom: x₁, x₂, X, Y, θ. Force on the second blade times `phase`.
pub(super) fn plane(phase: f64) -> Case {
    let (mass, inertia) = (1.58e-3, 1.58e-3 * 1e-4 / 12.0);
    let rows = NODES.iter().enumerate().map(|(i, &(a, blade, tilt))| {
        let normal = vec![(blade, -tilt), (3, 1.0), (4, a)];
        pair(i, [vec![(blade, -1.0), (2, 1.0)], vec![], normal], blade)
    });
    let damping = 2.0 * 0.002 * f64::sqrt(1.6e6 * 0.4);
    let mut model = assembled(
        [
            &[0.4, 0.4, mass, mass, inertia],
            &[damping, damping, 0.0, 0.0, 0.0],
            &[1.6e6, 1.6e6, 0.0, 0.0, 0.0],
        ],
        Some(3),
        rows.collect(),
    );
    model.retention = Some(diagonal(&[0.0, 0.0, 1e3, 0.0, 0.0]));
    (model.cosine_force[0], model.cosine_force[1]) = (1.0, phase);
    let contact = ContactParameters {
        k_n: 2.5e6,
        k_t: [0.5825e6, 0.0],
        mu: 0.6,
        n_0: 0.0,
        anchor: [0.0; 2],
    };
    Case {
        model,
        contacts: vec![contact; 4],
    }
}

/// Two blades with three translations each and a rigid strip with six motions on 2 × 4 pairs, damping αM + βK.
/// Order of the degrees of freedom: x₁, y₁, z₁, x₂, y₂, z₂, X, Y, Z, θx, θy, θz. Forces in x and y, not in phase.
pub(super) fn space() -> Case {
    let (mass, [wide, long]) = (1.58e-3, [10e-3, 50e-3]);
    let inertia = [long * long, wide * wide, long * long + wide * wide].map(|l| mass * l / 12.0);
    let rows = (0..8).map(|i| {
        let (a, blade, tilt) = NODES[i / 2];
        let b = if i % 2 == 0 { -20e-3 } else { 15e-3 };
        let x = vec![(3 * blade, -1.0), (6, 1.0), (11, -b)];
        let y = vec![(3 * blade + 1, -1.0), (7, 1.0), (11, a)];
        let own = [(3 * blade, -tilt), (3 * blade + 1, 5.0 * b)];
        let z = [
            own[0],
            own[1],
            (3 * blade + 2, -1.0),
            (8, 1.0),
            (9, b),
            (10, -a),
        ];
        pair(i, [x, y, z.to_vec()], blade)
    });
    let masses: Vec<f64> = [0.4; 6]
        .into_iter()
        .chain([mass; 3])
        .chain(inertia)
        .collect();
    let springs: Vec<f64> = [1.6e6, 1.9e6, 3e6, 1.6e6, 1.9e6, 3e6]
        .into_iter()
        .chain([0.0; 6])
        .collect();
    let zero = vec![0.0; 12];
    let mut model = assembled([&masses, &zero, &springs], Some(8), rows.collect());
    for blade in [0, 3] {
        for (i, j, k) in [(0, 1, 1e5), (0, 2, -2e5), (1, 2, 1.5e5)] {
            model.stiffness[(blade + i, blade + j)] += k;
            model.stiffness[(blade + j, blade + i)] += k;
        }
    }
    let n = masses.len();
    model.damping = Mat::from_fn(n, n, |i, j| {
        0.5 * model.mass[(i, j)] + 2e-6 * model.stiffness[(i, j)]
    });
    let mut held = zero;
    (held[6], held[7], held[11]) = (1e3, 1e3, 1.0);
    model.retention = Some(diagonal(&held));
    for (dof, cosine, sine) in [(0, 1.0, 0.0), (1, 0.3, -0.4), (3, -0.7, 0.2), (4, 0.0, 0.5)] {
        (model.cosine_force[dof], model.sine_force[dof]) = (cosine, sine);
    }
    let contact = ContactParameters {
        k_n: 1.25e6,
        k_t: [0.29e6, 0.25e6],
        mu: 0.6,
        n_0: 0.0,
        anchor: [0.0; 2],
    };
    Case {
        model,
        contacts: vec![contact; 8],
    }
}

/// Errors in two digits.
pub(super) fn short(errors: &[f64]) -> String {
    let each: Vec<String> = errors.iter().map(|e| format!("{e:.1e}")).collect();
    each.join(" ")
}
