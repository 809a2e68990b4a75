//! Modules of probability: special functions, and what is inferred from samples. They know no structure and no contact.

pub mod special;
pub mod statistics;
