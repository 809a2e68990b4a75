//! Records that are no hysteresis loops are refused with their reason.

use crate::synthetic::{Bench, normal};
use microslip::identify::{IdentifyError, IdentifySettings, TestStatus, identify, identify_test};
use microslip::record::HysteresisRecord;

fn reason(record: &HysteresisRecord) -> String {
    match identify_test(record, &IdentifySettings::default()).status {
        TestStatus::Unusable(reason) => reason,
        other => panic!("{other:?}"),
    }
}

fn random(values: &mut [f64], seed: u64) {
    for (i, value) in values.iter_mut().enumerate() {
        *value = normal(seed, i as u64, 7);
    }
}

/// Seen to fail with any share of a period taken.
#[test]
fn a_random_displacement_is_no_loop() {
    let mut record = Bench::default().record();
    random(&mut record.displacement, 3);
    assert!(
        reason(&record).contains("is no hysteresis loop"),
        "{}",
        reason(&record)
    );
}

/// Seen to fail with noise taken for a force.
#[test]
fn a_random_force_is_no_loop() {
    let mut record = Bench::default().record();
    random(&mut record.tangential_force, 4);
    assert!(reason(&record).contains("is noise"), "{}", reason(&record));
}

/// Seen to fail with either sign taken.
#[test]
fn a_force_of_the_wrong_sign_is_told() {
    let mut record = Bench::default().record();
    record.tangential_force.iter_mut().for_each(|t| *t = -*t);
    assert!(reason(&record).contains("sign"), "{}", reason(&record));
    let mut record = Bench::default().record();
    record.normal_force.iter_mut().for_each(|n| *n = -*n);
    assert!(
        reason(&record).contains("compression is positive"),
        "{}",
        reason(&record)
    );
}

/// A normal force that is nearly lost for a part of the record, so that T/N is anything.
fn without_load(share: f64, force: f64) -> HysteresisRecord {
    let mut record = Bench::default().record();
    let lost = record.normal_force.len() as f64 * share;
    let kept = record.normal_force.len() - lost as usize;
    record.normal_force[kept..].fill(force);
    record
}

/// Seen to fail with an interval up to NaN, and nothing said of it.
#[test]
fn cycles_that_agree_on_nothing_are_no_test() {
    let reason = reason(&without_load(0.3, 0.0));
    let expected =
        "has cycles so different from each other that nothing is known of the friction coefficient";
    assert_eq!(reason, expected);
}

/// Seen to fail without the note, and with the cycles as the reason where it is the stated error of the cells.
#[test]
fn a_friction_coefficient_that_is_hardly_known_is_told() {
    let found = identify_test(&without_load(0.1, 60.0), &IdentifySettings::default());
    let told = |note: &String| note.starts_with("the friction coefficient is only known to ");
    assert!(found.notes.iter().any(told), "{:?}", found.notes);
    let differs = |note: &String| told(note) && note.ends_with("differs from cycle to cycle");
    assert!(found.notes.iter().any(differs), "{:?}", found.notes);
    let found = identify_test(&Bench::default().record(), &IdentifySettings::default());
    assert!(!found.notes.iter().any(told), "{:?}", found.notes);
    let coarse = IdentifySettings {
        force_error_percent: 4.0,
        ..IdentifySettings::default()
    };
    let found = identify_test(&Bench::default().record(), &coarse);
    let stated = |note: &String| told(note) && note.ends_with("is stated to be no better");
    assert!(found.notes.iter().any(stated), "{:?}", found.notes);
}

/// Seen to fail among noise without the rule of a stated frequency.
#[test]
fn part_of_a_period_is_no_loop() {
    let mut record = Bench::default().record();
    record.conditions.frequency_hz = Some(100.0);
    for column in [
        &mut record.time,
        &mut record.displacement,
        &mut record.tangential_force,
        &mut record.normal_force,
    ] {
        column.truncate(300);
    }
    assert!(
        reason(&record).contains("shorter than one period"),
        "{}",
        reason(&record)
    );
    // among noise a third of a period is hardly periodic, and still a part of one
    let mut third = Bench {
        noise: [3e-6, 0.5, 0.5],
        ..Bench::default()
    }
    .record();
    third.conditions.frequency_hz = Some(100.0);
    for column in [
        &mut third.time,
        &mut third.displacement,
        &mut third.tangential_force,
        &mut third.normal_force,
    ] {
        column.truncate(120);
    }
    assert!(
        reason(&third).contains("shorter than one period"),
        "{}",
        reason(&third)
    );
    record.conditions.frequency_hz = None;
    for column in [
        &mut record.time,
        &mut record.displacement,
        &mut record.tangential_force,
        &mut record.normal_force,
    ] {
        column.truncate(150);
    }
    assert!(
        reason(&record).contains("state the frequency"),
        "{}",
        reason(&record)
    );
}

/// Seen to fail with bad tests alone taken.
#[test]
fn one_bad_test_is_data_and_only_bad_ones_are_an_error() {
    let good = Bench::default().record();
    let mut bad = Bench::default().record();
    bad.name = "bad".to_owned();
    random(&mut bad.tangential_force, 4);
    let settings = IdentifySettings::default();
    let found = identify(&[bad.clone(), good], &settings).unwrap();
    assert!(
        matches!(found.tests[0].status, TestStatus::Unusable(_)),
        "{:?}",
        found.tests[0].status
    );
    assert!(
        found.notes[0].starts_with("not used: bad "),
        "{:?}",
        found.notes
    );
    let refused = identify(&[bad], &settings).unwrap_err();
    assert!(matches!(refused, IdentifyError::NoTest(_)), "{refused}");
    assert!(
        refused.to_string().contains("no test can be used: bad "),
        "{refused}"
    );
}

/// Seen to fail with settings that are not checked.
#[test]
fn settings_out_of_range_name_their_key() {
    let settings = IdentifySettings {
        series_stiffness_n_per_um: Some(-1.0),
        ..IdentifySettings::default()
    };
    let refused = identify(&[Bench::default().record()], &settings)
        .unwrap_err()
        .to_string();
    assert!(refused.contains("series_stiffness_n_per_um"), "{refused}");
}
