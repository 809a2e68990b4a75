//! Nominal forced response: what `solve` writes.
//!
//! `curve.csv` has one row per level and frequency; `solution.json` has the harmonics of every response.

use std::collections::BTreeMap;
use std::io::Write;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::output::OutputFolder;
use super::runs::progress::Progress;
use super::settings::frequency::{FrequencyUnit, Points};
use super::settings::read::Study;
use crate::Error;
use crate::file::refuse_inputs;
use crate::hb::response::forced_response::{
    CurveSettings, Gap, Largest, Response, Stop, over_band,
};
use crate::hb::response::values::{SlowSweep, at_frequencies};
use crate::hb::structure::resonance::Band;
use crate::hb::{ContactFractions, CycleWork, Solution, Status, WorkCount};
use crate::model::ReducedModel;

/// The curves.
const CURVE: &str = "curve.csv";
/// All harmonics.
const SOLUTION: &str = "solution.json";

/// Parts of the progress of one level.
const PARTS: u64 = 100;

/// Computes the nominal forced response level by level and writes it.
///
/// By continuation over the band or at the prescribed frequencies, as `study.frequency.points` says; on one half of a
/// mirror-symmetric model where the study lets it. `progress` is called before the first level and on the way.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Study`] if it is no harmonic balance problem; [`Error::File`] if
/// a result cannot be written or would replace a file of the study.
pub fn solve(
    study: &Study,
    folder: &OutputFolder,
    progress: impl Fn(Progress),
) -> Result<Vec<LevelCurve>, Error> {
    refuse_inputs(
        [CURVE, SOLUTION].map(|name| folder.path().join(name)),
        &study.inputs_on_disk(),
    )?;
    let prepared = study.prepared()?;
    let problem = prepared.nominal_problem()?;
    let band = prepared.band();
    let total = PARTS * study.levels.len() as u64;
    let mut curves = Vec::new();
    let newton_iterations = 0;
    progress(Progress {
        done: 0,
        total,
        newton_iterations,
    });
    for (&level, before) in study.levels.iter().zip(0..) {
        let progress = |share: f64| {
            let done = PARTS * before + (share * PARTS as f64) as u64;
            progress(Progress {
                done,
                total,
                newton_iterations,
            });
        };
        let response = match &study.frequency.points {
            Points::Continuation => {
                let curve = CurveSettings::for_plot(band);
                over_band(&problem, &study.solver, level, curve, progress)
            }
            Points::Prescribed { omega, sweep } => {
                let sweep = SlowSweep {
                    band,
                    direction: *sweep,
                    omega,
                };
                at_frequencies(&problem, &study.solver, level, sweep, progress)
            }
        };
        let points = response.solutions.into_par_iter();
        let judged = points.map(|point| point.with_stability(&problem, &study.solver));
        let response = Response {
            solutions: judged.collect(),
            ..response
        };
        progress(1.0);
        curves.push(LevelCurve {
            level,
            band,
            response,
        });
    }
    write_curves(folder, study, &prepared.reduced, &curves)?;
    Ok(curves)
}

/// Forced response at one excitation level.
#[derive(Debug, Clone)]
pub struct LevelCurve {
    /// Excitation level.
    pub level: f64,
    /// Band of the study.
    pub band: Band,
    /// Points in the order of the curve, failed ones included, and what of the band they leave out.
    pub response: Response,
}

impl LevelCurve {
    /// The largest amplitude of the first response in the band, and what it is.
    #[must_use]
    pub fn largest(&self) -> Option<(&Solution, Largest)> {
        self.response.largest(self.band)
    }
}

