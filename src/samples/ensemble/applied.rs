//! The nominal model with the inputs of one sample applied.

use super::atlas::AtlasPrediction;
use super::initial_tractions::shares;
use super::shared::Ensemble;
use super::strips::Strips;
use crate::contact::ContactParameters;
use crate::hb::equations::balance::balance_on;
use crate::hb::peak::predicted::PeakPrediction;
use crate::hb::{Balance, LinearModel, Problem, ProblemError, SliderAnchor, Status};
use crate::sampling::Input;
use std::borrow::Cow;

/// What the inputs of a sample change.
#[derive(Debug, Clone)]
pub(super) struct Applied<'m> {
    linear: Cow<'m, LinearModel>,
    pub(super) contacts: Vec<ContactParameters<f64>>,
    load_scale: f64,
    /// Initial tractions over the friction limit, where they are drawn. Shape: `[pairs]`.
    tractions: Option<Vec<[f64; 2]>>,
    /// Factor on the excitation levels.
    pub(super) excitation_scale: f64,
}

impl Ensemble<'_> {
    /// The model at the given input values, in the order of the design; nominal where there are none.
    ///
    /// # Errors
    /// The [`Status`] of a sample whose strip makes no model.
    pub(super) fn applied(&self, inputs: &[f64]) -> Result<Applied<'_>, Status> {
        // the other inputs act on what the thickness makes
        let linear = match self.thickness_mm(inputs) {
            Some((strips, mm)) => Cow::Owned(strips.linear(mm, self.linear)?),
            None => Cow::Borrowed(self.linear),
        };
        Ok(self.applied_to(linear, self.contacts.to_vec(), inputs))
    }

    /// The same of another structure with contacts of its own: those of the nominal one, as often as they fit in.
    pub(super) fn applied_to<'m>(
        &'m self,
        linear: Cow<'m, LinearModel>,
        contacts: Vec<ContactParameters<f64>>,
        inputs: &[f64],
    ) -> Applied<'m> {
        let mut applied = Applied {
            linear,
            contacts,
            load_scale: 1.0,
            tractions: None,
            excitation_scale: 1.0,
        };
        for ((input, _), value) in self.design.inputs().iter().zip(inputs) {
            applied.apply_input(*input, *value, self);
        }
        applied
    }

    /// What `search` finds from `prediction` at input values: it is given their balance equations on the harmonics of the prediction, and
    /// the predicted peak at their own level number `level`. None, too, where they make no problem.
    pub(super) fn search_at<T>(
        &self,
        inputs: &[f64],
        level: usize,
        prediction: AtlasPrediction,
        search: impl FnOnce(&Balance<'_>, PeakPrediction) -> Option<T>,
    ) -> Option<T> {
        let applied = self.applied(inputs).ok()?;
        let problem = applied.problem(self.settings.anchor).ok()?;
        let prediction = prediction.at_level(self.applied_levels(&applied)[level]);
        let balance = balance_on(&problem, prediction.harmonics, self.settings);
        search(&balance, prediction.peak)
    }

    fn thickness_mm(&self, inputs: &[f64]) -> Option<(&Strips, f64)> {
        let mut given = self.design.inputs().iter().zip(inputs);
        let (_, value) = given.find(|((input, _), _)| *input == Input::StripThickness)?;
        let Some(strips) = self.strips else {
            panic!("{} has no strips", Input::StripThickness.name());
        };
        Some((strips, *value))
    }
}

