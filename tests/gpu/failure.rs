//! Failures at the start are survived: every one leads to the processor, with a note that says why. Those of lanes: `lanes`.

use crate::device;
use microslip::contact::{Events, FrictionLaw};
use microslip::ensemble::backend::{BackendChoice, BackendSettings, OpenBackend};
use microslip::gpu::{Fault, Gpu, GpuError, GpuSettings, Precision};
use microslip::study::Study;

fn settings(index: usize) -> GpuSettings {
    GpuSettings {
        adapter: Some(index.to_string()),
        ..GpuSettings::default()
    }
}

/// The default study.
fn study() -> Study {
    Study::read("studies/two-blade-strip/study.toml".as_ref()).unwrap()
}

/// Why the processor solves `study`, if it does.
fn reason(study: &Study, choice: BackendChoice, gpu: GpuSettings) -> Option<String> {
    let prepared = study.prepared().unwrap();
    let settings = BackendSettings { choice, gpu };
    OpenBackend::open(&settings, &prepared.ensemble(None))
        .report()
        .reason
}

/// Seen to fail with: a self-test that ignores what it finds.
#[test]
fn a_wrong_device_is_not_used() {
    let Some(device) = device("a_wrong_device_is_not_used", Precision::F32) else {
        return;
    };
    let index = device.adapter.index;
    let fault = Some(Fault::WrongSelfTest);
    let opened = Gpu::open(GpuSettings {
        fault,
        ..settings(index)
    });
    assert!(
        matches!(opened, Err(GpuError::SelfTest { .. })),
        "{opened:?}"
    );
    let gpu = GpuSettings {
        fault,
        ..settings(index)
    };
    let why = reason(&study(), BackendChoice::Gpu, gpu).unwrap();
    assert!(why.contains("self-test"), "{why}");
}

/// `auto` leaves every study to the processor; `gpu` takes what is named. An adapter that is not there, and a law without shader lead to
/// the processor.
/// Seen to fail with: the self-test of another law; an `auto` that opens what is named.
#[test]
fn the_choice_says_why_it_is_the_processor() {
    let study = study();
    let mut sampled = study.clone();
    (sampled.solver.aft.law, sampled.solver.aft.events) = (FrictionLaw::Box, Events::Sampled);
    let absent = GpuSettings {
        adapter: Some("no such adapter".to_owned()),
        ..GpuSettings::default()
    };
    let why = reason(&study, BackendChoice::Gpu, absent.clone()).unwrap();
    assert!(why.contains("no such adapter"), "{why}");
    let why = reason(&study, BackendChoice::Auto, absent).unwrap();
    assert!(why.contains("as long as none saves time"), "{why}");
    assert_eq!(
        reason(&study, BackendChoice::Cpu, GpuSettings::default()),
        None
    );
    let Some(device) = device("the_choice_says_why_it_is_the_processor", Precision::F32) else {
        return;
    };
    let named = settings(device.adapter.index);
    assert_eq!(reason(&study, BackendChoice::Gpu, named.clone()), None);
    let why = reason(&sampled, BackendChoice::Gpu, named).unwrap();
    assert!(why.contains("no shader"), "{why}");
}