/// Writes `curve.csv` and `solution.json`.
///
/// `docs/src/outputs.md` says field by field what they hold. Without a solution amplitudes and shares stay empty in `curve.csv`;
/// `responses`, `contact_fractions` and `work_j` are null in `solution.json`.
///
/// # Errors
/// [`Error::File`] if a file cannot be written; both older files then stay as they were.
pub fn write_curves(
    folder: &OutputFolder,
    study: &Study,
    model: &ReducedModel,
    curves: &[LevelCurve],
) -> Result<(), Error> {
    let unit = study.frequency.unit;
    let names: Vec<&str> = model.responses.iter().map(|r| r.name.as_str()).collect();
    let record = SolutionRecord {
        study: &study.name,
        frequency_unit: unit,
        coefficient_order: "q(t) = q0 + sum ck cos(k w t) + sk sin(k w t): q0, c1, s1, ... over `harmonics`",
        levels: curves
            .iter()
            .map(|curve| LevelRecord::new(curve, unit, &names))
            .collect(),
    };
    let solution = |out: &mut dyn Write| {
        serde_json::to_writer(&mut *out, &record)?;
        writeln!(out)
    };
    let curve = |out: &mut dyn Write| write_csv(out, unit, &names, curves);
    folder.write_all(&[(SOLUTION, &solution), (CURVE, &curve)])?;
    Ok(())
}

/// Nominal forced response. With `frequency_unit` = "rad/s" the units m, N and J stand for those of the study.
#[derive(Serialize, JsonSchema)]
pub(super) struct SolutionRecord<'a> {
    /// Name of the study.
    study: &'a str,
    /// Unit of all frequencies.
    frequency_unit: FrequencyUnit,
    /// The convention of `responses`, in words.
    coefficient_order: &'static str,
    /// One entry per excitation level, ascending.
    levels: Vec<LevelRecord<'a>>,
}

/// Response at one excitation level.
#[derive(Serialize, JsonSchema)]
struct LevelRecord<'a> {
    /// Excitation level (N on each blade for the built-in model, else a factor).
    level: f64,
    /// Frequencies at which the continuations from both ends of the band stopped: the branch between is not known; null where nothing is missing.
    gap: Option<GapRecord>,
    /// The largest amplitude of the first response; null without a solution.
    largest_amplitude: Option<LargestRecord>,
    /// Points in the order of the curve, or of the values asked for; failed ones included.
    points: Vec<PointRecord<'a>>,
}

/// A frequency under the key of its unit.
#[derive(Serialize, JsonSchema)]
struct FrequencyRecord {
    /// Frequency (Hz); absent where the unit is rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency_hz: Option<f64>,
    /// Angular frequency (rad/s); absent where the unit is Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency_rad_s: Option<f64>,
}

/// Both ends of a gap.
#[derive(Serialize, JsonSchema)]
struct GapRecord {
    /// Where the sweep from the lower end stopped.
    below: StopRecord,
    /// Where the sweep from the upper end stopped.
    above: StopRecord,
}

/// Where a sweep along the response stopped.
#[derive(Serialize, JsonSchema)]
struct StopRecord {
    #[serde(flatten)]
    frequency: FrequencyRecord,
    /// Why; `converged` where this sweep answered every value that the other one did not reach.
    status: Status,
}

/// The largest amplitude of the first response.
#[derive(Serialize, JsonSchema)]
struct LargestRecord {
    #[serde(flatten)]
    frequency: FrequencyRecord,
    /// Amplitude of the first harmonic (m).
    amplitude: f64,
    /// What it is.
    is: Largest,
}

/// Response at one frequency.
#[derive(Serialize, JsonSchema)]
struct PointRecord<'a> {
    #[serde(flatten)]
    frequency: FrequencyRecord,
    /// How the solve ended.
    status: Status,
    /// Harmonics of this solution: 0, 1, ...
    harmonics: &'a [usize],
    /// Per response its coefficients (m): [q0, c1, s1, c2, s2, ...] over `harmonics`, q(t) = q0 + sum ck cos kwt + sk sin kwt;
    /// null without a solution.
    responses: Option<BTreeMap<&'a str, Vec<f64>>>,
    /// Shares of (pair, time) in each contact state; null without a solution.
    contact_fractions: Option<ContactFractions>,
    /// Work per period (J); null without a solution.
    work_j: Option<CycleWork>,
    /// Stated relative error of the amplitude by the harmonics left out; null with `alert = false`, or where no solution with
    /// other harmonics was found.
    truncation_error: Option<f64>,
    /// Floquet multiplier of the largest modulus [real part, imaginary part]: above 1.01 in modulus the solution is unstable; null
    /// where stability was not assessed.
    multiplier: Option<[f64; 2]>,
    /// Largest residual of the equations over the static displacement of the contacts; null where it is not finite.
    #[schemars(with = "Option<f64>")]
    residual: f64,
    /// Newton iterations, failed attempts included.
    newton_iterations: usize,
    /// Linear factorisations, failed attempts included.
    factorizations: usize,
}

