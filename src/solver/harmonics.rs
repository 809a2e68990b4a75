//! Harmonic set, coefficient order and the time grid of one period.
//!
//! q(t) = q₀ + Σₖ cₖ cos(kωt) + sₖ sin(kωt); coefficients are ordered 0, c₁, s₁, c₂, s₂, … over the
//! harmonics of the set. The complex amplitude of harmonic k is q̂ₖ = cₖ − i sₖ, so q(t) = Re Σ q̂ₖ e^{ikωt}.
//!
//! ```
//! # use microslip_solver as microslip;
//! use microslip::harmonics::HarmonicSet;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let odd = HarmonicSet::new(vec![0, 1, 3])?;
//! assert_eq!(odd.n_coefficients(), 5);
//! let q = odd.convert(&[1.0, 2.0, 3.0, 4.0, 5.0], 1, &HarmonicSet::up_to(3));
//! assert_eq!(q, [1.0, 2.0, 3.0, 0.0, 0.0, 4.0, 5.0]);
//! # Ok(())
//! # }
//! ```

use std::f64::consts::TAU;

/// Ascending harmonics of the excitation frequency; 0 and 1 are always members.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HarmonicSet {
    orders: Vec<usize>,
}

/// Why a list of harmonics is not a harmonic set.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HarmonicError {
    /// The list lacks 0 or 1, repeats an order, or is not ascending.
    #[error("harmonics {0:?}: must be ascending without repetition and contain 0 and 1")]
    BadSet(Vec<usize>),
}

impl HarmonicSet {
    /// The set of the given orders.
    ///
    /// # Errors
    /// [`HarmonicError::BadSet`] unless `orders` is strictly ascending and contains 0 and 1.
    pub fn new(orders: Vec<usize>) -> Result<Self, HarmonicError> {
        let ascending = orders.windows(2).all(|w| w[0] < w[1]);
        if ascending && orders.first() == Some(&0) && orders.get(1) == Some(&1) {
            Ok(Self { orders })
        } else {
            Err(HarmonicError::BadSet(orders))
        }
    }

    /// 0, 1, …, `highest` (at least 1).
    #[must_use]
    pub fn up_to(highest: usize) -> Self {
        Self {
            orders: (0..=highest.max(1)).collect(),
        }
    }

    /// The orders, ascending, starting with 0.
    #[must_use]
    pub fn orders(&self) -> &[usize] {
        &self.orders
    }

    /// Highest order.
    #[must_use]
    pub fn highest(&self) -> usize {
        self.orders[self.orders.len() - 1]
    }

    /// Number of real coefficients of one displacement: 2·len − 1.
    #[must_use]
    pub fn n_coefficients(&self) -> usize {
        2 * self.orders.len() - 1
    }

    /// Coefficients of the same motion in another set; harmonics absent here are 0, those absent there are dropped.
    ///
    /// Shape: `coefficients` `[self.n_coefficients() · width]`, coefficient-major (each coefficient is a row of `width`).
    #[must_use]
    pub fn convert(&self, coefficients: &[f64], width: usize, to: &Self) -> Vec<f64> {
        assert_eq!(
            coefficients.len(),
            self.n_coefficients() * width,
            "coefficients must match the harmonic set"
        );
        let mut out = vec![0.0; to.n_coefficients() * width];
        for (i, order) in to.orders.iter().enumerate() {
            if let Ok(j) = self.orders.binary_search(order) {
                let rows = if i == 0 { 1 } else { 2 };
                let (a, b) = (
                    (2 * i).saturating_sub(1) * width,
                    (2 * j).saturating_sub(1) * width,
                );
                out[a..a + rows * width].copy_from_slice(&coefficients[b..b + rows * width]);
            }
        }
        out
    }

    /// Basis row at phase θ = ωt: [1, cos k₁θ, sin k₁θ, …]. Shape: `[n_coefficients]`.
    #[must_use]
    pub fn basis(&self, theta: f64) -> Vec<f64> {
        let mut row = vec![1.0];
        for &k in &self.orders[1..] {
            let (sin, cos) = libm::sincos(k as f64 * theta);
            row.push(cos);
            row.push(sin);
        }
        row
    }
}

/// Phases θᵢ = 2πi/n of a period sampled at `n_time` equidistant points.
#[must_use]
pub fn phases(n_time: usize) -> Vec<f64> {
    (0..n_time)
        .map(|i| TAU * i as f64 / n_time as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_without_zero_or_one_are_refused() {
        assert!(HarmonicSet::new(vec![0, 1, 3, 5]).is_ok());
        assert!(HarmonicSet::new(vec![1, 3]).is_err());
        assert!(HarmonicSet::new(vec![0, 1, 3, 3]).is_err());
        assert!(HarmonicSet::new(vec![0, 2]).is_err());
    }

    #[test]
    fn conversion_keeps_common_harmonics_and_pads_with_zero() {
        let odd = HarmonicSet::new(vec![0, 1, 3]).unwrap();
        let all = HarmonicSet::up_to(3);
        let q = [9.0, 1.0, 2.0, 3.0, 4.0];
        let padded = odd.convert(&q, 1, &all);
        assert_eq!(padded, [9.0, 1.0, 2.0, 0.0, 0.0, 3.0, 4.0]);
        assert_eq!(all.convert(&padded, 1, &odd), q);
    }
}
