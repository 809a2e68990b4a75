//! Verification of `hb`.

#![expect(
    clippy::expect_used,
    reason = "functions shared by tests fail like tests"
)]

mod alert;
mod anchored;
mod branch_maximum;
mod built_in_sector;
mod closed_form;
mod compliance;
mod curve;
mod damping;
mod disk;
mod fold;
mod free;
mod invariants;
mod jacobian;
mod lumped_disk;
mod maxima;
mod mistuned;
mod models;
mod modes;
mod nodal;
mod peak;
mod polyline;
mod random_models;
mod stability;
mod status;
mod sweep;
mod symmetry;
mod time_integration;
mod time_integration_circle;
