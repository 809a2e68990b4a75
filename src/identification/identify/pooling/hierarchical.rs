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
        let means = MeansAtCovariances::new(&groups, &between)?;
        let next = [
            match nested {
                true => means.groups_given_data(&between[0]),
                false => zero.clone(),
            },
            means.tests_given_data(&between[1]),
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
    let means = MeansAtCovariances::new(&groups, &between)?;
    let [between_groups, between_tests] = between;
    Some(Fit {
        mean: means.mean,
        of_mean: means.of_mean,
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

/// Tests of one group.
struct Group {
    tests: Vec<Test>,
}

/// A test whose absent values are zero, as are the rows and columns of its matrices that belong to them.
struct Test {
    values: DVector<f64>,
    /// Parameters that it has.
    known: Vec<usize>,
    errors: DMatrix<f64>,
}

fn groups(observations: &[Observation]) -> Vec<Group> {
    let count = observations.iter().map(|o| o.group + 1).max().unwrap_or(0);
    let members = |group: usize| observations.iter().filter(move |o| o.group == group);
    let tests = |group: usize| -> Vec<Test> {
        let all = members(group).map(Test::of);
        all.filter(|test| !test.known.is_empty()).collect()
    };
    let all = (0..count).map(|group| Group {
        tests: tests(group),
    });
    all.filter(|group| !group.tests.is_empty()).collect()
}

impl Test {
    fn of(observation: &Observation) -> Self {
        let values = &observation.values;
        Self {
            values: DVector::from_fn(values.len(), |j, _| values[j].unwrap_or(0.0)),
            known: (0..values.len()).filter(|j| values[*j].is_some()).collect(),
            errors: observation.errors.clone(),
        }
    }

    /// Inverse of its covariance within the group.
    fn weight(&self, between_tests: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (known, count) = (&self.known, self.values.len());
        let covariance = |a: usize, b: usize| {
            let least = if a == b { LEAST_VARIANCE } else { 0.0 };
            let (i, j) = (known[a], known[b]);
            self.errors[(i, j)] + between_tests[(i, j)] + least
        };
        let covariance = DMatrix::from_fn(known.len(), known.len(), covariance);
        let inverse = covariance.cholesky()?.inverse();
        let mut weight = DMatrix::zeros(count, count);
        for (a, i) in known.iter().enumerate() {
            for (b, j) in known.iter().enumerate() {
                weight[(*i, *j)] = inverse[(a, b)];
            }
        }
        Some(weight)
    }
}

/// A group for given covariances.
struct Weighted<'a> {
    group: &'a Group,
    /// A: of each test.
    weights: Vec<DMatrix<f64>>,
    /// S: their sum.
    sum: DMatrix<f64>,
    /// M = (1 + G S)⁻¹ with the covariance G between groups: what the scatter of the group leaves of its weight.
    left: DMatrix<f64>,
    /// M G.
    given: DMatrix<f64>,
    /// Sum of the weighted values.
    values: DVector<f64>,
}

impl<'a> Weighted<'a> {
    fn new(group: &'a Group, [groups, tests]: &[DMatrix<f64>; 2]) -> Option<Self> {
        let parameters = groups.nrows();
        let weights = group.tests.iter().map(|test| test.weight(tests));
        let weights: Vec<DMatrix<f64>> = weights.collect::<Option<_>>()?;
        let mut sum = DMatrix::zeros(parameters, parameters);
        let mut values = DVector::zeros(parameters);
        for (test, weight) in group.tests.iter().zip(&weights) {
            sum += weight;
            values += weight * &test.values;
        }
        let left = (DMatrix::identity(parameters, parameters) + groups * &sum).try_inverse()?;
        Some(Self {
            given: &left * groups,
            group,
            weights,
            sum,
            left,
            values,
        })
    }

    /// Weight of the group in the means: S M.
    fn weight(&self) -> DMatrix<f64> {
        &self.sum * &self.left
    }

    /// Rest of the values for these means, weighted and summed over the group's tests.
    fn rest(&self, mean: &DVector<f64>) -> DVector<f64> {
        &self.values - &self.sum * mean
    }
}

/// Means and what they leave, for given covariances.
///
/// The covariance of a group's values is a block for each test, and G in all blocks. So its inverse is A for each test, less A M G A' between
/// two tests (Woodbury), and no matrix is larger than the number of parameters.
struct MeansAtCovariances<'a> {
    groups: Vec<Weighted<'a>>,
    mean: DVector<f64>,
    of_mean: DMatrix<f64>,
}

/// What the data say of one part of the values: the inverse covariance less what the means take (P of restricted likelihood, its block),
/// and the weighted rest.
struct ValuePart {
    projection: DMatrix<f64>,
    rest: DVector<f64>,
}

impl<'a> MeansAtCovariances<'a> {
    fn new(groups: &'a [Group], between: &[DMatrix<f64>; 2]) -> Option<Self> {
        let parameters = between[0].nrows();
        let weighted = groups.iter().map(|group| Weighted::new(group, between));
        let groups: Vec<Weighted<'_>> = weighted.collect::<Option<_>>()?;
        let mut information = DMatrix::zeros(parameters, parameters);
        let mut sum = DVector::zeros(parameters);
        for group in &groups {
            information += group.weight();
            sum += group.left.transpose() * &group.values;
        }
        let of_mean = information.cholesky()?.inverse();
        Some(Self {
            mean: &of_mean * sum,
            groups,
            of_mean,
        })
    }

    /// Mean over the tests of the expected square of their part.
    fn tests_given_data(&self, between: &DMatrix<f64>) -> DMatrix<f64> {
        let of_group = |group: &Weighted<'_>| -> Vec<ValuePart> {
            let rest = &group.given * group.rest(&self.mean);
            let tests = group.group.tests.iter().zip(&group.weights);
            let part = |(test, weight): (&Test, &DMatrix<f64>)| {
                let of_means = weight * &group.left;
                let of_group = weight * &group.given * weight;
                ValuePart {
                    projection: weight
                        - of_group
                        - &of_means * &self.of_mean * of_means.transpose(),
                    rest: weight * (&test.values - &self.mean - &rest),
                }
            };
            tests.map(part).collect()
        };
        expected(between, self.groups.iter().flat_map(of_group))
    }

    /// The same over the groups.
    fn groups_given_data(&self, between: &DMatrix<f64>) -> DMatrix<f64> {
        let part = |group: &Weighted<'_>| {
            let weight = group.weight();
            ValuePart {
                projection: &weight - &weight * &self.of_mean * weight.transpose(),
                rest: group.left.transpose() * group.rest(&self.mean),
            }
        };
        expected(between, self.groups.iter().map(part))
    }
}

