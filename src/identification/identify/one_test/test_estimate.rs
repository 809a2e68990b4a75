//! One test: from a record to the parameters of its contact with their uncertainty.

use super::known::known;
use super::series::Series;
use super::test_notes::{notes, other_share, other_start};
use super::unlike::{scatter_of, sides_apart};
use crate::identify::cycles::cycle::{Steady, cut};
use crate::identify::cycles::mean_loop::{MeanLoop, half_swing, noise, swing};
use crate::identify::cycles::scatter::{self, ChainError, RandomError, correlation, of_parts};
use crate::identify::found::result::{
    Friction, LoopResult, LoopValue, Onset, Tangential, TestEstimate, TestResult, TestStatus,
};
use crate::identify::found::uncertain::{Uncertain, factor};
use crate::identify::one_loop::branch::leaves_line;
use crate::identify::one_loop::figure::figure;
use crate::identify::one_loop::half::Ends;
use crate::identify::one_loop::loop_estimate::LoopNumbers;
use crate::identify::one_loop::loop_shape::{LoopShape, shape, shape_without_slip};
use crate::identify::one_loop::misfit::{elastic_coulomb, misfit};
use crate::identify::one_loop::slip_limits::{KnownPressure, PressureSpread};
use crate::identify::settings::IdentifySettings;
use crate::record::HysteresisRecord;
use crate::statistics::hull;
use crate::units::n_per_m_to_n_per_um;

/// Swing of the force of a contact that nowhere slips as a whole, over that of one that sticks, at least.
const LEAST_OF_STUCK: f64 = 0.1;

/// What one test says, with what its record states of the pressure.
#[must_use]
pub fn identify_test(record: &HysteresisRecord, settings: &IdentifySettings) -> TestResult {
    let stated = record.conditions.even_area;
    let spread = stated.map_or(PressureSpread::Unknown, PressureSpread::EvenArea);
    identified(record, settings, spread)
}

/// What one test says of a contact whose pressure is known, whatever its record states of it.
#[must_use]
pub fn identify_pressed_test(
    record: &HysteresisRecord,
    settings: &IdentifySettings,
    pressure: &KnownPressure,
) -> TestResult {
    let spread = PressureSpread::Map(pressure);
    let mut result = identified(record, settings, spread);
    result.notes.extend(other_share(record, pressure));
    result
}

fn identified(
    record: &HysteresisRecord,
    settings: &IdentifySettings,
    spread: PressureSpread<'_>,
) -> TestResult {
    let unusable = |reason| TestResult {
        name: record.name.clone(),
        conditions: record.conditions.clone(),
        status: TestStatus::Unusable(reason),
        cycles: None,
        estimate: None,
        loops: Vec::new(),
        figure: None,
        notes: Vec::new(),
    };
    let steady = match cut(record, settings) {
        Ok(steady) => steady,
        Err(reason) => return unusable(reason),
    };
    let cycles = Some(steady.cycles);
    let found = Test::new(&steady, spread, settings).map(|test| test.result(record));
    match found.and_then(known) {
        Ok(result) => result,
        Err(reason) => TestResult {
            cycles,
            ..unusable(reason)
        },
    }
}

/// Refuses a loop without plateaus that is much flatter than its stick branches: it slips, but nothing tells at which force.
fn check_stick(cycle: &MeanLoop, numbers: &LoopNumbers) -> Result<(), String> {
    let stuck = numbers.stick().unwrap_or(0.0) * swing(&cycle.displacement);
    let is_stuck = numbers.friction.is_some() || swing(&cycle.tangential) > LEAST_OF_STUCK * stuck;
    let samples = cycle.samples();
    is_stuck.then_some(()).ok_or_else(|| {
        format!("slips, but no plateau is told from its turns: more samples of a cycle than {samples} may show one")
    })
}

