//! Measured numbers as a likelihood takes them: means over repetitions, and what is known of their scatter.

use crate::record::{ResponsePoint, ResponseRecord};
use crate::setting::BadSetting;
use libm::log;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// A measured quantity of a resonance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ObservedQuantity {
    /// Resonance frequency (Hz).
    Frequency,
    /// Natural logarithm of the amplitude in m, so that scatter is relative.
    LogAmplitude,
}

impl ObservedQuantity {
    /// Both, in the order of every list by quantity.
    pub const ALL: [Self; 2] = [Self::Frequency, Self::LogAmplitude];

    fn of(self, point: &ResponsePoint) -> (f64, Option<f64>) {
        match self {
            Self::Frequency => (point.frequency_hz, point.frequency_deviation_hz),
            Self::LogAmplitude => {
                let relative = |deviation: f64| deviation / point.amplitude_m;
                let deviation = point.amplitude_deviation_m.map(relative);
                (log(point.amplitude_m), deviation)
            }
        }
    }
}

/// Mean of one quantity at one level.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Observation {
    /// Place of the level among those of the study.
    pub level: usize,
    /// The quantity.
    pub quantity: ObservedQuantity,
    /// Mean over the repetitions, weighted where they state deviations.
    pub mean: f64,
    /// Number of repetitions.
    pub repetitions: usize,
    /// Variance of the mean: by the deviations that are stated, else by the scatter of the repetitions.
    pub variance: f64,
}

/// Scatter of one measurement as the repetitions show it, of all levels together.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Scatter {
    /// Standard deviation: of a frequency in Hz, of an amplitude relative.
    pub standard_deviation: f64,
    /// Its degrees of freedom: repetitions without one for each level.
    pub degrees_of_freedom: usize,
}

/// Scatter of repetitions beside the standard deviations that their file states, of all levels together.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct StatedCheck {
    /// Scatter over what the stated deviations explain.
    pub factor: f64,
    /// Probability of so much scatter or more if the stated deviations are right.
    pub probability: f64,
}

/// All that was measured.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Observations {
    /// By level, then by quantity.
    pub means: Vec<Observation>,
    /// Scatter by quantity; absent where the deviations are stated.
    pub scatter: [Option<Scatter>; 2],
    /// Whether repetitions agree with stated deviations, by quantity; absent where none are stated or no level is repeated.
    pub stated: [Option<StatedCheck>; 2],
}

/// Fewest degrees of freedom of a scatter that stands for a standard deviation: Student's distribution has a variance then.
const FEWEST_FREEDOM: usize = 3;

impl Scatter {
    /// Variance of one measurement, with what so few repetitions leave unknown of it: that of Student's distribution.
    fn variance(self) -> f64 {
        let freedom = self.degrees_of_freedom as f64;
        self.standard_deviation.powi(2) * freedom / (freedom - 2.0)
    }
}

/// Why a measured response cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub struct BadResponse {
    /// Line of the point at fault; absent where it is the whole file.
    pub line: Option<u64>,
    /// The column and the rule.
    pub fault: BadSetting,
}

/// Relative difference of two levels that are the same.
const SAME_LEVEL: f64 = 1e-9;

impl Observations {
    /// Means of a measured response at the `levels` of a study.
    ///
    /// # Errors
    /// [`BadResponse`] with the name of a column: a level that the study does not have, or deviations that neither the file nor
    /// repetitions give.
    pub fn of(record: &ResponseRecord, levels: &[f64]) -> Result<Self, BadResponse> {
        let mut at: Vec<Vec<&ResponsePoint>> = vec![Vec::new(); levels.len()];
        for (i, point) in record.points.iter().enumerate() {
            let same = |level: &f64| (level / point.level_n - 1.0).abs() <= SAME_LEVEL;
            let rule = || format!("must be one of the levels of the study: {levels:?}");
            let refused = || BadResponse {
                line: record.lines.get(i).copied(),
                fault: BadSetting::new("level", point.level_n, rule()),
            };
            let place = levels.iter().position(same).ok_or_else(refused)?;
            at[place].push(point);
        }
        let is_stated = |quantity: ObservedQuantity| {
            let mut points = record.points.iter();
            points.all(|point| quantity.of(point).1.is_some())
        };
        let (mut scatter, mut stated) = ([None; 2], [None; 2]);
        for (k, quantity) in ObservedQuantity::ALL.into_iter().enumerate() {
            match is_stated(quantity) {
                true => stated[k] = stated_check(quantity, &at),
                false => {
                    let of_file = |fault| BadResponse { line: None, fault };
                    scatter[k] = Some(pooled(quantity, &at).map_err(of_file)?);
                }
            }
        }
        let measured = at
            .iter()
            .enumerate()
            .filter(|(_, points)| !points.is_empty());
        let means = measured.flat_map(|(level, points)| {
            let quantities = ObservedQuantity::ALL.into_iter().zip(scatter);
            quantities.map(move |(quantity, scatter)| mean(level, quantity, points, scatter))
        });
        let means = means.collect();
        Ok(Self {
            means,
            scatter,
            stated,
        })
    }

