//! A case: samples of one kind, and the intervals whose coverage is counted on them.

use super::super::functions::{Function, Numbers};

/// Confidence of the intervals but where a case says otherwise.
pub(crate) const CONFIDENCE: f64 = 0.95;

/// What is said of samples of one kind: one interval or several.
pub(crate) struct Case {
    /// Which intervals, in the order of [`Case::covers`].
    pub(crate) statements: Vec<Statement>,
    covers: Box<dyn Fn(u64) -> Vec<bool> + Sync>,
}

/// An interval on samples of a kind.
#[derive(Debug, Clone)]
pub(crate) struct Statement {
    /// Which interval.
    pub(crate) interval: &'static str,
    /// Law, number and design of the samples.
    pub(crate) samples: String,
    /// Coverage that is promised.
    pub(crate) stated: f64,
}

impl Case {
    /// Whether each interval of a repetition holds the truth.
    pub(crate) fn covers(&self, seed: u64) -> Vec<bool> {
        (self.covers)(seed)
    }
}

/// Adds cases of one stated coverage.
pub(crate) struct Cases(pub(crate) Vec<Case>);

impl Cases {
    pub(crate) fn add(
        &mut self,
        interval: &'static str,
        samples: String,
        covers: impl Fn(&mut Numbers, u64) -> bool + Sync + 'static,
    ) {
        let one = move |numbers: &mut Numbers, seed| vec![covers(numbers, seed)];
        self.add_several(vec![(interval, samples)], one);
    }

    pub(crate) fn add_several(
        &mut self,
        statements: Vec<(&'static str, String)>,
        covers: impl Fn(&mut Numbers, u64) -> Vec<bool> + Sync + 'static,
    ) {
        let statement = |(interval, samples)| Statement {
            interval,
            samples,
            stated: CONFIDENCE,
        };
        self.0.push(Case {
            statements: statements.into_iter().map(statement).collect(),
            covers: Box::new(move |seed| covers(&mut Numbers::of(seed), seed)),
        });
    }
}

/// A statement per input of a function.
pub(crate) fn per_input(
    interval: &'static str,
    samples: &str,
    function: &Function,
) -> Vec<(&'static str, String)> {
    let input = |j: usize| {
        (
            interval,
            format!("{samples}, {}, input {}", function.name, j + 1),
        )
    };
    (0..function.dimensions).map(input).collect()
}
