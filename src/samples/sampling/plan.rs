//! How the unit cube of the random inputs is filled.

use super::Input;
use super::correlation::identity;
use super::latin::LatinHypercube;
use super::pick_freeze::{INDEPENDENT, MOST_INPUTS, PickFreeze};
use super::sobol::{MOST_DIMENSIONS, Sobol};
use super::stream::{SCRAMBLE, uniform};
use crate::setting::BadSetting;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Kind of a design, as written in a study file.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum DesignKind {
    /// Independent samples, which depend neither on the other inputs nor on `samples`.
    #[default]
    MonteCarlo,
    /// One value in each of `samples` strata of each input, with controlled correlations; cannot be extended.
    LatinHypercube,
    /// Scrambled Sobol' points (Owen) in independent `replicates`, whose scatter shows the error; `samples` is a power of two
    /// times these.
    Sobol,
    /// Scrambled Sobol' points in rows that give Sobol' indices; `samples` is a power of two times 2 and one per random input.
    PickFreeze,
    /// Full grid of the middles of cells of equal probability, `points` per input; `samples` follows.
    Grid,
    /// Rows of the file `path`: a line of input names and one row per sample (`#` starts a comment). Inputs that it lacks are
    /// drawn by Monte Carlo.
    File,
}

impl DesignKind {
    /// Name in study files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::MonteCarlo => "monte-carlo",
            Self::LatinHypercube => "latin-hypercube",
            Self::Sobol => "sobol",
            Self::PickFreeze => "pick-freeze",
            Self::Grid => "grid",
            Self::File => "file",
        }
    }
}

/// How the samples are chosen. Each kind takes its own keys and refuses the others; without the table it is Monte Carlo.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    {
        "properties": {
            "kind": { "enum": ["monte-carlo", "latin-hypercube", "pick-freeze"] },
            "replicates": false, "points": false, "path": false
        }
    },
    { "properties": { "kind": { "const": "sobol" }, "points": false, "path": false } },
    {
        "properties": { "kind": { "const": "grid" }, "replicates": false, "path": false },
        "required": ["points"]
    },
    {
        "properties": { "kind": { "const": "file" }, "replicates": false, "points": false },
        "required": ["path"]
    }
]))]
pub struct DesignTable {
    /// Kind of the design.
    pub kind: DesignKind,
    /// Independent scramblings of Sobol' points.
    #[schemars(range(min = 1, max = MOST_REPLICATES), extend("default" = 1))]
    replicates: Option<u64>,
    /// Points of a grid: 5, or { NAME = 5, ... }.
    points: Option<Points>,
    /// File of a design of rows, `.csv` or `.parquet`, relative to the study file.
    path: Option<PathBuf>,
}

/// Points of a grid.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number of points, or a table of input = points"
)]
enum Points {
    /// So many for each input.
    Each(#[schemars(range(min = 1))] u64),
    /// By input.
    PerInput(BTreeMap<String, u64>),
}

/// Replicates at most.
const MOST_REPLICATES: u64 = 1000;
/// Samples of a Latin hypercube at most: it is held in memory.
const MOST_STRATA: u64 = 10_000_000;

/// A design of the unit cube, ready to give its points.
#[derive(Debug, Clone, PartialEq)]
pub enum Plan {
    /// Independent numbers.
    MonteCarlo,
    /// Strata in a fixed order.
    LatinHypercube(LatinHypercube),
    /// Sample i is point ⌊i / replicates⌋ of replicate i mod replicates.
    Sobol {
        /// The points.
        sequence: Sobol,
        /// Number of independent scramblings.
        replicates: u64,
    },
    /// Rows of points that share coordinates.
    PickFreeze(PickFreeze),
    /// Points per input; the first input changes fastest. Values are the middles of cells of equal probability.
    Grid(Vec<u64>),
}

/// How the number of samples of a design can grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Growth {
    /// By any number.
    Any,
    /// To any number up to that of the rows of a file.
    UpTo(u64),
    /// To `unit` times a power of two, of which `population` times that power are draws of the population.
    Doubling {
        /// Samples per point of the sequence.
        unit: u64,
        /// Those of them that are draws.
        population: u64,
    },
    /// Not at all: all samples depend on their number.
    Fixed,
}

impl Growth {
    /// Smallest number of samples of which at least `wanted` are draws of the population; `None` if the design cannot grow so far.
    #[must_use]
    pub fn total(self, wanted: u64) -> Option<u64> {
        match self {
            Self::Any => Some(wanted),
            Self::UpTo(rows) => Some(wanted).filter(|n| *n <= rows),
            Self::Doubling { unit, population } => {
                let points = wanted.div_ceil(population).checked_next_power_of_two()?;
                points.checked_mul(unit)
            }
            Self::Fixed => None,
        }
    }
}

