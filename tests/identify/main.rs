//! Contact parameters from hysteresis loops that are made from equations: what is known is found again.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its own result fails"
)]

mod coverage;
mod early_slip;
mod frequency;
mod other_laws;
mod pooling;
mod population;
mod recovery;
mod refusal;
mod round_robin;
mod synthetic;
mod varying_load;
