//! The parts of one Newton iteration, and what a strip of its own costs.

use crate::clock::milliseconds;
use crate::rig::{Rig, search, settings};
use microslip::aft::Want;
use microslip::ensemble::Strips;
use microslip::hb::newton::Iterate;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::{Balance, LinearModel, Solution};
use microslip::model::interface::InterfaceSettings;
use microslip::model::two_blade::{TwoBladeSettings, build};

pub(crate) fn parts() {
    println!("pairs  H    compliance  contact  motion  Jacobian and two solves (ms, fastest of 5)");
    for (grid, highest) in [
        ([5, 3], 3),
        ([5, 3], 5),
        ([5, 3], 9),
        ([5, 3], 21),
        ([4, 7], 5),
        ([5, 9], 5),
    ] {
        let rig = Rig::new(grid);
        let problem = rig.problem(1.0, 0.4);
        let settings = settings(highest, None);
        let start = track_peaks(&problem, &settings, search(), &[20.0]).expect("modes");
        let Some(solution) = &start[0].solution else {
            println!("{:5} {highest:2}  no peak", 2 * grid[0] * grid[1]);
            continue;
        };
        let balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
        print_iteration(&balance, solution);
    }
}

/// The parts of a Newton iteration at a solution.
pub(crate) fn print_iteration(balance: &Balance<'_>, solution: &Solution) {
    let at = Iterate::new(balance, solution.point());
    let (r, omega, force) = (&at.point.r, at.point.omega, &at.contact.force);
    let times = [
        milliseconds(5, || drop(balance.compliance(omega))),
        milliseconds(5, || drop(balance.contact(r, Want::ForcesAndTangents))),
        milliseconds(5, || {
            drop(balance.motion(&at.compliance, solution.level, r, force));
        }),
        milliseconds(2, || {
            let jacobian = at.jacobian(balance);
            drop(jacobian.solve(&at.residual));
            drop(at.frequency_rate(balance, &jacobian));
        }),
    ];
    let [compliance, contact, motion, jacobian] = times;
    println!(
        "{:5} {:2}  {compliance:10.3} {contact:8.3} {motion:7.3} {jacobian:9.3}",
        balance.layout.n_pairs,
        balance.harmonics.highest()
    );
}

pub(crate) fn strip() {
    let rig = build(&TwoBladeSettings::default()).expect("valid");
    let contacts = InterfaceSettings::default().parameters(&rig.reduced.contacts);
    let nominal = LinearModel::of(&rig.reduced, &contacts, true).expect("definite");
    let reduced = milliseconds(10, || drop(rig.with_strip(0.5)));
    let strips = Strips {
        rig,
        contacts,
        mirror: true,
    };
    let folded = milliseconds(10, || drop(strips.linear(0.5, &nominal)));
    println!(
        "{reduced:.1} ms to reduce a strip, {folded:.1} ms with folding and modes (fastest of 5)"
    );
}