/// The numbers of a test, of its mean loop and of its batches.
struct Test<'a> {
    settings: &'a IdentifySettings,
    steady: &'a Steady,
    shape: LoopShape<'a>,
    mean: LoopNumbers,
    batches: Vec<LoopNumbers>,
    /// Of the mean loop without each batch, with a knee of its own; empty where no knee was sought.
    own_knee: Vec<LoopNumbers>,
    /// Of the mean loop without each part of the phase.
    without: Vec<LoopNumbers>,
    series: Series,
    chain: ChainError,
    /// Slope of the stick branches as measured (N/m), and of the contact.
    slopes: [f64; 2],
}

impl<'a> Test<'a> {
    fn new(
        steady: &'a Steady,
        spread: PressureSpread<'a>,
        settings: &'a IdentifySettings,
    ) -> Result<Self, String> {
        let mut shape = shape(&steady.mean, steady.batches(), spread)?;
        let mut mean = LoopNumbers::of(&steady.mean, &shape);
        if !mean.has_way_to_slip() {
            shape = shape_without_slip(&steady.mean, steady.batches())?;
            mean = LoopNumbers::of(&steady.mean, &shape);
        }
        check_stick(&steady.mean, &mean)?;
        let series = Series::of(settings);
        let of_each = |loops: &[MeanLoop]| -> Vec<LoopNumbers> {
            loops
                .iter()
                .map(|one| LoopNumbers::of(one, &shape))
                .collect()
        };
        let measured = mean.stick().ok_or("has no stick branch that rises")?;
        Ok(Self {
            settings,
            steady,
            shape,
            batches: of_each(&steady.batches),
            own_knee: own_knee(steady, &shape, spread),
            without: of_each(&steady.common.without),
            mean,
            slopes: [measured, series.contact(measured)?],
            series,
            chain: ChainError::of(settings),
        })
    }

    fn result(&self, record: &HysteresisRecord) -> TestResult {
        let cycle = &self.steady.mean;
        let coefficient = self.mean.friction.map(|plateaus| plateaus.coefficient);
        let mut fitted = elastic_coulomb(cycle, self.slopes[0], coefficient);
        let (rest, misfit) = misfit(&cycle.tangential, &mut fitted);
        let friction = self.friction();
        let loops = self.loops();
        let estimate = TestEstimate {
            normal_force_n: self.mean.normal,
            normal_force_range_n: hull(cycle.normal.iter().copied()).unwrap_or_default(),
            displacement_amplitude_m: half_swing(&cycle.displacement),
            tangential_force_amplitude_n: half_swing(&cycle.tangential),
            friction,
            friction_at_least: match friction {
                None => self.friction_at_least(),
                Some(_) => None,
            },
            tangential: self.tangential(),
            normal_stiffness_n_per_um: self.normal_stiffness(),
            energy_j: self.energy(),
            onset: self.onset(),
            loop_scatter: Some(scatter_of(&loops)),
            error_correlation: correlation(
                &self.of_batches(|numbers| numbers.friction.map(|p| p.coefficient)),
                &self.of_batches(|numbers| Some(-numbers.compliance()?)),
            ),
            misfit,
        };
        let mut notes = notes(&estimate, &self.steady.cycles, record, self.settings);
        notes.extend(other_start(&self.shape));
        TestResult {
            name: record.name.clone(),
            conditions: record.conditions.clone(),
            status: match friction {
                Some(_) => TestStatus::Slips,
                None => TestStatus::NoSlip,
            },
            cycles: Some(self.steady.cycles),
            notes,
            estimate: Some(estimate),
            loops,
            figure: Some(figure(cycle, &self.shape, &self.mean, &fitted, &rest)),
        }
    }

    fn of_batches(&self, number: impl Fn(&LoopNumbers) -> Option<f64>) -> Vec<Option<f64>> {
        self.batches.iter().map(number).collect()
    }

    /// Error of the mean loop by the scatter of values of the batches.
    fn scatter(&self, of_batches: &[Option<f64>]) -> Option<RandomError> {
        scatter::of_batches(of_batches, &self.steady.batch_cycles)
    }

