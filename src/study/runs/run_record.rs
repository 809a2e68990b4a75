//! What `run.json` says of a study before its samples.

use super::contact_grid::{contact_grid, finer_grid};
use crate::Error;
use crate::ensemble::Ensemble;
use crate::ensemble::backend::BackendReport;
use crate::ensemble::outcome::CurvePoint;
use crate::ensemble::program::Program;
use crate::ensemble::store::Provenance;
use crate::hb::LinearModel;
use crate::hb::structure::resonance::{Band, linear_resonance, linear_response};
use crate::linalg::LinalgError;
use crate::model::two_blade::ComponentSummary;
use crate::report::RunRecord;
use crate::report::run::record::{DiskRecord, NodalRecord};
use crate::report::run::{
    ComponentRecord, DesignRecord, FileRecord, InputRecord, LinearRecord, StaticLoadRecord,
};
use crate::sampling::DesignKind;
use crate::study::estimate::inspect::{NodalFrequencies, nodal_diameters};
use crate::study::prepared::{FREQUENCY_TOLERANCE, PreparedStudy};
use crate::study::settings::frequency::PeakSetting;
use crate::study::settings::model::{CyclicSettings, ModelSettings, SectorSettings};
use crate::study::settings::read::Study;
use crate::units::rad_s_to_hz;

/// Points of the linear curves in the report, evenly over the band.
const LINEAR_POINTS: usize = 600;
/// Further points on each side of the resonance, and the factor from one distance to the next: a resonance is far narrower than the even
/// points are apart where there is little damping. The nearest is 4e-6 of the band away.
const RESONANCE_POINTS: usize = 120;
const RESONANCE_RATIO: f64 = 0.9;

/// The record of a study before its samples: no tables, and no part of the backend, no other programs.
pub(super) fn first_record(
    prepared: &PreparedStudy,
    ensemble: &Ensemble,
) -> Result<RunRecord, Error> {
    check_band(prepared)?;
    let study = &prepared.study;
    let (linear, band) = (&prepared.linear, prepared.band());
    let nominal = prepared.nominal_problem()?;
    let (outcome, finer_grid) =
        rayon::join(|| ensemble.nominal(), || finer_grid(prepared, ensemble));
    let design = &study.design;
    Ok(RunRecord {
        provenance: provenance(prepared),
        backend: BackendReport::default(),
        inputs: study.input_records(),
        design: DesignRecord {
            kind: design.kind(),
            description: design.description(),
            independent: design.kind() == DesignKind::MonteCarlo,
            growth: design.growth(),
            outer_points: design.outer_points(),
            further_points: 0,
            mixed_inputs: design.mixed_inputs().to_vec(),
            correlated: design.is_correlated(),
        },
        frequency_tolerance: FREQUENCY_TOLERANCE,
        levels: study.levels.clone(),
        curve_samples: study.output.curve_samples,
        bands: study.output.bands,
        level_unit: level_unit(study).to_owned(),
        stuck: linear_record(study, linear, &nominal.stuck_stiffness, band)?,
        free: linear_record(study, linear, &vec![0.0; linear.n_relative()], band)?,
        nominal: Some(outcome),
        one_at_a_time: None,
        components: component_records(&prepared.components),
        contact_grid: contact_grid(study),
        finer_grid,
        static_load: static_load(study),
        disk: disk(prepared)?,
        requirements: study.requirements.clone(),
        stopping: None,
        surrogate: study.surrogate,
        control_variate: study.control_variate,
        study_file: FileRecord::of(&study.file_name(), study.text.as_bytes()),
        files: study.file_records()?,
        tables: Vec::new(),
        wall_time_s: 0.0,
    })
}

/// The disk that the model is a sector of.
fn disk(prepared: &PreparedStudy) -> Result<Option<DiskRecord>, Error> {
    let Some(of) = &prepared.disk else {
        return Ok(None);
    };
    let no_modes = |error: LinalgError| prepared.study.no_problem(error);
    let found =
        nodal_diameters(of, &prepared.contacts, &prepared.study.frequency).map_err(no_modes)?;
    let record = |of: NodalFrequencies| NodalRecord {
        nodal_diameter: of.number,
        rigid_modes: of.rigid,
        free_hz: of.free,
        stuck_hz: of.stuck,
    };
    Ok(Some(DiskRecord {
        sector: Some(sector(&prepared.study)?),
        sectors: of.disk.n_sectors,
        engine_order: of.engine_order as u32,
        nodal_diameter: of.nodal_diameter(),
        nodal_diameters: found.into_iter().map(record).collect(),
    }))
}

/// Hash of `[model]`, `[contact]` and the files that the study names. The matrices of the sector themselves would not do: their last
/// digits depend on the instruction set.
fn sector(study: &Study) -> Result<String, Error> {
    let mut stated = format!("{:?}", study.model);
    for file in study.file_records()? {
        stated += &file.blake3;
    }
    Ok(FileRecord::of("", stated.as_bytes()).blake3)
}

/// The centrifugal load on the strip of the built-in rig.
fn static_load(study: &Study) -> Option<StaticLoadRecord> {
    let blades = study.model.blades()?;
    Some(StaticLoadRecord {
        load_n: blades.centrifugal_load_n,
        strip_thickness_mm: blades.strip_mm[2],
    })
}

