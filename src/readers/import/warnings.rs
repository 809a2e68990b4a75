//! What a user should look at, though it is no fault.

use super::Request;
use super::facts::Facts;
use super::model::{ImportedModel, ReadFile};
use super::role::Role;
use super::write;
use crate::model::matrix_checks::rounding;
use crate::units::hz_to_rad_s;

/// Up to so many rows people write a stiffness by hand, with few digits that are exact.
const HAND_WRITTEN: usize = 2;
/// Round-off of the largest K_ii/M_ii, over the lowest eigenvalue, from which on results may be wrong: of a chain that a spring holds
/// the amplitude is wrong by 6e-7 at 1e-3, by 1.4e-4 at 1e-2, by 20 % at 0.1.
const TOO_STIFF: f64 = 1e-2;

/// Of what the files hold and what is used of it.
pub(super) fn of_files(
    model: &ImportedModel,
    files: &[ReadFile],
    request: &Request,
) -> Vec<String> {
    let mut warnings = Vec::new();
    if !write::has_nodes(&model.dofs) {
        warnings.push(
            "no file has names: degrees of freedom are called 1, 2, ... and all count as displacements"
                .to_owned(),
        );
    }
    if model.forces.contains_key(&Role::Load) && request.load.is_none() {
        warnings.push(
            "the load of the files is not used: --load harmonic or --load static says what it is"
                .to_owned(),
        );
    }
    for file in files {
        for (name, _) in file.matrices.iter().filter(|(_, role)| role.is_none()) {
            let path = file.path.display();
            warnings.push(format!("{path}: matrix {name} is not used"));
        }
    }
    let stiffness = &model.matrices[&Role::Stiffness];
    // such numbers count as exact, so nothing allows for their rounding
    if stiffness.values.n > HAND_WRITTEN && rounding(stiffness.digits) == 0.0 {
        warnings.push(format!(
            "{}: K has {} digits: frequencies of the free structure and its rigid-body modes may be lost to rounding; write more digits",
            stiffness.path.display(),
            stiffness.digits
        ));
    }
    warnings
}

/// A degree of freedom whose stiffness drowns that of the others in round-off, as one does that is held by a very stiff spring.
///
/// The reference is the lowest flexible eigenvalue, or the median of K_ii/M_ii where that is lower: round-off may have spoiled the
/// eigenvalues already.
pub(super) fn too_stiff(model: &ImportedModel, facts: &Facts) -> Option<String> {
    let [k, m] = [Role::Stiffness, Role::Mass].map(|role| model.matrices[&role].values.diagonal());
    let mut ratios: Vec<(f64, usize)> = (k.iter().zip(&m).zip(0..))
        .filter(|((k, m), _)| **k > 0.0 && **m > 0.0)
        .map(|((k, m), row)| (k / m, row))
        .collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (largest, row) = *ratios.last()?;
    let (median, _) = ratios[ratios.len() / 2];
    let first = facts.frequencies_hz.first();
    let lowest = first.map_or(median, |hz| hz_to_rad_s(*hz).powi(2).min(median));
    let share = f64::EPSILON * largest / lowest;
    (share > TOO_STIFF).then(|| {
        format!(
            "degree of freedom {}: round-off of its stiffness is {share:.0e} times the lowest eigenvalue of the structure, so frequencies and \
             amplitudes may be wrong: leave degrees of freedom that are held out of the matrices, in place of holding them by a very stiff spring",
            model.dofs[row]
        )
    })
}
