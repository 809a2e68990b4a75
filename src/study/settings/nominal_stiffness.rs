//! Nominal stiffness of an interface, which measured stiffnesses are divided by.

use std::collections::BTreeMap;

use super::frequency::FrequencyUnit;
use super::model::ModelSettings;
use crate::model::matrix_contacts::ContactTable;
use crate::setting::BadSetting;
use crate::units::n_per_um_to_n_per_m;

/// Direction of a stiffness of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Across the interface.
    Normal,
    /// Along it.
    Tangential,
}

/// Difference of nominal stiffnesses, over the larger one, that rounding of a study file explains.
const SAME_STIFFNESS: f64 = 1e-6;

/// Nominal stiffness (N/µm) of an interface: of `[contact]` for the built-in model, else the sum over the pairs of an interface.
///
/// # Errors
/// [`BadSetting`] with a key of the study file: matrices in unknown units, or interfaces whose sums differ, so that no single
/// factor makes them a measured stiffness.
pub(super) fn nominal_stiffness(
    model: &ModelSettings,
    unit: FrequencyUnit,
    direction: Direction,
) -> Result<f64, BadSetting> {
    let of_rig = |stiffness: f64| stiffness / n_per_um_to_n_per_m(1.0);
    if let Some(interface) = model.interface() {
        return Ok(of_rig(match direction {
            Direction::Normal => interface.normal_stiffness,
            Direction::Tangential => interface.tangential_stiffness,
        }));
    }
    let rule = "must be absent: it needs a model in SI units, with frequency.band_hz, because its stiffnesses are in N/µm";
    let si = unit == FrequencyUnit::Hertz;
    BadSetting::unless(si, "inputs.from", "(given)", rule)?;
    let pairs = model
        .matrices()
        .map_or(&[][..], |settings| &settings.contact);
    of_pairs(pairs, direction)
}

fn of_pairs(pairs: &[ContactTable], direction: Direction) -> Result<f64, BadSetting> {
    let mut sums: BTreeMap<(usize, &str), f64> = BTreeMap::new();
    for pair in pairs {
        let springs = match direction {
            Direction::Normal => vec![("k_n", pair.k_n)],
            Direction::Tangential => vec![("k_t1", pair.k_t1), ("k_t2", pair.k_t2)],
        };
        for (key, stiffness) in springs {
            let stiffness = stiffness.unwrap_or(0.0) / n_per_um_to_n_per_m(1.0);
            *sums.entry((pair.interface, key)).or_default() += stiffness;
        }
    }
    sums.retain(|_, sum| *sum > 0.0);
    let least = sums.values().copied().fold(f64::INFINITY, f64::min);
    let most = sums.values().copied().fold(0.0, f64::max);
    let written: Vec<String> = (sums.iter())
        .map(|((interface, key), sum)| format!("{key} of interface {interface}: {sum} N/µm"))
        .collect();
    let key = "model.contact";
    let rule = "must have a stiffness that the one of the file of inputs.from can scale";
    BadSetting::unless(!sums.is_empty(), key, "(no stiffness)", rule)?;
    let rule = "must have the same sum over the pairs of every interface and direction: one factor makes all of them the \
                stiffness that the file of inputs.from states for an interface";
    let same = most - least <= SAME_STIFFNESS * most;
    BadSetting::unless(same, key, written.join(", "), rule)?;
    Ok(most)
}
