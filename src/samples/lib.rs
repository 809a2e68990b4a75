//! Modules of many samples: their random inputs, and how they are solved, stored and gone on with.

use microslip_base::{file, setting, units};
use microslip_probability::special;
use microslip_solver::{contact, gpu, harmonics, hb, lockstep, model};

pub mod ensemble;
pub mod sampling;
