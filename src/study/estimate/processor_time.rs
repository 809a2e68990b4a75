//! What a study takes of the processor, estimated from its sizes.
//!
//! The numbers of factorisations are those of the shipped studies; the table of what was stated and what was used is in
//! `benches/README.md`.

use super::pilot::{CostlyLevels, Pilot};
use super::size::SolveSize;
use crate::Error;
use crate::ensemble::runner::{FIRST_ANCHORS, generations};
use crate::study::settings::read::Study;

/// Processor time of the whole study (s), and the samples of a model of one's own that were solved for it.
pub(super) fn estimated_time(
    study: &Study,
    size: SolveSize,
    built_in: bool,
) -> Result<(f64, Option<Pilot>), Error> {
    let pilot = match built_in {
        true => None,
        false => Pilot::of(study)?,
    };
    let levels = CostlyLevels::of(study)?;
    let of_sample = time_of_sample(study, size, levels.slipping);
    let factor = pilot.map_or(1.0, |pilot| pilot.factor(of_sample));
    let of_tracks = match built_in {
        true => time_of_tracks(study, size, levels.slipping),
        false => 0.0,
    };
    let of_finer_grid = time_of_finer_grid(study, size, levels.slipping);
    let time = factor * processor_time(study, size, levels) + of_tracks + of_finer_grid;
    Ok((time, pilot))
}

/// Work of a peak at a level with slip, in factorisations of the first harmonic set, failures and the error alert included. Most of it
/// is the alert's, which a prediction from other samples hardly shortens.
const WORK_OF_PREDICTED: f64 = 18.0;
/// What one of the first samples takes more, which has few or no others to start from.
const WORK_OF_FIRST: f64 = 5.0;
/// Number of such samples.
const FIRST_SAMPLES: u64 = 64;
/// What one of the very first samples of the built-in model takes more, which follows its peak from the stuck structure through the levels: of
/// the larger harmonic sets of the alert nothing. A pilot has measured it of a model of one's own.
const WORK_OF_TRACK: f64 = 60.0;
/// Work of a nominal peak on a finer contact grid at a level with slip, in factorisations of that grid.
const WORK_OF_FINER_GRID: f64 = 17.0;
/// Work of the stability of a peak.
const WORK_OF_STABILITY: f64 = 3.0;
/// Operations of the stability of a peak of a disk, per sector and per square of its degrees of freedom.
const OPERATIONS_OF_RING: f64 = 1.2e5;
/// The same of a mistuned disk, per cube of its degrees of freedom.
const OPERATIONS_OF_MISTUNED: f64 = 200.0;
/// Work of a peak at a level without slip, which one harmonic solves.
const WORK_OF_STUCK: f64 = 1.0;
/// Work of a curve at a level with slip.
const WORK_OF_CURVE: f64 = 12.0;
/// Share of that work in a study without an error alert.
const SHARE_WITHOUT_ALERT: f64 = 0.15;
/// Threshold of the error alert of that work.
const THRESHOLD: f64 = 0.01;
/// Operations per second of a dense factorisation on one core.
const FLOPS: f64 = 5e9;
/// Time of everything but the factorisation, per unknown (s).
const ASSEMBLY_PER_UNKNOWN: f64 = 1e-5;
/// Newton iterations of a mistuned disk at one level, per blade, on one harmonic.
const ITERATIONS_PER_BLADE: f64 = 21.0;
/// Those that locate its highest maxima, on all harmonics.
const ITERATIONS_OF_MAXIMA: f64 = 10.0;
/// Time of the iterative solves of a Newton iteration, per square of the number of unknowns (s).
const SOLVE_PER_SQUARE: f64 = 3.5e-8;

