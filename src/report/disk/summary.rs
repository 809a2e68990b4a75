//! The numbers of a disk over its engine orders: `disk.json`.

use crate::report::assessment::Assessment;
use crate::report::numbers::margins::OrderMargin;
use crate::report::numbers::peaks::usable_peak;
use crate::report::numbers::population::Populations;
use crate::report::numbers::summary::Summary;
use crate::report::run::record::{DiskRecord, NodalRecord, RunRecord};
use crate::report::run::stored_run::StoredRun;
use crate::report::verdict::criterion_result::CriterionResult;
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
    /// Lowest and highest speed of all runs (1/min).
    pub speed_rpm: [f64; 2],
    /// Speeds that are held (1/min).
    pub dwell_rpm: Vec<f64>,
    /// One entry per run, by engine order.
    pub orders: Vec<OrderSummary>,
    /// Linear frequencies of every nodal diameter at nominal inputs.
    pub nodal_diameters: Vec<NodalRecord>,
    /// What every probability depends on, of the first run.
    pub condition: String,
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
}

impl DiskSummary {
    /// Gathers the runs of `folders`, which are of one disk.
    ///
    /// # Errors
    /// The place of a run that is not of the disk of the first, and why; place 0 without any run.
    pub fn of(folders: &[&Path], runs: &[StoredRun]) -> Result<Self, (usize, String)> {
        let Some(first) = runs.first() else {
            return Err((0, "no run is given".to_owned()));
        };
        let mut orders = Vec::new();
        let mut speeds: Vec<f64> = Vec::new();
        for (i, (folder, run)) in folders.iter().zip(runs).enumerate() {
            let disk = same_disk(&first.record, &run.record).map_err(|reason| (i, reason))?;
            orders.push(OrderSummary::of(folder, run, disk));
            let operation = run.record.requirements.operation.iter();
            speeds.extend(operation.flat_map(|operation| operation.speed_rpm));
        }
        orders.sort_by_key(|order| order.engine_order);
        let input = first.input();
        let assessment = Assessment::of(&input, &Summary::of(&input));
        let disk = first.record.disk.as_ref();
        let operation = first.record.requirements.operation.as_ref();
        Ok(Self {
            sectors: disk.map_or(0, |disk| disk.sectors),
            levels: first.record.levels.clone(),
            level_unit: first.record.level_unit.clone(),
            speed_rpm: [
                speeds.iter().copied().fold(f64::INFINITY, f64::min),
                speeds.iter().copied().fold(0.0, f64::max),
            ],
            dwell_rpm: operation.map_or(Vec::new(), |operation| operation.dwell_rpm.clone()),
            orders,
            nodal_diameters: disk.map_or(Vec::new(), |disk| disk.nodal_diameters.clone()),
            condition: assessment.condition,
        })
    }
}

/// The disk of `run`, if it is that of `first` at the same levels.
fn same_disk<'a>(first: &RunRecord, run: &'a RunRecord) -> Result<&'a DiskRecord, String> {
    let Some(disk) = &run.disk else {
        return Err("is no run of a model of kind \"cyclic\"".to_owned());
    };
    let Some(of_first) = &first.disk else {
        return Err("the first run is none of a model of kind \"cyclic\"".to_owned());
    };
    if disk.sectors != of_first.sectors || disk.nodal_diameters != of_first.nodal_diameters {
        return Err("has another disk: its sectors or their nominal frequencies differ".to_owned());
    }
    if run.levels != first.levels || run.level_unit != first.level_unit {
        return Err("has other levels".to_owned());
    }
    Ok(disk)
}

impl OrderSummary {
    fn of(folder: &Path, run: &StoredRun, disk: &DiskRecord) -> Self {
        let input = run.input();
        let assessment = Assessment::of(&input, &Summary::of(&input));
        let levels = assessment.levels.into_iter().enumerate();
        let levels = levels.map(|(i, level)| {
            let unsolved = |at: usize| usable_peak(&run.outcomes[at].levels[i]).is_none();
            OrderLevel {
                level: level.level,
                failed: (0..run.outcomes.len()).filter(|&at| unsolved(at)).count(),
                frequency_hz: Populations::of(&input, i, |peak| peak.frequency_hz).scatter(BAR),
                amplitude_m: Populations::of(&input, i, |peak| peak.amplitude_m).scatter(BAR),
                margin: level.margins.into_iter().next(),
            }
        });
        Self {
            engine_order: disk.engine_order,
            nodal_diameter: disk.nodal_diameter,
            study: run.record.provenance.study.clone(),
            folder: folder.display().to_string(),
            samples: run.outcomes.len(),
            levels: levels.collect(),
            criteria: assessment.criteria,
        }
    }
}
