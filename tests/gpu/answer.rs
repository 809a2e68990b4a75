//! Is it the same answer? A part of the default study on both backends, and what a failing device leaves of it.

use crate::device;
use microslip::contact::FrictionLaw;
use microslip::ensemble::Ensemble;
use microslip::ensemble::backend::{BackendChoice, BackendSettings, OpenBackend};
use microslip::ensemble::outcome::SampleOutcome;
use microslip::gpu::{Fault, GpuReport, GpuSettings, Precision};
use microslip::study::Study;

/// Largest relative difference of frequency and amplitude between the backends.
const AGREEMENT: f64 = 1e-9;

/// The first samples of the default study, stuck, slipping and lifting.
fn outcomes(
    law: FrictionLaw,
    samples: u64,
    settings: Option<GpuSettings>,
) -> (Vec<SampleOutcome>, Option<GpuReport>) {
    let mut study = Study::read("studies/two-blade-strip/study.toml".as_ref()).unwrap();
    study.solver.aft.law = law;
    let prepared = study.prepared().unwrap();
    let choice = match settings {
        Some(_) => BackendChoice::Gpu,
        None => BackendChoice::Cpu,
    };
    let backend = BackendSettings {
        choice,
        gpu: settings.unwrap_or_default(),
    };
    let backend = OpenBackend::open(&backend, &study.solver);
    let ensemble = Ensemble {
        curve_samples: 0,
        ..prepared.ensemble(backend.gpu())
    };
    let outcomes = backend.run(&ensemble, samples, || {}).unwrap();
    (outcomes, backend.report().gpu)
}

fn assert_agreement(found: &[SampleOutcome], expected: &[SampleOutcome]) {
    let mut largest = [0.0f64; 2];
    assert_eq!(found.len(), expected.len(), "no sample is lost");
    for (a, b) in found.iter().zip(expected) {
        for (a, b) in a.levels.iter().zip(&b.levels) {
            assert_eq!(a.status, b.status, "statuses");
            let (Some(a), Some(b)) = (&a.peak, &b.peak) else {
                assert!(a.peak.is_none() && b.peak.is_none(), "both or none");
                continue;
            };
            largest[0] = largest[0].max((a.frequency_hz / b.frequency_hz - 1.0).abs());
            largest[1] = largest[1].max((a.amplitude_m / b.amplitude_m - 1.0).abs());
        }
    }
    eprintln!(
        "largest differences: frequency {:.1e}, amplitude {:.1e}",
        largest[0], largest[1]
    );
    assert!(largest.iter().all(|d| *d <= AGREEMENT), "{largest:?}");
}

fn settings(adapter: &str, fault: Option<Fault>) -> GpuSettings {
    GpuSettings {
        adapter: Some(adapter.to_owned()),
        precision: Precision::F32,
        audit: 0.1,
        turns: 2,
        fault,
        ..GpuSettings::default()
    }
}

#[test]
fn both_backends_give_the_same_answer() {
    let Some(device) = device("both_backends_give_the_same_answer", Precision::F32) else {
        return;
    };
    let index = device.adapter.index.to_string();
    drop(device);
    for (law, samples, difference) in [(FrictionLaw::Circle, 8, 1e-4), (FrictionLaw::Box, 16, 1e-5)]
    {
        let (expected, _) = outcomes(law, samples, None);
        let (found, report) = outcomes(law, samples, Some(settings(&index, None)));
        assert_agreement(&found, &expected);
        let report = report.expect("the device was used");
        assert!(
            report.evaluations > 10 && report.batches < report.evaluations,
            "{report:?}"
        );
        assert!(report.audited > 0 && report.beyond_limit == 0, "{report:?}");
        assert!(report.largest_force_difference < difference, "{report:?}");
        assert!(
            report.fallbacks == 0 && report.notes.is_empty(),
            "{report:?}"
        );
    }
    let (expected, _) = outcomes(FrictionLaw::Box, 12, None);
    // a device that is lost, drafts that are wrong: the same answer
    for fault in [Fault::LoseDeviceAfter(3), Fault::WrongDrafts] {
        let all_audited = GpuSettings {
            audit: 1.0,
            ..settings(&index, Some(fault))
        };
        let (found, report) = outcomes(FrictionLaw::Box, 12, Some(all_audited));
        assert_agreement(&found, &expected);
        let report = report.expect("the device was used");
        assert_eq!(report.notes.len(), 1, "{report:?}");
        assert_eq!(
            report.beyond_limit > 0,
            fault == Fault::WrongDrafts,
            "{report:?}"
        );
    }
}
