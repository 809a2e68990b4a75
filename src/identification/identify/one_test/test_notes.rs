//! What a reader of a test should know.

use super::range_end::range_ends;
use super::unlike::sides_apart;
use crate::identify::found::result::{Cycles, TestEstimate};
use crate::identify::found::uncertain::Uncertain;
use crate::identify::one_loop::loop_shape::LoopShape;
use crate::identify::one_loop::slip_limits::KnownPressure;
use crate::identify::settings::IdentifySettings;
use crate::record::HysteresisRecord;

/// Difference of the two friction coefficients that is told.
const ENERGY_DIFFERENCE: f64 = 0.05;
/// Measured over series stiffness above which the rig decides.
const MOSTLY_RIG: f64 = 0.8;
/// Half an interval, over its value, that is told: the published accuracy.
const HARDLY_KNOWN: f64 = 0.05;
/// Energy over that of a rectangle of the same size, above which a loop that does not slip as a whole slips in part.
const PARTIAL_SLIP: f64 = 0.01;
/// Difference of a stated frequency from that of the record, over it, that clocks of two instruments do not make.
const CLOCKS_APART: f64 = 1e-3;
/// Difference of the slopes at the start of a stick branch and after it that is told: a fifth of the published accuracy.
const STARTS_APART: f64 = 0.01;
/// Offset of T over the force at slip that is told.
const OFFSET: f64 = 0.05;

/// Friction coefficient below which a force may be in a wrong unit: that of a dry or oily metal is larger.
const SMALL_FRICTION: f64 = 0.01;

/// Difference between the stated share of the area about the mean pressure and that of a pressure map, that is told.
const SHARES_APART: f64 = 0.05;

/// A sentence where the record states another share of the area about the mean pressure than the map has.
pub(super) fn other_share(record: &HysteresisRecord, pressure: &KnownPressure) -> Option<String> {
    let (stated, found) = (record.conditions.even_area?, pressure.even_area());
    let [stated_percent, found_percent] = [stated, found].map(|share| 100.0 * share);
    ((stated - found).abs() > SHARES_APART).then(|| {
        format!(
            "{stated_percent:.0} % of the area are stated to be within a tenth of the mean pressure, the pressure map has {found_percent:.0} %: the map is used"
        )
    })
}

/// A sentence where the start of a stick branch and the branch after it disagree on the slope.
pub(super) fn other_start(shape: &LoopShape<'_>) -> Option<String> {
    let windows = shape.windows.iter().flatten();
    let apart = windows.map(|window| window.apart).fold(0.0, f64::max);
    let percent = 100.0 * apart;
    (apart > STARTS_APART).then(|| {
        format!(
            "the slope at the start of a stick branch may be another one than after it, by up to {percent:.1} %: parts of the contact may slip \
             before the slope is taken, and the interval of the stiffness allows for it"
        )
    })
}

/// Sentences on one test.
pub(super) fn notes(
    estimate: &TestEstimate,
    cycles: &Cycles,
    record: &HysteresisRecord,
    settings: &IdentifySettings,
) -> Vec<String> {
    let mut notes = Vec::new();
    notes.extend(range_ends(record, cycles.samples_per_cycle));
    of_cycles(cycles, record, &mut notes);
    of_friction(estimate, &mut notes);
    of_stiffness(estimate, settings, &mut notes);
    if estimate.misfit.large {
        let percent = 100.0 * estimate.misfit.relative_rms;
        notes.push(format!(
            "the loop differs from an elastic-Coulomb one by {percent:.1} % of its swing (rms): the parameters describe it less well"
        ));
    }
    if record.approach.is_some() && estimate.normal_stiffness_n_per_um.is_none() {
        notes.push("the approach is measured but is mostly noise: no normal stiffness".to_owned());
    }
    notes
}

