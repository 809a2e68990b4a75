//! Strips of other thicknesses on the blades of one rig, and how their load is shared out.

use super::{K_N, K_T, RIG};
use microslip::model::ReducedModel;
use microslip::model::interface::{InterfaceSettings, StiffnessShare};
use microslip::model::two_blade::{
    PressureField, PressureInputs, TwoBladeModel, TwoBladeSettings, build,
};
use microslip::units::rad_s_to_hz;

/// A small rig whose strip keeps as many modes at any thickness, with loads of a punch and of a field: the frequencies of
/// its bending modes are in proportion to the thickness, and so is the cut-off.
fn small(strip_mm: [f64; 3], pressure_weights: Option<Vec<f64>>) -> TwoBladeModel {
    let settings = TwoBladeSettings {
        strip_mm,
        contact_nodes: [2, 3],
        blade_element_mm: [15.0, 25.0, 25.0],
        strip_cut_off_hz: 3e4 * strip_mm[2] / 0.4,
        pressure_weights,
        ..TwoBladeSettings::default()
    };
    let field = PressureField {
        standard_deviation: 0.1,
        correlation_length_mm: 10.0,
        modes: 2,
    };
    let pressure = PressureInputs::new(&settings, true, Some(&field)).expect("converges");
    build(&settings).expect("builds").with_pressure(pressure)
}

fn assert_same(a: &ReducedModel, b: &ReducedModel) {
    assert_eq!(a.mass, b.mass, "mass");
    assert_eq!(a.damping, b.damping, "damping");
    assert_eq!(a.stiffness, b.stiffness, "stiffness");
    assert_eq!(a.retention, b.retention, "retention");
    assert_eq!(a.contacts, b.contacts, "contacts");
    assert_eq!(a.static_force, b.static_force, "static force");
    assert_eq!(a.loads, b.loads, "loads");
    assert_eq!(a.mirror, b.mirror, "mirror");
}

/// The nominal thickness gives the nominal model, and any other one the model that is built with it, to the bit.
/// Seen to fail with the pressure loads of the nominal strip, and with its centrifugal load.
#[test]
fn a_strip_of_another_thickness_is_the_one_built_with_it() {
    let nominal = RIG.with_strip(0.4).expect("reduces");
    assert_same(&nominal, &RIG.reduced);
    let rig = small([10.0, 50.0, 0.4], None);
    for thickness in [0.3, 0.4, 0.7] {
        let mut settings = rig.settings.with_strip_thickness(thickness);
        settings.strip_cut_off_hz *= thickness / 0.4;
        let [_, _, built] = settings.strip_mm;
        assert_eq!(built, thickness);
        let load = 180.0 * thickness / 0.4;
        assert!((settings.centrifugal_load_n - load).abs() < 1e-12 * load);
        let mut expected = build(&settings).expect("builds");
        // other modes than those of bending do not follow the thickness
        for _ in 0..20 {
            settings.strip_cut_off_hz *= match expected.strip.n_modes.cmp(&rig.strip.n_modes) {
                std::cmp::Ordering::Less => 1.02,
                std::cmp::Ordering::Equal => break,
                std::cmp::Ordering::Greater => 0.98,
            };
            expected = build(&settings).expect("builds");
        }
        assert_eq!(expected.strip.n_modes, rig.strip.n_modes);
        let expected = expected.with_pressure(rig.pressure().clone());
        let found = rig.with_strip(thickness).expect("reduces");
        assert_same(&found, &expected.reduced);
        settings.centrifugal_load_n = 1.0;
        assert_ne!(
            found.static_force,
            build(&settings).expect("builds").reduced.static_force
        );
    }
}

/// Σ over the strip's displacements in z: r^T M r and r^T f of a unit translation.
fn mass_and_load(model: &ReducedModel) -> [f64; 2] {
    let along_z: Vec<usize> = (0..model.n_dofs())
        .filter(|&q| {
            let name = &model.dof_names[q];
            name.starts_with("strip") && name.ends_with(".z")
        })
        .collect();
    let row = |i: &usize| along_z.iter().map(|&j| model.mass[(*i, j)]).sum::<f64>();
    let load = along_z.iter().map(|&i| model.static_force[i]).sum();
    [along_z.iter().map(row).sum(), load]
}

