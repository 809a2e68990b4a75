//! Maxima on more harmonics that Newton's method does not reach from the one on fewer.

use super::{CLOSE_RIG, one_half};
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    AlertSettings, HbSettings, NewtonSettings, Problem, SliderAnchor, StabilityScope, Status,
};
use microslip::units::{hz_to_rad_s, rad_s_to_hz};

/// On 4 x 4 points, harmonics 15 and 16 of 20 N meet a resonance of the strip on its contacts. On 20 harmonics the branch has folds there, and a lower maximum
/// 0.1 Hz beside the one that the largest amplitude of `solve` is, on 20 harmonics from the start.
/// Seen to fail without the branch through that lower maximum.
#[test]
fn a_maximum_beside_a_resonance_of_the_strip_is_found_on_more_harmonics() {
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(5),
        aft: AftSettings {
            n_time: 128,
            law: FrictionLaw::Box,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        anchor: SliderAnchor::Unloaded,
        newton: NewtonSettings::default(),
        alert: Some(AlertSettings {
            threshold: 0.01,
            highest_harmonic: 20,
            ..AlertSettings::default()
        }),
        stability: StabilityScope::Off,
    };
    let peak = PeakSettings {
        band: Band {
            low: hz_to_rad_s(2605.0),
            high: hz_to_rad_s(2635.0),
        },
        frequency_tolerance: 3e-7,
    };
    let (model, contacts) = one_half(&CLOSE_RIG.reduced, 3.7223, 0.18353);
    let problem = Problem::new(&model, contacts, 1.0, settings.anchor).expect("well posed");
    let mut found = track_peaks(&problem, &settings, peak, &[0.1, 5.0, 20.0]).expect("modes");
    let found = found.pop().expect("a level");
    let solution = found.solution.expect("a peak");
    let (frequency, amplitude) = (rad_s_to_hz(solution.omega), solution.amplitude(0));
    println!("{frequency:.4} Hz, {amplitude:.5e} m");
    assert_eq!(found.status, Status::Converged);
    assert_eq!(solution.harmonics.highest(), 20);
    assert!((frequency - 2620.520).abs() < 1e-3, "{frequency}");
    assert!((amplitude / 1.8312e-5 - 1.0).abs() < 1e-4, "{amplitude}");
}
