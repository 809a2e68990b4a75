//! The equations in free modes against those of the stuck structure.

use super::lumped_disk::{contacts as of_sector, disk};
use super::models::{aft, space};
use crate::two_blade::folded;
use faer::Mat;
use faer::prelude::*;
use microslip::contact::{ContactParameters, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::equations::balance::ContactResponse;
use microslip::hb::equations::free::{FreeBalance, FreeMotion, StaticReference};
use microslip::hb::equations::jacobian::EXACT;
use microslip::hb::newton::{Condition, Direction, Iterate, Point, solve};
use microslip::hb::{Balance, LinearModel, NewtonSettings, Problem, SliderAnchor};
use microslip::model::disk::CyclicMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Bound on the relative difference of Newton steps, tangents, responses and their derivatives.
const AGREEMENT: f64 = 1e-9;

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |a, x| a.max(x.abs()))
}

fn assert_close(found: &[f64], expected: &[f64], what: &str) {
    let apart: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    let error = largest(&apart) / largest(expected);
    assert!(error < AGREEMENT, "{what}: {error:e}");
}

/// The stuck solution, each displacement changed by up to 30 %.
fn shaken(balance: &Balance<'_>, omega: f64, level: f64, rng: &mut ChaCha8Rng) -> Point {
    let mut point = Point::stuck(balance, omega, level);
    for r in &mut point.r {
        *r *= 1.0 + 0.3 * (2.0 * rng.random::<f64>() - 1.0);
    }
    point
}

/// Both forms at one point: Newton step, and response after it. At a solution, too: tangent of the branch, and derivative of the
/// response along it. (Elsewhere these depend on how the residual changes with the frequency.)
fn assert_same_step(
    balance: &Balance<'_>,
    reference: &StaticReference,
    point: Point,
    is_solution: bool,
) {
    let iterate = Iterate::new(balance, point);
    let jacobian = iterate.jacobian_within(balance, EXACT);
    let [correction, tangent] = iterate.correction_and_frequency_rate(balance, &jacobian);

    let free = FreeBalance::new(balance, reference).expect("diagonal receptances");
    let (point, contact) = (&iterate.point, &iterate.contact);
    let motion = free.motion(point.omega, point.level, &contact.force);
    let factors = jacobian_of(&free, contact, &motion).partial_piv_lu();
    let solve = |b: &[f64]| -> Vec<f64> {
        let x = factors.solve(Col::from_fn(b.len(), |i| -b[i]));
        x.iter().copied().collect()
    };
    let rate = |r: &[f64], omega: f64| {
        let free = free.response_rate(&motion, &free.contact_rate(contact, r), omega);
        let r = r.to_vec();
        let direction = Direction { r, omega };
        let stuck = iterate.response_rate(balance, &jacobian, &direction, 0.0);
        [free, stuck]
    };
    let assert_same = |[found, expected]: [c64; 2], what: &str| {
        let error = (found - expected).norm() / expected.norm();
        assert!(error < AGREEMENT, "{what}: {error:e}");
    };
    if is_solution {
        assert_close(&solve(&free.frequency_slope(&motion)), &tangent, "tangent");
        assert_same(rate(&tangent, 1.0), "response along the branch");
    } else {
        let residual = free.residual(&motion, &point.r, &contact.force);
        assert_close(&solve(&residual), &correction, "Newton step");
    }
    let [free_rate, stuck_rate] = rate(&correction, 0.0);
    let after = [
        free.response(&motion) + free_rate,
        iterate.response(balance) + stuck_rate,
    ];
    assert_same(after, "response after the step");
}

/// J, column by column.
fn jacobian_of(free: &FreeBalance<'_>, contact: &ContactResponse, motion: &FreeMotion) -> Mat<f64> {
    let size = free.balance.layout.n_unknowns();
    let mut matrix = Mat::zeros(size, size);
    for j in 0..size {
        let mut unit = vec![0.0; size];
        unit[j] = 1.0;
        let rate = free.contact_rate(contact, &unit);
        let product = free.product(motion, &unit, &rate);
        matrix.col_as_slice_mut(j).copy_from_slice(&product);
    }
    matrix
}

/// A sector of the lumped disk, whose damping is a sum of mass and stiffness, under an engine order.
fn sector(n_sectors: usize, engine_order: usize) -> LinearModel {
    let mut disk = disk(n_sectors);
    let [
        CyclicMatrix::Neighbours { own: mass, .. },
        CyclicMatrix::Neighbours { own, next },
    ] = [&disk.mass, &disk.stiffness]
    else {
        panic!("the lumped disk has matrices of neighbours")
    };
    let damping = CyclicMatrix::Neighbours {
        own: Scale(0.5) * mass + Scale(2e-6) * own,
        next: Scale(2e-6) * next,
    };
    disk.damping = damping;
    LinearModel::travelling_wave(&disk, engine_order).expect("definite")
}

/// Two laws, stuck to open contacts; a whole model, a folded one and travelling waves, reference springs that are not those of the
/// sample, a static load of its own. Seen to fail with K_ref in place of the sample's springs in the derivative, without the images in
/// the load, with the sine of a motion taken with the other sign, and with the conjugate of a wave's shapes in the loads.
#[test]
fn newton_steps_are_those_of_the_stuck_form() {
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    let whole = space().with_contacts(1.0, 0.3);
    let whole_linear = LinearModel::new(&whole.model).expect("definite");
    let (folded, contacts) = folded(1.0, 0.4);
    let (wave, backwards) = (sector(6, 1), sector(5, 4));
    let cases = [
        (&whole_linear, whole.contacts, [10.0, 60.0], 345.0),
        (&folded, contacts, [1.0, 20.0], 2620.0),
        (&wave, of_sector(2), [1.0, 40.0], 330.0),
        (&backwards, of_sector(2), [1.0, 40.0], 330.0),
    ];
    for (linear, contacts, levels, hertz) in cases {
        let problem = |contacts, load| {
            Problem::new(linear, contacts, load, SliderAnchor::Unloaded).expect("held")
        };
        let reference = StaticReference::new(&problem(contacts.clone(), 1.0));
        let softer = |c: &ContactParameters<f64>| ContactParameters {
            k_n: 0.4 * c.k_n,
            k_t: c.k_t.map(|k| 0.7 * k),
            ..*c
        };
        let own = problem(contacts.iter().map(softer).collect(), 1.3);
        for law in [FrictionLaw::Box, FrictionLaw::Circle] {
            let balance = Balance::new(&own, HarmonicSet::up_to(2), aft(64, law));
            for level in levels {
                let omega = TAU * hertz;
                let point = shaken(&balance, omega, level, &mut rng);
                assert_same_step(&balance, &reference, point, false);
                let (start, newton) = (
                    Point::stuck(&balance, omega, level),
                    NewtonSettings::default(),
                );
                let solved = solve(&balance, start, Condition::FixedFrequency, newton);
                assert_same_step(&balance, &reference, solved.expect("solved").point, true);
            }
        }
    }
}

/// Damping that couples modes has no diagonal receptance.
#[test]
fn coupled_modes_have_no_free_form() {
    let mut case = space().with_contacts(1.0, 0.3);
    case.model.damping[(0, 0)] += 20.0;
    let linear = LinearModel::new(&case.model).expect("definite");
    let problem = Problem::new(&linear, case.contacts, 1.0, SliderAnchor::Unloaded).expect("held");
    let balance = Balance::new(&problem, HarmonicSet::up_to(1), aft(64, FrictionLaw::Box));
    let reference = StaticReference::new(&problem);
    assert!(FreeBalance::new(&balance, &reference).is_none());
}