impl Applied<'_> {
    /// The same with contacts that begin as the study says, not with drawn tractions: all sectors of a tuned disk begin alike.
    pub(super) fn without_tractions(self) -> Self {
        Self {
            tractions: None,
            ..self
        }
    }

    /// The harmonic balance problem.
    pub(super) fn problem(&self, anchor: SliderAnchor) -> Result<Problem<'_>, ProblemError> {
        let mut problem =
            Problem::new(&self.linear, self.contacts.clone(), self.load_scale, anchor)?;
        if let Some(shares) = &self.tractions {
            problem.begin_with_tractions(shares)?;
        }
        Ok(problem)
    }

    fn apply_input(&mut self, input: Input, value: f64, ensemble: &Ensemble) {
        let interfaces = ensemble.interfaces;
        match input {
            Input::StaticLoadScale => self.load_scale = value,
            Input::ExcitationScale => self.excitation_scale = value,
            Input::DampingScale => self.linear.to_mut().scale_damping(value),
            Input::EdgePressure | Input::PressureMode(_) => {
                let Some(load) = ensemble.loads.iter().position(|of| *of == input) else {
                    panic!("{} has no load", input.name());
                };
                for part in &mut self.linear.to_mut().parts {
                    let entries = part.static_force.iter_mut().zip(&part.loads[load]);
                    entries.for_each(|(force, f)| *force += value * f);
                }
            }
            Input::InitialTraction => {
                let law = ensemble.settings.aft.law;
                let stiffness = self.contacts.iter().map(|contact| contact.k_t);
                self.tractions = Some(shares(value, stiffness, law));
            }
            Input::StripThickness | Input::BladeFrequency(_) => {}
            _ => {
                // a ring has the pairs of a sector again and again
                let interface = |pair: usize| interfaces[pair % interfaces.len()];
                let of_side = |pair: usize| input.interface().is_none_or(|i| interface(pair) == i);
                for (pair, contact) in self.contacts.iter_mut().enumerate() {
                    if of_side(pair) {
                        apply_to_contact(contact, input, value);
                    }
                }
            }
        }
    }
}

/// Scales the normal stiffness. A negative force at zero approach stands for a gap, a length that stays; a preload is a force that stays.
fn scale_normal_stiffness(contact: &mut ContactParameters<f64>, factor: f64) {
    contact.k_n *= factor;
    if contact.n_0 < 0.0 {
        contact.n_0 *= factor;
    }
}

/// Applies an input of the contacts to one pair.
fn apply_to_contact(contact: &mut ContactParameters<f64>, input: Input, value: f64) {
    match input {
        Input::StiffnessScale | Input::LeftStiffnessScale | Input::RightStiffnessScale => {
            scale_normal_stiffness(contact, value);
            contact.k_t = contact.k_t.map(|k| k * value);
        }
        Input::NormalStiffnessScale => scale_normal_stiffness(contact, value),
        Input::TangentialStiffnessScale => contact.k_t = contact.k_t.map(|k| k * value),
        Input::FrictionCoefficient
        | Input::LeftFrictionCoefficient
        | Input::RightFrictionCoefficient => contact.mu = value,
        Input::StaticLoadScale
        | Input::DampingScale
        | Input::ExcitationScale
        | Input::EdgePressure
        | Input::StripThickness
        | Input::InitialTraction
        | Input::BladeFrequency(_)
        | Input::PressureMode(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stiffer contact closes at the same distance and keeps its preload. Seen to fail where the gap is left as the force at zero
    /// approach: it shrinks by the factor.
    #[test]
    fn a_gap_and_a_preload_stay_when_the_stiffness_is_scaled() {
        for input in [Input::StiffnessScale, Input::NormalStiffnessScale] {
            for n_0 in [-30.0, 20.0] {
                let before = ContactParameters {
                    k_n: 100.0,
                    k_t: [50.0; 2],
                    mu: 0.5,
                    n_0,
                    anchor: [0.0; 2],
                };
                let mut contact = before;
                apply_to_contact(&mut contact, input, 4.0);
                assert_eq!(contact.k_n, 400.0);
                match n_0 < 0.0 {
                    true => assert_eq!(contact.n_0 / contact.k_n, n_0 / before.k_n, "gap"),
                    false => assert_eq!(contact.n_0, n_0, "preload"),
                }
            }
        }
    }
}
