//! Total mass and weight of a model, as `inspect` and `import` list them.

use std::io::Write;

use microslip::units::STANDARD_GRAVITY;

/// Both along x, y, z. Masses of a model that is not in SI units are no kg and have no weight.
pub(super) fn show_mass(
    out: &mut dyn Write,
    total: Option<[f64; 3]>,
    si: bool,
) -> std::io::Result<()> {
    let Some(mass) = total else {
        return writeln!(
            out,
            "total mass          not known: no names with the components 1, 2, 3"
        );
    };
    let along = |values: [f64; 3]| values.map(|value| format!("{value:.6}")).join(" ");
    if !si {
        return writeln!(out, "total mass          {} along x, y, z", along(mass));
    }
    writeln!(out, "total mass          {} kg along x, y, z", along(mass))?;
    let weight = along(mass.map(|m| m * STANDARD_GRAVITY));
    writeln!(
        out,
        "weight              {weight} N at {STANDARD_GRAVITY} m/s2"
    )
}
