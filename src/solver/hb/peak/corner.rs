//! A maximum at a corner of the branch, where the growth of the amplitude jumps: secants hardly come closer to it.
//!
//! Between two solutions with growths of either sign lies a maximum. A solution halfway, on a plane normal to the chord of both, takes
//! the place of the one whose sign it has, so that every step halves the way whatever the branch does between them. Newton's method
//! may fail on the corner itself; then a plane beside it is taken, and at last a larger residual: at a jump it does not change signs.

use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Direction, Iterate, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;

/// Most halvings of the way between two solutions.
const MOST_HALVINGS: usize = 60;
/// Shares of the way between two solutions at which the next one is sought.
const SHARES: [f64; 5] = [0.5, 0.3, 0.7, 0.1, 0.9];

/// The maximum between two solutions of one branch, up to a relative `tolerance` of the frequency: the amplitude grows at the first and
/// falls at the second. The settings of Newton's method are tried one after the other.
///
/// # Errors
/// The status of a solve that failed, unless both solutions are one up to ten times the tolerance of the frequency.
pub(super) fn maximum_between<'p>(
    balance: &Balance<'p>,
    [mut from, mut to]: [BranchPoint<'p>; 2],
    tolerance: f64,
    newton: [NewtonSettings; 2],
) -> Result<Iterate<'p>, Status> {
    let apart = |from: &BranchPoint<'_>, to: &BranchPoint<'_>| {
        let [a, b] = [from, to].map(|end| end.iterate.point.omega);
        (a / b - 1.0).abs()
    };
    let mut halvings = 0;
    while apart(&from, &to) > tolerance {
        let middle = match halvings < MOST_HALVINGS {
            true => between(balance, [&from, &to], newton),
            false => Err(Status::MaxIterations),
        };
        match middle {
            Ok(middle) if middle.growth() > 0.0 => from = middle,
            Ok(middle) => to = middle,
            Err(_) if apart(&from, &to) <= 10.0 * tolerance => break,
            Err(status) => return Err(status),
        }
        halvings += 1;
    }
    let higher = match from.response.norm() > to.response.norm() {
        true => from,
        false => to,
    };
    Ok(higher.iterate)
}

/// A solution between two, in the metric of the first.
fn between<'p>(
    balance: &Balance<'p>,
    [from, to]: [&BranchPoint<'p>; 2],
    newton: [NewtonSettings; 2],
) -> Result<BranchPoint<'p>, Status> {
    let base = &from.iterate.point;
    let way = Direction::between(base, &to.iterate.point);
    let length = from.metric.length(&way);
    let chord = way.scaled(1.0 / length);
    let mut failure = Status::MaxIterations;
    let tries = (newton.iter()).flat_map(|newton| SHARES.map(|share| (*newton, share)));
    for (newton, share) in tries {
        let condition = Condition::ArcLength {
            base,
            tangent: &chord,
            step: share * length,
            metric: from.metric,
        };
        match solve(balance, base.moved(&way, share), condition, newton) {
            Ok(found) => {
                let found = BranchPoint::in_metric(balance, found, from.metric);
                return Ok(found.following(&chord));
            }
            Err(status) => failure = status,
        }
    }
    Err(failure)
}
