//! The module of all HTML and SVG.

use microslip_base::units;
use microslip_probability::statistics;

pub mod page;