/// Samples at the points of a search for each number that a criterion judges.
pub(super) fn further_samples(study: &Study) -> u64 {
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

/// Time of one of the first samples at all levels (s), contacts slipping at so many, without its curves and its stability.
fn time_of_sample(study: &Study, size: SolveSize, slipping: usize) -> f64 {
    if let Some(blades) = size.mistuned_blades {
        return study.levels.len() as f64 * time_of_mistuned(size, blades);
    }
    let stuck = study.levels.len() - slipping;
    let work =
        slipping as f64 * share_of_work(study) * work_of_peaks(1, 0) + stuck as f64 * WORK_OF_STUCK;
    work * time_of_factorisation(size.unknowns)
}

/// What the samples that start from no other take more (s), contacts slipping at so many levels.
fn time_of_tracks(study: &Study, size: SolveSize, slipping: usize) -> f64 {
    if size.mistuned_blades.is_some() {
        return 0.0;
    }
    let samples = study.samples.min(FIRST_ANCHORS) as f64;
    samples * slipping as f64 * WORK_OF_TRACK * time_of_factorisation(size.unknowns)
}

/// Time of the nominal peaks on a finer contact grid (s), contacts slipping at so many levels.
fn time_of_finer_grid(study: &Study, size: SolveSize, slipping: usize) -> f64 {
    let nodes = |[across, along]: [usize; 2]| (across * along) as f64;
    let blades = study.model.blades();
    let Some((own, finer)) = blades.zip(study.model.finer_contact_nodes()) else {
        return 0.0;
    };
    // a mistuned disk has them of all its sectors, and its nominal peaks are those of one
    let of_sector = size.unknowns / size.mistuned_blades.unwrap_or(1);
    let unknowns = of_sector as f64 * nodes(finer) / nodes(own.contact_nodes);
    slipping as f64 * WORK_OF_FINER_GRID * time_of_factorisation(unknowns as usize)
}

/// Time of a mistuned disk at one level (s): a sweep that passes the resonances of all blades, and the highest maxima located.
fn time_of_mistuned(size: SolveSize, blades: usize) -> f64 {
    ITERATIONS_PER_BLADE * blades as f64 * time_of_iteration(size.unknowns_up_to(1))
        + ITERATIONS_OF_MAXIMA * time_of_iteration(size.unknowns)
}

/// Seconds of a Newton iteration of many contacts, whose linear systems are solved by iterations.
fn time_of_iteration(unknowns: usize) -> f64 {
    let n = unknowns as f64;
    SOLVE_PER_SQUARE * n.powi(2) + ASSEMBLY_PER_UNKNOWN * n
}

/// Share of the work of a study whose alert has the threshold [`THRESHOLD`]: the work on larger harmonic sets goes with the root of the
/// threshold, as the harmonics that slip needs do.
fn share_of_work(study: &Study) -> f64 {
    let larger = study
        .solver
        .alert
        .map_or(0.0, |alert| (THRESHOLD / alert.threshold).sqrt());
    SHARE_WITHOUT_ALERT + (1.0 - SHARE_WITHOUT_ALERT) * larger
}

/// Time of all samples (s).
fn processor_time(study: &Study, size: SolveSize, levels: CostlyLevels) -> f64 {
    let samples = study.samples.saturating_add(further_samples(study));
    let of_stability = time_of_stability(size) * levels.assessed as f64;
    if size.mistuned_blades.is_some() {
        // a disk hardly gains from those before it: no other has the same modes
        let of_sample = time_of_sample(study, size, levels.slipping);
        return samples as f64 * (of_sample + of_stability);
    }
    let alone = match study.output.one_at_a_time {
        true => 1 + 2 * study.design.drawn().len() as u64,
        false => 0,
    };
    let (slipping, all) = (levels.slipping as f64, study.levels.len() as f64);
    let curves = study.output.curve_samples.min(study.samples);
    let work = work_of_peaks(samples, alone) + WORK_OF_CURVE * curves as f64;
    let stuck = WORK_OF_STUCK * (samples + alone + curves) as f64;
    let stability = of_stability * (samples + alone) as f64;
    let control = study.control_variate.map_or(0.0, |control| {
        let work = SHARE_WITHOUT_ALERT * work_of_peaks(control.samples(), 0);
        work * time_of_factorisation(size.unknowns_up_to(control.highest_harmonic()))
    });
    let factorisations = slipping * work * share_of_work(study) + (all - slipping) * stuck;
    factorisations * time_of_factorisation(size.unknowns) + stability + slipping * control
}

/// Time of the stability of a peak (s).
fn time_of_stability(size: SolveSize) -> f64 {
    let Some([sectors, dofs]) = size.ring else {
        return WORK_OF_STABILITY * time_of_factorisation(size.unknowns);
    };
    let operations = match size.mistuned_blades {
        None => OPERATIONS_OF_RING * (sectors * dofs * dofs) as f64,
        Some(_) => OPERATIONS_OF_MISTUNED * ((sectors * dofs) as f64).powi(3),
    };
    operations / FLOPS
}

/// Work of so many samples at one level without their curves, and of so many solutions that start from nothing near.
fn work_of_peaks(samples: u64, alone: u64) -> f64 {
    let first = samples.min(FIRST_SAMPLES) + alone;
    WORK_OF_PREDICTED * samples as f64 + WORK_OF_FIRST * first as f64
}

/// Rounds of so many threads over the samples, each the time of one sample, over the number of samples: a generation of the atlas waits
/// for its last sample.
pub(super) fn turns(samples: u64, threads: u64) -> f64 {
    let rounds = generations(samples).map(|generation| {
        let samples = generation.end - generation.start;
        samples.div_ceil(threads.max(1))
    });
    rounds.sum::<u64>() as f64 / samples.max(1) as f64
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
