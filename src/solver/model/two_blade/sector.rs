//! One sector of a disk: a blade of the rig and the strip between it and the next blade.
//!
//! The blades are clamped as in the rig, so that only the strips couple them. All of them are equal, not mirror images, and
//! a strip lies at both edges of a platform. The platforms' undersides are those of the rig, in one plane: the angle of 2π/N
//! between the platforms of a gap is left out.

use super::assembly::{modal_damping, strip_damping_time};
use super::placed_strip::{PlacedStrip, names_of};
use super::{Blade, ComponentSummary, TwoBladeSettings};
use super::{Component, components::Layout};
use crate::fe::Rectangle;
use crate::model::disk::{CyclicMatrix, Disk};
use crate::model::{ModelError, Response};
use faer::{Mat, Scale};

/// A disk of the rig's blades and what a report says about its making.
#[derive(Debug, Clone)]
pub struct SectorModel {
    /// The model for harmonic balance. Degrees of freedom: blade, strip.
    pub disk: Disk,
    /// One blade without strip.
    pub blade: ComponentSummary,
    /// The free strip.
    pub strip: ComponentSummary,
}

/// Builds the sector of a disk with `n_sectors` blades. [`TwoBladeSettings::excitation_phase`] has no meaning here.
///
/// # Errors
/// [`ModelError`]: a setting breaks a rule, or the mesh or an eigenvalue problem fails.
pub fn sector(settings: &TwoBladeSettings, n_sectors: usize) -> Result<SectorModel, ModelError> {
    settings.validate()?;
    let layout = Layout::new(settings)?;
    let contact = layout.contact_cells();
    let mut patches: Vec<Rectangle> = contact.iter().map(|cell| cell.patch).collect();
    patches.extend(layout.other_patches(&contact));
    let (blade, of_blade) = Blade::new(settings, &layout, &patches)?;
    let (strip, of_strip) = Component::strip(settings, &layout, &contact)?;
    let first = blade.component.reduced.n_dofs();
    let placed = PlacedStrip {
        settings,
        contact: &contact,
        strip: &strip,
        first,
        n_dofs: first + strip.reduced.n_dofs(),
    };
    Ok(SectorModel {
        disk: assembled(settings, n_sectors, &blade, &placed),
        blade: of_blade,
        strip: of_strip,
    })
}

fn assembled(
    settings: &TwoBladeSettings,
    n_sectors: usize,
    blade: &Blade,
    strip: &PlacedStrip<'_>,
) -> Disk {
    let (component, n, nodes) = (&blade.component, strip.n_dofs, strip.contact.len());
    let beside = |of_blade: &Mat<f64>, of_strip: &Mat<f64>| {
        let first = strip.first;
        CyclicMatrix::uncoupled(Mat::from_fn(n, n, |i, j| {
            match (i.checked_sub(first), j.checked_sub(first)) {
                (None, None) => of_blade[(i, j)],
                (Some(i), Some(j)) => of_strip[(i, j)],
                _ => 0.0,
            }
        }))
    };
    let strip_damping = Scale(strip_damping_time(settings)) * &strip.strip.reduced.stiffness;
    let pair = |side: usize, node: usize| {
        let platform = component.nodes[side * nodes + node] + side * n;
        let name = format!("{}.contact{node}", ["blade", "next"][side]);
        strip.pair(name, side, node, platform)
    };
    let direction = settings.excitation_direction;
    let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
    let mut cosine_force = vec![0.0; n];
    for (axis, d) in direction.iter().enumerate() {
        cosine_force[component.nodes[2 * nodes] + axis] = d / norm;
    }
    Disk {
        name: "disk of blades with strip dampers".to_owned(),
        n_sectors,
        dof_names: [names_of("blade", component), names_of("strip", strip.strip)].concat(),
        mass: beside(&component.reduced.mass, &strip.strip.reduced.mass),
        damping: beside(
            &modal_damping(blade, settings.blade_damping_ratio),
            &strip_damping,
        ),
        stiffness: beside(&component.reduced.stiffness, &strip.strip.reduced.stiffness),
        retention: Some(strip.retention()),
        blade_stiffness: Some(Mat::from_fn(n, n, |i, j| match i.max(j) < strip.first {
            true => component.reduced.stiffness[(i, j)],
            false => 0.0,
        })),
        contacts: (0..2)
            .flat_map(|side| (0..nodes).map(move |node| (side, node)))
            .map(|(side, node)| pair(side, node))
            .collect(),
        static_force: strip.centrifugal_force(),
        loads: Vec::new(),
        cosine_force,
        sine_force: vec![0.0; n],
        responses: vec![Response {
            name: "blade.airfoil.x".to_owned(),
            row: vec![(component.nodes[2 * nodes + 1], 1.0)],
        }],
    }
}
