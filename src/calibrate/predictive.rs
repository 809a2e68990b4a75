//! Whether a calibrated model can have given the measurement.

use super::posterior::Posterior;
use crate::special::normal_cdf;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Probability, by position, of a mean below the measured one: averaged over the positions, for each observation.
///
/// 0 or 1 where all predictions lie to one side. Exact over the measurement's own scatter, so that no random number is needed.
#[must_use]
pub fn below_measured<P: AsRef<[f64]>>(posterior: &Posterior<'_>, positions: &[P]) -> Vec<f64> {
    let observed = &posterior.observations().means;
    let mut sums = vec![0.0; observed.len()];
    for position in positions {
        let predicted = posterior.predictions(position.as_ref());
        for ((sum, [mean, variance]), observation) in sums.iter_mut().zip(predicted).zip(observed) {
            *sum += normal_cdf((observation.mean - mean) / variance.sqrt());
        }
    }
    let each = sums
        .into_iter()
        .map(|sum| sum / positions.len().max(1) as f64);
    each.collect()
}

/// Posterior predictive p-value of Σ (y − m)²/V over all observations: the probability that a repetition of the whole measurement
/// lies as far from the model as the measured one (Gelman, Meng & Stern, Stat. Sin. 6 (1996) 733–760). Small = the model misfits.
#[must_use]
pub fn misfit<P: AsRef<[f64]>>(posterior: &Posterior<'_>, positions: &[P]) -> f64 {
    let observed = &posterior.observations().means;
    let Ok(law) = ChiSquared::new(observed.len() as f64) else {
        return 1.0;
    };
    let one = |position: &P| {
        let predicted = posterior.predictions(position.as_ref());
        let squares = predicted.iter().zip(observed);
        let squares = squares.map(|([mean, variance], o)| (o.mean - mean).powi(2) / variance);
        law.sf(squares.sum())
    };
    positions.iter().map(one).sum::<f64>() / positions.len().max(1) as f64
}
