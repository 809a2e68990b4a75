//! The motion of the platform in steps: as it is given, or as a blade's under a force.

use super::blade::Blade;
use super::blade_march::BladeMarch;
use super::excitation::Excitation;

/// State of the platform during the march.
pub(super) struct Platform<'a> {
    excitation: &'a Excitation,
    frequency_hz: f64,
    blade: Option<(BladeMarch<'a>, &'a Blade)>,
    /// Amplitude of a motion that is given; a motion that a force gives at rest (m).
    scale: f64,
}

impl<'a> Platform<'a> {
    /// With steps of the length `h` (s).
    pub(super) fn at_rest(
        excitation: &'a Excitation,
        blade: Option<&'a Blade>,
        frequency_hz: f64,
        h: f64,
    ) -> Self {
        Self {
            excitation,
            frequency_hz,
            blade: blade.map(|blade| (BladeMarch::new(blade, h), blade)),
            scale: blade.map_or_else(|| excitation.amplitude(), Blade::scale),
        }
    }

    /// Its displacement (m) at the next step, at the time `t` (s), without the traction of that step.
    pub(super) fn without_traction(&mut self, t: f64) -> f64 {
        let (excitation, frequency_hz) = (self.excitation, self.frequency_hz);
        match &mut self.blade {
            None => excitation.sine(excitation.amplitude(), frequency_hz, t),
            Some((march, blade)) => {
                march.without_traction(excitation.sine(blade.force, frequency_hz, t))
            }
        }
    }

    /// What a unit traction of the step takes from its displacement (m/N).
    pub(super) fn flexibility(&self) -> f64 {
        (self.blade.as_ref()).map_or(0.0, |(march, _)| march.flexibility)
    }

    /// The traction (N) of the step.
    pub(super) fn add_traction(&mut self, traction: f64) {
        if let Some((march, _)) = &mut self.blade {
            march.add_traction(traction);
        }
    }

    /// A displacement that errors are compared with; of a blade at resonance its own, `now`.
    pub(super) fn scale(&self, now: f64) -> f64 {
        match self.blade {
            None => self.scale,
            Some(_) => self.scale.max(now.abs()),
        }
    }
}
