//! A study with its model built: what all its samples share.

use super::built::{StudyDisk, StudyModel};
use super::frequency::PeakSetting;
use super::read::Study;
use crate::Error;
use crate::contact::ContactParameters;
use crate::ensemble::{Ensemble, MistunedDisk, Strips};
use crate::gpu::Gpu;
use crate::hb::LinearModel;
use crate::hb::equations::problem::stuck_stiffness;
use crate::hb::peak::maxima::PeakChoice;
use crate::hb::peak::search::PeakSettings;
use crate::hb::structure::resonance::{Band, candidates};
use crate::model::ReducedModel;
use crate::model::two_blade::ComponentSummary;
use crate::sampling::Input;
use crate::setting::BadSetting;
use std::borrow::Cow;

/// Relative change of frequency at which a peak counts as located: a peak reached on two ways, or with two backends,
/// differs by at most 1e-9 (by 3.2e-10 among 2100 random ones, `cargo bench --bench peaks -- slow-path`).
pub(super) const FREQUENCY_TOLERANCE: f64 = 1e-9;

/// A study with its model built.
#[derive(Debug, Clone)]
pub struct PreparedStudy<'s> {
    /// The study.
    pub study: Cow<'s, Study>,
    /// The structure.
    pub reduced: ReducedModel,
    /// The components that it was reduced from, by name; none for the user's own matrices.
    pub components: Vec<(&'static str, ComponentSummary)>,
    /// What is solved: the structure, or one half of it where the mirror gives the other.
    pub linear: LinearModel,
    /// The disk whose sector is solved, if it is one.
    pub disk: Option<StudyDisk>,
    /// Constants of the contact pairs that are solved.
    pub contacts: Vec<ContactParameters<f64>>,
    /// Interface of each of them.
    interfaces: Vec<usize>,
    /// Inputs that are static loads, in the order of the model's.
    loads: Vec<Input>,
    /// What gives a sample its own strip, where the thickness of the strip is an input.
    strips: Option<Strips>,
    /// The disk that samples are, where its blades differ.
    mistuned: Option<MistunedDisk>,
    /// Which of the maxima is the peak.
    choice: PeakChoice,
}

/// Relative distance of two frequencies of one mode, computed in two ways.
const SAME_MODE: f64 = 1e-6;

impl Study {
    /// Builds the model and folds it where the study lets it.
    ///
    /// # Errors
    /// Whatever building the model refuses; [`Error::Study`] on an input of something that the model does not have.
    pub fn prepared(&self) -> Result<PreparedStudy<'_>, Error> {
        PreparedStudy::of(Cow::Borrowed(self))
    }

    /// The same, which keeps the study.
    ///
    /// # Errors
    /// As [`Study::prepared`].
    pub fn into_prepared(self) -> Result<PreparedStudy<'static>, Error> {
        PreparedStudy::of(Cow::Owned(self))
    }

    /// The peak that `frequency.peak` names, in the modes of what is solved.
    fn choice(
        &self,
        model: &StudyModel,
        (linear, solved): (&LinearModel, &[ContactParameters<f64>]),
    ) -> Result<PeakChoice, Error> {
        let number = match self.frequency.peak {
            PeakSetting::Highest => return Ok(PeakChoice::Highest),
            PeakSetting::All => return Ok(PeakChoice::All),
            PeakSetting::Mode(number) => number,
        };
        let no_modes = |error: crate::linalg::LinalgError| Error::Problem(error.into());
        let stuck = model.frequencies(true).map_err(no_modes)?;
        let [low, high] = self.frequency.band;
        let found = candidates(linear, &stuck_stiffness(solved), Band { low, high });
        let found = found.map_err(no_modes)?;
        let same = |a: f64, b: f64| (a / b - 1.0).abs() <= SAME_MODE;
        let named = stuck.get(number - 1);
        let mode = named.and_then(|omega| found.iter().find(|c| same(c.omega, *omega)));
        if let Some(candidate) = mode {
            return Ok(PeakChoice::Mode(candidate.mode));
        }
        let mut numbers: Vec<String> = (stuck.iter().zip(1..))
            .filter(|(omega, _)| found.iter().any(|c| same(c.omega, **omega)))
            .map(|(omega, n): (_, usize)| {
                let unit = self.frequency.unit;
                format!("{n} ({:.5} {})", unit.of_rad_s(*omega), unit.name())
            })
            .collect();
        if numbers.is_empty() {
            numbers.push("none".to_owned());
        }
        Err(self.bad_setting(&BadSetting {
            key: "frequency.peak".to_owned(),
            value: number.to_string(),
            rule: format!(
                "must be a mode that is excited and has its stuck or its free frequency in the band: {}",
                numbers.join(", ")
            ),
        }))
    }

    /// What is solved: `model`, one half of it where the mirror gives the other, or a sector for its disk.
    pub(super) fn linear(&self, model: &StudyModel) -> Result<LinearModel, Error> {
        self.check_inputs(&model.reduced)?;
        if let Some(of) = &model.disk {
            return Ok(LinearModel::travelling_wave(&of.disk, of.engine_order)?);
        }
        Ok(LinearModel::of(
            &model.reduced,
            &model.contacts,
            self.folds(),
        )?)
    }
}

