//! Verification of `hb`.
