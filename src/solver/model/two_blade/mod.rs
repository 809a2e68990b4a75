//! Two blades with a strip damper under their platforms: the rig of the published strip-damper studies, on a
//! geometry of our own.
//!
//! Settings → finite element models of one blade and the strip → Craig–Bampton components → one reduced model. The
//! second blade is the mirror image of the first, so it is never meshed. Pressure and shear are integrated over the
//! interface by Gauss' rule: a contact pair stands for the area of one of its points, sees the mean displacements of both
//! faces over a patch around it, and its force is spread evenly over this patch. Source of the rig and of the relations that
//! the default geometry is tuned to: Gastaldi, Berruti & Gola 2018, Exp. Tech., doi 10.1007/s40799-018-0248-z.

mod assembly;
mod blade_modes;
mod components;
mod grid_error;
mod interface_cells;
mod linear;
mod placed_strip;
mod pressure;
mod sector;
mod settings;

pub use blade_modes::{BladeModes, blade_modes};
pub use grid_error::GridError;
pub use interface_cells::{InterfaceCell, interface_cells};
pub use linear::{LinearModes, TrackedMode};
pub use pressure::{PressureField, PressureInputs};
pub use sector::{SectorModel, sector};
pub use settings::{Phase, TwoBladeSettings};

use super::{CraigBampton, ModelError, ReducedModel, ReductionError, SparseRow};
use crate::fe::{FeModel, Rectangle};
use crate::linalg::lowest_modes;
use crate::setting::BadSetting;
use crate::units::rad_s_to_hz;
use components::{ContactCell, Layout};
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
    first_blade: Blade,
    pressure: PressureInputs,
}

/// A component before and after reduction.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentSummary {
    /// Degrees of freedom of the finite element model.
    pub n_fe_dofs: usize,
    /// Masters: three displacements per contact cell, excited and response node.
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
    /// Mass along x, y and z (kg); what moves with a clamped node is not in it.
    pub mass: [f64; 3],
}

/// Blade 1 with its modes in reduced coordinates.
#[derive(Debug, Clone)]
struct Blade {
    component: Component,
    lambda: Vec<f64>,
    shapes: Mat<f64>,
    /// Indices of the first two modes with most of their modal mass in x: airfoil flap and neck bending.
    x_bending: [usize; 2],
    /// Diagonal of the mirror map between the blades: −1 for displacements in x.
    mirror: Vec<f64>,
}

/// A reduced component.
#[derive(Debug, Clone)]
struct Component {
    reduced: CraigBampton,
    /// First master coordinate of every contact cell, then of every further node, in the order asked for.
    nodes: Vec<usize>,
}

/// Builds the rig.
///
/// # Errors
/// [`ModelError`]: a setting breaks a rule, or the mesh or an eigenvalue problem fails.
pub fn build(settings: &TwoBladeSettings) -> Result<TwoBladeModel, ModelError> {
    settings.validate()?;
    let layout = Layout::new(settings)?;
    let contact = layout.contact_cells();
    let patches: Vec<Rectangle> = contact.iter().map(|cell| cell.patch).collect();
    let (first_blade, blade) = Blade::new(settings, &layout, &patches)?;
    let (strip, of_strip) = Component::strip(settings, &layout, &contact)?;
    Ok(TwoBladeModel {
        reduced: assembly::reduced_model(settings, &contact, &first_blade, &strip),
        settings: settings.clone(),
        blade,
        strip: of_strip,
        first_blade,
        pressure: PressureInputs::default(),
    })
}

impl TwoBladeModel {
    /// The rig with [`ReducedModel::loads`] for the inputs of the contact pressure, which a strip of another thickness has too.
    #[must_use]
    pub fn with_pressure(mut self, pressure: PressureInputs) -> Self {
        self.reduced.loads = pressure.loads(self.settings.centrifugal_load_n, &self.reduced);
        self.pressure = pressure;
        self
    }

