//! Modules that read what others wrote: matrices of finite-element programs, and records of instruments.

use microslip_base::{file, setting, units};
use microslip_solver::{linalg, model};

pub mod import;
pub mod record;