    /// A value of the mean loop with the scatter of the batches, or with `inside`, the error inside the only loop; and with the error
    /// of the model, which is the same in all cycles.
    fn uncertain(
        &self,
        value: f64,
        number: impl Fn(&LoopNumbers) -> Option<f64>,
        inside: RandomError,
        model_error: f64,
        systematic: f64,
    ) -> Uncertain {
        let random = self.scatter(&self.of_batches(number)).unwrap_or(inside);
        let errors = [random.standard_error.hypot(model_error), systematic];
        let freedom = with_model_error(random, model_error);
        Uncertain::new(value, errors, freedom, self.settings.confidence)
    }

    fn friction(&self) -> Option<Friction> {
        let plateaus = self.mean.friction?;
        let places = self.shape.plateaus?;
        let samples = places
            .iter()
            .map(|[first, last]| last + 1 - first)
            .sum::<usize>();
        let inside = RandomError {
            standard_error: plateaus.standard_error.unwrap_or(plateaus.coefficient),
            freedom: samples as f64 - 2.0,
        };
        let from_energy = self.mean.friction_from_energy();
        let offset = plateaus.offset + self.steady.tangential_mean;
        let side = |sign: f64| plateaus.coefficient + sign * offset / plateaus.normal;
        Some(Friction {
            coefficient: self.uncertain(
                plateaus.coefficient,
                |numbers| numbers.friction.map(|p| p.coefficient),
                inside,
                // half a cycle lies between the plateaus: a drift of T moves them apart by half of it
                0.25 * self.steady.unresolved_drift / plateaus.normal,
                plateaus.coefficient * self.chain.of_ratio(),
            ),
            sides: [side(1.0), side(-1.0)],
            tangential_offset_n: offset,
            from_energy,
            energy_difference: from_energy.map(|energy| energy / plateaus.coefficient - 1.0),
            slip_distance_m: plateaus.slip_distance.unwrap_or(0.0),
        })
    }

    /// T/N at both ends, whatever the offset of T, less what noise and the measuring chain may have added.
    fn friction_at_least(&self) -> Option<f64> {
        let of_ends = |cycle: &MeanLoop| {
            let ends = Ends::of(&self.shape.halves, cycle, self.shape.least_normal);
            ends.map(|ends| ends.ratio)
        };
        let value = of_ends(&self.steady.mean)?;
        let batches: Vec<Option<f64>> = self.steady.batches.iter().map(of_ends).collect();
        let random = self.scatter(&batches).unwrap_or(RandomError {
            standard_error: noise(&self.steady.mean.tangential) / self.mean.normal,
            freedom: f64::INFINITY,
        });
        let error = random.standard_error.hypot(value * self.chain.of_ratio());
        let one_side = factor(random.freedom, 2.0 * self.settings.confidence - 1.0);
        Some((value - one_side * error).max(0.0))
    }

    fn tangential(&self) -> Tangential {
        let windows = self.shape.windows;
        let samples = windows.map(|w| w.map_or(0, |w| w.places[1] + 1 - w.places[0]));
        let sides = [0, 1].map(|side| {
            let line = self.mean.lines[side].filter(|line| line.slope > 0.0)?;
            let contact = self.series.contact(line.slope).ok()?;
            let number = move |numbers: &LoopNumbers| numbers.lines[side].map(|l| 1.0 / l.slope);
            let model_error = line.model_error / line.slope;
            Some(self.stiffness(
                [line.slope, contact],
                number,
                self.inside(side),
                model_error,
            ))
        });
        let lines = || (0..2).filter_map(|side| Some((side, self.mean.lines[side]?)));
        let count = lines().count() as f64;
        let insides: Vec<RandomError> = lines().map(|(side, _)| self.inside(side)).collect();
        let square: f64 = insides.iter().map(|e| e.standard_error.powi(2)).sum();
        let inside = RandomError {
            standard_error: square.sqrt() / count,
            freedom: insides.iter().map(|e| e.freedom).sum(),
        };
        let models = lines().map(|(_, line)| (line.model_error / line.slope).abs());
        let mut model_error = models.sum::<f64>() / count;
        if let Some(distance) = sides_apart(&sides) {
            // one stiffness for two: the standard error of their mean
            let half = 0.5 * libm::log(1.0 + distance);
            let amplified =
                self.series.derivative(self.slopes[0]) * self.slopes[0] / self.slopes[1];
            model_error = model_error.hypot(half / amplified);
        }
        Tangential {
            stiffness_n_per_um: self.stiffness(
                self.slopes,
                LoopNumbers::compliance,
                inside,
                model_error,
            ),
            sides_n_per_um: sides,
            measured_n_per_um: n_per_m_to_n_per_um(self.slopes[0]),
            samples,
            window_end: windows.map(|w| w.map_or(0.0, |w| w.end)),
            bent: windows.map(|w| {
                w.is_some_and(|w| w.straightened.is_some_and(|s| s.knee.bends_before(w.end)))
            }),
        }
    }

