//! Predicted peaks of many samples, improved by a device before the processor searches them.
//!
//! Only samples that take the inverse of an anchor are given to it ([`super::with_inverse`]). A lane depends on its sample and the
//! atlas alone, not on the lanes beside it.

use super::atlas::{Atlas, AtlasPrediction, Place};
use super::inverses::Lazy;
use super::shared::Ensemble;
use super::with_inverse::MOST_UNKNOWNS;
use crate::hb::Solution;
use crate::hb::equations::balance::{Balance, balance_on};
use crate::hb::equations::free::{FreeBalance, StaticReference};
use crate::hb::equations::inverse::InverseJacobian;
use crate::hb::peak::anchored::AnchorInverse;
use crate::hb::peak::predicted::PeakPrediction;
use crate::lockstep::LaneDevice;
use crate::lockstep::search::LaneSearch;
use crate::lockstep::system::LaneSystem;
use rayon::prelude::*;
use std::sync::Arc;

/// Samples whose lanes go to the device together: 137 lanes per level and inverse, which share tiles of 64.
pub(super) const SAMPLES_OF_BATCH: usize = 2048;
/// Largest relative difference of frequency and amplitude between a peak searched from a lane and the same searched without: ten
/// times what two searches with the tolerance of peaks differ by.
const LIMIT: f64 = 1e-8;

/// A peak of a sample that a lane may search.
struct WantedPeak {
    /// Values of the inputs of the sample, and their place in the unit cube.
    inputs: Vec<f64>,
    place: Vec<f64>,
    level: usize,
    mode: usize,
    prediction: AtlasPrediction,
    inverse: Arc<Lazy<InverseJacobian>>,
}

impl WantedPeak {
    fn at(&self) -> Place<'_> {
        Place {
            inputs: &self.place,
            level: self.level,
            mode: self.mode,
        }
    }
}