    /// Mass of both blades and the strip along x, y and z (kg).
    #[must_use]
    pub fn total_mass(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| 2.0 * self.blade.mass[axis] + self.strip.mass[axis])
    }

    /// The inputs of its contact pressure.
    #[must_use]
    pub fn pressure(&self) -> &PressureInputs {
        &self.pressure
    }

    /// The reduced model with a strip of another thickness (mm), loaded as [`TwoBladeSettings::with_strip_thickness`] says.
    ///
    /// Blades, degrees of freedom and contact pairs stay: the strip's mesh moves its lower face only, and it keeps as many
    /// fixed-interface modes as here, where a cut-off would let their number jump. So everything is smooth in the thickness. At
    /// that of the settings it is [`TwoBladeModel::reduced`] to the bit.
    ///
    /// # Errors
    /// [`ModelError`]: the thickness breaks a rule, or the reduction of the strip fails.
    pub fn with_strip(&self, thickness_mm: f64) -> Result<ReducedModel, ModelError> {
        let settings = self.settings.with_strip_thickness(thickness_mm);
        settings.validate()?;
        let layout = Layout::new(&settings)?;
        let contact = layout.contact_cells();
        let fe = layout.strip()?;
        let patches = strip_patches(&contact);
        let strip = Component::new(&settings, &fe, &patches, &[], |masters| {
            Ok(CraigBampton::with_modes(
                &fe.stiffness,
                &fe.mass,
                masters,
                self.strip.n_modes,
            )?)
        })?;
        let mut model = assembly::reduced_model(&settings, &contact, &self.first_blade, &strip);
        model.loads = (self.pressure).loads(settings.centrifugal_load_n, &model);
        Ok(model)
    }
}

/// The refusal of a contact grid with a patch that lies between two lines of a mesh.
fn too_fine(settings: &TwoBladeSettings) -> BadSetting {
    let rule = format!(
        "must be fewer where the strip lies under a platform by only {:.3e} mm: a contact patch is narrower than a \
         millionth of the blade or of the strip, which no mesh resolves",
        settings.strip_overlap_mm()
    );
    BadSetting::new(
        "contact_nodes",
        format!("{:?}", settings.contact_nodes),
        rule,
    )
}

/// Contact patches of the strip: under blade 1, then under blade 2.
fn strip_patches(contact: &[ContactCell]) -> Vec<Rectangle> {
    let patches = contact.iter().map(|cell| cell.patch);
    let mirrored = patches.clone().map(|patch| Rectangle {
        x: [-patch.x[1], -patch.x[0]],
        ..patch
    });
    patches.chain(mirrored).collect()
}

/// A component with the modes below a cut-off (Hz), which the settings give under `key`.
fn below(
    fe: &FeModel,
    masters: &[SparseRow],
    key: &str,
    cut_off: f64,
) -> Result<CraigBampton, ModelError> {
    CraigBampton::new(&fe.stiffness, &fe.mass, masters, cut_off).map_err(|error| match error {
        ReductionError::Linalg(error) => ModelError::from(error),
        ReductionError::TooManyModes { .. } => {
            ModelError::from(BadSetting::new(key, cut_off, error.to_string()))
        }
    })
}

impl Blade {
    /// Blade 1, and what a report says about its making.
    fn new(
        settings: &TwoBladeSettings,
        layout: &Layout,
        patches: &[Rectangle],
    ) -> Result<(Self, ComponentSummary), ModelError> {
        let heights = [settings.excitation_height, settings.response_height];
        let fe = layout.blade(patches, &heights)?;
        let points = heights.map(|height| layout.airfoil_point(height));
        let cut_off = settings.blade_cut_off_hz;
        let reduce = |masters: &[SparseRow]| below(&fe, masters, "blade_cut_off_hz", cut_off);
        let component = Component::new(settings, &fe, patches, &points, reduce)?;
        let reduced = &component.reduced;
        let (lambda, shapes) = reduced.modes()?;
        let summary = ComponentSummary::new(&fe, reduced, &lambda, cut_off, 0.0)?;
        let in_x = |q: usize| q < reduced.n_masters && q.is_multiple_of(3);
        let mirror = (0..reduced.n_dofs()).map(|q| if in_x(q) { -1.0 } else { 1.0 });
        let blade = Self {
            x_bending: first_x_bending_modes(&fe, reduced, &shapes)?,
            mirror: mirror.collect(),
            component,
            lambda,
            shapes,
        };
        Ok((blade, summary))
    }
}

