//! Verification of `fe`, and of the reduction of finite element models.

#![expect(
    clippy::expect_used,
    reason = "functions shared by tests fail like tests"
)]

use faer::Mat;
use faer::linalg::solvers::Solve;
use microslip::fe::{Cuboid, FeModel, HexMesh, Material, Rectangle, grid_lines, tensor_mesh};
use microslip::linalg::{lowest_modes, symmetric_generalized_eigen};
use microslip::model::{CraigBampton, ReductionError, SparseRow};
use microslip::units::rad_s_to_hz;
use std::f64::consts::{PI, TAU};

const STEEL: Material = Material {
    youngs_modulus: 210e9,
    poisson_ratio: 0.3,
    density: 7850.0,
};
/// Without lateral contraction the closed forms of bars and beams hold exactly at a clamp.
const NO_CONTRACTION: Material = Material {
    poisson_ratio: 0.0,
    ..STEEL
};

/// Box [0, size] with n elements per axis.
fn block(size: [f64; 3], n: [usize; 3]) -> HexMesh {
    let lines: [Vec<f64>; 3] =
        std::array::from_fn(|i| grid_lines(&[0.0, size[i]], size[i] / n[i] as f64));
    let whole = Cuboid {
        min: [0.0; 3],
        max: size,
    };
    tensor_mesh(&lines, &[whole])
}

fn free(_: [f64; 3]) -> bool {
    false
}

fn clamped_at_origin(x: [f64; 3]) -> bool {
    x[0] < 1e-9
}

/// log₂ of the ratio of successive errors under halving.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

/// Any linear displacement field leaves the inner nodes of a distorted mesh without force.
/// Seen to fail: with the gradients of the bubbles taken from the local Jacobian, and without the |J₀|/|J| factor.
#[test]
fn distorted_mesh_passes_the_patch_test() {
    let mut mesh = block([1.0, 1.2, 0.9], [3, 3, 3]);
    let inside = |x: [f64; 3]| (0..3).all(|i| x[i] > 0.1 && x[i] < [0.9, 1.1, 0.8][i]);
    let inner: Vec<usize> = (0..mesh.nodes.len())
        .filter(|&n| inside(mesh.nodes[n]))
        .collect();
    for (k, &node) in inner.iter().enumerate() {
        for i in 0..3 {
            mesh.nodes[node][i] += 0.09 * (1.7 * (3 * k + i) as f64 + 0.3).sin();
        }
    }
    assert_eq!(inner.len(), 8, "a 3 x 3 x 3 block has 8 inner nodes");
    let model = FeModel::new(mesh, &STEEL, free).expect("valid mesh");
    let gradient = [[1.0, 0.3, -0.2], [-0.4, 0.7, 0.5], [0.6, -0.1, -0.8]];
    let u = Mat::from_fn(model.n_dofs(), 1, |dof, _| {
        let x = model.mesh.nodes[dof / 3];
        (0..3).map(|j| gradient[dof % 3][j] * x[j]).sum::<f64>()
    });
    let force = &model.stiffness * &u;
    for &node in &inner {
        for i in 0..3 {
            let residual = force[(3 * node + i, 0)].abs() / force.norm_max();
            assert!(residual < 1e-12, "node {node}: {residual:.1e}");
        }
    }
}

/// ρV in translation and ρV(a² + b²)/12 in rotation: consistent mass of trilinear shapes holds both exactly.
/// Seen to fail: with the mass not weighted by |J|.
#[test]
fn rigid_body_inertia_is_exact() {
    let size = [0.03, 0.05, 0.02];
    let model = FeModel::new(block(size, [2, 3, 2]), &STEEL, free).expect("valid mesh");
    let mass = STEEL.density * size.iter().product::<f64>();
    for axis in 0..3 {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let translation = Mat::from_fn(model.n_dofs(), 1, |dof, _| f64::from(dof % 3 == axis));
        let rotation = Mat::from_fn(model.n_dofs(), 1, |dof, _| {
            let x = model.mesh.nodes[dof / 3];
            match dof % 3 {
                i if i == a => -(x[b] - 0.5 * size[b]),
                i if i == b => x[a] - 0.5 * size[a],
                _ => 0.0,
            }
        });
        let inertia = mass * (size[a].powi(2) + size[b].powi(2)) / 12.0;
        for (motion, exact) in [(translation, mass), (rotation, inertia)] {
            let got = (motion.transpose() * (&model.mass * &motion))[(0, 0)];
            assert!(
                (got / exact - 1.0).abs() < 1e-12,
                "axis {axis}: {got} against {exact}"
            );
        }
    }
}

