//! Verification of `fe`.
