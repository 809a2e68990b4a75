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

/// The default study with so many samples.
fn study(samples: u64) -> Study {
    let path = "studies/two-blade-strip/study.toml";
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("samples = 200", &format!("samples = {samples}"));
    Study::parse(path.as_ref(), &text).unwrap()
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
    let why = reason(&study(200), BackendChoice::Gpu, gpu).unwrap();
    assert!(why.contains("self-test"), "{why}");
}

/// `auto` never takes software, named or not, and leaves small studies to the processor; `gpu` takes what is named. An adapter that
/// is not there, and a law without shader lead to the processor.
/// Seen to fail with: the check of hardware left out; the self-test of another law.
#[test]
fn the_choice_says_why_it_is_the_processor() {
    let [small, large] = [200, 2000].map(study);
    let mut sampled = small.clone();
    (sampled.solver.aft.law, sampled.solver.aft.events) = (FrictionLaw::Box, Events::Sampled);
    let absent = GpuSettings {
        adapter: Some("no such adapter".to_owned()),
        ..GpuSettings::default()
    };
    let why = reason(&small, BackendChoice::Gpu, absent.clone()).unwrap();
    assert!(why.contains("no such adapter"), "{why}");
    let why = reason(&large, BackendChoice::Auto, absent.clone()).unwrap();
    assert!(why.contains("no such adapter"), "{why}");
    let why = reason(&small, BackendChoice::Auto, absent).unwrap();
    assert!(why.contains("200 samples are too few"), "{why}");
    assert_eq!(
        reason(&large, BackendChoice::Cpu, GpuSettings::default()),
        None
    );
    let Some(device) = device("the_choice_says_why_it_is_the_processor", Precision::F32) else {
        return;
    };
    let named = settings(device.adapter.index);
    if !device.adapter.is_hardware() {
        let why = reason(&large, BackendChoice::Auto, named.clone()).unwrap();
        assert!(why.contains("software"), "{why}");
        assert_eq!(reason(&small, BackendChoice::Gpu, named.clone()), None);
    }
    let why = reason(&sampled, BackendChoice::Gpu, named).unwrap();
    assert!(why.contains("no shader"), "{why}");
}
