//! The numbers of a disk over its engine orders: `disk.json`.

use crate::report::assessment::Assessment;
use crate::report::numbers::margins::OrderMargin;
use crate::report::numbers::population::Populations;
use crate::report::numbers::several_answers::SeveralAnswers;
use crate::report::numbers::stability::StabilityCounts;
use crate::report::numbers::summary::Summary;
use crate::report::run::input::ReportInput;
use crate::report::run::record::{DiskRecord, NodalRecord, RunRecord};
use crate::report::run::stored_run::{CHANGED, StoredRun};
use crate::report::verdict::criterion_result::{CriterionResult, LevelResult};
use serde::Serialize;
use std::path::Path;

/// Probabilities of a scatter bar.
const BAR: [f64; 2] = [0.01, 0.99];

/// What the runs of a disk say together.
#[derive(Debug, Clone, Serialize)]
pub struct DiskSummary {
    /// Number of sectors.
    pub sectors: usize,
    /// Excitation levels of every run.
    pub levels: Vec<f64>,
    /// Unit of the levels.
    pub level_unit: String,
    /// Range of the speed, that of every run (1/min).
    pub speed_rpm: [f64; 2],
    /// Speeds that are held (1/min).
    pub dwell_rpm: Vec<f64>,
    /// One entry per run, by engine order.
    pub orders: Vec<OrderSummary>,
    /// Linear frequencies of every nodal diameter at nominal inputs.
    pub nodal_diameters: Vec<NodalRecord>,
}

/// What the run of an engine order says.
#[derive(Debug, Clone, Serialize)]
pub struct OrderSummary {
    /// Engine order.
    pub engine_order: u32,
    /// The nodal diameter that it excites.
    pub nodal_diameter: usize,
    /// Name of its study.
    pub study: String,
    /// Folder of its results, as given.
    pub folder: String,
    /// Number of samples, failed ones included.
    pub samples: usize,
    /// What every probability of this order depends on.
    pub condition: String,
    /// Judgements.
    pub criteria: Vec<CriterionResult>,
    /// One entry per excitation level.
    pub levels: Vec<OrderLevel>,
}

/// An engine order at one excitation level.
#[derive(Debug, Clone, Serialize)]
pub struct OrderLevel {
    /// Excitation level.
    pub level: f64,
    /// Samples without a solution.
    pub failed: usize,
    /// 1 %, 50 % and 99 % quantile of the resonance frequency (Hz), over outer points the lowest, middle and highest; absent
    /// without a solution.
    pub frequency_hz: Option<[f64; 3]>,
    /// The same of the amplitude (m).
    pub amplitude_m: Option<[f64; 3]>,
    /// Margin to the engine order.
    pub margin: Option<OrderMargin>,
    /// How many peaks were assessed for stability, and what was found.
    pub stability: StabilityCounts,
    /// Samples with several solutions at some frequency, of those with a curve.
    pub several_answers: SeveralAnswers,
}

impl DiskSummary {
    /// Gathers the runs of `folders`, which are of one disk.
    ///
    /// # Errors
    /// The place of a run that is not of the disk of the first, or has the engine order of another, and why; place 0 without any
    /// run.
    pub fn of(folders: &[&Path], runs: &[StoredRun]) -> Result<Self, (usize, String)> {
        let Some(first) = runs.first() else {
            return Err((0, "no run is given".to_owned()));
        };
        let mut orders: Vec<OrderSummary> = Vec::new();
        for (i, (folder, run)) in folders.iter().zip(runs).enumerate() {
            let disk = same_disk(first, run).map_err(|reason| (i, reason))?;
            let same_order = |other: &&OrderSummary| other.engine_order == disk.engine_order;
            if let Some(other) = orders.iter().find(same_order) {
                return Err((i, format!("has the engine order of {}", other.folder)));
            }
            let input = run.input();
            let summary = Summary::of(&input);
            let assessment = Assessment::of(&input, &summary);
            orders.push(OrderSummary::of(folder, &input, &summary, assessment, disk));
        }
        orders.sort_by_key(|order| order.engine_order);
        let disk = first.record.disk.as_ref();
        let operation = first.record.requirements.operation.as_ref();
        Ok(Self {
            sectors: disk.map_or(0, |disk| disk.sectors),
            levels: first.record.levels.clone(),
            level_unit: first.record.level_unit.clone(),
            speed_rpm: operation.map_or([0.0; 2], |operation| operation.speed_rpm),
            dwell_rpm: operation.map_or(Vec::new(), |operation| operation.dwell_rpm.clone()),
            orders,
            nodal_diameters: nodal_diameters(runs),
        })
    }
}

