//! Studies of the built-in model that the program refuses.

use super::cases::Case;

/// A study of the built-in model.
pub(crate) const RIG: &str = "\
name = \"rig\"
levels = [1.0]

[model]
kind = \"two-blade-strip\"
contact_nodes = [3, 5]

[contact]
friction_coefficient = 0.6

[frequency]
band_hz = [2605, 2635]
";

/// Changes of [`RIG`] that the program and the schema refuse.
pub(crate) const RIG_REFUSED: &[Case] = &[
    (
        "contact_nodes = [3, 5]",
        "contact_nodes = [1000000, 1000000]",
        &[":6: model.contact_nodes = [1000000, 1000000]: needs 2 to 50"],
    ),
    (
        "contact_nodes = [3, 5]",
        "strip_mm = [10.0, 50.0, 0.4, 1.0]",
        &[":6: model.strip_mm: expected a list of 3 values, not of 4"],
    ),
    (
        "contact_nodes = [3, 5]",
        "blade_cut_off_hz = 1e12",
        &[":6: model.blade_cut_off_hz = 1e12: must be from 0 to 1e9"],
    ),
    (
        "contact_nodes = [3, 5]",
        "blade_damping_ratio = 1e30",
        &[":6: model.blade_damping_ratio = 1e30: must be from 0 to 1"],
    ),
    (
        "contact_nodes = [3, 5]",
        "strip_damping_ratio = -1e-3",
        &[":6: model.strip_damping_ratio = -0.001: must be from 0 to 1"],
    ),
    (
        "contact_nodes = [3, 5]",
        "youngs_modulus_gpa = 9e18",
        &[":6: model.youngs_modulus_gpa = 9e18: must be from 0.001 to 10000"],
    ),
    (
        "contact_nodes = [3, 5]",
        "density_kg_m3 = 1e-300",
        &[":6: model.density_kg_m3 = 1e-300: must be from 1 to 1e5"],
    ),
    (
        "contact_nodes = [3, 5]",
        "strip_youngs_modulus_gpa = 0",
        &[":6: model.strip_youngs_modulus_gpa = 0: must be from 0.001 to 10000"],
    ),
    (
        "contact_nodes = [3, 5]",
        "strip_density_kg_m3 = 1e9",
        &[":6: model.strip_density_kg_m3 = 1e9: must be from 1 to 1e8"],
    ),
    (
        "contact_nodes = [3, 5]",
        "airfoil_mm = [4.6, 25.2, 1e-300]",
        &[":6: model.airfoil_mm = 1e-300: must be from 0.001 to 10000"],
    ),
    (
        "contact_nodes = [3, 5]",
        "strip_element_mm = 1e308",
        &[":6: model.strip_element_mm = 1e308: must be from 0.001 to 10000"],
    ),
    (
        "contact_nodes = [3, 5]",
        "centrifugal_load_n = 1e30",
        &[":6: model.centrifugal_load_n = 1e30: must be from 1e-6 to 1e9"],
    ),
    (
        "contact_nodes = [3, 5]",
        "retention_n_per_m = 1e308",
        &[":6: model.retention_n_per_m = 1e308: must be from"],
    ),
    (
        "contact_nodes = [3, 5]",
        "excitation_direction = [1e308, 0.0, 0.0]",
        &[
            ":6: model.excitation_direction = ",
            "must be a vector of numbers up to 1e30",
        ],
    ),
    (
        "friction_coefficient = 0.6",
        "friction_coefficient = 20",
        &[":9: contact.friction_coefficient = 20: must be from 0 to 10"],
    ),
    (
        "friction_coefficient = 0.6",
        "normal_stiffness_n_per_um = 1e9",
        &[":9: contact.normal_stiffness_n_per_um = 1e9: must be from 1e-6 to 1e6"],
    ),
];

/// Changes of [`RIG`] that the program alone refuses.
pub(crate) const RIG_BEYOND_SCHEMA: &[Case] = &[
    (
        "contact_nodes = [3, 5]",
        "blade_cut_off_hz = 1",
        &[
            ":6: model.blade_cut_off_hz = 1: must be above the band of [frequency], which ends at 2635 Hz",
        ],
    ),
    (
        "contact_nodes = [3, 5]",
        "blade_element_mm = [0.01, 0.01, 0.01]",
        &[":6: model.blade_element_mm = edges for ", "must be longer"],
    ),
    (
        "contact_nodes = [3, 5]",
        "contact_nodes = [50, 2]\ngap_mm = 9.98",
        &[":6: model.contact_nodes = [50, 2]: must be fewer"],
    ),
];