/// Free strip: six frequencies at zero (round-off), the first bending next.
/// Seen to fail: without the incompatible modes.
#[test]
fn free_strip_has_six_rigid_body_modes() {
    let mesh = block([10e-3, 50e-3, 0.4e-3], [5, 12, 1]);
    let model = FeModel::new(mesh, &STEEL, free).expect("valid mesh");
    let modes = lowest_modes(&model.stiffness, &model.mass, 8, 1e6).expect("converges");
    let f: Vec<f64> = modes
        .lambda
        .iter()
        .map(|l| rad_s_to_hz(l.abs().sqrt()))
        .collect();
    assert!(f[..6].iter().all(|f| *f < 0.5), "{f:?}");
    assert!(f[6] > 800.0 && f[6] < 900.0, "{f:?}");
}

/// Clamped bar: f = c/4L; the mesh is a chain of linear elements, so the error falls with h².
/// Seen to fail: with the quadrature points at ±0.5.
#[test]
fn longitudinal_frequency_converges_with_second_order() {
    let length = 0.1;
    let exact = (NO_CONTRACTION.youngs_modulus / NO_CONTRACTION.density).sqrt() / (4.0 * length);
    let error = |n: usize| {
        let mesh = block([length, 5e-3, 5e-3], [n, 1, 1]);
        let model = FeModel::new(mesh, &NO_CONTRACTION, clamped_at_origin).expect("valid mesh");
        let modes = lowest_modes(&model.stiffness, &model.mass, 20, 0.0).expect("converges");
        let pull = |mode: usize| {
            let along = modes.shapes.col(mode).iter().step_by(3);
            along.sum::<f64>().abs()
        };
        let longitudinal = (0..20)
            .max_by(|&a, &b| pull(a).total_cmp(&pull(b)))
            .expect("modes");
        rad_s_to_hz(modes.lambda[longitudinal].sqrt()) / exact - 1.0
    };
    let errors = [4, 8, 16].map(error);
    assert!(errors[2] < 5e-4, "{errors:?}");
    assert!(
        orders(&errors).iter().all(|p| (p - 2.0).abs() < 0.1),
        "{errors:?}"
    );
}

/// Free-free bending of the strip without contraction: β₁L = 4.730041, f = (β₁L)²/(2πL²) √(EI/ρA).
/// Source: Blevins 1979, Table 8-1. Seen to fail: without the incompatible modes (shear locking: error > 1).
#[test]
fn bending_frequency_of_a_thin_strip_converges_with_second_order() {
    let (length, width, thickness) = (50e-3, 10e-3, 0.4e-3);
    let bending = (NO_CONTRACTION.youngs_modulus * thickness * thickness
        / (12.0 * NO_CONTRACTION.density))
        .sqrt();
    let exact = 4.730_041_f64.powi(2) * bending / (TAU * length * length);
    let error = |n: usize| {
        let mesh = block([length, width, thickness], [n, 1, 1]);
        let model = FeModel::new(mesh, &NO_CONTRACTION, free).expect("valid mesh");
        let modes = lowest_modes(&model.stiffness, &model.mass, 7, 1e6).expect("converges");
        rad_s_to_hz(modes.lambda[6].sqrt()) / exact - 1.0
    };
    let errors = [6, 12, 24].map(error);
    println!("errors {errors:?} orders {:?}", orders(&errors));
    assert!(errors[2].abs() < 5e-3, "{errors:?}");
    assert!(
        orders(&errors).iter().all(|p| (p - 2.0).abs() < 0.3),
        "{errors:?}"
    );
}