/// The disk of `run`, if it is that of `first` at the same levels and speeds, with the same random inputs.
fn same_disk<'a>(first: &StoredRun, run: &'a StoredRun) -> Result<&'a DiskRecord, String> {
    if let Some(name) = run.changed.first() {
        return Err(format!("{name} {CHANGED}"));
    }
    let (first, run) = (&first.record, &run.record);
    let Some(disk) = &run.disk else {
        return Err("is no run of a model of kind \"cyclic\"".to_owned());
    };
    let Some(of_first) = &first.disk else {
        return Err("the first run is none of a model of kind \"cyclic\"".to_owned());
    };
    if disk.sectors != of_first.sectors || !have_the_same(disk, of_first) {
        return Err("has another disk: its sectors or their nominal frequencies differ".to_owned());
    }
    let sectors = disk.sector.as_ref().zip(of_first.sector.as_ref());
    let differ = sectors.is_some_and(|(this, that)| this != that);
    if differ || run.provenance.law != first.provenance.law {
        let what = "[model], [contact] or a file that its study names differs from the first run's";
        return Err(format!("has another sector: {what}"));
    }
    if run.levels != first.levels || run.level_unit != first.level_unit {
        return Err("has other levels".to_owned());
    }
    let inputs = |of: &RunRecord| -> Vec<String> {
        let inputs = of.inputs.iter();
        inputs
            .map(|i| format!("{} ({})", i.name, i.prior))
            .collect()
    };
    let [these, those] = [run, first].map(|of| inputs(of).join(", "));
    if these != those {
        let message = "has other random inputs than the first run";
        return Err(format!("{message}: {these}; there {those}"));
    }
    let speeds = |of: &RunRecord| {
        let operation = of.requirements.operation.as_ref();
        operation.map(|operation| (operation.speed_rpm, operation.dwell_rpm.clone()))
    };
    if speeds(run) != speeds(first) {
        return Err("has another range of speeds, or other speeds that are held".to_owned());
    }
    let base = |of: &RunRecord| {
        let operation = of.requirements.operation.as_ref();
        operation.map(|operation| operation.margin_relative_to)
    };
    if base(run) != base(first) {
        let what = "margins that are relative to something else";
        return Err(format!("has {what}: operation.margin_relative_to differs"));
    }
    Ok(disk)
}

/// Whether two disks have the same nominal frequencies, as far as both state them: the bands of their studies end the lists.
fn have_the_same(one: &DiskRecord, other: &DiskRecord) -> bool {
    let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a == b);
    let diameters = one.nodal_diameters.iter().zip(&other.nodal_diameters);
    let mut pairs = diameters.map(|(a, b)| [(&a.free_hz, &b.free_hz), (&a.stuck_hz, &b.stuck_hz)]);
    one.nodal_diameters.len() == other.nodal_diameters.len()
        && pairs.all(|lists| lists.iter().all(|(a, b)| same(a, b)))
}

/// The longest list of nominal frequencies that one of the `runs` has: that of the highest band.
fn nodal_diameters(runs: &[StoredRun]) -> Vec<NodalRecord> {
    let of_runs = runs.iter().filter_map(|run| run.record.disk.as_ref());
    let lists = of_runs.map(|disk| &disk.nodal_diameters);
    let length = |list: &&Vec<NodalRecord>| list.iter().map(|d| d.stuck_hz.len()).sum::<usize>();
    lists.max_by_key(length).cloned().unwrap_or_default()
}

impl OrderSummary {
    /// What a criterion says, and how often there are several answers at the level that decides.
    #[must_use]
    pub fn sentence(&self, result: &CriterionResult) -> String {
        let at = |deciding: &LevelResult| self.levels.iter().find(|l| l.level == deciding.level);
        match result.deciding().and_then(at) {
            None => result.sentence.clone(),
            Some(level) => format!("{} ({})", result.sentence, level.several_answers.in_words()),
        }
    }

    fn of(
        folder: &Path,
        input: &ReportInput,
        summary: &Summary,
        assessment: Assessment,
        disk: &DiskRecord,
    ) -> Self {
        let levels = assessment.levels.into_iter().zip(&summary.levels);
        let levels = levels.enumerate().map(|(i, (level, counted))| OrderLevel {
            level: level.level,
            failed: counted.failed,
            frequency_hz: Populations::of(input, i, |peak| peak.frequency_hz).scatter(BAR),
            amplitude_m: Populations::of(input, i, |peak| peak.amplitude_m).scatter(BAR),
            margin: level.margins.into_iter().next(),
            stability: StabilityCounts::of(input.outcomes, i),
            several_answers: counted.several_answers,
        });
        Self {
            engine_order: disk.engine_order,
            nodal_diameter: disk.nodal_diameter,
            study: summary.provenance.study.clone(),
            folder: folder.display().to_string(),
            samples: summary.samples,
            condition: assessment.condition,
            levels: levels.collect(),
            criteria: assessment.criteria,
        }
    }
}
