//! Verification: every numerical routine against an independent truth.

mod aft;
#[path = "../common/compliance_product.rs"]
mod compliance_product;
mod contact;
mod fe;
mod hb;
mod reference;
mod response;
mod sampling;
mod statistics;
mod two_blade;
