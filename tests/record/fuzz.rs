//! Files mutated at random; see the shared file.

use microslip::record::{read_response, read_tests};

use super::shared_mutation::survive;
use crate::contact::whole_contact;
use crate::{csv, mat_file, tdms, uff58};

/// Seen to fail with a row's fields taken without their number: a panic.
#[test]
fn mutated_tables_are_survived() {
    let mut tests = ["a", "b"].map(whole_contact);
    tests[1].conditions.frequency_hz = Some(50.0);
    let text = csv::written(&tests);
    survive(|path| read_tests(path).is_ok(), "rig.csv", text.as_bytes());
    let text = csv::written(&tests[..1])
        .replace(',', ";")
        .replace('.', ",");
    survive(|path| read_tests(path).is_ok(), "rig.csv", text.as_bytes());
}

#[test]
fn mutated_responses_are_survived() {
    let text = "# seed 3\nlevel [N],resonance frequency [Hz],amplitude [um]\n1,1034.25,12.3\n2,1032.5,20\n";
    survive(
        |path| read_response(path).is_ok(),
        "blade.csv",
        text.as_bytes(),
    );
}

#[test]
fn mutated_universal_files_are_survived() {
    for form in uff58::forms() {
        survive(|path| read_tests(path).is_ok(), "rig.unv", &form.file());
    }
}

#[test]
fn mutated_variables_are_survived() {
    for form in mat_file::forms() {
        survive(|path| read_tests(path).is_ok(), "rig.mat", &form.test());
    }
    for form in mat_file::forms().into_iter().step_by(3) {
        survive(|path| read_tests(path).is_ok(), "rig.mat", &form.tests());
    }
}

#[test]
fn mutated_segments_are_survived() {
    for bytes in [tdms::whole(), tdms::in_segments()] {
        survive(|path| read_tests(path).is_ok(), "rig.tdms", &bytes);
    }
}
