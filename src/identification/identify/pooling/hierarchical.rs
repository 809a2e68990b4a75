//! A normal model with three levels: y = mean + group + test + error, the errors known, the covariances of groups and tests not.

use nalgebra::{DMatrix, DVector};

/// One test: values of the parameters that it has, and the covariance of their errors.
#[derive(Debug, Clone)]
pub(super) struct Observation {
    /// Group of the test, from 0 without gaps.
    pub(super) group: usize,
    /// Value of each parameter, where the test has it.
    pub(super) values: Vec<Option<f64>>,
    /// Covariance of the errors; rows of absent values do not matter. Shape: square, as `values`.
    pub(super) errors: DMatrix<f64>,
}

/// What was fitted. Shape of the matrices: square, in the order of the parameters.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// Mean of each parameter.
    pub(super) mean: DVector<f64>,
    /// Covariance of the means.
    pub(super) of_mean: DMatrix<f64>,
    /// Covariance between groups; zero if no group has two tests, or there is one group.
    pub(super) between_groups: DMatrix<f64>,
    /// Covariance between tests of a group; between all tests where that of groups is zero.
    pub(super) between_tests: DMatrix<f64>,
}

/// Most steps of the iteration.
const MOST_STEPS: usize = 2000;
/// Largest change of a variance over the largest, at which the iteration ends.
const CHANGE: f64 = 1e-7;
/// Least variance of an error, for records without noise.
const LEAST_VARIANCE: f64 = 1e-18;

/// Covariances of greatest restricted likelihood, and means by generalised least squares. Every parameter must be in a test.
///
/// The expectation-maximisation algorithm keeps covariances positive semidefinite, and absent values need nothing special. None if
/// the tests do not determine the means.
///
/// Source: Laird, Ware, Biometrics 38 (1982) 963-974; Jackson, Riley, White, Stat. Med. 30 (2011) 2481-2498.
pub(super) fn fit(observations: &[Observation]) -> Option<Fit> {
    let parameters = observations.first()?.values.len();
    let groups = groups(observations);
    let nested = groups.len() > 1 && groups.len() < observations.len();
    let start = start(observations, parameters);
    let zero = DMatrix::zeros(parameters, parameters);
    let mut between = match nested {
        true => [0.5 * &start, 0.5 * &start],
        false => [zero.clone(), start],
    };
    for _ in 0..MOST_STEPS {
        let solved = Solved::new(&groups, &between)?;
        let next = [
            match nested {
                true => solved.groups_given_data(&between[0]),
                false => zero.clone(),
            },
            solved.tests_given_data(&between[1]),
        ];
        let size = between.iter().map(DMatrix::amax).fold(0.0, f64::max);
        let change = between
            .iter()
            .zip(&next)
            .map(|(a, b)| (a - b).amax())
            .fold(0.0, f64::max);
        between = next;
        if change <= CHANGE * size {
            break;
        }
    }
    let solved = Solved::new(&groups, &between)?;
    let [between_groups, between_tests] = between;
    Some(Fit {
        mean: solved.mean,
        of_mean: solved.of_mean,
        between_groups,
        between_tests,
    })
}

/// Variances of the values, as a first guess.
fn start(observations: &[Observation], parameters: usize) -> DMatrix<f64> {
    let variance = |j: usize| {
        let known: Vec<f64> = observations.iter().filter_map(|o| o.values[j]).collect();
        let n = known.len() as f64;
        let mean = known.iter().sum::<f64>() / n;
        match known.len() {
            0 | 1 => 0.0,
            _ => known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0),
        }
    };
    DMatrix::from_diagonal(&DVector::from_fn(parameters, |j, _| variance(j)))
}

/// Values of one group in one column.
struct Group {
    y: DVector<f64>,
    /// Which value is which parameter: a one in each row. Shape `[values, parameters]`.
    incidence: DMatrix<f64>,
    /// The same for each test: rows of other tests are zero.
    tests: Vec<DMatrix<f64>>,
    errors: DMatrix<f64>,
}

fn groups(observations: &[Observation]) -> Vec<Group> {
    let count = observations.iter().map(|o| o.group + 1).max().unwrap_or(0);
    let members = |group: usize| observations.iter().filter(move |o| o.group == group);
    (0..count)
        .map(|group| Group::of(&members(group).collect::<Vec<_>>()))
        .filter(|g| !g.y.is_empty())
        .collect()
}

