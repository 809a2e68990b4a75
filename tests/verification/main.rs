//! Verification: every numerical routine against an independent truth.

mod aft;
mod contact;
mod fe;
mod hb;
mod reference;
mod response;
mod sampling;
mod statistics;
mod two_blade;