impl DesignTable {
    /// Checks that the keys are those of the kind.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[design]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        let given = [
            ("replicates", self.replicates.is_some(), DesignKind::Sobol),
            ("points", self.points.is_some(), DesignKind::Grid),
            ("path", self.path.is_some(), DesignKind::File),
        ];
        for (key, given, kind) in given {
            let name = self.kind.name();
            let rule = format!("must be absent: a design of kind \"{name}\" does not take it");
            BadSetting::unless(!given || self.kind == kind, key, "(given)", &rule)?;
            let rule = format!("must be given for a design of kind \"{name}\"");
            let optional = kind == DesignKind::Sobol;
            let holds = given || optional || self.kind != kind;
            BadSetting::unless(holds, key, "(absent)", &rule)?;
        }
        let replicates = self.replicates();
        let rule = format!("must be from 1 to {MOST_REPLICATES}");
        let holds = (1..=MOST_REPLICATES).contains(&replicates);
        BadSetting::unless(holds, "replicates", replicates, &rule)
    }

    /// The file of a design of rows.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    fn replicates(&self) -> u64 {
        self.replicates.unwrap_or(1)
    }

    /// Points per input of a grid, in the order of `inputs`.
    fn grid(&self, inputs: &[Input]) -> Result<Vec<u64>, BadSetting> {
        let points: Vec<u64> = match &self.points {
            None => Vec::new(),
            Some(Points::Each(n)) => vec![*n; inputs.len()],
            Some(Points::PerInput(table)) => {
                let named = |input: &Input| input.name();
                if let Some(name) = table
                    .keys()
                    .find(|k| !inputs.iter().any(|i| named(i) == **k))
                {
                    let rule = "must name an input with a distribution";
                    let key = format!("design.points.{name}");
                    return Err(BadSetting::new(key, "(given)", rule));
                }
                let of = |input: &Input| {
                    let rule = format!("must hold {} too", input.name());
                    let points = table.get(input.name()).copied();
                    points.ok_or_else(|| BadSetting::new("design.points", "{...}", rule))
                };
                inputs.iter().map(of).collect::<Result<_, _>>()?
            }
        };
        match points.iter().find(|n| **n < 1) {
            Some(n) => Err(BadSetting::new("design.points", n, "must be at least 1")),
            None => Ok(points),
        }
    }

    /// The plan for the given inputs, and the number of its samples where the design decides that.
    ///
    /// `samples` is the number asked for (per outer point), `correlation` that of the normal scores; shape: inputs square.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to the file: `samples`, `design.…`.
    pub fn plan(
        &self,
        seed: u64,
        samples: Option<u64>,
        inputs: &[Input],
        correlation: Option<&[Vec<f64>]>,
    ) -> Result<(Plan, Option<u64>), BadSetting> {
        self.validate().map_err(|bad| bad.under("design"))?;
        match self.kind {
            DesignKind::MonteCarlo | DesignKind::File => Ok((Plan::MonteCarlo, None)),
            DesignKind::LatinHypercube => {
                let hypercube = latin_hypercube(seed, samples, inputs, correlation)?;
                Ok((Plan::LatinHypercube(hypercube), None))
            }
            DesignKind::Sobol => Ok((self.sobol(samples, inputs)?, None)),
            DesignKind::PickFreeze => {
                let rule = "must be absent: with correlated inputs Sobol' indices are no shares of the variance";
                let free = correlation.is_none();
                BadSetting::unless(free, "correlation", "(given)", rule)?;
                Ok((pick_freeze(samples, inputs)?, None))
            }
            DesignKind::Grid => {
                let points = self.grid(inputs)?;
                let rule = "must be absent: correlated inputs have no grid";
                let free = correlation.is_none();
                BadSetting::unless(free, "correlation", "(given)", rule)?;
                let count = points.iter().try_fold(1_u64, |all, n| all.checked_mul(*n));
                let rule = format!(
                    "must be the number of grid points, {}, or absent",
                    count.unwrap_or(u64::MAX)
                );
                let holds = samples.is_none() || samples == count;
                BadSetting::unless(holds, "samples", samples.unwrap_or(0), &rule)?;
                Ok((Plan::Grid(points), Some(count.unwrap_or(u64::MAX))))
            }
        }
    }

    fn sobol(&self, samples: Option<u64>, inputs: &[Input]) -> Result<Plan, BadSetting> {
        let replicates = self.replicates();
        let of = match replicates {
            1 => String::new(),
            n => format!(" times {n} replicates"),
        };
        power_of_two_times(replicates, given(samples)?, &of)?;
        let rule =
            format!("must be of another kind: Sobol' points have at most {MOST_DIMENSIONS} inputs");
        let few = inputs.len() <= MOST_DIMENSIONS;
        BadSetting::unless(few, "design.kind", "\"sobol\"", &rule)?;
        Ok(Plan::Sobol {
            sequence: Sobol::new(inputs.len()),
            replicates,
        })
    }
}

fn given(samples: Option<u64>) -> Result<u64, BadSetting> {
    let rule = "must be given for this kind of design";
    samples.ok_or_else(|| BadSetting::new("samples", "(absent)", rule))
}

