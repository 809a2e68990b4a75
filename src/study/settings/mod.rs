//! The study file: its tables, what they must satisfy, and their schema.
//!
//! Start reading at [`read::Study`].

pub mod document;
mod engine_orders;
pub mod frequency;
pub mod identified_inputs;
mod inputs;
pub mod key_reference;
pub mod model;
mod nominal_stiffness;
pub mod read;
mod requirements;
mod samples;
pub mod schema;
pub mod solver_section;
