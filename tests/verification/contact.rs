//! Verification of `contact`.