fn component_records(components: &[(&'static str, ComponentSummary)]) -> Vec<ComponentRecord> {
    let record = |(name, component): &(&str, ComponentSummary)| ComponentRecord {
        name: (*name).to_owned(),
        modes: component.n_modes,
        first_left_out_hz: Some(component.first_left_out).filter(|f| f.is_finite()),
    };
    components.iter().map(record).collect()
}

impl Study {
    /// Names of the inputs with their distributions or intervals.
    pub(in crate::study) fn input_records(&self) -> Vec<InputRecord> {
        let design = &self.design;
        let inputs = design.inputs().iter().enumerate();
        inputs
            .map(|(j, (input, distribution))| InputRecord {
                name: input.name().to_owned(),
                prior: design.assumption(j),
                origin: self.origin(*input),
                distribution: design.drawn().contains(&j).then(|| distribution.clone()),
            })
            .collect()
    }
}

/// Refuses a band in which no peak can be.
///
/// # Errors
/// [`Error::Unfit`] if the band holds no natural frequency of the structure with stuck or with open contacts, and whatever building the
/// nominal problem refuses.
pub(super) fn check_band(prepared: &PreparedStudy) -> Result<(), Error> {
    let (study, linear, band) = (&prepared.study, &prepared.linear, prepared.band());
    let stuck = prepared.nominal_problem()?.stuck_stiffness;
    for springs in [stuck, vec![0.0; linear.n_relative()]] {
        let found = linear_resonance(linear, &springs, band);
        if (found.map_err(|error| study.no_problem(error))?).is_some() {
            return Ok(());
        }
    }
    let of = prepared.disk.as_ref().map_or_else(String::new, |of| {
        let (order, diameter) = (of.engine_order, of.nodal_diameter());
        format!(" in nodal diameter {diameter}, which engine order {order} excites")
    });
    let [low, high] = [band.low, band.high].map(|omega| study.frequency.unit.shown(omega));
    let rule = "holds no natural frequency of the structure with stuck or with open contacts";
    let fact = format!("frequency: the band {low} to {high} {rule}{of}; `inspect` lists them");
    Err(Error::unfit(&study.path, fact))
}

/// Linear response per unit level over the band, and its resonance in the band, if any.
fn linear_record(
    study: &Study,
    model: &LinearModel,
    k: &[f64],
    band: Band,
) -> Result<LinearRecord, Error> {
    let resonance = linear_resonance(model, k, band).map_err(|error| study.no_problem(error))?;
    let resonance = resonance.map(|found| found.omega);
    let even =
        (0..LINEAR_POINTS).map(|i| band.low + band.width() * i as f64 / (LINEAR_POINTS - 1) as f64);
    let mut omega: Vec<f64> = even.chain(resonance).collect();
    if let Some(resonance) = resonance {
        let nearer = |distance: &f64| Some(RESONANCE_RATIO * distance);
        let distances = std::iter::successors(Some(band.width()), nearer);
        let around =
            (distances.take(RESONANCE_POINTS)).flat_map(|d| [resonance - d, resonance + d]);
        omega.extend(around.filter(|omega| band.contains(*omega)));
    }
    omega.sort_by(f64::total_cmp);
    let curve = omega
        .into_iter()
        .map(|omega| CurvePoint {
            frequency_hz: rad_s_to_hz(omega),
            amplitude_m: linear_response(model, k, omega).norm(),
            unstable: None,
        })
        .collect();
    Ok(LinearRecord {
        frequency_hz: resonance.map(rad_s_to_hz),
        curve,
    })
}

fn level_unit(study: &Study) -> &'static str {
    match study.model.blades() {
        Some(_) => "N",
        None => "units of the harmonic force",
    }
}

fn of_disk(study: &Study, settings: &CyclicSettings) -> String {
    let sector = match settings.sector {
        SectorSettings::BladeStrip { .. } => "blade and strip damper (built in)",
        SectorSettings::Matrices(_) => "matrices of the user",
    };
    let disk = match settings.blade_frequency_scatter {
        0.0 => format!("one sector of a tuned disk of {}", settings.sectors),
        scatter => format!(
            "a mistuned disk of {} blades whose frequencies scatter by {scatter}",
            settings.sectors
        ),
    };
    let operation = study.requirements.operation.iter();
    let orders: Vec<String> = operation
        .flat_map(|operation| &operation.engine_orders)
        .map(u32::to_string)
        .collect();
    format!(
        "{disk}, {sector}, excited by engine order {}",
        orders.join(", ")
    )
}

pub(super) fn provenance(prepared: &PreparedStudy) -> Provenance {
    let study = &prepared.study;
    let solver = &study.solver;
    let program = Program::this();
    Provenance {
        study: study.name.clone(),
        seed: study.design.seed(),
        version: program.version,
        commit: program.commit,
        instruction_set: program.instruction_set,
        other_programs: Vec::new(),
        model: match &study.model {
            ModelSettings::TwoBladeStrip { .. } => {
                "two blades with a strip damper (built in)".to_owned()
            }
            ModelSettings::Matrices(_) => "matrices of the user".to_owned(),
            ModelSettings::Cyclic(settings) => of_disk(study, settings),
        },
        law: solver.aft.law,
        events: solver.aft.events,
        anchor: solver.anchor,
        harmonics: solver.harmonics.orders().to_vec(),
        time_points: solver.aft.n_time,
        folded: prepared.folded(),
        truncation_threshold: solver.alert.map(|alert| alert.threshold),
        highest_harmonic: solver.alert.map(|alert| alert.highest_harmonic),
        compared_with: solver.alert.map(|alert| alert.compared_with),
        followed_modes: prepared.followed_modes.clone(),
        peak_mode: match study.frequency.peak {
            PeakSetting::Mode(number) => Some(number),
            PeakSetting::Highest | PeakSetting::All => None,
        },
    }
}
