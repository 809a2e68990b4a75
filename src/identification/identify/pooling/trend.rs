//! Dependence of a parameter on load or frequency.

use crate::identify::found::uncertain::factor;
use nalgebra::{Matrix2, Vector2};

/// Fewest tests of a trend.
const LEAST_TESTS: usize = 4;
/// Least ratio of the greatest to the least load or frequency.
const LEAST_RANGE: f64 = 1.2;
/// Fewest degrees of freedom of a trend's interval.
const LEAST_FREEDOM: f64 = 1.0;
/// Most steps of the iteration for the variances.
const MOST_STEPS: usize = 2000;
/// Largest change of a variance, over the sum of both and the least one of an error, at which the iteration ends.
const CHANGE: f64 = 1e-8;
/// Variance between two specimens over that of all values: their difference then says nothing.
const FIXED: f64 = 1e6;
/// Least variance of an error, for records without noise.
const LEAST_VARIANCE: f64 = 1e-18;
/// Information on the variances, over that of a design without a common part, at which rounding is all that is left.
const SINGULAR: f64 = 1e-9;

/// One test.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrendPoint {
    /// Its specimen, from 0 without gaps.
    pub(super) group: usize,
    /// Load or frequency.
    pub(super) over: f64,
    /// Logarithm of the parameter.
    pub(super) value: f64,
    /// Variance of its error.
    pub(super) variance: f64,
}

/// Exponent of a parameter over load or frequency, and its interval; none of too few tests, of too small a range, or where too few
/// specimens tell it.
///
/// y = a + b ln x + specimen + test + error. Both variances have the greatest restricted likelihood, b is that of generalised least
/// squares. Where each specimen has a load of its own, their scatter decides with (specimens − 2) degrees of freedom; where each is
/// tested at several (or where there are two), that of its tests with (tests − specimens − 1); designs between these have a number between.
///
/// Source: Kenward, Roger, Biometrics 53 (1997) 983-997; for the variances Zhou et al., J. Comput. Graph. Stat. 28 (2019) 350-361.
pub(super) fn exponent(points: &[TrendPoint], confidence: f64) -> Option<(f64, [f64; 2])> {
    let usable: Vec<TrendPoint> = points.iter().copied().filter(|p| p.over > 0.0).collect();
    let ends = |(low, high): (f64, f64), p: &TrendPoint| (low.min(p.over), high.max(p.over));
    let (low, high) = usable.iter().fold((f64::INFINITY, 0.0), ends);
    if usable.len() < LEAST_TESTS || high < LEAST_RANGE * low {
        return None;
    }
    let model = Model::new(&usable);
    let variances = model.variances()?;
    let (slope, error, freedom) = model.slope(variances)?;
    let freedom = freedom.min(model.most_freedom());
    let half = factor(freedom, confidence) * error;
    (freedom >= LEAST_FREEDOM).then_some((slope, [slope - half, slope + half]))
}

/// Tests of one specimen, in columns.
#[derive(Debug, Default)]
struct SpecimenTests {
    /// Logarithm of load or frequency, about the mean of all.
    x: Vec<f64>,
    /// Logarithm of the parameter, about the mean of all.
    y: Vec<f64>,
    errors: Vec<f64>,
}

struct Model {
    groups: Vec<SpecimenTests>,
    /// Whether specimens and tests can be told apart.
    nested: bool,
    /// Variance of the values.
    spread: f64,
}

/// Sums over one specimen for given variances; V is the covariance of its values, B = V⁻¹ [1, x].
struct Sums {
    /// [1, x]ᵀ V⁻¹ [1, x], and the same with y.
    design: Matrix2<f64>,
    with_y: Vector2<f64>,
    columns: [Vec<f64>; 3],
    /// 1ᵀ B.
    total: Vector2<f64>,
    /// Bᵀ B.
    square: Matrix2<f64>,
    /// Bᵀ V⁻¹ B.
    cube: Matrix2<f64>,
    /// Traces of V⁻¹ and of V⁻¹ V⁻¹.
    traces: [f64; 2],
}