    /// Relative error of a slope inside the mean loop.
    fn inside(&self, side: usize) -> RandomError {
        let window = self.shape.windows[side];
        let [first, last] = window.map_or([0, 0], |w| w.places);
        let y = self.shape.halves[side].force(&self.steady.mean);
        // two points, each with the noise of the force
        let coarse = noise(&self.steady.mean.tangential) * 2_f64.sqrt() / (y[last] - y[first]);
        let line = self.mean.lines[side];
        let own = line.and_then(|line| Some(line.standard_error? / line.slope));
        RandomError {
            standard_error: own.unwrap_or(coarse).abs(),
            freedom: ((last + 1 - first) as f64 - 2.0).max(1.0),
        }
    }

    /// Stiffness of the contact (N/µm) from the slope as measured and that of the contact (N/m). Its errors are those of its logarithm,
    /// as of the compliance: noise of the displacement is even in the compliance, and may be as large. `inside` and `model_error` are
    /// relative.
    fn stiffness(
        &self,
        [measured, contact]: [f64; 2],
        compliance: impl Fn(&LoopNumbers) -> Option<f64>,
        inside: RandomError,
        model_error: f64,
    ) -> Uncertain {
        let relative = |found: RandomError| RandomError {
            standard_error: measured * found.standard_error,
            ..found
        };
        // noise that bends a branch moves its knee, too: the scatter of batches with the knee of the mean loop does not show it
        let batches = match self.own_knee.is_empty() {
            true => self.scatter(&self.of_batches(&compliance)),
            false => of_parts(&self.own_knee.iter().map(&compliance).collect::<Vec<_>>()),
        };
        let batches = batches.map(relative);
        let without: Vec<Option<f64>> = self.without.iter().map(compliance).collect();
        let common = of_parts(&without).map(relative);
        let steps = self.steady.common.steps.map(|steps| RandomError {
            standard_error: steps.error_of_slope(swing(&self.steady.mean.tangential) / measured),
            freedom: f64::INFINITY,
        });
        // what all cycles have in common, such as a rig that rings after each reversal, is inside the line or between its parts
        let others = [batches, common, steps].into_iter().flatten();
        let larger = |a: RandomError, b: RandomError| match b.standard_error > a.standard_error {
            true => b,
            false => a,
        };
        let random = others.fold(inside, larger);
        let errors = [
            random.standard_error.hypot(model_error),
            self.chain.of_slope(),
        ];
        let amplified = self.series.derivative(measured) * measured / contact;
        Uncertain::of_logarithm(
            libm::log(n_per_m_to_n_per_um(contact)),
            errors.map(|error| amplified * error),
            with_model_error(random, model_error),
            self.settings.confidence,
        )
    }

    fn normal_stiffness(&self) -> Option<Uncertain> {
        let line = self.mean.normal_line?;
        let inside = RandomError {
            standard_error: line.standard_error?,
            freedom: 0.5 * self.steady.mean.samples() as f64,
        };
        let number = |numbers: &LoopNumbers| numbers.normal_line.map(|line| line.slope);
        let found = self.uncertain(
            line.slope,
            number,
            inside,
            0.0,
            line.slope * self.chain.of_slope(),
        );
        (line.slope > 0.0).then(|| found.scaled(n_per_m_to_n_per_um(1.0)))
    }

