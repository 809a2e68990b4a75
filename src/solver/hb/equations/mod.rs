//! The balance equations of one problem on one harmonic set, and their Jacobian.

pub mod balance;
pub mod effort;
pub mod free;
pub mod jacobian;
pub mod layout;
pub mod problem;
