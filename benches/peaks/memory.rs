//! Memory of a large study.

use crate::rig::{LEVELS, Rig, design, settings};
use crate::truncation::CERTIFIED;
use microslip::ensemble::atlas::{Anchor, Atlas};
use microslip::ensemble::backend::BackendReport;
use microslip::ensemble::outcome::SampleOutcome;
use microslip::ensemble::store::{Provenance, write_samples};
use microslip::hb::HbSettings;
use microslip::report::asked::Bands;
use microslip::report::asked::Requirements;
use microslip::report::run::{DesignRecord, FileRecord, InputRecord, LinearRecord};
use microslip::report::{self, ReportInput, RunRecord};
use microslip::sampling::{DesignKind, Growth};

/// Peak of the memory with the results of 100 000 samples, the largest atlas and what writes them.
pub(crate) fn memory() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(17), settings(5, Some(CERTIFIED)));
    let ensemble = rig.ensemble(&design, &LEVELS, &settings);
    let few: Vec<_> = (0..4)
        .map(|index| ensemble.sample(index, &Atlas::default()))
        .collect();
    let atlas: Atlas = (0..1024).map(|i| few[i % 4].1.clone()).collect();
    let outcomes: Vec<(SampleOutcome, Option<Anchor>)> = (0..100_000)
        .map(|index| {
            let mut outcome = few[index as usize % 4].0.clone();
            outcome.index = index;
            (outcome, None)
        })
        .collect();
    let (outcomes, _): (Vec<SampleOutcome>, Vec<Option<Anchor>>) = outcomes.into_iter().unzip();
    let folder = tempfile::tempdir().expect("a folder");
    let provenance = provenance(&settings);
    let names = ["stiffness-scale", "friction-coefficient"].map(str::to_owned);
    write_samples(
        &folder.path().join("samples.parquet"),
        &provenance,
        &names,
        &outcomes,
    )
    .expect("written");
    let record = record(provenance, &names);
    let input = ReportInput {
        record: &record,
        outcomes: &outcomes,
        mixed: &[],
        control: &[],
        changed: &[],
        folder: "results",
    };
    report::write(folder.path(), &input).expect("written");
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find(|line| line.starts_with("VmHWM"));
    println!(
        "{} samples x {} levels: {}",
        outcomes.len(),
        LEVELS.len(),
        peak.unwrap_or("the system does not tell")
    );
    drop(atlas);
}

fn record(provenance: Provenance, names: &[String]) -> RunRecord {
    let linear = |frequency_hz: f64| LinearRecord {
        frequency_hz: Some(frequency_hz),
        curve: Vec::new(),
    };
    let input = |name: &String| InputRecord {
        name: name.clone(),
        prior: String::new(),
        origin: None,
        distribution: None,
    };
    RunRecord {
        provenance,
        backend: BackendReport::default(),
        static_load: None,
        disk: None,
        inputs: names.iter().map(input).collect(),
        design: DesignRecord {
            kind: DesignKind::MonteCarlo,
            description: "monte-carlo".to_owned(),
            independent: true,
            growth: Growth::Any,
            outer_points: 1,
            further_points: 0,
            mixed_inputs: Vec::new(),
            correlated: false,
        },
        frequency_tolerance: 3e-7,
        levels: LEVELS.to_vec(),
        curve_samples: 0,
        bands: Bands::default(),
        level_unit: "N".to_owned(),
        free: linear(2600.0),
        stuck: linear(2620.0),
        nominal: None,
        one_at_a_time: None,
        components: Vec::new(),
        contact_grid: None,
        finer_grid: None,
        requirements: Requirements::default(),
        stopping: None,
        surrogate: None,
        control_variate: None,
        study_file: FileRecord::of("study.toml", b""),
        files: Vec::new(),
        tables: Vec::new(),
        wall_time_s: 0.0,
    }
}

fn provenance(settings: &HbSettings) -> Provenance {
    Provenance {
        study: "memory".to_owned(),
        seed: 17,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: None,
        instruction_set: "avx2".to_owned(),
        other_programs: Vec::new(),
        model: "two blades with a strip damper".to_owned(),
        law: settings.aft.law,
        events: settings.aft.events,
        anchor: settings.anchor,
        harmonics: settings.harmonics.orders().to_vec(),
        time_points: settings.aft.n_time,
        folded: true,
        truncation_threshold: settings.alert.map(|alert| alert.threshold),
        highest_harmonic: settings.alert.map(|alert| alert.highest_harmonic),
        compared_with: settings.alert.map(|alert| alert.compared_with),
        followed_modes: Vec::new(),
        peak_mode: None,
    }
}
