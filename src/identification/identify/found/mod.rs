//! What is found: the parameters of a contact with their uncertainty, per test ([`result`]), over tests ([`pooled_result`]) and as
//! the distribution that a study reads ([`identified`]).

pub mod identified;
pub mod parameter;
pub mod pooled_result;
pub mod result;
pub mod uncertain;
