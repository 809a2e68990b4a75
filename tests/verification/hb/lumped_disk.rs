//! A lumped disk, and its whole ring as an ordinary model.

use super::models::diagonal;
use faer::prelude::*;
use microslip::contact::ContactParameters;
use microslip::model::disk::{CyclicMatrix, Disk};
use microslip::model::{ContactPair, ReducedModel, Response, SparseRow};
use std::f64::consts::TAU;

/// Degrees of freedom of a sector: blade x, y, z; disk x; strip X, Y, Z.
const N: usize = 7;
/// Centrifugal load on a strip (N).
const LOAD: f64 = 180.0;

/// A blade with three motions on a disk mass, which springs and a dashpot couple with the next one, and a strip between the
/// blade and the next one. Nothing of it is mirror-symmetric, so that the waves have complex matrices.
pub(super) fn disk(n_sectors: usize) -> Disk {
    let strip = 1.58e-3;
    let mass = diagonal(&[0.4, 0.4, 0.4, 2.0, strip, strip, strip]);
    let mut own = diagonal(&[1.6e6, 1.9e6, 3e6, 9e6, 0.0, 0.0, 0.0]);
    for (i, j, k) in [(0, 1, 1e5), (0, 2, -2e5), (1, 2, 1.5e5), (0, 3, -6e5)] {
        own[(i, j)] += k;
        own[(j, i)] += k;
    }
    let mut next = Mat::zeros(N, N);
    (next[(3, 3)], next[(3, 0)], next[(2, 3)]) = (-3e6, -2e5, 1.5e5);
    let mut damping = Mat::from_fn(N, N, |i, j| 0.5 * mass[(i, j)] + 2e-6 * own[(i, j)]);
    damping[(3, 3)] += 60.0;
    let mut between = Mat::from_fn(N, N, |i, j| 2e-6 * next[(i, j)]);
    between[(3, 3)] -= 25.0;
    let mut retention = Mat::zeros(N, N);
    (retention[(4, 4)], retention[(5, 5)]) = (1e3, 1e3);
    let pair = |side: usize, tilt: f64| {
        let blade = N * side;
        ContactPair {
            name: format!("pair{side}"),
            t1: vec![(4, 1.0), (blade, -1.0)],
            t2: vec![(5, 1.0), (blade + 1, -1.0), (blade + 3, 0.1)],
            n: vec![(6, 1.0), (blade + 2, -1.0), (blade, -tilt)],
            area: 1.0,
            interface: side,
        }
    };
    let mut static_force = vec![0.0; N];
    static_force[6] = LOAD;
    Disk {
        name: "lumped disk".to_owned(),
        n_sectors,
        dof_names: (0..N).map(|i| i.to_string()).collect(),
        mass: CyclicMatrix::uncoupled(mass),
        damping: CyclicMatrix::Neighbours {
            own: damping,
            next: between,
        },
        stiffness: CyclicMatrix::Neighbours { own, next },
        retention: Some(retention),
        blade_stiffness: None,
        contacts: vec![pair(0, 0.3), pair(1, -0.2)],
        static_force,
        loads: Vec::new(),
        cosine_force: vec![1.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0],
        sine_force: vec![0.0, -0.4, 0.2, 0.0, 0.0, 0.0, 0.0],
        responses: each(N),
    }
}

/// Every displacement.
pub(super) fn each(n: usize) -> Vec<Response> {
    let response = |i: usize| Response {
        name: i.to_string(),
        row: vec![(i, 1.0)],
    };
    (0..n).map(response).collect()
}

pub(super) fn contacts(n_pairs: usize) -> Vec<ContactParameters<f64>> {
    let contact = ContactParameters {
        k_n: 2.5e6,
        k_t: [0.58e6, 0.5e6],
        mu: 0.6,
        n_0: 0.0,
        anchor: [0.0; 2],
    };
    vec![contact; n_pairs]
}

/// All sectors, one after the other: excited by `engine_order`, or each with the force of sector 0 for none.
pub(super) fn ring(disk: &Disk, engine_order: usize) -> ReducedModel {
    let of_sector = disk.dof_names.len();
    let (n_sectors, n) = (disk.n_sectors, disk.n_sectors * of_sector);
    let whole = |a: &CyclicMatrix| {
        let CyclicMatrix::Neighbours { own, next } = a else {
            panic!("the lumped disk has matrices of neighbours")
        };
        let mut ring = Mat::zeros(n, n);
        for sector in 0..n_sectors {
            let (here, there) = (sector * of_sector, (sector + 1) % n_sectors * of_sector);
            for (i, j) in (0..of_sector).flat_map(|i| (0..of_sector).map(move |j| (i, j))) {
                ring[(here + i, here + j)] += own[(i, j)];
                ring[(here + i, there + j)] += next[(i, j)];
                ring[(there + j, here + i)] += next[(i, j)];
            }
        }
        ring
    };
    let row = |row: &SparseRow, sector: usize| -> SparseRow {
        let placed = |&(dof, weight): &(usize, f64)| ((sector * of_sector + dof) % n, weight);
        row.iter().map(placed).collect()
    };
    let repeated = |f: &[f64]| f.repeat(n_sectors);
    let force = |part: fn(c64) -> f64| -> Vec<f64> {
        let at = |i: usize| {
            let (sector, dof) = (i / of_sector, i % of_sector);
            let angle = TAU * (engine_order * sector) as f64 / n_sectors as f64;
            let unit = c64::new(disk.cosine_force[dof], -disk.sine_force[dof]);
            part(unit * c64::new(angle.cos(), -angle.sin()))
        };
        (0..n).map(at).collect()
    };
    ReducedModel {
        name: "ring".to_owned(),
        dof_names: (0..n).map(|i| i.to_string()).collect(),
        mass: whole(&disk.mass),
        damping: whole(&disk.damping),
        stiffness: whole(&disk.stiffness),
        retention: disk
            .retention
            .as_ref()
            .map(|held| repeated_matrix(held, n_sectors)),
        contacts: (0..n_sectors)
            .flat_map(|sector| (disk.contacts.iter()).map(move |pair| (sector, pair)))
            .map(|(sector, pair)| ContactPair {
                name: format!("sector{sector}.{}", pair.name),
                t1: row(&pair.t1, sector),
                t2: row(&pair.t2, sector),
                n: row(&pair.n, sector),
                ..pair.clone()
            })
            .collect(),
        static_force: repeated(&disk.static_force),
        loads: Vec::new(),
        cosine_force: force(|z| z.re),
        sine_force: force(|z| -z.im),
        responses: each(n),
        mirror: None,
    }
}

/// A matrix of every sector alone.
fn repeated_matrix(of_sector: &Mat<f64>, n_sectors: usize) -> Mat<f64> {
    let n = of_sector.nrows();
    Mat::from_fn(n_sectors * n, n_sectors * n, |i, j| match i / n == j / n {
        true => of_sector[(i % n, j % n)],
        false => 0.0,
    })
}

/// The disk without what couples its sectors, but for the contacts.
pub(super) fn uncoupled(n_sectors: usize) -> Disk {
    let mut disk = disk(n_sectors);
    for matrix in [&mut disk.mass, &mut disk.damping, &mut disk.stiffness] {
        if let CyclicMatrix::Neighbours { own, .. } = matrix {
            *matrix = CyclicMatrix::uncoupled(own.clone());
        }
    }
    assert!(disk.is_uncoupled(), "a matrix couples the sectors");
    disk
}
