//! Verification of `hb`.

#![expect(
    clippy::expect_used,
    reason = "functions shared by tests fail like tests"
)]

mod invariants;
mod jacobian;
mod models;
