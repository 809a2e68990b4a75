//! The error of the contact grid that a run states.

use super::{K_N, K_T};
use microslip::model::interface::InterfaceSettings;
use microslip::model::two_blade::TwoBladeSettings;

/// The stated error of a contact grid is 0.75 to 1.33 times that against a grid of 12 x 12 nodes and order 1.5, and smaller for a
/// finer grid. Prints the numbers. Without the extrapolation beyond the finer grid it would say 0.12 Hz of 0.16.
#[test]
fn the_stated_grid_error_is_that_of_finer_grids() {
    let interface = InterfaceSettings {
        normal_stiffness: K_N,
        tangential_stiffness: K_T,
        ..InterfaceSettings::default()
    };
    // the coarse blades of the comparison of grids above
    let limit = 7.454;
    let grids = [([3, 2], 1.0), ([5, 3], 1.0), ([4, 4], 0.8)];
    let stated = grids.map(|(contact_nodes, contact_spacing_at_gap)| {
        let settings = TwoBladeSettings {
            contact_nodes,
            contact_spacing_at_gap,
            ..TwoBladeSettings::default()
        };
        let found = settings.grid_error(&interface).expect("a small grid");
        let error = (found.shift_hz - limit).abs();
        let said = found.relative() * found.shift_hz;
        println!("{found:.3?}: {said:.3} Hz, {error:.3} Hz");
        assert!(said > 0.75 * error && said < 1.33 * error, "{found:?}");
        said
    });
    assert!(stated.is_sorted_by(|a, b| a > b), "{stated:?}");
    let large = TwoBladeSettings {
        contact_nodes: [10, 7],
        ..TwoBladeSettings::default()
    };
    assert!(large.grid_error(&interface).is_none());
}
