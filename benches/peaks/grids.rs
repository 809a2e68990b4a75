//! What the contact grid changes of the answer, and of its price.

use crate::clock::processor_time;
use crate::rig::{Rig, search, settings};
use microslip::hb::AlertSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::model::interface::InterfaceSettings;
use microslip::model::two_blade::{TwoBladeSettings, build};

/// Contact nodes per interface, across the gap and along it, and their spacing at the gap. The first is the default.
const GRIDS: [([usize; 2], f64); 10] = [
    ([5, 3], 1.0),
    ([3, 5], 1.0),
    ([4, 4], 1.0),
    ([4, 4], 0.8),
    ([5, 4], 1.0),
    ([4, 5], 1.0),
    ([5, 5], 1.0),
    ([6, 6], 1.0),
    ([5, 8], 1.0),
    ([8, 8], 1.0),
];
/// Stiffnesses over the nominal ones.
const SCALES: [f64; 3] = [0.1, 1.0, 10.0];
/// Of the excitation (N).
const LEVELS: [f64; 4] = [5.0, 10.0, 20.0, 50.0];

/// Stuck shifts of neck bending, and the nominal peaks with as many harmonics as the default study asks for.
pub(crate) fn grids() {
    println!("nodes, spacing  shift at {SCALES:?} (Hz)  amplitude at {LEVELS:?} N (um/N)  seconds");
    for (contact_nodes, contact_spacing_at_gap) in GRIDS {
        let blades = TwoBladeSettings {
            contact_nodes,
            contact_spacing_at_gap,
            ..TwoBladeSettings::default()
        };
        let rig = build(&blades).expect("valid");
        let interface = InterfaceSettings::default();
        let shifts = SCALES.map(|scale| {
            let [k_n, k_t] = [interface.normal_stiffness, interface.tangential_stiffness];
            let stuck = rig.stuck_neck_bending(scale * k_n, scale * k_t);
            stuck.expect("definite").frequency - rig.free_neck_bending()
        });
        let contacts = interface.parameters(&rig.reduced.contacts);
        let half = Rig::folded(&rig.reduced, contacts);
        let problem = half.problem(1.0, interface.friction_coefficient);
        let settings = settings(5, Some(AlertSettings::default()));
        let (seconds, found) =
            processor_time(|| track_peaks(&problem, &settings, search(), &LEVELS).expect("modes"));
        let amplitudes: Vec<String> = (found.iter())
            .map(|peak| match &peak.solution {
                Some(solution) => format!(
                    "{:.4} ({})",
                    1e6 * solution.amplitude(0) / peak.level,
                    solution.harmonics.highest()
                ),
                None => peak.status.name().to_owned(),
            })
            .collect();
        let [across, along] = contact_nodes;
        println!(
            "{across} x {along}, {contact_spacing_at_gap}  {shifts:.3?}  {amplitudes:?}  {seconds:.1}"
        );
    }
}
