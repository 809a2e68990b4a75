//! Rules of all formats: signals that are no test of a contact are refused with one clear message.

use microslip::record::HysteresisRecord;

use crate::contact::{contact, read_as};
use crate::csv::written;

/// The message on a test that a change has spoilt.
fn refused(change: impl FnOnce(&mut HysteresisRecord)) -> String {
    let mut test = contact("rig");
    change(&mut test);
    let read = read_as("rig.csv", written(&[test]).as_bytes());
    read.map_or_else(|error| error.to_string(), |_| "is read".to_owned())
}

fn assert_says(message: &str, rule: &str) {
    assert!(message.contains("rig.csv"), "{message}");
    assert!(message.contains(rule), "{message} lacks {rule}");
}

/// Seen to fail without the question whether forces are exchanged: the message was on an open contact.
#[test]
fn exchanged_forces_are_noticed() {
    let message =
        refused(|test| std::mem::swap(&mut test.normal_force, &mut test.tangential_force));
    assert_says(
        &message,
        "normal force changes its sign and tangential force does not: are the two exchanged?",
    );
    // with an offset above its swing, the tangential force changes its sign no more
    let message = refused(|test| {
        test.tangential_force.iter_mut().for_each(|t| *t += 200.0);
        std::mem::swap(&mut test.normal_force, &mut test.tangential_force);
    });
    assert_says(
        &message,
        "normal force does more work over the relative displacement than tangential force: are the two exchanged?",
    );
}

/// Seen to fail without each of the rules.
#[test]
fn a_normal_force_is_positive_in_compression() {
    let message = refused(|test| test.normal_force.iter_mut().for_each(|n| *n = -*n));
    assert_says(
        &message,
        "normal force is negative: must be positive in compression; change its sign",
    );
    let message = refused(|test| test.normal_force.fill(0.0));
    assert_says(&message, "normal force is <= 0 in 100 % of the samples");
    let message = refused(|test| {
        test.normal_force
            .iter_mut()
            .step_by(2)
            .for_each(|n| *n = -0.1)
    });
    assert_says(
        &message,
        "normal force is <= 0 in 50 % of the samples: must be positive (compression) in 60 %",
    );
}

/// While a contact is open nothing pulls at it. Seen to fail without the rule: a friction coefficient of 0.92 in place of 0.6 for a
/// normal force of -5 N in every third sample.
#[test]
fn an_open_contact_carries_no_force() {
    let every_third = refused(|test| {
        let third = test.normal_force.iter_mut().step_by(3);
        third.for_each(|n| *n = -5.0);
    });
    let rule = "an open contact carries none; is the zero of the normal force right?";
    assert_says(&every_third, rule);
    assert_says(
        &every_third,
        ":3: normal force is <= 0 in 34 % of the samples, in which tangential force changes by",
    );
    let last_part = refused(|test| {
        let n = test.normal_force.len();
        test.normal_force[n * 7 / 10..].fill(0.0);
    });
    assert_says(&last_part, rule);
    let open = |test: &mut HysteresisRecord| {
        for (i, n) in test.normal_force.iter_mut().enumerate() {
            if i % 64 < 12 {
                *n = 0.0;
                test.tangential_force[i] = 3.0;
            }
        }
    };
    assert_eq!(
        refused(open),
        "is read",
        "a contact may be open for a while"
    );
    let single = refused(|test| test.normal_force[9] = 0.0);
    assert_eq!(single, "is read", "a spike");
}

/// Gross slip has no correlation, elastic contacts have no work. Seen to fail without each of the two.
#[test]
fn a_force_grows_with_the_displacement() {
    let rule = "tangential force falls where relative displacement grows";
    let message = refused(|test| test.tangential_force.iter_mut().for_each(|t| *t = -*t));
    assert_says(&message, rule);
    let slip = |test: &mut HysteresisRecord, sign: f64| {
        let phase = |t: &f64| (std::f64::consts::TAU * 100.0 * t).cos();
        let force = test.time.iter().map(|t| 50.0 * sign * phase(t));
        test.tangential_force = force.collect();
    };
    assert_says(&refused(|test| slip(test, -1.0)), rule);
    assert_eq!(refused(|test| slip(test, 1.0)), "is read", "gross slip");
    let message = refused(|test| {
        let elastic = test.displacement.iter().map(|x| -3e6 * x);
        test.tangential_force = elastic.collect();
    });
    assert_says(&message, rule);
    let message = refused(|test| {
        let elastic = test.displacement.iter().map(|x| 3e6 * x);
        test.tangential_force = elastic.collect();
    });
    assert_eq!(
        message, "is read",
        "whether there is slip is not asked here"
    );
}

/// Seen to fail with limits a thousand times wider.
#[test]
fn units_that_cannot_be_meant_are_noticed() {
    let message = refused(|test| test.displacement.iter_mut().for_each(|x| *x *= 1e6));
    assert_says(&message, "relative displacement changes by");
    assert_says(&message, "is its unit right?");
    let message = refused(|test| test.displacement.fill(1e-6));
    assert_says(
        &message,
        "relative displacement changes by 0e0 m: must change by 1e-10 to 1e-1 m",
    );
    let message = refused(|test| test.tangential_force.fill(3.0));
    assert_says(&message, "tangential force changes by 0e0 N");
    let message = refused(|test| test.normal_force[5] = -1e8);
    assert_says(
        &message,
        ":8: normal force = -1e8 N: must be at most 1e7 N in size",
    );
}