/// Cantilever under an end force: Fℓ³/3EI + 6Fℓ/5GA. Source: Timoshenko & Goodier 1970, art. 21.
/// Seen to fail: without the incompatible modes.
#[test]
fn static_deflection_of_a_cantilever() {
    let [length, width, height]: [f64; 3] = [0.1, 0.01, 0.01];
    let mesh = block([length, width, height], [20, 2, 2]);
    let model = FeModel::new(mesh, &NO_CONTRACTION, clamped_at_origin).expect("valid mesh");
    let at_tip: Vec<usize> = (0..model.mesh.nodes.len())
        .filter(|&n| (model.mesh.nodes[n][0] - length).abs() < 1e-9)
        .filter_map(|n| model.first_dof[n])
        .collect();
    let mut u = Mat::zeros(model.n_dofs(), 1);
    for first in &at_tip {
        u[(first + 2, 0)] = 1.0 / at_tip.len() as f64;
    }
    let force = u.clone();
    let factor = model
        .stiffness
        .sp_cholesky(faer::Side::Lower)
        .expect("clamped");
    factor.solve_in_place(&mut u);
    let deflection = (force.transpose() * &u)[(0, 0)];
    let e = NO_CONTRACTION.youngs_modulus;
    let exact = 4.0 * length.powi(3) / (e * width * height.powi(3))
        + 1.2 * length / (0.5 * e * width * height);
    println!("deflection {:.2e} off", deflection / exact - 1.0);
    assert!(
        (deflection / exact - 1.0).abs() < 3e-3,
        "{deflection:e} against {exact:e}"
    );
}

/// Simply supported thin square plate, f₁₁ = (π/a²)·√(D/ρt): bending both ways with contraction.
/// Source: Blevins 1979, Table 11-4. Seen to fail: without the incompatible modes.
#[test]
fn plate_frequency_matches_the_closed_form() {
    let (side, thickness): (f64, f64) = (0.1, 1e-3);
    let rigidity =
        STEEL.youngs_modulus * thickness.powi(3) / (12.0 * (1.0 - STEEL.poisson_ratio.powi(2)));
    let exact = PI / (side * side) * (rigidity / (STEEL.density * thickness)).sqrt();
    let error = |n: usize| {
        let model =
            FeModel::new(block([side, side, thickness], [n, n, 2]), &STEEL, free).expect("valid");
        // Support: u_z of the middle plane's edge. The free rigid in-plane motion stays at zero.
        let supported: Vec<usize> = (0..model.mesh.nodes.len())
            .filter(|&node| {
                let x = model.mesh.nodes[node];
                let edge = |c: f64| c < 1e-9 || c > side - 1e-9;
                (x[2] - 0.5 * thickness).abs() < 1e-9 && (edge(x[0]) || edge(x[1]))
            })
            .map(|node| 3 * node + 2)
            .collect();
        let mut entries: Vec<_> = model
            .stiffness
            .triplet_iter()
            .map(|t| faer::sparse::Triplet {
                row: t.row,
                col: t.col,
                val: *t.val,
            })
            .collect();
        entries.extend(supported.iter().map(|&dof| faer::sparse::Triplet {
            row: dof,
            col: dof,
            val: 1e13,
        }));
        let n_dofs = model.n_dofs();
        let stiffness = faer::sparse::SparseColMat::try_new_from_triplets(n_dofs, n_dofs, &entries)
            .expect("in range");
        let modes = lowest_modes(&stiffness, &model.mass, 4, 1e5).expect("converges");
        rad_s_to_hz(modes.lambda[3].sqrt()) / exact - 1.0
    };
    let errors = [8, 16, 32].map(error);
    println!("errors {errors:?} orders {:?}", orders(&errors));
    assert!(errors[2].abs() < 3e-3, "{errors:?}");
}

/// Thin plate clamped on its whole upper face: hundreds of modes within a few per cent, so the Krylov space outgrows
/// 128 columns. Nothing lies below the lowest mode found: K − λM is definite just below λ₁ and not just above.
/// Seen to fail: with faer's divide and conquer for the projected matrix (wrong pairs, no convergence).
#[test]
fn densely_packed_modes_of_a_plate_converge() {
    let mesh = block([10e-3, 50e-3, 0.4e-3], [17, 16, 1]);
    let model = FeModel::new(mesh, &STEEL, |x| x[2] > 0.2e-3).expect("valid mesh");
    let modes = lowest_modes(&model.stiffness, &model.mass, 13, 0.0).expect("converges");
    let definite_at = |lambda: f64| {
        let shifted = &model.stiffness - faer::Scale(lambda) * &model.mass;
        shifted.sp_cholesky(faer::Side::Lower).is_ok()
    };
    assert!(
        definite_at(0.9999 * modes.lambda[0]),
        "a lower mode was missed"
    );
    assert!(
        !definite_at(1.0001 * modes.lambda[0]),
        "the lowest mode is no mode"
    );
}

