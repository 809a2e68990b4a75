//! Verification of `aft`.
