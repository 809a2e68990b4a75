//! Verification of `sampling`.
