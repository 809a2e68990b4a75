//! Two blades with a strip damper under their platforms: the rig of the published strip-damper studies, on a
//! geometry of our own.
//!
//! Settings → finite element models of one blade and the strip → Craig–Bampton components → one reduced model. The
//! second blade is the mirror image of the first, so it is never meshed. Source of the rig and of the relations that
//! the default geometry is tuned to: Gastaldi, Berruti & Gola 2018, Exp. Tech., doi 10.1007/s40799-018-0248-z.

mod assembly;
mod components;
mod linear;
mod pressure;
mod settings;

pub use linear::{LinearModes, TrackedMode};
pub use pressure::{PressureField, PressureModes, edge_load};
pub use settings::{Phase, TwoBladeSettings};

use super::{CraigBampton, ModelError, ReducedModel, ReductionError};
use crate::fe::FeModel;
use crate::linalg::lowest_modes;
use crate::setting::BadSetting;
use crate::units::rad_s_to_hz;
use components::Layout;
use faer::Mat;

/// Full-model modes that are computed for comparison with the reduced ones.
const COMPARED_MODES: usize = 14;
/// Shift for the modes of the free strip ((rad/s)²): well below its first bending mode near 1 kHz.
const STRIP_SHIFT: f64 = 1e6;

/// The reduced rig and what a report says about its making.
#[derive(Debug, Clone)]
pub struct TwoBladeModel {
    /// The model for harmonic balance. Degrees of freedom: blade 1, blade 2, strip.
    pub reduced: ReducedModel,
    /// What it was made from.
    pub settings: TwoBladeSettings,
    /// One blade without strip.
    pub blade: ComponentSummary,
    /// The free strip.
    pub strip: ComponentSummary,
    blade_modes: BladeModes,
}

/// A component before and after reduction.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentSummary {
    /// Degrees of freedom of the finite element model.
    pub n_fe_dofs: usize,
    /// Master degrees of freedom.
    pub n_masters: usize,
    /// Fixed-interface modes kept: those below the cut-off.
    pub n_modes: usize,
    /// Cut-off of the settings (Hz).
    pub cut_off: f64,
    /// First fixed-interface mode left out (Hz); infinite if none was.
    pub first_left_out: f64,
    /// Lowest natural frequencies of the finite element model (Hz).
    pub full_frequencies: Vec<f64>,
    /// The same of the reduced component (Hz).
    pub reduced_frequencies: Vec<f64>,
    /// Mass (kg).
    pub mass: f64,
}

/// Modes of one blade in reduced coordinates, and the first two of the family that bends in x.
#[derive(Debug, Clone)]
struct BladeModes {
    lambda: Vec<f64>,
    shapes: Mat<f64>,
    /// Indices of the first two modes with most of their modal mass in x: airfoil flap and neck bending.
    x_bending: [usize; 2],
    /// Diagonal of the mirror map between the blades: −1 for displacements in x.
    mirror: Vec<f64>,
}

/// A reduced component with its place in the mesh.
struct Component {
    reduced: CraigBampton,
    lambda: Vec<f64>,
    shapes: Mat<f64>,
    summary: ComponentSummary,
    /// First master coordinate of every master node, in the order asked for.
    nodes: Vec<usize>,
}

