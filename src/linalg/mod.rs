//! Linear algebra on top of faer.

pub mod gmres;
