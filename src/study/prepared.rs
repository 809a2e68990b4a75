//! A study with its model built: what all its samples share.

use super::built::{StudyDisk, StudyModel};
use super::settings::frequency::PeakSetting;
use super::settings::read::Study;
use crate::Error;
use crate::contact::ContactParameters;
use crate::ensemble::backend::LaneDevice;
use crate::ensemble::store::FollowedMode;
use crate::ensemble::{Ensemble, MistunedDisk, Strips};
use crate::hb::equations::problem::stuck_stiffness;
use crate::hb::peak::maxima::PeakChoice;
use crate::hb::peak::search::PeakSettings;
use crate::hb::structure::resonance::{
    Band, Candidate, candidates, natural_frequencies, undamped_frequencies,
};
use crate::hb::{LinearModel, Problem, ProblemError, SliderAnchor};
use crate::linalg::LinalgError;
use crate::model::ReducedModel;
use crate::model::two_blade::ComponentSummary;
use crate::sampling::Input;
use crate::setting::BadSetting;
use crate::units::rad_s_to_hz;
use std::borrow::Cow;

/// Relative change of frequency at which a peak counts as located. A peak reached by two routes, or with two backends, differs by 1e-9
/// or so: 99 % of 2100 random ones by less than 2.8e-10 (`cargo bench --bench peaks -- slow-path`). With and without the inverses of
/// anchors it differs by 2.0e-9 at most, more than 1e-9 in 5 of 6144.
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
    /// Numbers of the modes that maxima are attributed to; empty where the study does not follow all modes.
    mode_numbers: Vec<u32>,
    /// Those of them that are searched in the band.
    pub followed_modes: Vec<FollowedMode>,
}

/// Relative distance of two frequencies of one mode, computed in two ways.
const SAME_MODE: f64 = 1e-6;

/// Modes of what is solved, with their numbers as `inspect` counts them.
struct NumberedModes {
    /// Numbers of all, by their index; 0 where there is none.
    numbers: Vec<u32>,
    /// Those that are searched in the band, ascending.
    in_band: Vec<(u32, Candidate)>,
}

/// Numbers, as `inspect` counts the frequencies `stuck` (rad/s), of the modes with the frequencies `solved` of what is solved: 0 where
/// there is none. Both ascend; each number is given once.
fn mode_numbers(stuck: &[f64], solved: &[f64]) -> Vec<u32> {
    let mut numbers = (1..).zip(stuck).peekable();
    let mut number = |&omega: &f64| {
        let below = |&(_, of): &(u32, &f64)| *of < omega * (1.0 - SAME_MODE);
        while numbers.next_if(below).is_some() {}
        let same = |&(_, of): &(u32, &f64)| *of <= omega * (1.0 + SAME_MODE);
        numbers.next_if(same).map_or(0, |(number, _)| number)
    };
    solved.iter().map(&mut number).collect()
}

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
        linear: &LinearModel,
        solved: &[ContactParameters<f64>],
    ) -> Result<PeakChoice, Error> {
        let number = match self.frequency.peak {
            PeakSetting::Highest => return Ok(PeakChoice::Highest),
            PeakSetting::All => return Ok(PeakChoice::All),
            PeakSetting::Mode(number) => number,
        };
        let found = self.numbered_modes(model, linear, solved)?.in_band;
        let mode = found.iter().find(|(n, _)| *n as usize == number);
        if let Some((_, candidate)) = mode {
            return Ok(PeakChoice::Mode(candidate.mode));
        }
        let unit = self.frequency.unit;
        let mut numbers: Vec<String> = (found.iter())
            .map(|(n, c)| format!("{n} ({:.5} {})", unit.of_rad_s(c.omega), unit.name()))
            .collect();
        if numbers.is_empty() {
            numbers.push("none".to_owned());
        }
        let rule = format!(
            "must be a mode that is excited and has its stuck or its free frequency in the band: {}",
            numbers.join(", ")
        );
        Err(self.bad_setting(&BadSetting::new("frequency.peak", number, rule)))
    }

    /// Numbers of all modes of what is solved, by their index, and the modes in the band with theirs, ascending.
    fn numbered_modes(
        &self,
        model: &StudyModel,
        linear: &LinearModel,
        solved: &[ContactParameters<f64>],
    ) -> Result<NumberedModes, Error> {
        let no_modes = |error: LinalgError| self.no_problem(error);
        let stuck = model.stuck_frequencies().map_err(no_modes)?;
        let springs = stuck_stiffness(solved);
        let own = natural_frequencies(linear, &springs).map_err(no_modes)?;
        let numbers = mode_numbers(&stuck, &own);
        let [low, high] = self.frequency.band;
        let found = candidates(linear, &springs, Band { low, high }).map_err(no_modes)?;
        let named = found.into_iter().map(|c| (numbers[c.mode], c));
        let mut named: Vec<_> = named.filter(|(number, _)| *number > 0).collect();
        named.sort_by_key(|(number, _)| *number);
        Ok(NumberedModes {
            numbers,
            in_band: named,
        })
    }

    /// Numbers of the modes that maxima are attributed to, and those in the band, where the study follows all modes. The blades of a
    /// mistuned disk have no modes in common.
    fn followed(
        &self,
        model: &StudyModel,
        linear: &LinearModel,
        solved: &[ContactParameters<f64>],
    ) -> Result<(Vec<u32>, Vec<FollowedMode>), Error> {
        if self.frequency.peak != PeakSetting::All || self.is_mistuned() {
            return Ok((Vec::new(), Vec::new()));
        }
        let found = self.numbered_modes(model, linear, solved)?;
        let mode = |(mode, c): (u32, Candidate)| FollowedMode {
            mode,
            stuck_frequency_hz: rad_s_to_hz(c.omega),
        };
        Ok((found.numbers, found.in_band.into_iter().map(mode).collect()))
    }

    /// What is solved: `model`, one half of it where the mirror gives the other, or a sector for its disk.
    pub(super) fn linear(&self, model: &StudyModel) -> Result<LinearModel, Error> {
        self.check_inputs(&model.reduced)?;
        if let Some(of) = &model.disk {
            let wave = LinearModel::travelling_wave(&of.disk, of.engine_order);
            return wave.map_err(|error| self.no_problem(error));
        }
        let linear = LinearModel::of(&model.reduced, &model.contacts, self.folds());
        linear.map_err(|error| self.no_problem(error))
    }
}