/// Beam clamped at one end, the degrees of freedom of a node at its tip, and its frequencies with that node fixed (Hz),
/// by the dense solver.
fn beam_with_fixed_tip() -> (FeModel, [usize; 3], Vec<f64>) {
    let mesh = block([0.1, 0.02, 0.01], [10, 2, 1]);
    let model = FeModel::new(mesh, &STEEL, clamped_at_origin).expect("valid");
    let tip = model.dofs_at([0.1, 0.0, 0.0]).expect("node");
    let inner: Vec<usize> = (0..model.n_dofs()).filter(|i| !tip.contains(i)).collect();
    let [k, m] = [&model.stiffness, &model.mass].map(|full| {
        let full = full.to_dense();
        Mat::from_fn(inner.len(), inner.len(), |i, j| full[(inner[i], inner[j])])
    });
    let (lambda, _) = symmetric_generalized_eigen(k.as_ref(), m.as_ref()).expect("definite");
    let fixed = lambda.iter().map(|l| rad_s_to_hz(l.sqrt())).collect();
    (model, tip, fixed)
}

/// Displacements as masters.
fn displacements(dofs: [usize; 3]) -> [SparseRow; 3] {
    dofs.map(|dof| vec![(dof, 1.0)])
}

/// Every fixed-interface mode below the cut-off is kept and none above, from no mode to all of them.
/// Seen to fail: with a cut-off in rad/s; with the first mode above the cut-off kept.
#[test]
fn craig_bampton_keeps_the_modes_below_the_cut_off() {
    let (model, tip, fixed) = beam_with_fixed_tip();
    for n in [0, 1, 7, 8, 9, 20, 33, 100, fixed.len()] {
        let last = if n == 0 { 0.0 } else { fixed[n - 1] };
        let next = fixed.get(n).copied().unwrap_or(f64::INFINITY);
        for cut_off in [last * (1.0 + 1e-6), 0.5 * (last + next.min(1e9))] {
            let reduced =
                CraigBampton::new(&model.stiffness, &model.mass, &displacements(tip), cut_off)
                    .expect("clamped");
            let kept: Vec<f64> = (reduced.n_masters..reduced.n_dofs())
                .map(|i| rad_s_to_hz(reduced.stiffness[(i, i)].sqrt()))
                .collect();
            assert_eq!(kept.len(), n, "below {cut_off} Hz");
            assert!(
                kept.iter().all(|f| *f < cut_off),
                "{kept:?} above {cut_off}"
            );
            assert!(
                reduced.first_left_out >= cut_off,
                "{} left out",
                reduced.first_left_out
            );
            let found = kept.iter().chain([&reduced.first_left_out]);
            for (found, exact) in found.zip(fixed[..n].iter().chain([&next])) {
                assert!(
                    found == exact || (found / exact - 1.0).abs() < 1e-9,
                    "{found} {exact}"
                );
            }
        }
    }
}

/// Seen to fail: with the number of modes not limited.
#[test]
fn craig_bampton_refuses_too_many_modes() {
    let mesh = block([0.1, 0.02, 0.01], [12, 3, 2]);
    let model = FeModel::new(mesh, &STEEL, clamped_at_origin).expect("valid");
    let tip = model.dofs_at([0.1, 0.0, 0.0]).expect("node");
    let refused = CraigBampton::new(&model.stiffness, &model.mass, &displacements(tip), 1e9)
        .expect_err("429 modes");
    assert!(
        matches!(refused, ReductionError::TooManyModes { .. }),
        "{refused}"
    );
}

