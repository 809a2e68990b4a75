//! All tests together: medians over contacts, scatter between contacts, correlation.

use super::hierarchical::{Fit, Observation, fit};
use super::trend::{TrendPoint, exponent};
use crate::identify::cycles::scatter::ChainError;
use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::pooled_result::{Pooled, PooledParameter, Trend, TrendOver};
use crate::identify::found::result::{TestEstimate, TestResult, TestStatus};
use crate::identify::found::uncertain::{Uncertain, factor};
use crate::identify::settings::IdentifySettings;
use crate::special::normal_quantile;
use libm::{exp, log};
use nalgebra::DMatrix;

const ALL: [ContactParameter; 3] = ContactParameter::ALL;
/// Tests without correlation that are added to those that tell a correlation: two tests alone would say that it is one.
const TESTS_WITHOUT_CORRELATION: f64 = 1.0;

/// A test with what pooling needs of it.
struct Used<'a> {
    test: &'a TestResult,
    estimate: &'a TestEstimate,
    group: usize,
}

/// Pools the tests that can be used; without parameters if there is none.
#[must_use]
pub fn pool(tests: &[TestResult], settings: &IdentifySettings) -> Pooled {
    let used = used(tests);
    let parameters: Vec<usize> = (0..ALL.len())
        .filter(|j| used.iter().any(|u| positive(u.estimate, ALL[*j]).is_some()))
        .collect();
    let at_least = used.iter().filter_map(|u| u.estimate.friction_at_least);
    let mut pooled = Pooled {
        specimens: used.iter().map(|u| u.group + 1).max().unwrap_or(0),
        friction_at_least: at_least.max_by(f64::total_cmp),
        trends: trends(&used, settings.confidence),
        ..Pooled::default()
    };
    let observations: Vec<Observation> = used.iter().map(|u| observation(u, &parameters)).collect();
    let Some(found) = fit(&observations) else {
        return pooled;
    };
    let chain = chain(&used, &parameters, settings);
    let counts: Vec<Counts> = parameters.iter().map(|j| counts(&used, ALL[*j])).collect();
    let few: Vec<f64> = counts.iter().map(|c| c.few(settings.confidence)).collect();
    fill(&mut pooled, &found, &chain, &few, used.len());
    let one = |row: usize| {
        let which = ALL[parameters[row]];
        parameter(
            which,
            row,
            &found,
            &chain,
            &counts[row],
            settings.confidence,
        )
    };
    pooled.parameters = (0..parameters.len()).map(one).collect();
    pooled
}

/// Tests with an estimate, in groups of one specimen.
fn used(tests: &[TestResult]) -> Vec<Used<'_>> {
    let mut specimens: Vec<Option<&str>> = Vec::new();
    let mut used = Vec::new();
    for test in tests
        .iter()
        .filter(|t| !matches!(t.status, TestStatus::Unusable(_)))
    {
        let Some(estimate) = &test.estimate else {
            continue;
        };
        let specimen = test.conditions.specimen.as_deref();
        let known = specimen.and_then(|_| specimens.iter().position(|s| *s == specimen));
        let group = known.unwrap_or_else(|| {
            specimens.push(specimen);
            specimens.len() - 1
        });
        used.push(Used {
            test,
            estimate,
            group,
        });
    }
    used
}

/// The value of a parameter that a test gives, where it has a logarithm.
fn positive(estimate: &TestEstimate, parameter: ContactParameter) -> Option<Uncertain> {
    let found = estimate.value(parameter);
    found.filter(|uncertain| uncertain.value > 0.0)
}

fn observation(used: &Used<'_>, parameters: &[usize]) -> Observation {
    let found: Vec<Option<Uncertain>> = parameters
        .iter()
        .map(|j| positive(used.estimate, ALL[*j]))
        .collect();
    let error = |i: usize| found[i].map_or(0.0, |u| u.standard_error / u.value);
    // only the errors of the friction coefficient and of the tangential stiffness are from the same samples
    let correlation = |i: usize, j: usize| match (parameters[i], parameters[j]) {
        (a, b) if a == b => 1.0,
        (0, 1) | (1, 0) => used.estimate.error_correlation,
        _ => 0.0,
    };
    let n = parameters.len();
    Observation {
        group: used.group,
        values: found.iter().map(|u| u.map(|u| log(u.value))).collect(),
        errors: DMatrix::from_fn(n, n, |i, j| error(i) * error(j) * correlation(i, j)),
    }
}

