//! Complex matrices as two real ones, so that a real matrix costs what a real matrix costs.

use super::vector::dot;
use faer::prelude::*;

/// A matrix A by its real and its imaginary part.
#[derive(Debug, Clone)]
pub struct SplitMat {
    /// Re A.
    pub real: Mat<f64>,
    /// Im A; none if it is zero.
    pub imaginary: Option<Mat<f64>>,
}

impl From<Mat<f64>> for SplitMat {
    fn from(real: Mat<f64>) -> Self {
        Self {
            real,
            imaginary: None,
        }
    }
}

impl From<Mat<c64>> for SplitMat {
    fn from(a: Mat<c64>) -> Self {
        let part = |of: fn(c64) -> f64| Mat::from_fn(a.nrows(), a.ncols(), |i, j| of(a[(i, j)]));
        Self {
            real: part(|z| z.re),
            imaginary: Some(part(|z| z.im)),
        }
    }
}

impl SplitMat {
    /// Whether all entries are real.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.imaginary.is_none()
    }

    /// Number of rows.
    #[must_use]
    pub fn nrows(&self) -> usize {
        self.real.nrows()
    }

    /// Number of columns.
    #[must_use]
    pub fn ncols(&self) -> usize {
        self.real.ncols()
    }

    /// One entry.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> c64 {
        let imaginary = self.imaginary.as_ref().map_or(0.0, |a| a[(i, j)]);
        c64::new(self.real[(i, j)], imaginary)
    }

    /// All entries as complex numbers.
    #[must_use]
    pub fn complex(&self) -> Mat<c64> {
        Mat::from_fn(self.nrows(), self.ncols(), |i, j| self.entry(i, j))
    }

    /// A times a real number, in place.
    pub fn scale(&mut self, factor: f64) {
        self.real *= Scale(factor);
        if let Some(imaginary) = &mut self.imaginary {
            *imaginary *= Scale(factor);
        }
    }

    /// A x, column by column. Shape: `[ncols]` → `[nrows]`.
    #[must_use]
    #[inline(always)]
    pub fn times(&self, x: &[c64]) -> Vec<c64> {
        let mut y = vec![c64::new(0.0, 0.0); self.nrows()];
        add_columns(&self.real, x, &mut y);
        if let Some(imaginary) = &self.imaginary {
            let turned: Vec<c64> = x.iter().map(|x| c64::new(-x.im, x.re)).collect();
            add_columns(imaginary, &turned, &mut y);
        }
        y
    }

    /// (Aᴴ f)ⱼ of a column j, f by its real and its imaginary part.
    #[must_use]
    #[inline(always)]
    pub fn adjoint_times(&self, j: usize, [real, imaginary]: [&[f64]; 2]) -> c64 {
        let column = self.real.col_as_slice(j);
        let along = c64::new(dot(column, real), dot(column, imaginary));
        match &self.imaginary {
            None => along,
            Some(a) => {
                let column = a.col_as_slice(j);
                along + c64::new(dot(column, imaginary), -dot(column, real))
            }
        }
    }
}

/// y += A x for a real A.
#[inline(always)]
fn add_columns(a: &Mat<f64>, x: &[c64], y: &mut [c64]) {
    for (j, x) in x.iter().enumerate() {
        for (y, a) in y.iter_mut().zip(a.col(j).iter()) {
            *y += x * *a;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn largest(x: impl Iterator<Item = c64>) -> f64 {
        x.fold(0.0, |m: f64, z| m.max(z.norm()))
    }

    /// Products with A and with its adjoint against those of complex matrices.
    #[test]
    fn products_are_those_of_complex_numbers() {
        let number = |i: usize, j: usize| c64::new((3 * i + j) as f64 - 4.0, (i * j) as f64 - 1.5);
        let a = Mat::from_fn(5, 3, number);
        let split = SplitMat::from(a.clone());
        let x: Vec<c64> = (0..3).map(|j| number(2, j)).collect();
        let f: Vec<c64> = (0..5).map(|i| number(i, 7)).collect();
        let expected = &a * Col::from_fn(3, |j| x[j]);
        let product = split.times(&x);
        let differs = product.iter().zip(expected.iter()).map(|(a, b)| a - b);
        assert!(largest(differs) < 1e-12, "A x");
        let expected = a.adjoint() * Col::from_fn(5, |i| f[i]);
        let part = |of: fn(&c64) -> f64| f.iter().map(of).collect::<Vec<f64>>();
        let parts = [part(|z| z.re), part(|z| z.im)];
        let [real, imaginary] = parts.each_ref().map(Vec::as_slice);
        let differs = (0..3).map(|j| split.adjoint_times(j, [real, imaginary]) - expected[j]);
        assert!(largest(differs) < 1e-12, "adjoint of A");
    }
}
