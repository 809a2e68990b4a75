//! Failures are survived: every one leads to the processor, with a note that says why.

use crate::device;
use crate::states::{located, random};
use microslip::aft::{AftForces, AftScratch, Drafts, Want, evaluate};
use microslip::contact::{Events, FrictionLaw};
use microslip::ensemble::backend::{BackendChoice, BackendSettings, OpenBackend};
use microslip::gpu::{Fault, Gpu, GpuError, GpuSettings, Precision};
use microslip::harmonics::HarmonicSet;
use microslip::hb::HbSettings;
use microslip::study::Study;

fn settings(index: usize) -> GpuSettings {
    GpuSettings {
        adapter: Some(index.to_string()),
        turns: 4,
        ..GpuSettings::default()
    }
}

/// The solver of the default study.
fn solver() -> HbSettings {
    let study = Study::read("studies/two-blade-strip/study.toml".as_ref()).unwrap();
    study.solver
}

/// Index of the adapter of the tests.
fn adapter(test: &str) -> Option<usize> {
    device(test, Precision::F32).map(|device| device.adapter.index)
}

/// Whether the device gives a draft, and that it is right.
fn drafts(gpu: &Gpu, states: usize, seed: u64) -> bool {
    let set = HarmonicSet::up_to(2);
    let plan = located::<f64>(&set, 64);
    let batch = random(&set, states, seed);
    let (mut out, mut exact) = (AftForces::default(), AftForces::default());
    let answered = gpu.draft(&plan, &batch, &mut out);
    if answered {
        evaluate(
            &plan,
            &batch,
            Want::ForcesAndTangents,
            &mut AftScratch::default(),
            &mut exact,
        );
        let largest = exact.forces.iter().fold(0.0f64, |a, f| a.max(f.abs()));
        for (a, b) in out.forces.iter().zip(&exact.forces) {
            assert!((a - b).abs() < 1e-5 * largest, "{a} {b}");
        }
    }
    answered
}

/// A lost device is opened again once; after that the processor is asked.
/// Seen to fail with: a lost device that is not noticed.
#[test]
fn a_lost_device_is_opened_again_once() {
    let Some(index) = adapter("a_lost_device_is_opened_again_once") else {
        return;
    };
    let gpu = Gpu::open(settings(index)).unwrap();
    assert!(drafts(&gpu, 40, 1));
    gpu.lose_device();
    assert!(drafts(&gpu, 40, 2), "{:?}", gpu.report().notes);
    gpu.lose_device();
    assert!(!drafts(&gpu, 40, 3));
    assert!(!drafts(&gpu, 40, 4));
    let report = gpu.report();
    assert_eq!(report.fallbacks, 2, "{report:?}");
    assert!(
        report
            .notes
            .iter()
            .any(|note| note.contains("opened again")),
        "{report:?}"
    );
    assert!(
        report.notes.iter().any(|note| note.contains("processor")),
        "{report:?}"
    );
}

/// Batches that the device refuses are halved; one that cannot be halved goes to the processor.
/// Seen to fail with: a limit that is not lowered (it does not end).
#[test]
fn refused_batches_are_halved() {
    let Some(index) = adapter("refused_batches_are_halved") else {
        return;
    };
    let fault = Some(Fault::RefuseAbove(20));
    let gpu = Gpu::open(GpuSettings {
        fault,
        ..settings(index)
    })
    .unwrap();
    std::thread::scope(|scope| {
        for seed in 0..4 {
            let gpu = &gpu;
            scope.spawn(move || {
                let _turn = gpu.turn();
                for round in 0..3 {
                    assert!(
                        drafts(gpu, 16, 10 * seed + round),
                        "small ones are answered"
                    );
                }
            });
        }
    });
    assert!(gpu.report().halved > 0, "{:?}", gpu.report());
    assert_eq!(gpu.report().fallbacks, 0);
    assert!(!drafts(&gpu, 40, 99));
    assert_eq!(gpu.report().fallbacks, 1);
}

/// Seen to fail with: a self-test that ignores what it finds.
#[test]
fn a_wrong_device_is_not_used() {
    let Some(index) = adapter("a_wrong_device_is_not_used") else {
        return;
    };
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
    let backend = BackendSettings {
        choice: BackendChoice::Gpu,
        gpu,
    };
    let report = OpenBackend::open(&backend, &solver()).report();
    assert_eq!(report.adapter(), None);
    assert!(report.reason.unwrap().contains("self-test"));
}

/// `auto` never takes software, named or not; `gpu` takes it when named. An adapter that is not there, and a tolerance
/// coarser than drafts or a law without shader lead to the processor.
/// Seen to fail with: the check of hardware left out; the self-test of another law.
#[test]
fn the_choice_says_why_it_is_the_processor() {
    let reason = |choice, gpu, solver: &HbSettings| {
        let report = OpenBackend::open(&BackendSettings { choice, gpu }, solver).report();
        report.reason
    };
    let solver = solver();
    let mut coarse = solver.clone();
    coarse.newton.tolerance = 1e-2;
    let mut sampled = solver.clone();
    (sampled.aft.law, sampled.aft.events) = (FrictionLaw::Box, Events::Sampled);
    let absent = GpuSettings {
        adapter: Some("no such adapter".to_owned()),
        ..GpuSettings::default()
    };
    let why = reason(BackendChoice::Gpu, absent, &solver).unwrap();
    assert!(why.contains("no such adapter"), "{why}");
    let why = reason(BackendChoice::Gpu, GpuSettings::default(), &coarse).unwrap();
    assert!(why.contains("tolerance"), "{why}");
    assert_eq!(
        reason(BackendChoice::Cpu, GpuSettings::default(), &solver),
        None
    );
    let Some(device) = device("the_choice_says_why_it_is_the_processor", Precision::F32) else {
        return;
    };
    if !device.adapter.is_hardware() {
        let why = reason(BackendChoice::Auto, settings(device.adapter.index), &solver).unwrap();
        assert!(why.contains("software"), "{why}");
        assert_eq!(
            reason(BackendChoice::Gpu, settings(device.adapter.index), &solver),
            None
        );
    }
    let why = reason(BackendChoice::Gpu, settings(device.adapter.index), &sampled).unwrap();
    assert!(why.contains("no shader"), "{why}");
}
