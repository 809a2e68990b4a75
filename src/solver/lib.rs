//! Modules that solve one sample: the structure, its contacts, and their harmonic balance.

use microslip_base::{file, setting, units};

pub mod aft;
pub mod contact;
pub mod fe;
pub mod gpu;
pub mod harmonics;
pub mod hb;
pub mod linalg;
pub mod lockstep;
pub mod model;