/// Mass and load of the strip grow in proportion; stuck in-phase bending gets stiffer with the strip.
/// Seen to fail with the centrifugal load of the nominal strip.
#[test]
fn a_thicker_strip_is_heavier_and_stiffer() {
    let interface = InterfaceSettings {
        normal_stiffness: K_N,
        tangential_stiffness: K_T,
        friction_coefficient: 0.6,
        share: StiffnessShare::TributaryArea,
    };
    let contacts = interface.parameters(&RIG.reduced.contacts);
    let [mass, load] = mass_and_load(&RIG.reduced);
    // round-off of the reduction
    assert!(
        (mass / (7850.0 * 10e-3 * 50e-3 * 0.4e-3) - 1.0).abs() < 1e-10,
        "{mass}"
    );
    assert!((load / 180.0 - 1.0).abs() < 1e-10, "{load}");
    let frequency = |thickness: f64| {
        let model = RIG.with_strip(thickness).expect("reduces");
        let [own_mass, own_load] = mass_and_load(&model);
        for (own, nominal) in [(own_mass, mass), (own_load, load)] {
            assert!(
                (own / nominal / (thickness / 0.4) - 1.0).abs() < 1e-10,
                "{own}"
            );
        }
        // the in-phase neck bending is the fifth mode of the stuck rig, close below the one out of phase
        let stuck = model.stuck_frequencies(&contacts).expect("definite");
        rad_s_to_hz(stuck[4])
    };
    let found = [0.2, 0.3, 0.6].map(frequency);
    println!("{found:.5?}");
    assert!(found.windows(2).all(|w| w[1] > w[0] + 0.05), "{found:?}");
}

/// Nodal loads of the contacts from the nominal ones to those of the punch: none pulls, also where a node carries nothing,
/// and each interface keeps its load.
/// Seen to fail with the punch's deviation from an even load on top of the nominal load.
#[test]
fn edge_pressure_pulls_no_node() {
    let unloaded = [0.0, 1.0, 0.0, 4.0, 0.0, 1.0].repeat(2);
    for weights in [None, Some(unloaded)] {
        let rig = small([10.0, 50.0, 0.4], weights.clone());
        let model = &rig.reduced;
        let nodal = |share: f64| -> Vec<f64> {
            let force = model.static_force.iter().zip(&model.loads[0]);
            let force: Vec<f64> = force.map(|(f, load)| f + share * load).collect();
            let strip = |row: &[(usize, f64)]| row.iter().find(|(_, w)| *w > 0.0).map(|(q, _)| *q);
            let dofs = model.contacts.iter().filter_map(|pair| strip(&pair.n));
            dofs.map(|q| force[q]).collect()
        };
        let punch = nodal(1.0);
        for share in [0.0, 0.5, 1.0] {
            let loads = nodal(share);
            assert!(loads.iter().all(|f| *f > -1e-12), "{share}: {loads:?}");
            for interface in loads.chunks(6) {
                let load: f64 = interface.iter().sum();
                assert!((load - 90.0).abs() < 1e-9, "{share}: {load} N");
            }
        }
        // two columns with equal parts of the width: a punch presses on both alike, and along the gap by area, 5 : 8 : 5
        let expected = [12.5, 12.5, 20.0, 20.0, 12.5, 12.5].repeat(2);
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        let worst = punch.iter().zip(&expected).map(off).fold(0.0, f64::max);
        assert!(worst < 1e-9, "{punch:?}");
    }
}

/// A strip of its own material: the blades stay as they are, its mass is in proportion to its density, and its free frequencies to the root of
/// its modulus over its density; that of the blades, given as its own, changes nothing. Seen to fail with the material of the strip for the
/// blades and that of the blades for the strip.
#[test]
fn a_strip_may_have_its_own_material() {
    let built = |modulus: Option<f64>, density: Option<f64>| {
        let settings = TwoBladeSettings {
            contact_nodes: [2, 3],
            blade_element_mm: [15.0, 25.0, 25.0],
            strip_youngs_modulus_gpa: modulus,
            strip_density_kg_m3: density,
            ..TwoBladeSettings::default()
        };
        build(&settings).expect("builds")
    };
    let steel = built(None, None);
    assert_same(&steel.reduced, &built(Some(210.0), Some(7850.0)).reduced);
    let other = built(Some(420.0), Some(3925.0));
    assert_eq!(other.blade, steel.blade);
    for axis in 0..3 {
        let ratio = other.strip.mass[axis] / steel.strip.mass[axis];
        assert!((ratio - 0.5).abs() < 1e-12, "mass: {ratio}");
    }
    let frequencies = |of: &TwoBladeModel| of.strip.full_frequencies.clone();
    let (ours, theirs) = (frequencies(&other), frequencies(&steel));
    // after the six rigid motions
    for (ours, theirs) in ours.iter().zip(&theirs).skip(6) {
        assert!((ours / theirs - 2.0).abs() < 1e-6, "{ours} {theirs}");
    }
    let load = mass_and_load(&other.reduced)[1] / mass_and_load(&steel.reduced)[1];
    assert!((load - 1.0).abs() < 1e-12, "load: {load}");
}