impl FrequencyRecord {
    fn new(omega: f64, unit: FrequencyUnit) -> Self {
        let frequency = |u| (unit == u).then(|| unit.of_rad_s(omega));
        Self {
            frequency_hz: frequency(FrequencyUnit::Hertz),
            frequency_rad_s: frequency(FrequencyUnit::RadiansPerSecond),
        }
    }
}

impl<'a> LevelRecord<'a> {
    fn new(curve: &'a LevelCurve, unit: FrequencyUnit, names: &[&'a str]) -> Self {
        let stop = |stop: Stop| StopRecord {
            frequency: FrequencyRecord::new(stop.omega, unit),
            status: stop.status,
        };
        let Response {
            solutions, work, ..
        } = &curve.response;
        Self {
            level: curve.level,
            gap: curve.response.gap.map(|Gap { below, above }| GapRecord {
                below: stop(below),
                above: stop(above),
            }),
            largest_amplitude: curve.largest().map(|(solution, is)| LargestRecord {
                frequency: FrequencyRecord::new(solution.omega, unit),
                amplitude: solution.amplitude(0),
                is,
            }),
            points: (solutions.iter().zip(work))
                .map(|(solution, work)| PointRecord::new(solution, *work, unit, names))
                .collect(),
        }
    }
}

impl<'a> PointRecord<'a> {
    fn new(
        solution: &'a Solution,
        work: WorkCount,
        unit: FrequencyUnit,
        names: &[&'a str],
    ) -> Self {
        let coefficients = |i: usize| {
            let rows = solution.responses.chunks_exact(names.len());
            rows.map(|row| row[i]).collect()
        };
        let named = names.iter().enumerate();
        let solved = solution.status.has_solution();
        Self {
            frequency: FrequencyRecord::new(solution.omega, unit),
            status: solution.status,
            harmonics: solution.harmonics.orders(),
            responses: solved.then(|| named.map(|(i, name)| (*name, coefficients(i))).collect()),
            contact_fractions: solved.then_some(solution.contact),
            work_j: solved.then_some(solution.work),
            truncation_error: solution.truncation_error,
            multiplier: multiplier(solution),
            residual: solution.residual,
            newton_iterations: work.iterations,
            factorizations: work.factorizations,
        }
    }
}

/// Real and imaginary part of the largest multiplier.
fn multiplier(solution: &Solution) -> Option<[f64; 2]> {
    let stability = solution.stability?;
    Some([stability.multiplier.re, stability.multiplier.im])
}

fn write_csv(
    out: &mut dyn Write,
    unit: FrequencyUnit,
    names: &[&str],
    curves: &[LevelCurve],
) -> std::io::Result<()> {
    let length = match unit {
        FrequencyUnit::Hertz => "_m",
        FrequencyUnit::RadiansPerSecond => "",
    };
    let amplitude = |name: &&str| format!("amplitude_{name}{length}");
    let head = [
        vec![
            "level".to_owned(),
            format!("frequency_{}", unit.suffix()),
            "status".to_owned(),
        ],
        names.iter().map(amplitude).collect(),
        LAST_COLUMNS.map(str::to_owned).to_vec(),
    ];
    let mut table = csv::Writer::from_writer(out);
    table.write_record(head.concat())?;
    for curve in curves {
        let Response {
            solutions, work, ..
        } = &curve.response;
        for (solution, work) in solutions.iter().zip(work) {
            let frequency = unit.of_rad_s(solution.omega);
            let place = [curve.level.to_string(), frequency.to_string()];
            table.write_record(row(place, solution, *work, names.len()))?;
        }
    }
    table.flush()
}

/// Columns of `curve.csv` after the amplitudes.
const LAST_COLUMNS: [&str; 9] = [
    "stick_fraction",
    "slip_fraction",
    "separated_fraction",
    "truncation_error",
    "multiplier_real",
    "multiplier_imaginary",
    "residual",
    "newton_iterations",
    "factorizations",
];

/// A row at a level and frequency: what a failed solve does not have stays empty.
fn row(
    place: [String; 2],
    solution: &Solution,
    work: WorkCount,
    n_responses: usize,
) -> Vec<String> {
    let solved = solution.status.has_solution();
    let optional = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    let if_solved = |value: f64| optional(solved.then_some(value));
    let ContactFractions {
        stick,
        slip,
        separated,
    } = solution.contact;
    let mut row = place.to_vec();
    row.push(solution.status.name().to_owned());
    row.extend((0..n_responses).map(|i| if_solved(solution.amplitude(i))));
    row.extend([stick, slip, separated].map(if_solved));
    row.push(optional(solution.truncation_error.filter(|_| solved)));
    let multiplier = multiplier(solution);
    row.extend([0, 1].map(|part| optional(multiplier.map(|m| m[part]))));
    row.push(optional(Some(solution.residual).filter(|r| r.is_finite())));
    row.extend([work.iterations, work.factorizations].map(|n| n.to_string()));
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harmonics::HarmonicSet;

    fn solution(status: Status) -> Solution {
        Solution {
            status,
            omega: std::f64::consts::TAU * 50.0,
            level: 2.0,
            harmonics: HarmonicSet::up_to(1),
            relative: Vec::new(),
            responses: vec![0.0, 7.0, 3.0, 0.0, 4.0, 1.0],
            residual: 1e-12,
            contact: ContactFractions::default(),
            flight_fraction: 0.0,
            work: CycleWork::default(),
            kinetic_energy: 0.0,
            truncation_error: None,
            stability: None,
            sharpness: None,
            route: None,
            force: Vec::new(),
        }
    }

    const WORK: WorkCount = WorkCount {
        iterations: 3,
        factorizations: 2,
    };

    fn curve(solutions: Vec<Solution>) -> LevelCurve {
        LevelCurve {
            level: 2.0,
            band: Band {
                low: 1.0,
                high: 1000.0,
            },
            response: Response {
                work: vec![WORK; solutions.len()],
                solutions,
                is_curve: true,
                gap: None,
            },
        }
    }

    /// Seen to fail with the amplitude written whatever the status.
    #[test]
    fn rows_hold_amplitudes_of_solved_points_only() {
        let overflown = Solution {
            residual: f64::NAN,
            ..solution(Status::NonFinite)
        };
        let solved = solution(Status::Converged);
        let curves = [curve(vec![
            solved,
            solution(Status::MaxIterations),
            overflown,
        ])];
        let mut text = Vec::new();
        write_csv(
            &mut text,
            FrequencyUnit::Hertz,
            &["tip", "a,\"b\""],
            &curves,
        )
        .unwrap();
        let text = String::from_utf8(text).unwrap();
        let lines: Vec<_> = text.lines().collect();
        assert!(
            lines[0].starts_with(
                "level,frequency_hz,status,amplitude_tip_m,\"amplitude_a,\"\"b\"\"_m\","
            )
        );
        assert!(lines[1].starts_with("2,50,converged,5,1,"), "{}", lines[1]);
        assert!(
            lines[2].starts_with("2,50,max-iterations,,,"),
            "{}",
            lines[2]
        );
        let columns = |line: &str| line.matches(',').count();
        assert_eq!(columns(lines[1]), columns(lines[2]));
        assert_eq!(lines[3], "2,50,non-finite,,,,,,,,,,3,2");
    }

    #[test]
    fn records_order_coefficients_by_response() {
        let solution = solution(Status::Converged);
        let unit = FrequencyUnit::RadiansPerSecond;
        let record = PointRecord::new(&solution, WORK, unit, &["x", "y"]);
        let responses = record.responses.unwrap();
        assert_eq!(responses["x"], [0.0, 3.0, 4.0]);
        assert_eq!(responses["y"], [7.0, 0.0, 1.0]);
        assert!(record.frequency.frequency_hz.is_none());
    }
}
