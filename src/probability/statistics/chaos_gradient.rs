//! Value and gradient of an expansion, for samplers that need both.

use super::chaos::{Chaos, Polynomials};

impl Polynomials {
    /// dψ_k/dx for k up to the last of `values`, the ψ_k at x.
    ///
    /// Hermite: He_k' = k He_{k−1}. Legendre: P_k' = Σ (2j + 1) P_j over j = k − 1, k − 3, ... Both in orthonormal form;
    /// Legendre polynomials have 2x − 1 for their argument.
    fn slopes(self, values: &[f64]) -> Vec<f64> {
        let slope = |k: usize| match self {
            Self::Hermite if k == 0 => 0.0,
            Self::Hermite => (k as f64).sqrt() * values[k - 1],
            Self::Legendre => {
                let below = (0..k).rev().step_by(2);
                let weighted = below.map(|j| (2.0 * j as f64 + 1.0).sqrt() * values[j]);
                2.0 * (2.0 * k as f64 + 1.0).sqrt() * weighted.sum::<f64>()
            }
        };
        (0..values.len()).map(slope).collect()
    }
}

impl Chaos {
    /// Value and gradient. Shape: one number per input, in the domain of its polynomials; the gradient as the inputs.
    #[must_use]
    pub fn predict_with_gradient(&self, inputs: &[f64]) -> (f64, Vec<f64>) {
        let powers = self.powers(inputs);
        let slopes: Vec<Vec<f64>> = (powers.iter().zip(&self.polynomials))
            .map(|(values, basis)| basis.slopes(values))
            .collect();
        let (mut value, mut gradient) = (0.0, vec![0.0; inputs.len()]);
        for term in &self.terms {
            let factors = || term.degrees.iter().zip(&powers).map(|(&k, v)| v[k]);
            value += term.coefficient * factors().product::<f64>();
            for (j, slot) in gradient.iter_mut().enumerate() {
                let k = term.degrees[j];
                if k > 0 {
                    let others = factors().enumerate().filter(|(i, _)| *i != j);
                    let others: f64 = others.map(|(_, factor)| factor).product();
                    *slot += term.coefficient * slopes[j][k] * others;
                }
            }
        }
        (value, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::super::chaos::Term;
    use super::*;

    /// Against central differences, of both families and with interactions.
    #[test]
    fn the_gradient_is_that_of_the_value() {
        let term = |degrees: &[usize], coefficient: f64| Term {
            degrees: degrees.to_vec(),
            coefficient,
        };
        let chaos = Chaos {
            polynomials: vec![Polynomials::Legendre, Polynomials::Hermite],
            terms: vec![
                term(&[0, 0], 1.0),
                term(&[4, 0], 0.7),
                term(&[3, 2], -0.4),
                term(&[0, 5], 0.2),
                term(&[1, 1], 2.0),
            ],
            degree: 5,
            valid: 100,
            failed: 0,
        };
        let h = 1e-6;
        for x in [[0.3, -1.2], [0.9, 0.4], [0.02, 2.5]] {
            let (value, gradient) = chaos.predict_with_gradient(&x);
            assert!((value - chaos.predict(&x)).abs() < 1e-12, "value at {x:?}");
            for (j, slope) in gradient.iter().enumerate() {
                let [below, above] = [-h, h].map(|d| {
                    let mut moved = x;
                    moved[j] += d;
                    chaos.predict(&moved)
                });
                let difference = (above - below) / (2.0 * h);
                let error = (slope - difference).abs();
                assert!(
                    error < 1e-6 * (1.0 + difference.abs()),
                    "input {j} at {x:?}: {gradient:?}, {difference}"
                );
            }
        }
    }
}