    /// Places of the levels that were measured.
    #[must_use]
    pub fn levels(&self) -> Vec<usize> {
        let mut levels: Vec<usize> = self.means.iter().map(|o| o.level).collect();
        levels.dedup();
        levels
    }
}

fn mean(
    level: usize,
    quantity: ObservedQuantity,
    points: &[&ResponsePoint],
    scatter: Option<Scatter>,
) -> Observation {
    let variance = |stated: Option<f64>| match scatter {
        Some(scatter) => scatter.variance(),
        None => stated.unwrap_or(0.0).powi(2),
    };
    let numbers = points.iter().map(|point| quantity.of(point));
    let weighted: Vec<(f64, f64)> = numbers
        .map(|(value, deviation)| (value, 1.0 / variance(deviation)))
        .collect();
    let sum: f64 = weighted.iter().map(|(_, weight)| weight).sum();
    Observation {
        level,
        quantity,
        mean: weighted.iter().map(|(v, w)| v * w).sum::<f64>() / sum,
        repetitions: points.len(),
        variance: 1.0 / sum,
    }
}

/// Scatter of the repetitions about the means of their levels.
fn pooled(quantity: ObservedQuantity, at: &[Vec<&ResponsePoint>]) -> Result<Scatter, BadSetting> {
    let (mut square, mut degrees_of_freedom) = (0.0, 0);
    for points in at.iter().filter(|points| points.len() > 1) {
        let values: Vec<f64> = points.iter().map(|p| quantity.of(p).0).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        square += values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        degrees_of_freedom += values.len() - 1;
    }
    let key = match quantity {
        ObservedQuantity::Frequency => "frequency deviation",
        ObservedQuantity::LogAmplitude => "amplitude deviation",
    };
    let rule = "must be a column of the file, or levels must be repeated, at least three rows more than levels, with numbers that \
                differ: nothing else says how far a measurement is to be trusted";
    let known = degrees_of_freedom >= FEWEST_FREEDOM && square > 0.0;
    BadSetting::unless(known, key, "(absent)", rule)?;
    Ok(Scatter {
        standard_deviation: (square / degrees_of_freedom as f64).sqrt(),
        degrees_of_freedom,
    })
}

/// Repetitions against their stated deviations: Σ ((y − ȳ)/σ)² about the weighted means ȳ of the levels is χ² with one degree of
/// freedom less per level than repetitions.
fn stated_check(quantity: ObservedQuantity, at: &[Vec<&ResponsePoint>]) -> Option<StatedCheck> {
    let (mut square, mut degrees_of_freedom) = (0.0, 0);
    for points in at.iter().filter(|points| points.len() > 1) {
        let about = mean(0, quantity, points, None).mean;
        let of_points = points.iter().map(|point| quantity.of(point));
        let squares =
            of_points.filter_map(|(y, deviation)| Some(((y - about) / deviation?).powi(2)));
        square += squares.sum::<f64>();
        degrees_of_freedom += points.len() - 1;
    }
    let freedom = degrees_of_freedom as f64;
    // refused without a degree of freedom
    let law = ChiSquared::new(freedom).ok()?;
    Some(StatedCheck {
        factor: (square / freedom).sqrt(),
        probability: law.sf(square),
    })
}
