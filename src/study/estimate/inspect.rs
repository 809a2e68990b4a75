//! What a study is about to compute: sizes, linear frequencies, memory and time.

use super::pilot::Pilot;
use super::processor_time::{estimated_time, further_samples, turns};
use super::size::SolveSize;
use crate::Error;
use crate::contact::ContactParameters;
use crate::linalg::LinalgError;
use crate::model::rigid::RigidModes;
use crate::model::two_blade::{ComponentSummary, PressureInputs};
use crate::report::asked::Stopping;
use crate::report::run::InputRecord;
use crate::sampling::Input;
use crate::study::built::{StudyDisk, StudyModel};
use crate::study::settings::frequency::{FrequencySettings, FrequencyUnit};
use crate::study::settings::read::Study;
use rayon::current_num_threads;

/// Number of frequencies that are shown.
const SHOWN: usize = 10;
/// Range in which the first flexible frequency of a blade in SI units must lie (Hz).
const PLAUSIBLE_HZ: [f64; 2] = [0.1, 1e6];

/// Facts about a study. None needs a nonlinear solution, but the time of a model of one's own.
#[derive(Debug, Clone)]
pub struct Inspection {
    /// Name of the study.
    pub name: String,
    /// Unit of the frequencies.
    pub unit: FrequencyUnit,
    /// Names of the degrees of freedom.
    pub dof_names: Vec<String>,
    /// Names of the contact pairs.
    pub contact_names: Vec<String>,
    /// Names of the responses.
    pub response_names: Vec<String>,
    /// Components that were reduced, by name.
    pub components: Vec<(&'static str, ComponentSummary)>,
    /// Total mass along x, y and z (kg; in the unit of the matrices in a study in rad/s): of the finite elements of the built-in model;
    /// of matrices where names tell the directions, [`crate::model::ReducedModel::total_mass`].
    pub total_mass: Option<[f64; 3]>,
    /// Rigid-body modes without contact.
    pub rigid: RigidModes,
    /// First flexible natural frequencies without contact.
    pub free: Vec<f64>,
    /// First natural frequencies with every contact closed and stuck.
    pub stuck: Vec<f64>,
    /// Of a disk: the engine order that excites it, and its nodal diameter, which the frequencies are of.
    pub excited: Option<(usize, usize)>,
    /// Of a disk: the frequencies of every nodal diameter close to the band.
    pub nodal_diameters: Vec<NodalFrequencies>,
    /// Names of the random inputs.
    pub inputs: Vec<&'static str>,
    /// The distribution of each in words, with the file that states it where it is not the study file.
    pub distributions: Vec<String>,
    /// The design of the samples, in words.
    pub design: String,
    /// The random field of the contact pressure in words, if there is one.
    pub pressure_field: Option<String>,
    /// Number of samples, at most.
    pub samples: u64,
    /// When fewer are enough.
    pub stopping: Option<Stopping>,
    /// Further samples of the search for worst cases over the epistemic inputs, at most.
    pub further_samples: u64,
    /// Excitation levels.
    pub levels: Vec<f64>,
    /// Unknowns of one nonlinear solve at the first and at the highest harmonics.
    pub unknowns: [usize; 2],
    /// Memory of one solve on the highest harmonics (bytes): usually, and at most.
    pub memory_bytes: [f64; 2],
    /// Processor time of the whole study (s), all further samples with it, within about a factor of two for the shipped studies.
    pub processor_time_s: f64,
    /// Samples that were solved for it, of a model of one's own.
    pub pilot: Option<Pilot>,
    /// Threads of this process.
    pub threads: usize,
    /// Wall time (s) on these threads, if each has a core of its own.
    pub wall_time_s: f64,
    /// What looks like a mistake.
    pub warnings: Vec<String>,
}

/// Natural frequencies of a nodal diameter.
#[derive(Debug, Clone)]
pub struct NodalFrequencies {
    /// The nodal diameter.
    pub number: usize,
    /// Number of rigid-body modes without contact, which `free` leaves out.
    pub rigid: usize,
    /// Flexible ones without contact.
    pub free: Vec<f64>,
    /// Those with every contact closed and stuck.
    pub stuck: Vec<f64>,
}

/// Frequencies of nodal diameters up to so many times the end of the band are stored.
const BEYOND_BAND: f64 = 1.5;
/// Those of nodal diameters are shown as close to the band.
const CLOSE_TO_BAND: f64 = 1.2;
/// Below so many nodes of a sample that a random field of the load pulls at, nothing is said of them.
const SELDOM_PULLED: f64 = 0.01;

/// Natural frequencies of a study's model, in its unit.
struct LinearFrequencies {
    rigid: RigidModes,
    /// Flexible ones without contact forces.
    free: Vec<f64>,
    /// With all contacts stuck.
    stuck: Vec<f64>,
    nodal_diameters: Vec<NodalFrequencies>,
}

impl LinearFrequencies {
    fn of(built: &StudyModel, frequency: &FrequencySettings) -> Result<Self, LinalgError> {
        let unit = frequency.unit;
        let in_unit = |omega: Vec<f64>| omega.iter().map(|w| unit.of_rad_s(*w)).collect();
        let [low, high] = frequency.band.map(|w| unit.of_rad_s(w));
        let close = |mut of: NodalFrequencies| {
            let is_close = |f: &f64| (low / CLOSE_TO_BAND..=high * CLOSE_TO_BAND).contains(f);
            of.free.retain(is_close);
            of.stuck.retain(is_close);
            of
        };
        let (mut free, rigid) = built.reduced.free_modes()?;
        Ok(Self {
            free: match &built.disk {
                None => in_unit(free.split_off(rigid.count)),
                Some(_) => in_unit(flexible(built.free_frequencies()?)),
            },
            stuck: in_unit(built.stuck_frequencies()?),
            nodal_diameters: match &built.disk {
                None => Vec::new(),
                Some(of) => {
                    let all = nodal_diameters(of, &built.contacts, frequency)?;
                    all.into_iter().map(close).collect()
                }
            },
            rigid,
        })
    }

