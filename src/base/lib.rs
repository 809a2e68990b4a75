//! Modules without physics, below all others: units, rules of settings, files.

pub mod file;
pub mod setting;
pub mod units;