/// Covariance by the measuring chain, the same for all tests.
fn chain(used: &[Used<'_>], parameters: &[usize], settings: &IdentifySettings) -> DMatrix<f64> {
    let amplified = used.iter().map(|u| {
        let tangential = &u.estimate.tangential;
        tangential.stiffness_n_per_um.value / tangential.measured_n_per_um
    });
    let amplified = amplified.sum::<f64>() / used.len() as f64;
    let whole = ChainError::of(settings).covariance(amplified);
    let n = parameters.len();
    DMatrix::from_fn(n, n, |i, j| whole[parameters[i]][parameters[j]])
}

/// Tests that have a parameter.
struct Counts {
    tests: usize,
    specimens: usize,
    /// Degrees of freedom of the only test.
    freedom_inside: f64,
}

fn counts(used: &[Used<'_>], parameter: ContactParameter) -> Counts {
    let having: Vec<(usize, Uncertain)> = used
        .iter()
        .filter_map(|u| positive(u.estimate, parameter).map(|found| (u.group, found)))
        .collect();
    let mut groups: Vec<usize> = having.iter().map(|(group, _)| *group).collect();
    groups.sort_unstable();
    groups.dedup();
    Counts {
        tests: having.len(),
        specimens: groups.len(),
        freedom_inside: having
            .iter()
            .map(|(_, u)| u.degrees_of_freedom)
            .fold(f64::INFINITY, f64::min),
    }
}

impl Counts {
    /// Degrees of freedom of the scatter: of specimens, if there are several, else of tests, else of loops.
    fn freedom(&self) -> f64 {
        match (self.specimens, self.tests) {
            (_, 0 | 1) => self.freedom_inside,
            (1, tests) => tests as f64 - 1.0,
            (specimens, _) => specimens as f64 - 1.0,
        }
    }

    /// Factor for few specimens or tests: Student's over the normal quantile.
    fn few(&self, confidence: f64) -> f64 {
        factor(self.freedom(), confidence) / normal_quantile(0.5 * (1.0 + confidence))
    }
}

/// Covariances; `few` is the factor of each parameter for few specimens.
fn fill(pooled: &mut Pooled, found: &Fit, chain: &DMatrix<f64>, few: &[f64], tests: usize) {
    let random = &found.between_groups + &found.between_tests + &found.of_mean;
    let told = match (pooled.specimens, tests) {
        (_, 1) => 1.0,
        (1, count) | (count, _) => {
            (count as f64 - 1.0) / (count as f64 - 1.0 + TESTS_WITHOUT_CORRELATION)
        }
    };
    // the factor widens what few specimens tell, not the errors of the chain: it changes the correlation of their sum
    let widened = DMatrix::from_fn(random.nrows(), random.ncols(), |i, j| match i == j {
        true => few[i] * few[j] * random[(i, j)],
        false => told * few[i] * few[j] * random[(i, j)],
    });
    // products of matrices are symmetric up to rounding; a reader may ask for more
    let predictive = widened + chain;
    let predictive = 0.5 * (&predictive + predictive.transpose());
    let deviation = |i: usize| predictive[(i, i)].sqrt();
    let correlation = DMatrix::from_fn(predictive.nrows(), predictive.ncols(), |i, j| {
        let product = deviation(i) * deviation(j);
        match i == j {
            true => 1.0,
            false if product > 0.0 => predictive[(i, j)] / product,
            false => 0.0,
        }
    });
    pooled.between_specimens = rows(&found.between_groups);
    pooled.between_tests = rows(&found.between_tests);
    pooled.of_mean = rows(&(&found.of_mean + chain));
    pooled.correlation = rows(&correlation);
    pooled.predictive = rows(&predictive);
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix
        .row_iter()
        .map(|row| row.iter().copied().collect())
        .collect()
}

fn parameter(
    parameter: ContactParameter,
    row: usize,
    found: &Fit,
    chain: &DMatrix<f64>,
    counts: &Counts,
    confidence: f64,
) -> PooledParameter {
    let at = |matrix: &DMatrix<f64>| matrix[(row, row)];
    let scatter = at(&found.between_groups) + at(&found.between_tests);
    let normal = normal_quantile(0.5 * (1.0 + confidence));
    let few = counts.few(confidence);
    let random = scatter + at(&found.of_mean);
    let deviation = (few * few * random + at(chain)).sqrt();
    let mean = found.mean[row];
    let errors = [at(&found.of_mean), at(chain)].map(f64::sqrt);
    PooledParameter {
        parameter,
        tests: counts.tests,
        specimens: counts.specimens,
        median: Uncertain::of_logarithm(mean, errors, counts.freedom(), confidence),
        log_scatter: (counts.tests > 1).then(|| scatter.sqrt()),
        predictive_log_standard_deviation: deviation,
        few_tests_factor: few,
        further_contact: [-1.0, 1.0].map(|side| exp(mean + side * normal * deviation)),
    }
}

fn trends(used: &[Used<'_>], confidence: f64) -> Vec<Trend> {
    let mut trends = Vec::new();
    for parameter in ALL {
        for over in [TrendOver::NormalForce, TrendOver::Frequency] {
            let point = |u: &Used<'_>| {
                let x = match over {
                    TrendOver::NormalForce => u.estimate.normal_force_n,
                    TrendOver::Frequency => u.test.cycles?.frequency_hz,
                };
                positive(u.estimate, parameter).map(|found| TrendPoint {
                    group: u.group,
                    over: x,
                    value: log(found.value),
                    variance: (found.standard_error / found.value).powi(2),
                })
            };
            let points: Vec<TrendPoint> = used.iter().filter_map(point).collect();
            trends.extend(
                exponent(&points, confidence).map(|(exponent, interval)| Trend {
                    parameter,
                    over,
                    tests: points.len(),
                    exponent,
                    interval,
                }),
            );
        }
    }
    trends
}

#[cfg(test)]
mod tests {
    use super::{Counts, fill, parameter};
    use crate::identify::found::parameter::ContactParameter;
    use crate::identify::found::pooled_result::Pooled;
    use crate::identify::pooling::hierarchical::Fit;
    use nalgebra::{DMatrix, DVector};

    /// Two specimens whose scatter is correlated, and a chain whose errors are so the other way: the factor 6.5 leaves little of the
    /// chain.
    ///
    /// Seen to fail with the factor in the standard deviations alone: a variance of 0.0029 in place of 0.0767.
    #[test]
    fn the_correlation_is_that_of_the_distributions() {
        let two = |a: f64, b: f64| DMatrix::from_row_slice(2, 2, &[a, b, b, a]);
        let found = Fit {
            mean: DVector::zeros(2),
            of_mean: DMatrix::zeros(2, 2),
            between_groups: DMatrix::zeros(2, 2),
            between_tests: two(0.0018, 0.0018),
        };
        let chain = two(0.0011, -0.0011);
        let counts = Counts {
            tests: 2,
            specimens: 2,
            freedom_inside: 10.0,
        };
        let few = counts.few(0.95);
        let mut pooled = Pooled {
            specimens: 2,
            ..Pooled::default()
        };
        fill(&mut pooled, &found, &chain, &[few; 2], 2);
        let which = ContactParameter::FrictionCoefficient;
        let told = parameter(which, 0, &found, &chain, &counts, 0.95);
        let variance = told.predictive_log_standard_deviation.powi(2);
        let stated = pooled.predictive[0][0];
        assert!(
            (stated / variance - 1.0).abs() < 1e-12,
            "{stated} {variance}"
        );
        // half of the correlation of two tests is told
        let expected = (0.5 * few * few * 0.0018 - 0.0011) / variance;
        let found = pooled.correlation[0][1];
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}
