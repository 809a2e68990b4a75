//! The module that finds contact parameters in measured hysteresis loops.

use microslip_base::{file, setting, units};
use microslip_pages::page;
use microslip_probability::{special, statistics};
use microslip_readers::record;
use microslip_samples::sampling;

pub mod identify;