    fn energy(&self) -> Uncertain {
        let cycle = &self.steady.mean;
        let n = cycle.samples();
        let steps = (0..n)
            .map(|i| 0.5 * (cycle.displacement[(i + 1) % n] - cycle.displacement[(i + n - 1) % n]));
        let inside = RandomError {
            standard_error: noise(&cycle.tangential) * steps.map(|d| d * d).sum::<f64>().sqrt(),
            freedom: n as f64,
        };
        let energy = self.mean.energy;
        self.uncertain(
            energy,
            |numbers| Some(numbers.energy),
            inside,
            // the corners between samples are the same in all cycles: their scatter does not show them
            cycle.energy_at_corners(),
            energy.abs() * self.chain.of_slope(),
        )
    }

    fn onset(&self) -> Option<Onset> {
        let plateaus = self.mean.friction?;
        let cycle = &self.steady.mean;
        let left: Vec<(f64, f64)> = (0..2)
            .filter_map(|side| {
                let half = &self.shape.halves[side];
                let (way, place) = leaves_line(half, cycle, &self.mean.lines[side]?)?;
                let force = half.force(cycle);
                let swing = 2.0 * plateaus.coefficient * plateaus.normal;
                Some((way, (force[place] - force[0]) / swing))
            })
            .collect();
        let count = left.len() as f64;
        (!left.is_empty()).then(|| Onset {
            elastic_limit_m: plateaus.coefficient * plateaus.normal / self.slopes[1],
            first_slip_m: left.iter().map(|(way, _)| way).sum::<f64>() / count,
            first_slip_share: left.iter().map(|(_, share)| share).sum::<f64>() / count,
        })
    }

    fn loops(&self) -> Vec<LoopResult> {
        let numbered = self
            .steady
            .loops
            .iter()
            .zip(&self.steady.starts)
            .enumerate();
        let of = |(cycle, (one, start)): (usize, (&MeanLoop, &f64))| {
            let numbers = LoopNumbers::of(one, &self.shape);
            let stiffness = |side: usize| {
                let line = numbers.lines[side].filter(|line| line.slope > 0.0)?;
                let value = self.series.contact(line.slope).ok()?;
                let error = line
                    .standard_error
                    .map(|e| e * self.series.derivative(line.slope));
                Some(LoopValue {
                    value: n_per_m_to_n_per_um(value),
                    standard_error: error.map(n_per_m_to_n_per_um),
                })
            };
            LoopResult {
                cycle,
                start_s: *start,
                steady: cycle >= self.steady.cycles.run_in,
                normal_force_n: numbers.normal,
                friction_coefficient: numbers.friction.map(|p| LoopValue {
                    value: p.coefficient,
                    standard_error: p.standard_error,
                }),
                friction_from_energy: numbers.friction_from_energy(),
                tangential_stiffness_n_per_um: [0, 1].map(stiffness),
                normal_stiffness_n_per_um: numbers.normal_line.map(|line| LoopValue {
                    value: n_per_m_to_n_per_um(line.slope),
                    standard_error: line.standard_error.map(n_per_m_to_n_per_um),
                }),
                energy_j: numbers.energy,
            }
        };
        numbered.map(of).collect()
    }
}

/// Numbers of the mean loop without each batch in turn, with a knee of its own each; none where no knee was sought.
fn own_knee<'m>(
    steady: &Steady,
    shape: &LoopShape<'m>,
    spread: PressureSpread<'m>,
) -> Vec<LoopNumbers> {
    if !shape.has_knee() {
        return Vec::new();
    }
    let each = steady.without_batches();
    let numbers = |cycle: &MeanLoop| {
        let own = LoopShape::with_own_knee(cycle, steady.batches(), spread);
        LoopNumbers::of(cycle, &own.unwrap_or(*shape))
    };
    each.iter().map(numbers).collect()
}

/// Degrees of freedom of a random error with an error of the model, which has none that the batches could limit (Welch and
/// Satterthwaite).
fn with_model_error(random: RandomError, model_error: f64) -> f64 {
    let share = match random.standard_error > 0.0 {
        true => (model_error / random.standard_error).powi(2),
        false => 0.0,
    };
    random.freedom * (1.0 + share).powi(2)
}
