//! Density of the posterior.
//!
//! Mean of a measured number: y = m(z) + surrogate's error + discrepancy + measurement error, all normal. Hence ln
//! p = −½ |z|² − ½ Σ ((y − m)² / V + ln V) with V = σ²/n + s² + d² (Kennedy & O'Hagan, J. R. Stat. Soc. B 63 (2001) 425–464, with
//! one discrepancy per level). The standard deviation d is an unknown, too, with a prior.

use super::observation::{Observation, Observations, ObservedQuantity};
use super::prior::Prior;
use super::settings::Discrepancy;
use super::surrogate::Surrogates;
use libm::{exp, log};

/// A standard deviation of the model that is an unknown, by the logarithm of its ratio to its median.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Of which quantity.
    pub quantity: ObservedQuantity,
    /// Its median before.
    pub scale: f64,
}

impl Deviation {
    /// Variance that it adds to the mean of an observation.
    fn variance(self, log_ratio: f64, observation: &Observation) -> f64 {
        match self.quantity == observation.quantity {
            true => (self.scale * exp(log_ratio)).powi(2),
            false => 0.0,
        }
    }
}

/// The posterior of the inputs' scores, and of standard deviations that are not known.
///
/// A position has one score per random input, then one logarithm per [`Deviation`].
#[derive(Debug, Clone)]
pub struct Posterior<'a> {
    prior: &'a Prior,
    surrogates: &'a Surrogates,
    observations: &'a Observations,
    deviations: Vec<Deviation>,
}

impl<'a> Posterior<'a> {
    /// The posterior. The surrogates must be those of the observed levels.
    #[must_use]
    pub fn new(
        prior: &'a Prior,
        surrogates: &'a Surrogates,
        observations: &'a Observations,
        discrepancy: Discrepancy,
    ) -> Self {
        let scales = [discrepancy.frequency_hz, discrepancy.amplitude];
        let each = ObservedQuantity::ALL.into_iter().zip(scales);
        let asked = each.filter(|(_, scale)| *scale > 0.0);
        Self {
            prior,
            surrogates,
            observations,
            deviations: asked
                .map(|(quantity, scale)| Deviation { quantity, scale })
                .collect(),
        }
    }

    /// Length of a position.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.scores() + self.deviations.len()
    }

    /// Number of scores, which a position begins with.
    #[must_use]
    pub fn scores(&self) -> usize {
        self.prior.inputs().len()
    }

    /// What is measured.
    #[must_use]
    pub fn observations(&self) -> &Observations {
        self.observations
    }

    /// What is known before.
    #[must_use]
    pub fn prior(&self) -> &Prior {
        self.prior
    }

    /// Unknown standard deviations, in the order of a position.
    #[must_use]
    pub fn deviations(&self) -> &[Deviation] {
        &self.deviations
    }

    /// An unknown standard deviation, the `k`-th one, at a position.
    #[must_use]
    pub fn deviation(&self, position: &[f64], k: usize) -> f64 {
        self.deviations[k].scale * exp(position[self.scores() + k])
    }

    /// Mean and variance of each observation at a position: what the model predicts of it.
    #[must_use]
    pub fn predictions(&self, position: &[f64]) -> Vec<[f64; 2]> {
        let (scores, logs) = position.split_at(self.scores());
        let predicted = self.surrogates.predict(&self.prior.coordinates(scores));
        let means = self.observations.means.iter().enumerate();
        means
            .map(|(o, of)| [predicted[o], self.variance(o, of, logs)])
            .collect()
    }

    fn variance(&self, place: usize, observation: &Observation, logs: &[f64]) -> f64 {
        let unknown = self.deviations.iter().zip(logs);
        let unknown = unknown.map(|(deviation, log)| deviation.variance(*log, observation));
        let surrogate = self.surrogates.all[place].deviation.powi(2);
        observation.variance + surrogate + unknown.sum::<f64>()
    }

    /// Logarithm of the density but for a constant. Shape of `position`: [`Posterior::dimension`].
    #[must_use]
    pub fn log_density(&self, position: &[f64]) -> f64 {
        let observations = self.observations.means.iter();
        let predictions = self.predictions(position);
        let misfits = observations.zip(predictions).map(|(o, [mean, variance])| {
            let away = o.mean - mean;
            -0.5 * (away * away / variance + log(variance))
        });
        log_prior(position) + misfits.sum::<f64>()
    }
}

/// Logarithm of the density before the measurement, but for a constant: all coordinates of a position are standard normal then.
pub(super) fn log_prior(position: &[f64]) -> f64 {
    -0.5 * position.iter().map(|z| z * z).sum::<f64>()
}
