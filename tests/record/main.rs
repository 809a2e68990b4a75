//! Measurements: files that the tests write by the rules of each format, whole and damaged.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its files fails"
)]

mod contact;
mod csv;
#[path = "../common/damage.rs"]
mod damage;
mod even_area;
mod fuzz;
#[path = "../common/mat_file.rs"]
mod mat_file;
mod matlab;
mod page;
mod pressure_map;
mod response;
mod rules;
#[path = "../common/mutation.rs"]
mod shared_mutation;
mod tdms;
mod uff58;
mod written;