/// Builds the rig.
///
/// # Errors
/// [`ModelError`]: a setting breaks a rule, or the mesh or an eigenvalue problem fails.
pub fn build(settings: &TwoBladeSettings) -> Result<TwoBladeModel, ModelError> {
    settings.validate()?;
    let layout = Layout::new(settings);
    let heights = [settings.excitation_height, settings.response_height];
    let contact = layout.contact_nodes();
    let z = layout.contact_height();
    let on_blade = contact.iter().map(|c| [c.x, c.y, z]);
    let blade_nodes: Vec<_> = on_blade
        .clone()
        .chain(heights.iter().map(|&h| layout.airfoil_point(h)))
        .collect();
    let strip_nodes: Vec<_> = on_blade
        .chain(contact.iter().map(|c| [-c.x, c.y, z]))
        .collect();
    let blade_fe = layout.blade(&heights)?;
    let blade_cut_off = ("blade_cut_off_hz", settings.blade_cut_off_hz);
    let blade = Component::new(&blade_fe, &blade_nodes, blade_cut_off, 0.0)?;
    let strip_cut_off = ("strip_cut_off_hz", settings.strip_cut_off_hz);
    let strip = Component::new(&layout.strip()?, &strip_nodes, strip_cut_off, STRIP_SHIFT)?;
    let mirror = (0..blade.reduced.n_dofs())
        .map(|q| {
            if q < blade.reduced.n_masters && q % 3 == 0 {
                -1.0
            } else {
                1.0
            }
        })
        .collect();
    let blade_modes = BladeModes {
        x_bending: first_x_bending_modes(&blade_fe, &blade)?,
        lambda: blade.lambda.clone(),
        shapes: blade.shapes.clone(),
        mirror,
    };
    Ok(TwoBladeModel {
        reduced: assembly::reduced_model(settings, &contact, [&blade, &strip], &blade_modes.mirror),
        settings: settings.clone(),
        blade: blade.summary,
        strip: strip.summary,
        blade_modes,
    })
}

impl Component {
    fn new(
        fe: &FeModel,
        master_nodes: &[[f64; 3]],
        (key, cut_off): (&str, f64),
        shift: f64,
    ) -> Result<Self, ModelError> {
        let mut masters: Vec<usize> = Vec::new();
        let mut nodes = Vec::new();
        for &position in master_nodes {
            let Some(dofs) = fe.dofs_at(position) else {
                return Err(ModelError::NoFreeNode { position });
            };
            // Excitation and response may be the same node.
            let known = masters.iter().position(|&dof| dof == dofs[0]);
            nodes.push(known.unwrap_or(masters.len()));
            if known.is_none() {
                masters.extend(dofs);
            }
        }
        let reduced = CraigBampton::new(fe, &masters, cut_off).map_err(|error| match error {
            ReductionError::Linalg(error) => ModelError::from(error),
            ReductionError::TooManyModes { .. } => ModelError::from(BadSetting {
                key: key.to_owned(),
                value: cut_off.to_string(),
                rule: error.to_string(),
            }),
        })?;
        let (lambda, shapes) = reduced.modes()?;
        let full = lowest_modes(&fe.stiffness, &fe.mass, COMPARED_MODES, shift)?;
        let along_z = Mat::from_fn(fe.n_dofs(), 1, |i, _| if i % 3 == 2 { 1.0 } else { 0.0 });
        let summary = ComponentSummary {
            n_fe_dofs: fe.n_dofs(),
            n_masters: masters.len(),
            n_modes: reduced.n_dofs() - masters.len(),
            cut_off,
            first_left_out: reduced.first_left_out,
            reduced_frequencies: frequencies(&lambda[..full.lambda.len().min(lambda.len())]),
            full_frequencies: frequencies(&full.lambda),
            mass: (along_z.transpose() * (&fe.mass * &along_z))[(0, 0)],
        };
        Ok(Self {
            reduced,
            lambda,
            shapes,
            summary,
            nodes,
        })
    }
}

/// √λ/2π in Hz; round-off below zero counts as zero.
fn frequencies(lambda: &[f64]) -> Vec<f64> {
    lambda
        .iter()
        .map(|l| rad_s_to_hz(l.max(0.0).sqrt()))
        .collect()
}

/// The first two blade modes that carry most of their modal mass in x.
fn first_x_bending_modes(fe: &FeModel, blade: &Component) -> Result<[usize; 2], ModelError> {
    let n = COMPARED_MODES.min(blade.lambda.len());
    let shapes = &blade.reduced.basis * blade.shapes.subcols(0, n);
    let momenta = &fe.mass * &shapes;
    let share_in_x = |mode: usize| -> f64 {
        (0..fe.n_dofs())
            .step_by(3)
            .map(|dof| shapes[(dof, mode)] * momenta[(dof, mode)])
            .sum()
    };
    let mut bending = (0..n).filter(|&mode| share_in_x(mode) > 0.5);
    match (bending.next(), bending.next()) {
        (Some(first), Some(second)) => Ok([first, second]),
        _ => Err(ModelError::NoNeckBending { searched: n }),
    }
}
