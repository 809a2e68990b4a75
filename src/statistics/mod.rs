//! What a set of numbers says: quantiles with confidence, moments, histograms, failure bounds and curve bands.
//!
//! Pure functions on slices. Everything starts from [`Sorted`], so results depend neither on the order of the
//! samples nor on the number of threads, and no statistic is ever NaN: an absent answer is `None`.
//! Knows no blade, no contact and no file. Start reading in [`mod@quantile`].

pub mod band;
pub mod distribution;
pub mod failure;
pub mod quantile;
pub mod replicates;
pub mod reweight;

pub use band::{Band, BandPoint, Curve, pointwise_band};
pub use distribution::{Bin, Moments, empirical_cdf, histogram, moments, rank_correlation};
pub use failure::{FailureRate, failure_rate, quantile_bounds};
pub use quantile::{
    Interval, QuantileEstimate, Sorted, order_statistic_interval, quantile, quantile_estimate,
};
pub use replicates::{ReplicateMean, replicate_mean};
pub use reweight::Weights;
