//! What a study is about to compute: sizes, linear frequencies, memory and time.

use super::built::{StudyDisk, StudyModel};
use super::frequency::{FrequencySettings, FrequencyUnit};
use super::pilot::Pilot;
use super::read::Study;
use super::size::{solve_memory, unknowns};
use crate::Error;
use crate::contact::ContactParameters;
use crate::ensemble::runner::generations;
use crate::harmonics::HarmonicSet;
use crate::linalg::LinalgError;
use crate::model::rigid::RigidModes;
use crate::model::two_blade::{ComponentSummary, PressureInputs};
use crate::report::asked::Stopping;
use crate::report::run::InputRecord;
use crate::sampling::Input;
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
    /// Flexible ones without contact.
    pub free: Vec<f64>,
    /// Those with every contact closed and stuck.
    pub stuck: Vec<f64>,
}

/// Frequencies of nodal diameters up to so many times the end of the band are stored.
const BEYOND_BAND: f64 = 1.5;
/// Those of nodal diameters are shown as close to the band.
const CLOSE_TO_BAND: f64 = 1.2;

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
                Some(_) => in_unit(flexible(built.frequencies(false)?)),
            },
            stuck: in_unit(built.frequencies(true)?),
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
}

/// The frequencies of every nodal diameter of a disk.
pub(super) fn nodal_diameters(
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
        Ok(NodalFrequencies {
            number,
            free: first(flexible(of.disk.frequencies(number, None)?)),
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

/// Processor time of the whole study (s), and the samples of a model of one's own that were solved for it.
fn estimated_time(
    study: &Study,
    n_contacts: usize,
    built_in: bool,
) -> Result<(f64, Option<Pilot>), Error> {
    let pilot = match built_in {
        true => None,
        false => Pilot::of(study)?,
    };
    let of_sample = time_of_sample(study, n_contacts);
    let factor = pilot.map_or(1.0, |pilot| pilot.factor(of_sample));
    Ok((factor * processor_time(study, n_contacts), pilot))
}

/// Gathers the facts; of a disk under several engine orders those of the first, with the times of all.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Command`] if its eigenvalue problem fails.
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
    let n_contacts = study.linear(&built)?.n_contacts();
    let whole = n_contacts == built.reduced.n_contacts();
    let asymmetric = whole && study.folds() && built.reduced.mirror.is_some();
    let components = built.components();
    let unit = study.frequency.unit;
    let linear =
        LinearFrequencies::of(&built, &study.frequency).map_err(|error| Error::Command {
            path: study.path.clone(),
            message: format!("linear modes of the model: {error}"),
        })?;
    let excited = (built.disk.as_ref()).map(|of| (of.engine_order, of.nodal_diameter()));
    let StudyModel {
        reduced: model,
        rig,
        ..
    } = built;
    let names = |rows: &[crate::model::Response]| rows.iter().map(|r| r.name.clone()).collect();
    let inputs = study.design.inputs().iter();
    let unknowns = unknowns(study, n_contacts);
    let (processor_time_s, pilot) = estimated_time(study, n_contacts, !components.is_empty())?;
    Ok(Inspection {
        name: study.name.clone(),
        unit,
        contact_names: model.contacts.iter().map(|c| c.name.clone()).collect(),
        response_names: names(&model.responses),
        warnings: warnings(study, linear.free.first().copied(), asymmetric),
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
        unknowns,
        memory_bytes: solve_memory(n_contacts, unknowns[1]),
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
    let text = format!(
        "{modes} modes per interface hold {:.0} % of the variance and are scaled to all of it",
        100.0 * share
    );
    (modes > 0).then_some(text)
}

/// Work of a peak at one level, in factorisations of the first harmonic set, failures and the error alert included: of a sample
/// that is predicted from many others.
const WORK_OF_PREDICTED: f64 = 5.0;
/// What one of the first samples takes more, which has few or no others to start from.
const WORK_OF_FIRST: f64 = 24.0;
/// Number of such samples.
const FIRST_SAMPLES: u64 = 64;
/// Work of a curve.
const WORK_OF_CURVE: f64 = 25.0;
/// Share of that work in a study without an error alert.
const SHARE_WITHOUT_ALERT: f64 = 0.15;
/// Operations per second of a dense factorisation on one core.
const FLOPS: f64 = 5e9;
/// Time of everything but the factorisation, per unknown (s).
const ASSEMBLY_PER_UNKNOWN: f64 = 1e-5;

/// Samples at the points of a search for each number that a criterion judges.
fn further_samples(study: &Study) -> u64 {
    let design = &study.design;
    let criteria = study.requirements.criteria.iter();
    let judged: usize = criteria.map(|c| c.levels(&study.levels).len()).sum();
    let points = design.outer().map_or(0, |outer| outer.search);
    let inner = study.samples / design.outer_points();
    (points as u64)
        .saturating_mul(judged as u64)
        .saturating_mul(inner)
}

/// Seconds of a factorisation and what goes with it: ⅔ n³ operations and a linear part.
fn time_of_factorisation(unknowns: usize) -> f64 {
    let n = unknowns as f64;
    2.0 / 3.0 * n.powi(3) / FLOPS + ASSEMBLY_PER_UNKNOWN * n
}

/// Time of one of the first samples at all levels (s), without its curves.
fn time_of_sample(study: &Study, n_contacts: usize) -> f64 {
    let [unknowns, _] = unknowns(study, n_contacts);
    let work = share_of_work(study) * work_of_peaks(1, 0);
    study.levels.len() as f64 * work * time_of_factorisation(unknowns)
}

/// Share of the work of a study with an error alert.
fn share_of_work(study: &Study) -> f64 {
    match study.solver.alert {
        Some(_) => 1.0,
        None => SHARE_WITHOUT_ALERT,
    }
}

/// The numbers of factorisations are those of the shipped studies.
fn processor_time(study: &Study, n_contacts: usize) -> f64 {
    let levels = study.levels.len() as f64;
    let samples = study.samples.saturating_add(further_samples(study));
    let alone = match study.output.one_at_a_time {
        true => 1 + 2 * study.design.drawn().len() as u64,
        false => 0,
    };
    let curves = study.output.curve_samples.min(study.samples);
    let work = work_of_peaks(samples, alone) + WORK_OF_CURVE * curves as f64;
    let share = share_of_work(study);
    let [unknowns, _] = unknowns(study, n_contacts);
    let control = study.control_variate.map_or(0.0, |control| {
        let coefficients = HarmonicSet::up_to(control.highest_harmonic()).n_coefficients();
        let work = SHARE_WITHOUT_ALERT * work_of_peaks(control.samples(), 0);
        work * time_of_factorisation(3 * n_contacts * coefficients)
    });
    levels * (work * share * time_of_factorisation(unknowns) + control)
}

/// Work of so many samples at one level without their curves, and of so many solutions that start from nothing near.
fn work_of_peaks(samples: u64, alone: u64) -> f64 {
    let first = samples.min(FIRST_SAMPLES) + alone;
    WORK_OF_PREDICTED * samples as f64 + WORK_OF_FIRST * first as f64
}

/// Rounds of so many threads over the samples, each the time of one sample, over the number of samples: a generation of the atlas waits
/// for its last sample.
fn turns(samples: u64, threads: u64) -> f64 {
    let rounds = generations(samples).map(|generation| {
        let samples = generation.end - generation.start;
        samples.div_ceil(threads.max(1))
    });
    rounds.sum::<u64>() as f64 / samples.max(1) as f64
}

fn warnings(study: &Study, flexible: Option<f64>, asymmetric: bool) -> Vec<String> {
    let mut warnings = Vec::new();
    let [low, high] = PLAUSIBLE_HZ;
    match flexible {
        Some(f) if study.frequency.unit == FrequencyUnit::Hertz && !(low..=high).contains(&f) => {
            warnings.push(format!(
                "the first flexible frequency is {f:.3e} Hz: check the units of stiffness (N/m) and mass (kg)"
            ));
        }
        Some(_) => {}
        None => warnings.push("the structure has no flexible mode".to_owned()),
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
    warnings
}

#[cfg(test)]
mod tests {
    use super::turns;

    /// 5, 2, 3 and 2 samples by four: 2 + 1 + 1 + 1 rounds. Seen to fail with samples that do not wait for their generation.
    #[test]
    fn generations_wait_for_their_last_sample() {
        assert_eq!(turns(12, 1), 1.0);
        assert_eq!(turns(12, 4), 5.0 / 12.0);
        assert_eq!(turns(12, 100), 4.0 / 12.0);
    }
}