    /// Whether one of them is in the band of a study.
    fn reaches(&self, frequency: &FrequencySettings) -> bool {
        let [low, high] = frequency.band.map(|w| frequency.unit.of_rad_s(w));
        let mut both = self.free.iter().chain(&self.stuck);
        both.any(|f| (low..=high).contains(f))
    }
}

/// The frequencies of every nodal diameter of a disk.
pub(in crate::study) fn nodal_diameters(
    of: &StudyDisk,
    contacts: &[ContactParameters<f64>],
    frequency: &FrequencySettings,
) -> Result<Vec<NodalFrequencies>, LinalgError> {
    let highest = BEYOND_BAND * frequency.band[1];
    let first = |omega: Vec<f64>| -> Vec<f64> {
        let low = omega.into_iter().filter(|w| *w <= highest);
        low.map(|w| frequency.unit.of_rad_s(w)).collect()
    };
    let at = |number: usize| {
        let all = of.disk.frequencies(number, None)?;
        let modes = all.len();
        let free = flexible(all);
        Ok(NodalFrequencies {
            number,
            rigid: modes - free.len(),
            free: first(free),
            stuck: first(of.disk.frequencies(number, Some(contacts))?),
        })
    };
    (0..=of.disk.n_sectors / 2).map(at).collect()
}

/// Those that are more than the round-off of the highest one, whose squares the eigenvalues are.
fn flexible(omega: Vec<f64>) -> Vec<f64> {
    let highest = omega.last().copied().unwrap_or_default();
    let floor = (10.0 * f64::EPSILON * omega.len() as f64).sqrt() * highest;
    omega.into_iter().filter(|w| *w > floor).collect()
}

/// Gathers the facts; of a disk under several engine orders those of the first, with the times of all.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Unfit`] if its eigenvalue problem fails.
pub fn inspect(study: &Study) -> Result<Inspection, Error> {
    let Some(orders) = study.several_engine_orders() else {
        return inspect_one(study);
    };
    let mut facts = inspect_one(&study.of_engine_order(orders[0])?)?;
    facts.processor_time_s *= orders.len() as f64;
    facts.wall_time_s *= orders.len() as f64;
    facts.warnings.push(format!(
        "engine orders {orders:?} are solved one after the other: shown is order {}, the times are those of all",
        orders[0]
    ));
    Ok(facts)
}

fn inspect_one(study: &Study) -> Result<Inspection, Error> {
    let built = study.build_model()?;
    let solved = study.linear(&built)?;
    let undamped = study.without_damping(&solved);
    let n_contacts = solved.n_contacts();
    let whole = n_contacts == built.reduced.n_contacts();
    let asymmetric = whole && study.folds() && built.reduced.mirror.is_some();
    let components = built.components();
    let unit = study.frequency.unit;
    let linear = LinearFrequencies::of(&built, &study.frequency).map_err(|error| {
        Error::unfit(&study.path, format!("linear modes of the model: {error}"))
    })?;
    let excited = (built.disk.as_ref()).map(|of| (of.engine_order, of.nodal_diameter()));
    let StudyModel {
        reduced: model,
        rig,
        disk,
        ..
    } = built;
    let names = |rows: &[crate::model::Response]| rows.iter().map(|r| r.name.clone()).collect();
    let inputs = study.design.inputs().iter();
    let sizes = SolveSize::of(study, n_contacts, disk.as_ref());
    let (processor_time_s, pilot) = estimated_time(study, sizes, !components.is_empty())?;
    Ok(Inspection {
        name: study.name.clone(),
        unit,
        contact_names: model.contacts.iter().map(|c| c.name.clone()).collect(),
        response_names: names(&model.responses),
        warnings: warnings(study, &linear, asymmetric, undamped),
        total_mass: match &rig {
            Some(rig) => Some(rig.total_mass()),
            None if excited.is_some() && !components.is_empty() => Some(mass_of(&components)),
            None => model.total_mass(),
        },
        components,
        rigid: linear.rigid,
        free: linear.free.into_iter().take(SHOWN).collect(),
        excited,
        nodal_diameters: linear.nodal_diameters,
        stuck: linear.stuck.into_iter().take(SHOWN).collect(),
        inputs: inputs.map(|(i, _)| Input::name(*i)).collect(),
        distributions: (study.input_records().iter())
            .map(InputRecord::assumption)
            .collect(),
        design: study.design.description(),
        pressure_field: rig.and_then(|rig| pressure_field(rig.pressure())),
        samples: study.samples,
        stopping: study.stopping.clone(),
        further_samples: further_samples(study),
        levels: study.levels.clone(),
        unknowns: [sizes.unknowns, sizes.most_unknowns],
        memory_bytes: sizes.memory(),
        processor_time_s,
        pilot,
        threads: current_num_threads(),
        wall_time_s: processor_time_s * turns(study.samples, current_num_threads() as u64),
        dof_names: model.dof_names,
    })
}

/// Mass of a blade and a strip along x, y and z (kg).
fn mass_of(components: &[(&'static str, ComponentSummary)]) -> [f64; 3] {
    [0, 1, 2].map(|axis| components.iter().map(|(_, of)| of.mass[axis]).sum())
}

fn pressure_field(inputs: &PressureInputs) -> Option<String> {
    let (modes, share) = (inputs.modes_per_interface(), inputs.variance_share);
    let held = format!(
        "{modes} modes per interface hold {:.0} % of the variance and are scaled to all of it",
        100.0 * share
    );
    let pulls = match inputs.pulled_nodes {
        few if few < SELDOM_PULLED => String::new(),
        nodes => format!(": they pull at {nodes:.2} nodes of a sample in the mean"),
    };
    (modes > 0).then(|| held + &pulls)
}

fn warnings(
    study: &Study,
    linear: &LinearFrequencies,
    asymmetric: bool,
    undamped: Option<String>,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let [low, high] = PLAUSIBLE_HZ;
    match linear.free.first() {
        Some(f) if study.frequency.unit == FrequencyUnit::Hertz && !(low..=high).contains(f) => {
            warnings.push(format!(
                "the first flexible frequency is {f:.3e} Hz: check the units of stiffness (N/m) and mass (kg)"
            ));
        }
        Some(_) => {}
        None => warnings.push("the structure has no flexible mode".to_owned()),
    }
    if !linear.reaches(&study.frequency) {
        let what =
            "frequency: the band holds no natural frequency without contact or with stuck contacts";
        warnings.push(format!("{what}: `run` refuses the study"));
    }
    warnings.extend(study.warnings.iter().cloned());
    warnings.extend(study.unfolded());
    if asymmetric {
        let reason =
            "the mirror changes a matrix, a force or a contact pair: solved on all contacts";
        warnings.push(format!("model.mirror: {reason}"));
    }
    if study.samples > 1 && study.design.inputs().is_empty() {
        warnings.push("no [inputs]: every sample will be the same".to_owned());
    }
    warnings.extend(undamped);
    warnings
}
