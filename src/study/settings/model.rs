//! The structure that a study asks for: `[model]`, with `[contact]` and `[pressure_field]`.

use super::document::Document;
use super::frequency::FrequencyUnit;
use super::solver_section::ContactSection;
use crate::Error;
use crate::hb::StabilityScope;
use crate::model::disk::SectorMatrices;
use crate::model::interface::InterfaceSettings;
use crate::model::matrices::MatricesSettings;
use crate::model::two_blade::{Phase, PressureField, TwoBladeSettings};
use crate::sampling::input::MOST_BLADES;
use crate::setting::BadSetting;
use std::path::{Path, PathBuf};

/// Why a pressure cannot be shaped.
pub(super) const NO_POSITIONS: &str =
    "a model of kind \"matrices\" has no positions of its contacts";

/// Which structure is computed.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelSettings {
    /// The built-in two blades with a strip.
    TwoBladeStrip {
        /// Geometry and material.
        blades: TwoBladeSettings,
        /// Constants of both interfaces.
        interface: InterfaceSettings,
        /// Random field of the contact pressure.
        pressure: Option<PressureField>,
    },
    /// The user's own matrices.
    Matrices(MatricesSettings),
    /// One sector of a tuned disk.
    Cyclic(CyclicSettings),
}

impl ModelSettings {
    /// The value of `model.kind` that it was read with.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::TwoBladeStrip { .. } => "two-blade-strip",
            Self::Matrices(_) => "matrices",
            Self::Cyclic(_) => "cyclic",
        }
    }

    /// The built-in blades, if the model has any.
    #[must_use]
    pub fn blades(&self) -> Option<&TwoBladeSettings> {
        match self {
            Self::TwoBladeStrip { blades, .. } => Some(blades),
            Self::Matrices(_) => None,
            Self::Cyclic(settings) => match &settings.sector {
                SectorSettings::BladeStrip { blades, .. } => Some(blades),
                SectorSettings::Matrices(_) => None,
            },
        }
    }

    /// Contact nodes of a grid half again as fine in both directions, on which the nominal peaks of a built-in model are solved too, to see
    /// what its own changes. Absent for the user's own matrices, for so many nodes that it would take minutes, and with pressures that are
    /// given node by node.
    #[must_use]
    pub fn finer_contact_nodes(&self) -> Option<[usize; 2]> {
        let blades = self.blades()?;
        let finer = blades.contact_nodes.map(|n| n + n.div_ceil(2));
        let few = finer[0] * finer[1] <= MOST_FINER_NODES;
        (few && blades.pressure_weights.is_none()).then_some(finer)
    }

    /// The same with another contact grid, if the model is built in.
    #[must_use]
    pub fn with_contact_nodes(&self, contact_nodes: [usize; 2]) -> Self {
        let mut model = self.clone();
        match &mut model {
            Self::TwoBladeStrip { blades, .. }
            | Self::Cyclic(CyclicSettings {
                sector: SectorSettings::BladeStrip { blades, .. },
                ..
            }) => blades.contact_nodes = contact_nodes,
            Self::Matrices(_) | Self::Cyclic(_) => {}
        }
        model
    }

    /// Constants of the built-in interfaces, if the model has any.
    #[must_use]
    pub fn interface(&self) -> Option<&InterfaceSettings> {
        match self {
            Self::TwoBladeStrip { interface, .. } => Some(interface),
            Self::Matrices(_) => None,
            Self::Cyclic(settings) => match &settings.sector {
                SectorSettings::BladeStrip { interface, .. } => Some(interface),
                SectorSettings::Matrices(_) => None,
            },
        }
    }

    /// What may be meant but is unusual in `[contact]` and `[model]`, whose matrices are in SI units with frequencies in Hz.
    #[must_use]
    pub fn unusual(&self, unit: FrequencyUnit) -> Vec<BadSetting> {
        let in_si = unit == FrequencyUnit::Hertz;
        let interface = self.interface().map(InterfaceSettings::unusual);
        let of_contact = interface.unwrap_or_default().into_iter();
        let blades = self.blades().map(TwoBladeSettings::unusual);
        let matrices = self.matrices().map(|matrices| matrices.unusual(in_si));
        let of_model = blades.or(matrices).unwrap_or_default().into_iter();
        let under = |section: &'static str| move |bad: BadSetting| bad.under(section);
        of_contact
            .map(under("contact"))
            .chain(of_model.map(under("model")))
            .collect()
    }

    /// The files that it is made from, relative to the study file's folder.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        if let Self::Cyclic(disk) = self
            && let SectorSettings::Matrices(sector) = &disk.sector
        {
            return sector.files(disk.sectors);
        }
        let files = self.matrices().map_or(Vec::new(), MatricesSettings::files);
        files.into_iter().map(Path::to_owned).collect()
    }

    /// Which solutions are assessed for stability where the file does not say. An assessment of a disk takes long: there only solutions
    /// that would count as bouncing.
    #[must_use]
    pub fn assessed(&self) -> StabilityScope {
        match self {
            Self::Cyclic(_) => StabilityScope::Bouncing,
            Self::TwoBladeStrip { .. } | Self::Matrices(_) => StabilityScope::default(),
        }
    }

    /// The user's own matrices, if the model is made from any.
    #[must_use]
    pub fn matrices(&self) -> Option<&MatricesSettings> {
        match self {
            Self::TwoBladeStrip { .. } => None,
            Self::Matrices(settings) => Some(settings),
            Self::Cyclic(settings) => match &settings.sector {
                SectorSettings::BladeStrip { .. } => None,
                SectorSettings::Matrices(matrices) => Some(&matrices.sector),
            },
        }
    }
}

