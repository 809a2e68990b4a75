//! Curves through computed points, and sets of curves on one grid.

/// A curve through given points: piecewise cubic, without overshoot between the points.
///
/// Slopes after Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304 (weighted harmonic mean of the
/// neighbouring secants, 0 at an extremum); at the ends the secant.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Curve {
    /// The curve through the finite points whose abscissa exceeds that of the point before;
    /// `None` with fewer than two of them.
    #[must_use]
    pub fn through(points: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let (mut x, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for (px, py) in points {
            let ascends = x.last().is_none_or(|&last| px > last);
            if px.is_finite() && py.is_finite() && ascends {
                x.push(px);
                y.push(py);
            }
        }
        let slope = (x.len() >= 2).then(|| monotone_slopes(&x, &y))?;
        Some(Self { x, y, slope })
    }

    /// First and last abscissa.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        (self.x[0], self.x[self.x.len() - 1])
    }

    /// Value at `x`; `None` outside the points.
    #[must_use]
    pub fn at(&self, x: f64) -> Option<f64> {
        let (first, last) = self.range();
        if !(first..=last).contains(&x) {
            return None;
        }
        let i = self
            .x
            .partition_point(|&p| p <= x)
            .clamp(1, self.x.len() - 1)
            - 1;
        let h = self.x[i + 1] - self.x[i];
        let t = (x - self.x[i]) / h;
        let (a, b) = (self.y[i], self.y[i + 1]);
        let (da, db) = (self.slope[i] * h, self.slope[i + 1] * h);
        let rest = (3.0 - 2.0 * t) * (b - a) * t * t;
        Some(a + rest + t * (1.0 - t) * ((1.0 - t) * da - t * db))
    }

    /// The curve over x / `peak`: with the peak's abscissa, peaks of all curves lie at 1. `None` unless `peak` > 0.
    #[must_use]
    pub fn aligned(&self, peak: f64) -> Option<Self> {
        (peak > 0.0 && peak.is_finite()).then(|| Self {
            x: self.x.iter().map(|x| x / peak).collect(),
            y: self.y.clone(),
            slope: self.slope.iter().map(|slope| slope * peak).collect(),
        })
    }
}

/// Slopes that keep each cubic monotone between its end points.
fn monotone_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let secant: Vec<f64> = (1..x.len())
        .map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1]))
        .collect();
    let mut slope = vec![secant[0]];
    for i in 1..secant.len() {
        let (left, right) = (secant[i - 1], secant[i]);
        slope.push(if left * right <= 0.0 {
            0.0
        } else {
            let (h_left, h_right) = (x[i] - x[i - 1], x[i + 1] - x[i]);
            let weight = (h_left + 2.0 * h_right) / (3.0 * (h_left + h_right));
            left * right / (weight * right + (1.0 - weight) * left)
        });
    }
    slope.push(secant[secant.len() - 1]);
    slope
}

/// Curves of a set of samples on one grid. A failed sample has no curve; a short curve lacks some grid points.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveSet {
    grid: Vec<f64>,
    /// Per sample its values on the grid, NaN where missing; absent = failed.
    rows: Vec<Option<Vec<f64>>>,
}

impl CurveSet {
    /// Values of the curves on `grid`, one entry per sample in the order of its index; `None` = failed sample.
    #[must_use]
    pub fn of(curves: &[Option<Curve>], grid: &[f64]) -> Self {
        let values = |curve: &Curve| {
            let value = |&x: &f64| curve.at(x).unwrap_or(f64::NAN);
            grid.iter().map(value).collect::<Vec<f64>>()
        };
        Self {
            grid: grid.to_vec(),
            rows: curves
                .iter()
                .map(|curve| curve.as_ref().map(values))
                .collect(),
        }
    }

    /// Given values, one row per sample in the order of its index; `None` = failed sample, not finite = missing point.
    ///
    /// Shape: each row has one value per grid point.
    #[must_use]
    pub fn from_rows(grid: Vec<f64>, rows: Vec<Option<Vec<f64>>>) -> Self {
        for row in rows.iter().flatten() {
            assert_eq!(row.len(), grid.len(), "one value per grid point");
        }
        Self { grid, rows }
    }

