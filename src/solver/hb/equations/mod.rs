//! The balance equations of one problem on one harmonic set, and their Jacobian.

pub mod balance;
pub mod effort;
pub mod free;
pub mod inverse;
pub mod jacobian;
pub mod layout;
pub mod problem;
pub(in crate::hb) mod single_free;
