//! Many samples: from inputs to outcomes.

pub mod outcome;
pub mod store;