/// Most contact nodes per interface of a finer grid: with more its peaks take minutes.
const MOST_FINER_NODES: usize = 64;

/// A disk by one of its sectors.
#[derive(Debug, Clone, PartialEq)]
pub struct CyclicSettings {
    /// Number of sectors.
    pub sectors: usize,
    /// Standard deviation of a blade's frequency over the nominal one; 0 for a tuned disk.
    pub blade_frequency_scatter: f64,
    /// What a sector is.
    pub sector: SectorSettings,
}

/// One sector of a disk.
#[derive(Debug, Clone, PartialEq)]
pub enum SectorSettings {
    /// A blade of the built-in rig and the strip between it and the next one.
    BladeStrip {
        /// Geometry and material.
        blades: TwoBladeSettings,
        /// Constants of both interfaces of a strip.
        interface: InterfaceSettings,
    },
    /// The user's own matrices.
    Matrices(SectorMatrices),
}

/// Keys of `[model]` that a tuned disk has beside those of its sector. Every sector does what the one before it did, later by the phase
/// of the engine order that `[operation]` names: harmonic k of engine order r has the nodal diameter k r mod N.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
pub struct CyclicKeys {
    /// Number N of sectors.
    #[schemars(range(min = 2, max = MOST_SECTORS))]
    pub sectors: usize,
    /// Scatter of the blades' frequencies: standard deviation of the frequency of a blade alone over the nominal one, 0.002 for 0.2 %. Every
    /// blade of every sample gets a number of its own from a normal distribution, the input `blade_N_frequency_deviation`, and the whole
    /// disk of at least 3 and at most 128 sectors is solved. Without it, or with 0, the disk is tuned.
    #[serde(default)]
    #[schemars(range(min = 0, max = LARGEST_SCATTER))]
    pub blade_frequency_scatter: Option<f64>,
}

/// Largest scatter of the blades' frequencies: beyond, blades of one disk are hardly meant.
const LARGEST_SCATTER: f64 = 0.1;
/// Fewest sectors of a disk whose blades differ.
const FEWEST_BLADES: usize = 3;

/// Keys of `[model]` that a sector of the user's own matrices has beside those of a model of kind "matrices", but for `mirror`. Contact
/// rows may name a degree of freedom of the next sector as "next:NAME". Matrices that are reduced for each nodal diameter have "{nd}" in
/// the names of their files, such as "mass-{nd}.mtx", for 0 to N/2; they may be complex.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
pub struct BoundaryKeys {
    /// Degrees of freedom on the boundary to the sector before. None where only contacts couple the sectors.
    #[serde(default)]
    pub left: Vec<String>,
    /// Those on the boundary to the next sector, each at the place of its counterpart in `left`. They are the next sector's left ones.
    #[serde(default)]
    pub right: Vec<String>,
    /// Degrees of freedom of the blade, for `blade_frequency_scatter`: those that are free where the blade is held at the disk and vibrates
    /// alone. The stiffness among them is what differs from blade to blade.
    #[serde(default)]
    pub blade: Vec<String>,
}

/// Most sectors of a disk.
pub(super) const MOST_SECTORS: usize = 1000;

/// Reads `[model]` by its `kind`.
pub(super) fn model(
    document: &mut Document<'_>,
    contact: &ContactSection,
) -> Result<ModelSettings, Error> {
    let kind = document.take_string("model", "kind")?;
    if kind != "cyclic" && document.take_below::<f64>("model", SCATTER)?.is_some() {
        let rule = "must be absent: only a disk (kind = \"cyclic\") has blades that differ";
        return Err(document.at_key(&format!("model.{SCATTER}"), rule.to_owned()));
    }
    let of_contact = |bad: BadSetting| bad.under("contact");
    match kind.as_str() {
        "two-blade-strip" => {
            let blades: TwoBladeSettings = document.required("model")?;
            document.checked(blades.validate().map_err(|b| b.under("model")))?;
            let interface = document.checked(contact.interface().map_err(of_contact))?;
            let pressure: Option<PressureField> = document.take("pressure_field")?;
            if let Some(field) = &pressure {
                let nodes = blades.contact_nodes.iter().product();
                let valid = field.validate(nodes);
                let valid = valid.map_err(|b| b.under("pressure_field"));
                document.checked(valid)?;
            }
            Ok(ModelSettings::TwoBladeStrip {
                blades,
                interface,
                pressure,
            })
        }
        "matrices" => {
            if document.take::<PressureField>("pressure_field")?.is_some() {
                let rule = format!("must be absent: {NO_POSITIONS}");
                return Err(document.at_key("pressure_field", rule));
            }
            let settings: MatricesSettings = document.required("model")?;
            document.checked(settings.validate().map_err(|b| b.under("model")))?;
            document.checked(contact.refuse_interface().map_err(of_contact))?;
            Ok(ModelSettings::Matrices(settings))
        }
        "cyclic" => Ok(ModelSettings::Cyclic(cyclic(document, contact)?)),
        _ => {
            let rule = "must be \"two-blade-strip\", \"matrices\" or \"cyclic\"";
            Err(document.bad_setting(&BadSetting::new("model.kind", kind, rule)))
        }
    }
}