    /// Abscissas.
    #[must_use]
    pub fn grid(&self) -> &[f64] {
        &self.grid
    }

    /// Number of samples, failed ones included.
    #[must_use]
    pub fn total(&self) -> usize {
        self.rows.len()
    }

    /// Number of failed samples.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.rows.iter().filter(|row| row.is_none()).count()
    }

    /// Number of curves that lack a grid point.
    #[must_use]
    pub fn incomplete(&self) -> usize {
        let lacks = |row: &&Vec<f64>| row.iter().any(|v| !v.is_finite());
        self.rows.iter().flatten().filter(lacks).count()
    }

    /// Rows per sample, missing points not finite.
    pub(super) fn rows(&self) -> &[Option<Vec<f64>>] {
        &self.rows
    }

    /// Values at one grid point, those that are missing left out.
    pub(super) fn column(&self, point: usize) -> impl Iterator<Item = f64> {
        let values = self.rows.iter().flatten().map(move |row| row[point]);
        values.filter(|v| v.is_finite())
    }

    /// Samples of even and of odd index: one half shapes a band, the other tests it.
    pub(super) fn halves(&self) -> (Self, Self) {
        let half = |parity: usize| Self {
            grid: self.grid.clone(),
            rows: self.rows.iter().skip(parity).step_by(2).cloned().collect(),
        };
        (half(0), half(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line is reproduced, and no value leaves the range of its two neighbours.
    /// Seen to fail with the arithmetic mean of the secants (overshoot beside the step).
    #[test]
    fn interpolation_is_exact_on_lines_and_never_overshoots() {
        let line = Curve::through([(0.0, 1.0), (1.0, 3.0), (4.0, 9.0)]).unwrap();
        for x in [0.0, 0.3, 1.0, 2.5, 4.0] {
            assert!((line.at(x).unwrap() - (1.0 + 2.0 * x)).abs() < 1e-14);
        }
        let points = [
            (0.0, 0.0),
            (1.0, 0.1),
            (2.0, 5.0),
            (3.0, 5.1),
            (4.0, 0.0),
            (5.0, 0.0),
        ];
        let curve = Curve::through(points).unwrap();
        for pair in points.windows(2) {
            let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
            for i in 0..=20 {
                let value = curve.at(pair[0].0 + f64::from(i) / 20.0).unwrap();
                assert!(
                    (low - 1e-12..=high + 1e-12).contains(&value),
                    "{pair:?}: {value}"
                );
            }
        }
    }

    /// The error on a smooth monotone arc falls at least with the second order: halving the spacing quarters it.
    /// Seen to fail with the sign of the right-hand slope flipped.
    #[test]
    fn interpolation_converges() {
        let error = |n: usize| {
            let step = 1.0 / n as f64;
            let curve = Curve::through((0..=n).map(|i| (i as f64 * step, (i as f64 * step).exp())));
            let curve = curve.unwrap();
            (0..1000)
                .map(|i| f64::from(i) / 1000.0)
                .map(|x| (curve.at(x).unwrap() - x.exp()).abs())
                .fold(0.0, f64::max)
        };
        assert!(error(20) / error(40) > 3.9, "{}", error(20) / error(40));
    }

    /// Points that are not finite or do not ascend are left out; outside the points there is no value. Seen to
    /// fail with either kept.
    #[test]
    fn bad_points_are_left_out_and_the_outside_is_missing() {
        let points = [
            (0.0, 1.0),
            (f64::NAN, 2.0),
            (1.0, f64::NAN),
            (1.0, 2.0),
            (1.0, 7.0),
            (2.0, 3.0),
        ];
        let curve = Curve::through(points).unwrap();
        assert_eq!(
            (curve.at(1.0), curve.at(-0.1), curve.at(2.1)),
            (Some(2.0), None, None)
        );
        assert_eq!(curve.at(f64::NAN), None);
        assert!(Curve::through([(0.0, 1.0)]).is_none());
    }
}
