//! One file per format: its text or bytes become [`super::ImportedMatrix`] and names.

pub(super) mod abaqus_matrix;
pub(super) mod abaqus_substructure;
mod arrays;
pub(super) mod calculix;
pub(super) mod harwell_boeing;
pub(super) mod matlab;
mod nastran_cards;
pub(super) mod nastran_dmig;
pub(super) mod nastran_names;
pub(super) mod numpy;
mod op4;
pub(super) mod op4_binary;
pub(super) mod op4_text;