impl Ensemble<'_> {
    /// Whether a device can search peaks of this study; else why not.
    pub(super) fn has_lanes(&self) -> Result<(), String> {
        if self.strips.is_some() || self.mistuned.is_some() {
            return Err("every sample has a structure of its own".to_owned());
        }
        let unknowns = 3 * self.contacts.len() * self.settings.harmonics.n_coefficients();
        if unknowns > MOST_UNKNOWNS {
            return Err(format!(
                "a peak has {unknowns} unknowns, and the GPU takes those of up to {MOST_UNKNOWNS}"
            ));
        }
        let free = || {
            let applied = self.applied(&[]).ok()?;
            let problem = applied.problem(self.settings.anchor).ok()?;
            let harmonics = self.settings.harmonics.clone();
            let balance = balance_on(&problem, harmonics, self.settings);
            self.system(&balance, &StaticReference::new(&problem))
        };
        let found = free().map(|_| ());
        found.ok_or_else(|| "its damping couples modes, or harmonic 1 is left out".to_owned())
    }

    /// Lets the device of the run, if there is one, improve the predicted peaks of the samples `indices`.
    pub(super) fn improve_predictions(&self, atlas: &Atlas, indices: &[u64]) {
        let Some(device) = self.gpu.filter(|_| self.takes_inverses(atlas)) else {
            return;
        };
        let wanted: Vec<WantedPeak> = (indices.par_iter())
            .flat_map_iter(|&index| self.wanted(atlas, index))
            .collect();
        let Some(first) = wanted.first() else {
            return;
        };
        // others would need kernels of their own
        let harmonics = first.prediction.harmonics.clone();
        let same = |wanted: &&WantedPeak| wanted.prediction.harmonics == harmonics;
        let wanted: Vec<&WantedPeak> = wanted.iter().filter(same).collect();
        let found = self.lanes_of(atlas, device, &wanted);
        let improved = wanted.into_iter().zip(found.unwrap_or_default());
        for (wanted, start) in improved {
            if let Some(start) = start {
                atlas.inverses().keep_start(wanted.at().key(), start);
            }
        }
    }

    /// The peaks of sample `index`, for each level and each mode of the nearest anchor.
    fn wanted(&self, atlas: &Atlas, index: u64) -> Vec<WantedPeak> {
        let inputs = self.design.sample(index);
        let place = self.design.place(&inputs);
        let mut wanted = Vec::new();
        for level in 0..self.levels.len() {
            for mode in atlas.modes_near(&place, level) {
                let at = Place {
                    inputs: &place,
                    level,
                    mode,
                };
                let Some(prediction) = atlas.predict(&at) else {
                    continue;
                };
                if let Some(inverse) = self.inverse_near(atlas, &at, &prediction) {
                    wanted.push(WantedPeak {
                        inputs: inputs.clone(),
                        place: place.clone(),
                        level,
                        mode,
                        prediction,
                        inverse,
                    });
                }
            }
        }
        wanted
    }

    /// Better predictions of the `wanted` peaks, all on the same harmonics; none where there are no lanes.
    fn lanes_of(
        &self,
        atlas: &Atlas,
        device: &LaneDevice,
        wanted: &[&WantedPeak],
    ) -> Option<Vec<Option<PeakPrediction>>> {
        let reference = self.reference_of(atlas)?;
        let first = wanted.first()?;
        let applied = self.applied(&[]).ok()?;
        let problem = applied.problem(self.settings.anchor).ok()?;
        let balance = balance_on(&problem, first.prediction.harmonics.clone(), self.settings);
        let system = self.system(&balance, reference)?;
        let lanes: Vec<Option<LaneSearch<'_>>> = (wanted.par_iter())
            .map(|wanted| self.lane(wanted, reference, &system))
            .collect();
        let is_lane: Vec<bool> = lanes.iter().map(Option::is_some).collect();
        let lanes = lanes.into_iter().flatten().collect();
        let mut found = device.improved(&system, &balance, lanes).into_iter();
        let one = |is_lane: bool| {
            if is_lane {
                found.next().flatten()
            } else {
                None
            }
        };
        Some(is_lane.into_iter().map(one).collect())
    }

    /// What all lanes share, around the middle of the band.
    fn system(&self, balance: &Balance<'_>, reference: &StaticReference) -> Option<LaneSystem> {
        let middle = 0.5 * (self.peak.band.low + self.peak.band.high);
        LaneSystem::new(&FreeBalance::new(balance, reference)?, middle)
    }

    fn lane<'w>(
        &self,
        wanted: &'w WantedPeak,
        reference: &'w StaticReference,
        system: &LaneSystem,
    ) -> Option<LaneSearch<'w>> {
        let inverse = wanted.inverse.get()?.as_ref()?;
        let anchor = AnchorInverse { reference, inverse };
        let (settings, newton) = (self.peak, self.settings.newton);
        let prediction = wanted.prediction.clone();
        self.search_at(&wanted.inputs, wanted.level, prediction, |balance, peak| {
            LaneSearch::new(system, balance, anchor, peak, settings, newton)
        })
    }

    /// The peak `found` from a lane at `at`, or for a share of the peaks the one that is found `again` without, where both differ.
    pub(super) fn compared(
        &self,
        at: &Place<'_>,
        found: Solution,
        again: impl FnOnce() -> Option<Solution>,
    ) -> Option<Solution> {
        let gpu = self.gpu.map(|device| &device.gpu);
        let Some(gpu) = gpu.filter(|gpu| gpu.compares(at.inputs)) else {
            return Some(found);
        };
        let Some(again) = again() else {
            return Some(found);
        };
        let difference = |a: f64, b: f64| (a / b - 1.0).abs();
        let differences = [
            difference(found.omega, again.omega),
            difference(found.amplitude(0), again.amplitude(0)),
        ];
        let beyond = !differences.iter().all(|d| *d <= LIMIT);
        gpu.compared(differences, beyond);
        Some(if beyond { again } else { found })
    }
}