impl Group {
    fn of(tests: &[&Observation]) -> Self {
        let parameters = tests[0].values.len();
        let places = tests.iter().enumerate().flat_map(|(test, o)| {
            (0..parameters)
                .filter(|j| o.values[*j].is_some())
                .map(move |j| (test, j))
        });
        let places: Vec<(usize, usize)> = places.collect();
        let n = places.len();
        let value = |row: usize| tests[places[row].0].values[places[row].1].unwrap_or(0.0);
        let one = |holds: bool| f64::from(u8::from(holds));
        let error = |a: usize, b: usize| {
            let ((s, i), (t, j)) = (places[a], places[b]);
            let covariance = if s == t { tests[s].errors[(i, j)] } else { 0.0 };
            covariance + LEAST_VARIANCE * one(a == b)
        };
        Self {
            y: DVector::from_fn(n, |row, _| value(row)),
            incidence: DMatrix::from_fn(n, parameters, |row, j| one(places[row].1 == j)),
            tests: (0..tests.len())
                .map(|t| DMatrix::from_fn(n, parameters, |row, j| one(places[row] == (t, j))))
                .collect(),
            errors: DMatrix::from_fn(n, n, error),
        }
    }

    /// Covariance of the values.
    fn covariance(&self, [groups, tests]: &[DMatrix<f64>; 2]) -> DMatrix<f64> {
        let mut sum = &self.errors + &self.incidence * groups * self.incidence.transpose();
        for test in &self.tests {
            sum += test * tests * test.transpose();
        }
        sum
    }
}

/// Means and what they leave, for given covariances.
struct Solved<'a> {
    groups: &'a [Group],
    mean: DVector<f64>,
    of_mean: DMatrix<f64>,
    /// Inverse covariance of each group, less what the means take (P of restricted likelihood, its block).
    projections: Vec<DMatrix<f64>>,
    /// Inverse covariance times the rest of each group.
    weighted: Vec<DVector<f64>>,
}

impl<'a> Solved<'a> {
    fn new(groups: &'a [Group], between: &[DMatrix<f64>; 2]) -> Option<Self> {
        let parameters = between[0].nrows();
        let inverse = |group: &Group| group.covariance(between).cholesky().map(|c| c.inverse());
        let inverses: Vec<DMatrix<f64>> = groups.iter().map(inverse).collect::<Option<_>>()?;
        let mut information = DMatrix::zeros(parameters, parameters);
        let mut sum = DVector::zeros(parameters);
        for (group, inverse) in groups.iter().zip(&inverses) {
            let weighted = group.incidence.transpose() * inverse;
            information += &weighted * &group.incidence;
            sum += weighted * &group.y;
        }
        let of_mean = information.cholesky()?.inverse();
        let mean = &of_mean * sum;
        let both = || groups.iter().zip(&inverses);
        let projection = |(group, inverse): (&Group, &DMatrix<f64>)| {
            let weighted = inverse * &group.incidence;
            inverse - &weighted * &of_mean * weighted.transpose()
        };
        let rest = |(group, inverse): (&Group, &DMatrix<f64>)| {
            inverse * (&group.y - &group.incidence * &mean)
        };
        Some(Self {
            projections: both().map(projection).collect(),
            weighted: both().map(rest).collect(),
            groups,
            of_mean,
            mean,
        })
    }

    /// Mean over the tests of the expected square of their part.
    fn tests_given_data(&self, between: &DMatrix<f64>) -> DMatrix<f64> {
        self.expected(between, |group| &group.tests)
    }

    /// The same over the groups.
    fn groups_given_data(&self, between: &DMatrix<f64>) -> DMatrix<f64> {
        self.expected(between, |group| std::slice::from_ref(&group.incidence))
    }

    fn expected(
        &self,
        between: &DMatrix<f64>,
        parts: impl Fn(&Group) -> &[DMatrix<f64>],
    ) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(between.nrows(), between.ncols());
        let mut count = 0.0;
        for ((group, projection), weighted) in self
            .groups
            .iter()
            .zip(&self.projections)
            .zip(&self.weighted)
        {
            for part in parts(group) {
                let mean = between * part.transpose() * weighted;
                let known = between * part.transpose() * projection * part * between;
                sum += between - known + &mean * mean.transpose();
                count += 1.0;
            }
        }
        sum / count
    }
}
