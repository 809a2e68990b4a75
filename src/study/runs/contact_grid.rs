//! What the contact grid of a built-in model changes: the stuck shift of neck bending, and the peaks at nominal inputs.

use crate::ensemble::Ensemble;
use crate::ensemble::outcome::{LevelOutcome, PeakRecord};
use crate::hb::structure::resonance::linear_resonance;
use crate::hb::{HbSettings, StabilityScope};
use crate::report::run::{ContactGridRecord, FinerGridRecord};
use crate::study::prepared::PreparedStudy;
use crate::study::settings::model::ModelSettings;
use crate::study::settings::read::Study;
use crate::units::rad_s_to_hz;
use std::borrow::Cow;

/// Newton iterations of a search on either grid, at most. A level where contacts are open for most of the period would take as many as the
/// whole study.
const BUDGET: usize = 600;

/// The stuck shift of neck bending on the contact grid of the built-in rig, and where it goes on finer ones.
pub(super) fn contact_grid(study: &Study) -> Option<ContactGridRecord> {
    let ModelSettings::TwoBladeStrip {
        blades, interface, ..
    } = &study.model
    else {
        return None;
    };
    let found = blades.grid_error(interface)?;
    Some(ContactGridRecord {
        contact_nodes: found.contact_nodes,
        shift_hz: found.shift_hz,
        limit_hz: found.limit_hz(),
        relative: found.relative(),
    })
}

/// The peaks at nominal inputs on a finer contact grid against those on the grid of the study, both on the study's first harmonics. Absent
/// where [`ModelSettings::finer_contact_nodes`] has no such grid.
pub(super) fn finer_grid(prepared: &PreparedStudy, ensemble: &Ensemble) -> Option<FinerGridRecord> {
    let contact_nodes = prepared.study.model.finer_contact_nodes()?;
    let finer = Study {
        model: prepared.study.model.with_contact_nodes(contact_nodes),
        ..Study::clone(&prepared.study)
    };
    let finer = PreparedStudy::of(Cow::Owned(finer)).ok()?;
    let finer = finer.ensemble(None);
    let (here, there) = rayon::join(|| nominal_peaks(ensemble), || nominal_peaks(&finer));
    let pairs: Vec<(Option<PeakRecord>, Option<PeakRecord>)> =
        here.into_iter().zip(there).collect();
    // the elements of the blades follow the grid, so that it moves their own frequencies, too
    let free = free_frequency_hz(ensemble).zip(free_frequency_hz(&finer));
    let change = |of: &dyn Fn(PeakRecord, PeakRecord) -> Option<f64>| -> Vec<Option<f64>> {
        let pairs = pairs.iter();
        pairs.map(|(here, there)| of((*here)?, (*there)?)).collect()
    };
    Some(FinerGridRecord {
        contact_nodes,
        shift_change_hz: change(&|here, there| {
            let (free_here, free_there) = free?;
            Some((there.frequency_hz - free_there) - (here.frequency_hz - free_here))
        }),
        amplitude_change: change(&|here, there| Some(there.amplitude_m / here.amplitude_m - 1.0)),
    })
}

/// Resonance in the band of the structure without contacts (Hz).
fn free_frequency_hz(ensemble: &Ensemble) -> Option<f64> {
    let open = vec![0.0; ensemble.linear.n_relative()];
    let found = linear_resonance(ensemble.linear, &open, ensemble.peak.band).ok()??;
    Some(rad_s_to_hz(found.omega))
}

/// Nominal peaks on the first harmonics of the study; absent at levels without a solution.
fn nominal_peaks(ensemble: &Ensemble) -> Vec<Option<PeakRecord>> {
    let mut settings = HbSettings {
        alert: None,
        stability: StabilityScope::Off,
        ..ensemble.settings.clone()
    };
    settings.newton.budget = settings.newton.budget.min(BUDGET);
    let ensemble = Ensemble {
        settings: &settings,
        ..*ensemble
    };
    let levels = ensemble.nominal_levels();
    levels.iter().map(LevelOutcome::solved_peak).collect()
}