/// Reduced against full: frequencies from above, falling error with a rising cut-off, exact statics at the masters.
/// Seen to fail: with the constraint modes' sign reversed.
#[test]
fn craig_bampton_component_converges_to_the_full_model() {
    let (model, tip, fixed) = beam_with_fixed_tip();
    let full = lowest_modes(&model.stiffness, &model.mass, 6, 0.0).expect("converges");
    let worst = |n_modes: usize| {
        let cut_off = 0.5 * (fixed[n_modes - 1] + fixed[n_modes]);
        let reduced =
            CraigBampton::new(&model.stiffness, &model.mass, &displacements(tip), cut_off)
                .expect("clamped");
        let (lambda, _) = reduced.modes().expect("definite");
        let errors = full.lambda.iter().zip(&lambda).map(|(f, r)| r / f - 1.0);
        assert!(
            errors.clone().all(|e| e > -1e-9),
            "reduction can only stiffen"
        );
        println!(
            "below {cut_off:.0} Hz {n_modes} modes, errors {:.1e}",
            errors.clone().fold(0.0, f64::max)
        );
        errors.fold(0.0, f64::max)
    };
    let errors = [6, 12, 24, 48, 96, 176].map(worst);
    assert!(
        errors[1] < 0.2 * errors[0] && errors[2] < 0.2 * errors[1],
        "{errors:?}"
    );
    assert!(
        errors[5] < 1e-8 && errors.windows(2).all(|w| w[1] <= w[0] + 1e-9),
        "{errors:?}"
    );

    let reduced = CraigBampton::new(&model.stiffness, &model.mass, &displacements(tip), 0.0)
        .expect("clamped");
    let mut u = Mat::zeros(model.n_dofs(), 3);
    tip.iter()
        .enumerate()
        .for_each(|(i, &dof)| u[(dof, i)] = 1.0);
    model
        .stiffness
        .sp_cholesky(faer::Side::Lower)
        .expect("clamped")
        .solve_in_place(&mut u);
    let unit = &reduced.stiffness * Mat::from_fn(3, 3, |i, j| u[(tip[i], j)]);
    assert!(
        (unit - Mat::<f64>::identity(3, 3)).norm_max() < 1e-9,
        "static condensation is exact"
    );
}

/// Mean displacements of the halves of a beam's end face as masters: their compliance to forces that are spread with the
/// same weights is that of the full model, the modes with all means held are those of the constrained full model, and
/// with all modes the component is the full model.
/// Seen to fail: with the pivot's row of the map without the division by its weight.
#[test]
fn means_over_rectangles_are_masters() {
    let mesh = block([0.1, 0.02, 0.01], [4, 4, 1]);
    let model = FeModel::new(mesh, &STEEL, clamped_at_origin).expect("valid");
    let cell = |y: [f64; 2]| Rectangle {
        x: [0.05, 0.1],
        y,
        z: 0.01,
    };
    let cells = [cell([0.0, 0.01]), cell([0.01, 0.02])];
    let masters: Vec<SparseRow> = (cells.iter())
        .flat_map(|cell| model.mean_over(cell).expect("on grid lines"))
        .collect();
    let n = model.n_dofs();
    let weights = Mat::from_fn(n, 6, |dof, k| {
        let own = masters[k].iter().filter(|(d, _)| *d == dof);
        own.map(|(_, w)| w).sum::<f64>()
    });
    for (k, column) in (0..6).map(|k| (k, weights.col(k))) {
        assert!((column.iter().sum::<f64>() - 1.0).abs() < 1e-14, "mean {k}");
    }
    let mut u = weights.clone();
    let factor = model.stiffness.sp_cholesky(faer::Side::Lower);
    factor.expect("clamped").solve_in_place(&mut u);
    let compliance = weights.transpose() * &u;
    let few = CraigBampton::new(&model.stiffness, &model.mass, &masters, 0.0).expect("clamped");
    let unit = &few.stiffness * &compliance;
    let off = (unit - Mat::<f64>::identity(6, 6)).norm_max();
    assert!(off < 1e-9, "statics {off:e}");
    let recovered = (weights.transpose() * &few.basis) - Mat::<f64>::identity(6, 6);
    assert!(
        recovered.norm_max() < 1e-12,
        "means of the constraint modes"
    );

    let all = CraigBampton::new(&model.stiffness, &model.mass, &masters, 1e9).expect("few enough");
    let (lambda, _) = all.modes().expect("definite");
    let full = lowest_modes(&model.stiffness, &model.mass, 20, 0.0).expect("converges");
    for (found, exact) in lambda.iter().zip(&full.lambda) {
        assert!((found / exact - 1.0).abs() < 1e-9, "{found} {exact}");
    }
    let held = (weights.transpose() * &all.basis)
        .subcols(6, all.n_dofs() - 6)
        .norm_max();
    assert!(
        held < 1e-12 * all.basis.norm_max(),
        "modes move the means by {held:e}"
    );
    assert!(
        model.mean_over(&cell([0.0, 0.008])).is_none(),
        "no grid line"
    );
}