impl Component {
    /// The strip of the settings, reduced below their cut-off.
    fn strip(
        settings: &TwoBladeSettings,
        layout: &Layout,
        contact: &[ContactCell],
    ) -> Result<(Self, ComponentSummary), ModelError> {
        let cut_off = settings.strip_cut_off_hz;
        let fe = layout.strip()?;
        let strip = Self::new(settings, &fe, &strip_patches(contact), &[], |masters| {
            below(&fe, masters, "strip_cut_off_hz", cut_off)
        })?;
        let (lambda, _) = strip.reduced.modes()?;
        let summary = ComponentSummary::new(&fe, &strip.reduced, &lambda, cut_off, STRIP_SHIFT)?;
        Ok((strip, summary))
    }

    /// The component with the mean displacements of `patches` and the displacements of the nodes at `points` as masters,
    /// which `reduce` keeps. The settings are what a patch that the mesh cannot hold is blamed on.
    fn new(
        settings: &TwoBladeSettings,
        fe: &FeModel,
        patches: &[Rectangle],
        points: &[[f64; 3]],
        reduce: impl FnOnce(&[SparseRow]) -> Result<CraigBampton, ModelError>,
    ) -> Result<Self, ModelError> {
        let mut masters: Vec<SparseRow> = Vec::new();
        let mut nodes = Vec::new();
        for patch in patches {
            let means = fe.mean_over(patch);
            nodes.push(masters.len());
            masters.extend(means.ok_or_else(|| too_fine(settings))?);
        }
        for &position in points {
            let Some(dofs) = fe.dofs_at(position) else {
                return Err(ModelError::NoFreeNode { position });
            };
            let of_node = dofs.map(|dof| vec![(dof, 1.0)]);
            // Excitation and response may be the same node.
            let known = masters.iter().position(|master| *master == of_node[0]);
            nodes.push(known.unwrap_or(masters.len()));
            if known.is_none() {
                masters.extend(of_node);
            }
        }
        Ok(Self {
            reduced: reduce(&masters)?,
            nodes,
        })
    }
}

impl ComponentSummary {
    /// `lambda` are the eigenvalues of the reduced component; `shift` is for the modes of the full one ((rad/s)²).
    fn new(
        fe: &FeModel,
        reduced: &CraigBampton,
        lambda: &[f64],
        cut_off: f64,
        shift: f64,
    ) -> Result<Self, ModelError> {
        let full = lowest_modes(&fe.stiffness, &fe.mass, COMPARED_MODES, shift)?;
        let along = |axis: usize| {
            let unit = Mat::from_fn(fe.n_dofs(), 1, |i, _| f64::from(u8::from(i % 3 == axis)));
            (unit.transpose() * (&fe.mass * &unit))[(0, 0)]
        };
        Ok(Self {
            n_fe_dofs: fe.n_dofs(),
            n_masters: reduced.n_masters,
            n_modes: reduced.n_dofs() - reduced.n_masters,
            cut_off,
            first_left_out: reduced.first_left_out,
            reduced_frequencies: frequencies(&lambda[..full.lambda.len().min(lambda.len())]),
            full_frequencies: frequencies(&full.lambda),
            mass: [0, 1, 2].map(along),
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
fn first_x_bending_modes(
    fe: &FeModel,
    blade: &CraigBampton,
    shapes: &Mat<f64>,
) -> Result<[usize; 2], ModelError> {
    let n = COMPARED_MODES.min(shapes.ncols());
    let shapes = &blade.basis * shapes.subcols(0, n);
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