impl SpecimenTests {
    fn sums(&self, [between, within]: [f64; 2]) -> Sums {
        let weights: Vec<f64> = self.errors.iter().map(|e| 1.0 / (within + e)).collect();
        let power = |n: i32| weights.iter().map(|w| w.powi(n)).sum::<f64>();
        let common = between / (1.0 + between * power(1));
        let inverse = |column: &[f64]| {
            let product = dot(&weights, column);
            let each = weights.iter().zip(column);
            each.map(|(w, v)| w * (v - common * product))
                .collect::<Vec<f64>>()
        };
        let ones = vec![1.0; self.x.len()];
        let [one, x] = [inverse(&ones), inverse(&self.x)];
        let twice = [inverse(&one), inverse(&x)];
        let products = |a: [&[f64]; 2], b: [&[f64]; 2]| {
            Matrix2::new(
                dot(a[0], b[0]),
                dot(a[0], b[1]),
                dot(a[1], b[0]),
                dot(a[1], b[1]),
            )
        };
        Sums {
            design: products([&ones, &self.x], [&one, &x]),
            with_y: Vector2::new(dot(&one, &self.y), dot(&x, &self.y)),
            total: Vector2::new(one.iter().sum(), x.iter().sum()),
            square: products([&one, &x], [&one, &x]),
            cube: products([&one, &x], [&twice[0], &twice[1]]),
            traces: [
                power(1) - common * power(2),
                power(2) - 2.0 * common * power(3) + (common * power(2)).powi(2),
            ],
            columns: [one, x, inverse(&self.y)],
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Intercept and slope for given variances, and sums over all specimens. Pairs are of the variance between specimens and of that between tests.
struct LineAtVariances {
    /// Covariance of intercept and slope.
    covariance: Matrix2<f64>,
    coefficients: Vector2<f64>,
    /// Square that each variance explains, and its expectation.
    squares: [f64; 2],
    expected: [f64; 2],
    /// Bᵀ Vᵢ B: decrease of the information with each variance.
    decrease: [Matrix2<f64>; 2],
    /// Second derivatives of the same kind, of both specimens, mixed and both tests.
    second: [Matrix2<f64>; 3],
    /// Information on the variances, and what it is without intercept and slope.
    information: Matrix2<f64>,
    without: Matrix2<f64>,
}

impl Model {
    fn new(points: &[TrendPoint]) -> Self {
        let n = points.len() as f64;
        let x = |p: &TrendPoint| libm::log(p.over);
        let centre = points.iter().map(x).sum::<f64>() / n;
        let mean = points.iter().map(|p| p.value).sum::<f64>() / n;
        let count = points.iter().map(|p| p.group + 1).max().unwrap_or(0);
        let mut groups: Vec<SpecimenTests> = (0..count).map(|_| SpecimenTests::default()).collect();
        for point in points {
            let group = &mut groups[point.group];
            group.x.push(x(point) - centre);
            group.y.push(point.value - mean);
            group.errors.push(point.variance + LEAST_VARIANCE);
        }
        groups.retain(|group| !group.x.is_empty());
        let square = points.iter().map(|p| (p.value - mean).powi(2)).sum::<f64>();
        Self {
            nested: groups.len() > 1 && groups.len() < points.len(),
            groups,
            spread: square / (n - 1.0),
        }
    }

    /// Whether there are two specimens: their only difference does not tell its own scatter, and counts as unknown.
    fn two(&self) -> bool {
        self.nested && self.groups.len() == 2
    }

    /// Whether the variance between specimens is sought.
    fn free(&self) -> bool {
        self.nested && !self.two()
    }

    /// Degrees of freedom of the scatter between specimens or of that between their tests, whichever has more.
    fn most_freedom(&self) -> f64 {
        let specimens = self.groups.len() as f64;
        let tests: f64 = self.groups.iter().map(|g| g.x.len() as f64).sum();
        match self.nested {
            true => (tests - specimens - 1.0).max(specimens - 2.0),
            false => tests - 2.0,
        }
    }

    /// Variances between specimens and between tests, of greatest restricted likelihood; none where the design does not tell them.
    fn variances(&self) -> Option<[f64; 2]> {
        let mut variances = match (self.nested, self.two()) {
            (false, _) => [0.0, self.spread],
            (true, false) => [0.5 * self.spread; 2],
            (true, true) => [FIXED * self.spread, self.spread],
        };
        let design = self.line_at([0.5 * self.spread; 2])?;
        design.of_variances(self.nested)?;
        let errors = self.groups.iter().flat_map(|group| &group.errors);
        let least = errors.copied().fold(f64::INFINITY, f64::min);
        for _ in 0..MOST_STEPS {
            let line = self.line_at(variances)?;
            line.of_variances(self.free())?;
            // each step raises the likelihood, and no variance gets below 0
            let step = |k: usize| {
                let ratio = line.squares[k] / line.expected[k].max(f64::MIN_POSITIVE);
                variances[k] * ratio.sqrt()
            };
            let next = match self.free() {
                true => [step(0), step(1)],
                false => [variances[0], step(1)],
            };
            let change = (0..2).map(|k| (next[k] - variances[k]).abs());
            let done = change.fold(0.0, f64::max)
                <= CHANGE * (next[usize::from(!self.free())] + next[1] + least);
            variances = next;
            if done {
                break;
            }
        }
        Some(variances)
    }

    /// Slope, its standard error, and the degrees of freedom of that.
    fn slope(&self, variances: [f64; 2]) -> Option<(f64, f64, f64)> {
        let line = self.line_at(variances)?;
        let of_variances = line.of_variances(self.free())?;
        let covariance = line.covariance;
        let at = |k: usize| (covariance * line.decrease[k] * covariance)[(1, 1)];
        let gradient = Vector2::new(at(0), at(1));
        let freedom = 2.0 * covariance[(1, 1)].powi(2)
            / gradient
                .dot(&(of_variances * gradient))
                .max(f64::MIN_POSITIVE);
        // variances that are estimated, too, make the weights of specimens and tests inexact
        let [a, b] = line.decrease;
        let [both, mixed, tests] = line.second;
        let inexact = of_variances[(0, 0)] * (both - a * covariance * a)
            + of_variances[(0, 1)]
                * (mixed + mixed.transpose() - a * covariance * b - b * covariance * a)
            + of_variances[(1, 1)] * (tests - b * covariance * b);
        let more = (covariance * inexact * covariance)[(1, 1)].max(0.0);
        let error = (covariance[(1, 1)] + 2.0 * more).sqrt();
        (error.is_finite() && freedom.is_finite()).then_some((line.coefficients[1], error, freedom))
    }

    fn line_at(&self, variances: [f64; 2]) -> Option<LineAtVariances> {
        let sums: Vec<Sums> = self.groups.iter().map(|g| g.sums(variances)).collect();
        let matrix = |of: &dyn Fn(&Sums) -> Matrix2<f64>| sums.iter().map(of).sum::<Matrix2<f64>>();
        let number = |of: &dyn Fn(&Sums) -> f64| sums.iter().map(of).sum::<f64>();
        let covariance = matrix(&|s| s.design).cholesky()?.inverse();
        let with_y: Vector2<f64> = sums.iter().map(|s| s.with_y).sum();
        let coefficients = covariance * with_y;
        let rest = |s: &Sums| -> Vec<f64> {
            let [one, x, y] = &s.columns;
            let at = |i: usize| y[i] - coefficients[0] * one[i] - coefficients[1] * x[i];
            (0..y.len()).map(at).collect()
        };
        let squares = [
            number(&|s| rest(s).iter().sum::<f64>().powi(2)),
            number(&|s| rest(s).iter().map(|r| r * r).sum()),
        ];
        let decrease = [
            matrix(&|s| s.total * s.total.transpose()),
            matrix(&|s| s.square),
        ];
        // the first column of B is V⁻¹ 1
        let of_one = |s: &Sums| s.square.row(0).into_owned();
        let second = [
            matrix(&|s| s.total[0] * s.total * s.total.transpose()),
            matrix(&|s| s.total * of_one(s)),
            matrix(&|s| s.cube),
        ];
        let [first, mixed, last] = [
            number(&|s| s.total[0].powi(2)),
            number(&|s| s.square[(0, 0)]),
            number(&|s| s.traces[1]),
        ];
        let without = 0.5 * Matrix2::new(first, mixed, mixed, last);
        let taken = |i: usize, j: usize| {
            let product = covariance * decrease[i] * covariance * decrease[j];
            (covariance * second[i + j]).trace() - 0.5 * product.trace()
        };
        let all = Matrix2::new(taken(0, 0), taken(0, 1), taken(0, 1), taken(1, 1));
        Some(LineAtVariances {
            expected: [
                number(&|s| s.total[0]) - (covariance * decrease[0]).trace(),
                number(&|s| s.traces[0]) - (covariance * decrease[1]).trace(),
            ],
            information: without - all,
            covariance,
            coefficients,
            squares,
            decrease,
            second,
            without,
        })
    }
}

impl LineAtVariances {
    /// Covariance of both variances; none where the tests do not tell them.
    fn of_variances(&self, nested: bool) -> Option<Matrix2<f64>> {
        let [a, b] = [0, 1].map(|k| self.information[(k, k)]);
        let told = |k: usize| self.information[(k, k)] > SINGULAR * self.without[(k, k)];
        if !nested {
            return told(1).then(|| Matrix2::new(0.0, 0.0, 0.0, 1.0 / b));
        }
        let determinant = self.information.determinant();
        (told(0) && told(1) && determinant > SINGULAR * a * b)
            .then(|| self.information.try_inverse())
            .flatten()
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        reason = "a test that cannot read its own result fails"
    )]

    use super::{TrendPoint, exponent};
    use crate::sampling::stream::uniform;
    use crate::special::normal_quantile;

    /// Tests of specimens whose parameter goes with load^`slope`.
    struct Design {
        /// Specimen and load of each test.
        tests: Vec<(usize, f64)>,
        slope: f64,
        /// Standard deviations of ln parameter between specimens and between tests, and of the error of test 0; that of the last
        /// one is six times as large.
        scatter: [f64; 3],
    }

    impl Design {
        /// Each of `specimens` at `loads` of its own.
        fn own(specimens: usize, loads: usize, scatter: [f64; 3]) -> Self {
            let load = |s: usize| 60.0 + 80.0 * s as f64 / (specimens - 1) as f64;
            let tests = (0..specimens * loads).map(|i| (i / loads, load(i / loads)));
            Self {
                tests: tests.collect(),
                slope: 0.0,
                scatter,
            }
        }

        /// Each of `specimens` at all of the loads 80, 100, 125.
        fn crossed(specimens: usize, scatter: [f64; 3]) -> Self {
            let tests = (0..3 * specimens).map(|i| (i / 3, [80.0, 100.0, 125.0][i % 3]));
            Self {
                tests: tests.collect(),
                slope: -0.15,
                scatter,
            }
        }

        /// So many tests of each specimen, at loads that differ within them and from one to the next.
        fn mixed(counts: &[usize], scatter: [f64; 3]) -> Self {
            let tests = counts.iter().enumerate().flat_map(|(s, n)| {
                (0..*n).map(move |j| {
                    (
                        s,
                        60.0 + 8.0 * s as f64 + 70.0 * uniform(5, s as u64, j as u32),
                    )
                })
            });
            Self {
                tests: tests.collect(),
                slope: 0.3,
                scatter,
            }
        }

        fn points(&self, seed: u64) -> Vec<TrendPoint> {
            let [between, within, error] = self.scatter;
            let count = self.tests.len();
            let point = |(i, (group, load)): (usize, &(usize, f64))| {
                let normal = |place: usize, dimension| {
                    normal_quantile(uniform(seed, place as u64, dimension))
                };
                let error = error * (1.0 + 5.0 * i as f64 / (count - 1) as f64);
                TrendPoint {
                    group: *group,
                    over: *load,
                    value: self.slope * load.ln()
                        + between * normal(*group, 0)
                        + within * normal(i, 1)
                        + error * normal(i, 2),
                    variance: error * error,
                }
            };
            self.tests.iter().enumerate().map(point).collect()
        }

        /// Share of the 95 % intervals that hold the exponent, of so many repetitions, and the median of their half widths.
        fn coverage(&self, repetitions: u64) -> (f64, f64) {
            let intervals = (0..repetitions).filter_map(|seed| exponent(&self.points(seed), 0.95));
            let intervals: Vec<[f64; 2]> = intervals.map(|(_, interval)| interval).collect();
            let holds = intervals
                .iter()
                .filter(|[low, high]| *low <= self.slope && self.slope <= *high);
            let mut halves: Vec<f64> = intervals
                .iter()
                .map(|[low, high]| 0.5 * (high - low))
                .collect();
            halves.sort_by(f64::total_cmp);
            (
                holds.count() as f64 / halves.len() as f64,
                halves[halves.len() / 2],
            )
        }
    }

    /// With 300 repetitions a share of 95 % has a standard deviation of 1.3 %.
    ///
    /// Seen to fail with least squares over all tests: 61 % of the intervals of four specimens with a load of their own.
    #[test]
    fn intervals_hold_the_exponent_for_any_design() {
        let designs = [
            ("own loads, 4 x 3", Design::own(4, 3, [0.1, 0.03, 0.0])),
            ("own loads, 8 x 3", Design::own(8, 3, [0.1, 0.03, 0.0])),
            ("own loads, 4 x 5", Design::own(4, 5, [0.1, 0.02, 0.0])),
            ("own loads, alike", Design::own(8, 3, [0.0, 0.03, 0.0])),
            ("crossed", Design::crossed(5, [0.1, 0.003, 0.0])),
            ("crossed, 2", Design::crossed(2, [0.1, 0.003, 0.0])),
            ("crossed, noise", Design::crossed(5, [0.1, 0.003, 0.003])),
            ("mixed", Design::mixed(&[3, 3, 3, 4], [0.1, 0.03, 0.0])),
            (
                "mixed, alike",
                Design::mixed(&[3, 3, 3, 4], [0.01, 0.03, 0.0]),
            ),
            ("mixed, 2 x 2", Design::mixed(&[2, 2], [0.1, 0.03, 0.0])),
            (
                "mixed, most alone",
                Design::mixed(&[1, 1, 1, 1, 2, 2], [0.05, 0.03, 0.0]),
            ),
            ("alone", Design::mixed(&[1; 8], [0.1, 0.03, 0.0])),
            ("one specimen", Design::mixed(&[6], [0.1, 0.03, 0.0])),
        ];
        let shares = designs.map(|(name, design)| (name, design.coverage(300).0));
        let few = shares.iter().filter(|(_, share)| *share < 0.92);
        assert_eq!(few.count(), 0, "{shares:?}");
    }

    /// Within specimens the tests tell the exponent to 0.009, whatever the scatter between specimens.
    ///
    /// Seen to fail with least squares over all tests: 0.25.
    #[test]
    fn scatter_between_specimens_does_not_widen_what_each_of_them_tells() {
        let (_, half) = Design::crossed(5, [0.1, 0.003, 0.0]).coverage(100);
        assert!((0.007..0.012).contains(&half), "{half}");
    }

    /// Seen to fail with least squares over all tests.
    #[test]
    fn two_specimens_with_a_load_each_tell_no_trend() {
        let points = Design::own(2, 8, [0.1, 0.005, 0.0]).points(3);
        assert_eq!(exponent(&points, 0.95), None);
    }
}
