//! What a set of numbers says, and what failed samples leave open.
//!
//! Pure functions on slices. A sample that failed is never dropped and never a number: it is counted, widens every
//! interval ([`Observed`]), or the answer is refused with a reason. No statistic is ever NaN; a side that the samples do
//! not bound is [`Limit::Unbounded`]. Results depend neither on the order of threads nor on the number of shards.
//! Knows no blade, no contact and no file. Start reading in [`mod@observed`].
//!
//! The 95 % quantile of 200 results of which three failed, with its interval:
//!
//! ```
//! # use microslip_probability as microslip;
//! use microslip::statistics::{Limit, Observed, Sorted, quantile_estimate};
//!
//! let results = Sorted::finite((0..197).map(|i| 100.0 + f64::from(i)));
//! let observed = Observed::with_failed(results, 3);
//! let quantile = quantile_estimate(&observed, 0.95, 0.95).expect("valid samples");
//! assert!(quantile.coverage >= 0.95);
//! // the failed samples may lie anywhere: with 200 samples the upper limit still exists
//! assert!(matches!(quantile.interval.upper, Limit::Value(limit) if limit > quantile.estimate));
//! ```

pub mod acceptance;
pub mod band;
pub mod bin;
pub mod bootstrap;
pub mod chaos;
pub mod comparison;
pub mod control_variate;
pub mod convergence;
pub mod cross_fit;
pub mod curve;
pub mod depth;
pub mod distribution;
pub mod exceedance;
pub mod failure;
pub mod given_data;
mod hull;
pub mod independent_rows;
pub mod joint;
pub mod limit;
pub mod looks;
pub mod margin;
pub mod markov_chain;
mod mean;
pub mod moment;
pub mod observed;
pub mod order_statistic;
pub mod proportion;
pub mod replicates;
pub mod reweight;
pub mod sensitivity;
pub mod sobol_index;
pub mod tolerance;
pub mod weighted;

pub use acceptance::{Counted, Demonstration, Remedy};
pub use band::{
    Band, BandPoint, Envelope, EnvelopePoint, EnvelopeRefusal, MissingPoints, pointwise_band,
    simultaneous_band,
};
pub use bin::{Group, equal_count};
pub use bootstrap::Bootstrap;
pub use chaos::{Chaos, ChaosRefusal, ChaosSettings, Effect, Polynomials, fit_chaos};
pub use comparison::{Better, Comparison, Ranking, compare, difference, rank_designs};
pub use control_variate::{ControlledExceedance, ControlledMean, ControlledSamples};
pub use convergence::{Prefix, convergence, nested_prefixes};
pub use cross_fit::{
    CrossFit, HoldOutSettings, PredictionError, SurrogateExceedance, SurrogateIndices,
    SurrogateSamples, cross_fit,
};
pub use curve::{Curve, CurveSet};
pub use depth::{depth_band, modified_band_depth};
pub use distribution::{Bin, empirical_cdf, histogram, rank_correlation};
pub use exceedance::{Exceedance, exceedance};
pub use failure::{FailureBin, FailurePattern, failure_pattern};
pub use given_data::{
    ConditionalMean, GivenData, GivenDataIndex, conditional_means, first_order_index,
};
pub use hull::hull;
pub use independent_rows::independent_rows;
pub use joint::{JointRegion, joint_region};
pub use limit::{Interval, Limit};
pub use looks::{confidence_at, looks};
pub use margin::{
    Criterion, Denominator, FrequencyMargin, Judgement, frequency_margin, goodman_allowable, judge,
    reserve_factor,
};
pub use markov_chain::{Mixing, mixing};
pub use mean::student;
pub use moment::{MomentEstimate, Moments, moment_estimate, moments};
pub use observed::{Enclosed, Observed, Sorted};
pub use order_statistic::{
    QuantileEstimate, order_statistic_interval, quantile, quantile_estimate, quantile_rank,
};
pub use proportion::{Proportion, Share, proportion, share};
pub use replicates::{ReplicateMean, ReplicateQuantile, replicate_mean, replicate_quantile};
pub use reweight::Weights;
pub use sensitivity::{Index, Influence, SensitivityRefusal, varies};
pub use sobol_index::{SobolIndex, sobol_indices};
pub use tolerance::{
    Side, ToleranceBound, tolerance_bound, tolerance_confidence, tolerance_order, wilks_sample_size,
};
pub use weighted::{
    WeightedExceedance, WeightedQuantile, effective_sample_size, weighted_exceedance,
    weighted_quantile,
};
