//! Files mutated at random; the name decides the reader where it can. See the shared file.

use super::shared_mutation as shared;
use crate::chain::{mass, stiffness};
use crate::op4::{Form, layouts, text};
use crate::{abaqus, ansys, calculix, mat_file, nastran, numpy};
use microslip::import::read;

pub(crate) fn survive(name: &str, bytes: &[u8]) {
    shared::survive(|path| read(path).is_ok(), name, bytes);
}

/// Seen to fail without the check of the order of the column pointers: a panic.
#[test]
fn mutated_harwell_boeing_files_are_survived() {
    survive(
        "K.matrix",
        ansys::harwell_boeing(stiffness, Some(1.0)).as_bytes(),
    );
}

#[test]
fn mutated_mappings_are_survived() {
    survive("K.mapping", ansys::mapping().as_bytes());
}

#[test]
fn mutated_markets_are_survived() {
    survive("K.mmf", ansys::dense_market(mass).as_bytes());
}

#[test]
fn mutated_abaqus_matrices_are_survived() {
    survive("K.mtx", abaqus::matrix(stiffness, true, true).as_bytes());
}

#[test]
fn mutated_user_elements_are_survived() {
    survive("super.mtx", abaqus::abaqus_element().as_bytes());
    survive("super.dat", abaqus::calculix_element().as_bytes());
}

#[test]
fn mutated_calculix_files_are_survived() {
    survive("job.sti", calculix::matrix(stiffness).as_bytes());
    survive("job.dof", calculix::names().as_bytes());
}

#[test]
fn mutated_dmig_is_survived() {
    let both = nastran::punch("KAAX", stiffness, false) + &nastran::punch("MAAX", mass, true);
    survive("model.pch", both.as_bytes());
}

#[test]
fn mutated_names_of_nastran_are_survived() {
    let text = "GRID,3\nGRID,4\nASET1,123,3,4\nASET,5,12\nSPOINT,90,THRU,95\nEXTRN,11,123,12,3\n";
    survive("model.asm", text.as_bytes());
}

#[test]
fn mutated_output4_text_is_survived() {
    for form in [Form::Dense, Form::Strings, Form::BigStrings] {
        survive("model.op4", text("KXX", stiffness, form).as_bytes());
    }
}

#[test]
fn mutated_binary_output4_is_survived() {
    for layout in layouts().into_iter().step_by(5) {
        survive("model.op4", &layout.file("KXX", stiffness));
    }
}

#[test]
fn mutated_arrays_are_survived() {
    let diagonal = |i: u8| f64::from(u8::from(i.is_multiple_of(4)));
    let data: Vec<u8> = (0..9).flat_map(|i| diagonal(i).to_le_bytes()).collect();
    survive("K.npy", &numpy::npy("<f8", false, "(3, 3)", &data));
    survive("K.npz", &numpy::save_npz());
    survive("model.npz", &numpy::savez(zip::CompressionMethod::Stored));
}

#[test]
fn mutated_variables_are_survived() {
    for form in mat_file::forms() {
        survive("model.mat", &form.model());
    }
}