impl Study {
    /// Whether the blades of its disk differ.
    pub(super) fn is_mistuned(&self) -> bool {
        let differ = |(input, _): &(Input, _)| matches!(input, Input::BladeFrequency(_));
        self.design.inputs().iter().any(differ)
    }

    /// The whole disk, if its blades differ.
    fn mistuned(&self, of: &StudyDisk) -> Result<Option<MistunedDisk>, Error> {
        if !self.is_mistuned() {
            return Ok(None);
        }
        let [_, high] = self.frequency.band;
        Ok(Some(MistunedDisk::new(
            of.disk.clone(),
            of.engine_order,
            high,
        )?))
    }
}

impl<'s> PreparedStudy<'s> {
    fn of(study: Cow<'s, Study>) -> Result<Self, Error> {
        let model = study.build_model()?;
        let linear = study.linear(&model)?;
        let interface = |&pair: &usize| model.reduced.contacts[pair].interface;
        let contact = |&pair: &usize| model.contacts[pair];
        let contacts: Vec<_> = linear.pairs.iter().map(contact).collect();
        let inputs = study.design.inputs().iter().map(|(input, _)| *input);
        let own_strips = inputs.clone().any(|input| input == Input::StripThickness);
        let choice = study.choice(&model, (&linear, &contacts))?;
        let mistuned = match &model.disk {
            Some(of) => study.mistuned(of)?,
            None => None,
        };
        Ok(Self {
            components: model.components(),
            interfaces: linear.pairs.iter().map(interface).collect(),
            loads: inputs.filter(|input| input.is_load()).collect(),
            strips: model.rig.filter(|_| own_strips).map(|rig| Strips {
                rig,
                contacts: model.contacts.clone(),
                mirror: study.folds(),
            }),
            mistuned,
            choice,
            disk: model.disk,
            contacts,
            linear,
            reduced: model.reduced,
            study,
        })
    }
}

impl PreparedStudy<'_> {
    /// Whether the contacts of one side stand for both.
    #[must_use]
    pub fn folded(&self) -> bool {
        self.linear.n_contacts() < self.reduced.n_contacts()
    }

    /// Where peaks are searched.
    #[must_use]
    pub fn band(&self) -> Band {
        let [low, high] = self.study.frequency.band;
        Band { low, high }
    }

    /// Its samples, contact forces drafted by `gpu` if there is one.
    #[must_use]
    pub fn ensemble<'a>(&'a self, gpu: Option<&'a Gpu>) -> Ensemble<'a> {
        Ensemble {
            linear: &self.linear,
            strips: self.strips.as_ref(),
            mistuned: self.mistuned.as_ref(),
            contacts: &self.contacts,
            interfaces: &self.interfaces,
            loads: &self.loads,
            design: &self.study.design,
            levels: &self.study.levels,
            settings: &self.study.solver,
            peak: PeakSettings {
                band: self.band(),
                frequency_tolerance: FREQUENCY_TOLERANCE,
            },
            choice: self.choice,
            curve_samples: self.study.output.curve_samples,
            gpu,
            solver: self.study.sample_solver,
        }
    }
}