fn pick_freeze(samples: Option<u64>, inputs: &[Input]) -> Result<Plan, BadSetting> {
    let n = inputs.len();
    let rule = format!(
        "must be of another kind: a pick-freeze design has 1 to {MOST_INPUTS} random inputs, not {n}"
    );
    let holds = (1..=MOST_INPUTS).contains(&n);
    BadSetting::unless(holds, "design.kind", "\"pick-freeze\"", &rule)?;
    let design = PickFreeze::new(n);
    let of = format!(" times {} (2 and one per input)", design.row());
    power_of_two_times(design.row(), given(samples)?, &of)?;
    Ok(Plan::PickFreeze(design))
}

/// Refuses a number of samples that is no power of two times `unit`, which the message calls `of`.
fn power_of_two_times(unit: u64, samples: u64, of: &str) -> Result<(), BadSetting> {
    let points = samples / unit;
    let whole = points * unit == samples && points.is_power_of_two();
    let lower = match points {
        0 => 1,
        n => 1 << n.ilog2(),
    };
    let (lower, upper) = (lower * unit, 2 * lower * unit);
    let rule = format!("must be a power of two{of}: {lower} or {upper}");
    BadSetting::unless(whole, "samples", samples, &rule)
}

fn latin_hypercube(
    seed: u64,
    samples: Option<u64>,
    inputs: &[Input],
    correlation: Option<&[Vec<f64>]>,
) -> Result<LatinHypercube, BadSetting> {
    let samples = given(samples)?;
    let bad = |rule: String| BadSetting::new("samples", samples, rule);
    let count = u32::try_from(samples)
        .ok()
        .filter(|_| samples <= MOST_STRATA);
    let rule = format!("must be at most {MOST_STRATA} in a Latin hypercube");
    let count = count.ok_or_else(|| bad(rule))?;
    let dimensions: Vec<u32> = inputs.iter().map(|input| input.dimension()).collect();
    let none = identity(inputs.len());
    let wanted = correlation.unwrap_or(&none);
    LatinHypercube::new(seed, count, &dimensions, wanted).ok_or_else(|| {
        bad(format!(
            "must be more than a Latin hypercube of {} inputs has here: its correlations cannot be controlled",
            inputs.len()
        ))
    })
}

impl Plan {
    /// Uniform numbers of sample `i` for the given inputs, the same as in [`DesignTable::plan`]. Shape: `[inputs]`.
    #[must_use]
    pub fn point(&self, seed: u64, i: u64, inputs: &[Input]) -> Vec<f64> {
        match self {
            Self::MonteCarlo => (inputs.iter())
                .map(|input| uniform(seed, i, input.dimension()))
                .collect(),
            Self::LatinHypercube(hypercube) => hypercube.point(seed, i),
            Self::Sobol {
                sequence,
                replicates,
            } => sequence.scrambled(seed, i % replicates, SCRAMBLE, i / replicates),
            Self::PickFreeze(design) => design.point(seed, i),
            Self::Grid(points) => {
                let mut rest = i;
                (points.iter())
                    .map(|n| {
                        let cell = rest % n;
                        rest /= n;
                        (cell as f64 + 0.5) / *n as f64
                    })
                    .collect()
            }
        }
    }

    /// Independent replicates, if there are several.
    #[must_use]
    pub fn replicates(&self) -> Option<u64> {
        match self {
            Self::Sobol { replicates, .. } if *replicates > 1 => Some(*replicates),
            _ => None,
        }
    }

    /// Place of sample `i` in its row of a pick-freeze design.
    #[must_use]
    pub fn place(&self, i: u64) -> Option<u64> {
        match self {
            Self::PickFreeze(design) => Some(design.place(i)),
            _ => None,
        }
    }

    /// To which numbers of samples the design can grow so that the first samples stay as they are.
    #[must_use]
    pub fn growth(&self) -> Growth {
        match self {
            Self::MonteCarlo => Growth::Any,
            Self::Sobol { replicates, .. } => Growth::Doubling {
                unit: *replicates,
                population: *replicates,
            },
            Self::PickFreeze(design) => Growth::Doubling {
                unit: design.row(),
                population: INDEPENDENT,
            },
            Self::LatinHypercube(_) | Self::Grid(_) => Growth::Fixed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that `extend` takes: of a pick-freeze design in two inputs, rows of four with two draws each. Seen to fail
    /// with all samples of a row counted as draws.
    #[test]
    fn designs_grow_to_numbers_that_they_take() {
        assert_eq!(Plan::MonteCarlo.growth().total(59), Some(59));
        let sequence = Sobol::new(2);
        let sobol = Plan::Sobol {
            sequence,
            replicates: 3,
        };
        assert_eq!(sobol.growth().total(59), Some(96));
        assert_eq!(
            Plan::PickFreeze(PickFreeze::new(2)).growth().total(59),
            Some(128)
        );
        assert_eq!(Plan::Grid(vec![3]).growth().total(59), None);
    }
}