fn of_cycles(cycles: &Cycles, record: &HysteresisRecord, notes: &mut Vec<String>) {
    if let Some(stated) = record.conditions.frequency_hz
        && stated != cycles.frequency_hz
    {
        let found = cycles.frequency_hz;
        let wrong = match (stated / found - 1.0).abs() > CLOCKS_APART {
            true => "the stated frequency is wrong: ",
            false => "",
        };
        notes.push(format!(
            "{wrong}the frequency is stated as {stated} Hz, the record has {found:.6} Hz, which is used"
        ));
    }
    if cycles.steady == 1 {
        notes.push("one loop: the intervals hold the noise inside of it, not the scatter from loop to loop".to_owned());
    }
    if let Some(resonance) = cycles.force_resonance {
        let (frequency, damping) = (resonance.frequency_hz, 100.0 * resonance.damping_ratio);
        notes.push(format!(
            "the force cell has a resonance at {frequency:.0} Hz (damping ratio {damping:.1} %): the force of the mass before it is taken out of the tangential force"
        ));
    }
    if cycles.spikes > 0 {
        let spikes = cycles.spikes;
        notes.push(format!(
            "{spikes} values far from those of the other cycles are replaced by their median"
        ));
    }
}

fn of_friction(estimate: &TestEstimate, notes: &mut Vec<String>) {
    if let Some(least) = estimate.friction_at_least {
        notes.push(format!(
            "the contact never slips as a whole: the friction coefficient is at least {least:.3}, no more is known of it"
        ));
        let rectangle =
            4.0 * estimate.displacement_amplitude_m * estimate.tangential_force_amplitude_n;
        if estimate.energy_j.value > PARTIAL_SLIP * rectangle {
            notes.push("a part of the contact slips: the loop has an area".to_owned());
        }
    }
    let Some(friction) = estimate.friction else {
        return;
    };
    if let Some(difference) = friction
        .energy_difference
        .filter(|d| d.abs() > ENERGY_DIFFERENCE)
    {
        let percent = 100.0 * difference;
        notes.push(format!(
            "the friction coefficient from the energy differs from that of the plateaus by {percent:+.1} %"
        ));
    }
    let known = friction.coefficient;
    if known.value < SMALL_FRICTION {
        notes.push(format!(
            "the friction coefficient is {:.2e}, below {SMALL_FRICTION}: is the unit of one force wrong?",
            known.value
        ));
    }
    let differs = "T/N of the plateaus differs from cycle to cycle";
    if let Some(known) = hardly_known(known, differs) {
        notes.push(format!("the friction coefficient is {known}"));
    }
    let slip = known.value * estimate.normal_force_n;
    if friction.tangential_offset_n.abs() > OFFSET * slip {
        let offset = friction.tangential_offset_n;
        notes.push(format!("the plateaus show an offset of the tangential force of {offset:.4} N, which is taken out"));
    }
}

/// A wide interval in percent about the value, and why it is wide: by the stated errors of the measuring chain, or as `random` says.
fn hardly_known(known: Uncertain, random: &str) -> Option<String> {
    let wide = known.upper - known.value > HARDLY_KNOWN * known.value;
    let [below, above] = [known.lower, known.upper].map(|end| 100.0 * (end / known.value - 1.0));
    let cause = match known.systematic > known.standard_error {
        true => "the measuring chain is stated to be no better",
        false => random,
    };
    wide.then(|| format!("only known to {below:.0} and {above:+.0} %: {cause}"))
}

fn of_stiffness(estimate: &TestEstimate, settings: &IdentifySettings, notes: &mut Vec<String>) {
    let tangential = &estimate.tangential;
    if let ([Some(a), Some(b)], Some(_)) = (
        tangential.sides_n_per_um,
        sides_apart(&tangential.sides_n_per_um),
    ) {
        notes.push(format!(
            "the stiffness is {:.4} N/um after the reversal at the greatest displacement and {:.4} N/um after that at the least: the interval of the one \
             stiffness of the test holds both",
            a.value, b.value
        ));
    }
    if tangential.bent.contains(&true) {
        notes.push("parts of the contact slip before the whole (microslip): the stick branches are straightened by the spread of the slip limits that fits them".to_owned());
    }
    let small = "its travel is small beside noise and steps of the displacement, or parts of the contact slip early";
    if let Some(known) = hardly_known(tangential.stiffness_n_per_um, small) {
        notes.push(format!("the stiffness is {known}"));
    }
    let stated = settings.series_stiffness_n_per_um;
    if stated.is_some_and(|series| tangential.measured_n_per_um > MOSTLY_RIG * series) {
        notes.push("most of the measured compliance is the rig's: an error of the series stiffness changes the contact's by a multiple".to_owned());
    }
}