/// Mean of the expected squares of parts with the covariance `between`.
fn expected(between: &DMatrix<f64>, parts: impl Iterator<Item = ValuePart>) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(between.nrows(), between.ncols());
    let mut count = 0.0;
    for ValuePart { projection, rest } in parts {
        let mean = between * rest;
        sum += between - between * projection * between + &mean * mean.transpose();
        count += 1.0;
    }
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three groups of one to three tests of two parameters, one value absent.
    fn observations() -> Vec<Observation> {
        let test = |group: usize, a: f64, b: Option<f64>| Observation {
            group,
            values: vec![Some(a), b],
            errors: DMatrix::from_row_slice(2, 2, &[0.3 + a, 0.1, 0.1, 0.5]),
        };
        vec![
            test(0, 1.0, Some(2.0)),
            test(0, 1.4, None),
            test(0, 0.7, Some(1.1)),
            test(1, 2.0, Some(2.5)),
            test(2, 1.1, Some(0.4)),
            test(2, 0.2, Some(1.9)),
        ]
    }

    /// Means and one step of both covariances from whole matrices, as the papers write them.
    ///
    /// Seen to fail without the covariance between groups in the projection of a test, and in its rest.
    #[test]
    fn a_step_is_that_of_whole_matrices() {
        let all = observations();
        let between = [
            DMatrix::from_row_slice(2, 2, &[0.4, 0.2, 0.2, 0.3]),
            DMatrix::from_row_slice(2, 2, &[0.5, -0.1, -0.1, 0.2]),
        ];
        let places: Vec<(usize, usize)> = (0..all.len())
            .flat_map(|test| (0..2).map(move |j| (test, j)))
            .filter(|(test, j)| all[*test].values[*j].is_some())
            .collect();
        let n = places.len();
        let y = DVector::from_fn(n, |row, _| {
            all[places[row].0].values[places[row].1].unwrap()
        });
        let covariance = DMatrix::from_fn(n, n, |a, b| {
            let ((s, i), (t, j)) = (places[a], places[b]);
            let group = if all[s].group == all[t].group {
                between[0][(i, j)]
            } else {
                0.0
            };
            group
                + if s == t {
                    all[s].errors[(i, j)] + between[1][(i, j)]
                } else {
                    0.0
                }
        });
        let one = |holds: bool| f64::from(u8::from(holds));
        let x = DMatrix::from_fn(n, 2, |row, j| one(places[row].1 == j));
        let inverse = covariance.try_inverse().unwrap();
        let of_mean = (x.transpose() * &inverse * &x).try_inverse().unwrap();
        let projection = &inverse - &inverse * &x * &of_mean * x.transpose() * &inverse;
        let mean = &of_mean * x.transpose() * &inverse * &y;
        let step = |between: &DMatrix<f64>, parts: usize, part_of: &dyn Fn(usize) -> usize| {
            let mut sum = DMatrix::zeros(2, 2);
            for part in 0..parts {
                let z = DMatrix::from_fn(n, 2, |row, j| {
                    one(part_of(places[row].0) == part && places[row].1 == j)
                });
                let expected = between * z.transpose() * &projection * &y;
                let known = between * z.transpose() * &projection * &z * between;
                sum += between - known + &expected * expected.transpose();
            }
            sum / parts as f64
        };
        let groups = groups(&all);
        let means = MeansAtCovariances::new(&groups, &between).unwrap();
        let close = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() < 1e-12;
        assert!((&means.mean - &mean).amax() < 1e-12, "{mean}");
        assert!(close(&means.of_mean, &of_mean), "{of_mean}");
        let tests = step(&between[1], all.len(), &|test| test);
        assert!(
            close(&means.tests_given_data(&between[1]), &tests),
            "{tests}"
        );
        let of_groups = step(&between[0], 3, &|test| all[test].group);
        let found = means.groups_given_data(&between[0]);
        assert!(close(&found, &of_groups), "{found} {of_groups}");
    }
}
