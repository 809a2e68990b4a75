//! The nominal model of a study, built.

use super::settings::model::{CyclicSettings, ModelSettings, SectorSettings};
use super::settings::read::Study;
use crate::Error;
use crate::contact::ContactParameters;
use crate::linalg::LinalgError;
use crate::model::disk::Disk;
use crate::model::matrices::MatricesError;
use crate::model::two_blade::{self, ComponentSummary, PressureInputs, TwoBladeModel};
use crate::model::{ModelError, ReducedModel};
use crate::sampling::Input;

/// The nominal model of a study.
#[derive(Debug, Clone)]
pub struct StudyModel {
    /// The structure.
    pub reduced: ReducedModel,
    /// Constants of its contact pairs. Shape: `[n_contacts]`.
    pub contacts: Vec<ContactParameters<f64>>,
    /// The built-in rig that it is of; none for the user's own matrices.
    pub rig: Option<TwoBladeModel>,
    /// The disk whose sector it is; [`StudyModel::reduced`] is then the sector where all sectors do the same at the same time.
    pub disk: Option<StudyDisk>,
}

/// A disk and what excites it.
#[derive(Debug, Clone)]
pub struct StudyDisk {
    /// The disk by one of its sectors.
    pub disk: Disk,
    /// The engine order, at least 1.
    pub engine_order: usize,
    /// The components of the sector; none for the user's own matrices.
    components: Vec<(&'static str, ComponentSummary)>,
}

impl StudyDisk {
    /// The wave of the first harmonic.
    #[must_use]
    pub fn wave(&self) -> usize {
        self.disk.wave_of(self.engine_order, 1)
    }

    /// Its nodal diameter.
    #[must_use]
    pub fn nodal_diameter(&self) -> usize {
        self.disk.nodal_diameter(self.wave())
    }
}

impl StudyModel {
    /// The components that it was reduced from, by name; none for the user's own matrices.
    #[must_use]
    pub fn components(&self) -> Vec<(&'static str, ComponentSummary)> {
        let rig = self.rig.iter();
        let of_rig =
            rig.flat_map(|rig| [("blade", rig.blade.clone()), ("strip", rig.strip.clone())]);
        let of_sector = self.disk.iter().flat_map(|disk| disk.components.clone());
        of_rig.chain(of_sector).collect()
    }

    /// Natural angular frequencies (rad/s) of what the first harmonic excites, ascending, without contact forces.
    ///
    /// # Errors
    /// [`LinalgError`] if the matrices are not what the model promises.
    pub fn free_frequencies(&self) -> Result<Vec<f64>, LinalgError> {
        match &self.disk {
            Some(of) => of.disk.frequencies(of.wave(), None),
            None => self.reduced.free_frequencies(),
        }
    }

    /// The same with all contacts stuck.
    ///
    /// # Errors
    /// [`LinalgError`] if the matrices are not what the model promises.
    pub fn stuck_frequencies(&self) -> Result<Vec<f64>, LinalgError> {
        match &self.disk {
            Some(of) => of.disk.frequencies(of.wave(), Some(&self.contacts)),
            None => self.reduced.stuck_frequencies(&self.contacts),
        }
    }
}

impl Study {
    /// Builds the nominal model and the nominal constants of its contact pairs.
    ///
    /// # Errors
    /// [`Error::Study`] or [`Error::File`] on the first rule that the model's tables or files break.
    pub fn build_model(&self) -> Result<StudyModel, Error> {
        self.one_engine_order()?;
        match &self.model {
            ModelSettings::TwoBladeStrip {
                blades,
                interface,
                pressure,
            } => {
                let rig = two_blade::build(blades).map_err(|error| self.bad_model(error))?;
                let edge = self.has_input(Input::EdgePressure);
                let inputs = PressureInputs::new(blades, edge, pressure.as_ref());
                let rig = rig.with_pressure(inputs.map_err(ModelError::from)?);
                let mut reduced = rig.reduced.clone();
                reduced.name.clone_from(&self.name);
                Ok(StudyModel {
                    contacts: interface.parameters(&reduced.contacts),
                    reduced,
                    rig: Some(rig),
                    disk: None,
                })
            }
            ModelSettings::Matrices(settings) => {
                let built = settings.build(&self.name, self.folder());
                let (reduced, contacts) = built.map_err(|error| self.bad_matrices(error))?;
                Ok(StudyModel {
                    reduced,
                    contacts,
                    rig: None,
                    disk: None,
                })
            }
            ModelSettings::Cyclic(settings) => self.build_disk(settings),
        }
    }

    fn bad_model(&self, error: ModelError) -> Error {
        match error {
            ModelError::Setting(bad) => self.bad_setting(&bad.under("model")),
            error => Error::Model(error),
        }
    }

    fn bad_matrices(&self, error: MatricesError) -> Error {
        match error {
            MatricesError::Setting(bad) => self.bad_setting(&bad.under("model")),
            MatricesError::File(error) => self.bad_file(error),
        }
    }

    fn build_disk(&self, settings: &CyclicSettings) -> Result<StudyModel, Error> {
        let n = settings.sectors;
        let (mut disk, contacts, components) = match &settings.sector {
            SectorSettings::BladeStrip { blades, interface } => {
                let built = two_blade::sector(blades, n);
                let built = built.map_err(|error| self.bad_model(error))?;
                let contacts = interface.parameters(&built.disk.contacts);
                let components = vec![("blade", built.blade), ("strip", built.strip)];
                (built.disk, contacts, components)
            }
            SectorSettings::Matrices(matrices) => {
                let built = matrices.build(&self.name, self.folder(), n);
                let (disk, contacts) = built.map_err(|error| self.bad_matrices(error))?;
                (disk, contacts, Vec::new())
            }
        };
        disk.name.clone_from(&self.name);
        let operation = self.requirements.operation.as_ref();
        let engine_order = operation.and_then(|operation| operation.engine_orders.first());
        Ok(StudyModel {
            reduced: disk.standing(0),
            contacts,
            rig: None,
            disk: Some(StudyDisk {
                disk,
                engine_order: engine_order.map_or(1, |&order| order as usize),
                components,
            }),
        })
    }
}
