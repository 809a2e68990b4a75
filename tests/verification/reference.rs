//! Verification of `reference`.