impl Study {
    /// What a user should know of the modes without contact in the band, if any has no damping.
    pub(super) fn without_damping(&self, linear: &LinearModel) -> Option<String> {
        let [low, high] = self.frequency.band;
        let unit = self.frequency.unit;
        let found = undamped_frequencies(linear, Band { low, high });
        let found: Vec<String> = (found.into_iter())
            .map(|omega| format!("{:.5}", unit.of_rad_s(omega)))
            .collect();
        (!found.is_empty()).then(|| {
            format!(
                "the structure without contacts has no damping at its natural frequencies {} {}: where contacts slip or open, nothing bounds the peak",
                found.join(", "),
                unit.name()
            )
        })
    }

    /// Requires a static equilibrium without friction where the sliders start from it: a sample without one could only fail.
    fn check_rest(
        &self,
        linear: &LinearModel,
        contacts: &[ContactParameters<f64>],
    ) -> Result<(), Error> {
        let rest = SliderAnchor::StaticEquilibrium;
        let (key, value) = match self.solver.anchor {
            _ if self.has_input(Input::InitialTraction) => ("inputs.initial_traction", "{ ... }"),
            SliderAnchor::StaticEquilibrium => ("contact.anchor", "\"static-equilibrium\""),
            SliderAnchor::Unloaded => return Ok(()),
        };
        match Problem::new(linear, contacts.to_vec(), 1.0, rest) {
            Err(
                rule @ (ProblemError::NotHeldWithoutFriction | ProblemError::NoStaticEquilibrium),
            ) => Err(self.bad_setting(&BadSetting::new(key, value, rule.to_string()))),
            other => other.map(drop).map_err(|error| self.no_problem(error)),
        }
    }

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
        let disk = MistunedDisk::new(of.disk.clone(), of.engine_order, high);
        disk.map(Some).map_err(|error| self.no_problem(error))
    }
}

impl<'s> PreparedStudy<'s> {
    pub(super) fn of(study: Cow<'s, Study>) -> Result<Self, Error> {
        let model = study.build_model()?;
        let linear = study.linear(&model)?;
        let interface = |&pair: &usize| model.reduced.contacts[pair].interface;
        let contact = |&pair: &usize| model.contacts[pair];
        let contacts: Vec<_> = linear.pairs.iter().map(contact).collect();
        let inputs = study.design.inputs().iter().map(|(input, _)| *input);
        let own_strips = inputs.clone().any(|input| input == Input::StripThickness);
        study.check_rest(&linear, &contacts)?;
        let choice = study.choice(&model, &linear, &contacts)?;
        let (mode_numbers, followed_modes) = study.followed(&model, &linear, &contacts)?;
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
            mode_numbers,
            followed_modes,
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

    /// The nominal model at one unit of excitation.
    ///
    /// # Errors
    /// [`Error::Study`] if it is no harmonic balance problem.
    pub fn nominal_problem(&self) -> Result<Problem<'_>, Error> {
        let anchor = self.study.solver.anchor;
        let problem = Problem::new(&self.linear, self.contacts.clone(), 1.0, anchor);
        problem.map_err(|error| self.study.no_problem(error))
    }

    /// Its samples, predicted peaks improved by `gpu` if there is one.
    #[must_use]
    pub fn ensemble<'a>(&'a self, gpu: Option<&'a LaneDevice>) -> Ensemble<'a> {
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
            mode_numbers: &self.mode_numbers,
            curve_samples: self.study.output.curve_samples,
            gpu,
            solver: self.study.sample_solver,
        }
    }
}
