//! The stress and the amplitude that a study allows.

use crate::report::asked::requirement::{RequiredQuantity, Stress};
use crate::report::run::record::RunRecord;
use crate::statistics::{goodman_allowable, reserve_factor};
use crate::units::{m_to_um, um_to_m};

/// Allowable alternating stress (MPa); the settings are checked, so it exists.
pub(in crate::report) fn allowable_mpa(stress: &Stress) -> f64 {
    let allowable = goodman_allowable(
        stress.endurance_limit_mpa,
        stress.mean_stress_mpa,
        stress.ultimate_strength_mpa,
    );
    allowable.unwrap_or(f64::NAN)
}

/// Amplitude at which the allowable stress is reached (m).
pub(in crate::report) fn allowable_amplitude_m(stress: &Stress) -> f64 {
    um_to_m(allowable_mpa(stress) / stress.modal_stress_mpa_per_um)
}

/// Reserve factor of an amplitude (m); NaN for a failed sample.
pub(in crate::report) fn factor(amplitude_m: f64, stress: &Stress) -> f64 {
    let applied = m_to_um(amplitude_m) * stress.modal_stress_mpa_per_um;
    reserve_factor(allowable_mpa(stress), applied).unwrap_or(f64::NAN)
}

/// Limits of the amplitude (m) that the study states for level `i`, ascending: criteria and allowable stress.
pub(in crate::report) fn amplitude_limits_m(record: &RunRecord, i: usize) -> Vec<f64> {
    let requirements = &record.requirements;
    let criteria = requirements.criteria.iter().filter(|criterion| {
        let here = criterion.level.is_none_or(|l| l == record.levels[i]);
        criterion.quantity == RequiredQuantity::AmplitudeUm && here
    });
    let stated = criteria.map(|criterion| um_to_m(criterion.limit));
    let stress = requirements.stress.as_ref().map(allowable_amplitude_m);
    let mut limits: Vec<f64> = stated.chain(stress).collect();
    limits.sort_by(f64::total_cmp);
    limits.dedup();
    limits
}