/// The scatter of the blades' frequencies.
const SCATTER: &str = "blade_frequency_scatter";

/// Reads it, for a disk of so many sectors.
fn scatter(document: &mut Document<'_>, sectors: usize) -> Result<f64, Error> {
    let given: Option<f64> = document.take_below("model", SCATTER)?;
    let Some(scatter) = given.filter(|scatter| *scatter != 0.0) else {
        return Ok(0.0);
    };
    let rule = format!(
        "must be from 0 to {LARGEST_SCATTER}: the standard deviation of a blade's frequency over the nominal one, 0.002 for 0.2 %"
    );
    let can_be = (0.0..=LARGEST_SCATTER).contains(&scatter);
    let key = format!("model.{SCATTER}");
    document.checked(BadSetting::unless(can_be, &key, scatter, &rule))?;
    let rule = format!(
        "must be from {FEWEST_BLADES} to {MOST_BLADES} where {SCATTER} is given: every blade of the disk is solved"
    );
    let many = (FEWEST_BLADES..=MOST_BLADES).contains(&sectors);
    document.checked(BadSetting::unless(many, "model.sectors", sectors, &rule))?;
    Ok(scatter)
}

/// Reads `[model]` of a sector from matrices, of a disk whose blades scatter by `scatter`.
fn sector_matrices(document: &mut Document<'_>, scatter: f64) -> Result<SectorMatrices, Error> {
    let mut names = |key| document.take_below::<Vec<String>>("model", key);
    let [left, right, blade] = [names("left")?, names("right")?, names("blade")?];
    let settings = SectorMatrices {
        sector: document.required("model")?,
        left: left.unwrap_or_default(),
        right: right.unwrap_or_default(),
        blade: blade.unwrap_or_default(),
    };
    let key = format!("model.{SCATTER}");
    let rule = "must be absent where matrices are reduced for each nodal diameter: they have no blade of their own";
    let has_sectors = scatter == 0.0 || !settings.is_nodal();
    document.checked(BadSetting::unless(has_sectors, &key, scatter, rule))?;
    let rule = format!("must name the degrees of freedom of the blade where {SCATTER} is given");
    let has_blade = scatter == 0.0 || !settings.blade.is_empty();
    document.checked(BadSetting::unless(has_blade, "model.blade", "[]", &rule))?;
    document.checked(settings.validate().map_err(|b| b.under("model")))?;
    Ok(settings)
}

/// Reads `[model]` of a disk by its `sector`.
fn cyclic(document: &mut Document<'_>, contact: &ContactSection) -> Result<CyclicSettings, Error> {
    let sector = document.take_string("model", "sector")?;
    let sectors: Option<usize> = document.take_below("model", "sectors")?;
    let Some(sectors) = sectors else {
        return Err(document.at_key("model.sectors", "must be given".to_owned()));
    };
    let rule = format!("must be from 2 to {MOST_SECTORS}, the sectors of the whole disk");
    let known = (2..=MOST_SECTORS).contains(&sectors);
    document.checked(BadSetting::unless(known, "model.sectors", sectors, &rule))?;
    let blade_frequency_scatter = scatter(document, sectors)?;
    if document.take::<PressureField>("pressure_field")?.is_some() {
        let rule = "must be absent: a model of kind \"cyclic\" has no field of pressure";
        return Err(document.at_key("pressure_field", rule.to_owned()));
    }
    let of_contact = |bad: BadSetting| bad.under("contact");
    let sector = match sector.as_str() {
        "blade-strip" => {
            if document
                .take_below::<Phase>("model", "excitation_phase")?
                .is_some()
            {
                let rule = "must be absent: the engine order gives the phase between neighbours";
                return Err(document.at_key("model.excitation_phase", rule.to_owned()));
            }
            let blades: TwoBladeSettings = document.required("model")?;
            document.checked(blades.validate().map_err(|b| b.under("model")))?;
            let interface = document.checked(contact.interface().map_err(of_contact))?;
            SectorSettings::BladeStrip { blades, interface }
        }
        "matrices" => {
            let settings = sector_matrices(document, blade_frequency_scatter)?;
            document.checked(contact.refuse_interface().map_err(of_contact))?;
            SectorSettings::Matrices(settings)
        }
        _ => {
            let rule = "must be \"blade-strip\" or \"matrices\"";
            return Err(document.bad_setting(&BadSetting::new("model.sector", sector, rule)));
        }
    };
    Ok(CyclicSettings {
        sectors,
        blade_frequency_scatter,
        sector,
    })
}
