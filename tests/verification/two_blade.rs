//! Verification of `two_blade`.
