//! A sample of a mistuned disk: its largest amplitude over all blades, against the tuned disk with the same inputs.

use super::applied::Applied;
use super::atlas::{Atlas, ModePeaks};
use super::mistuned_disk::MistunedDisk;
use super::outcome::{AroundPeak, LevelOutcome, MistunedRecord};
use super::sample::{SampleResult, record};
use super::shared::Ensemble;
use super::times::SampleTimes;
use crate::hb::peak::blades::{LargestBlade, largest_of_blades};
use crate::hb::peak::maxima::Maxima;
use crate::hb::structure::mistuned::{LinearLargest, LinearRing};
use crate::hb::{ProblemError, Solution, Status, WorkCount};
use crate::sampling::Input;
use crate::sampling::design::in_32_bits;
use std::borrow::Cow;
use std::time::Instant;

/// The tuned disk that a sample is compared with.
struct Tuned {
    /// At each level.
    peaks: Vec<Maxima>,
    /// Largest amplitude per unit level (m) with all contacts stuck, of the tuned and of the mistuned disk; NaN where there is none.
    linear: [f64; 2],
}

impl Ensemble<'_> {
    /// Records of the levels of a mistuned disk. Where a sample starts from others it hardly gains: no other disk has the same modes.
    pub(super) fn mistuned(
        &self,
        of: &MistunedDisk,
        inputs: &[f64],
        place: &[f64],
    ) -> SampleResult {
        let begun = Instant::now();
        let solved = self.applied(inputs).and_then(|tuned| {
            let tuned = tuned.without_tractions();
            let levels = self.applied_levels(&tuned);
            let deviations = self.deviations(of, inputs);
            let linear = of.ring.linear(&deviations);
            let linear = linear.map_err(|_| Status::NonFinite)?;
            let contacts = self.contacts.repeat(of.ring.n_sectors());
            let applied = self.applied_to(Cow::Owned(linear), contacts, inputs);
            let problem = applied
                .problem(self.settings.anchor)
                .map_err(|error| error.status())?;
            let tuned = self.tuned(of, &tuned, &levels, inputs, place);
            let tuned = tuned.map_err(|error| error.status())?;
            let found = levels.iter().map(|&level| {
                let found = largest_of_blades(&problem, self.settings, self.peak, level);
                problem.effort.grant(self.settings.newton.budget);
                found
            });
            let found: Vec<LargestBlade> = found.collect();
            let to_peaks = begun.elapsed();
            let assessed = found.into_iter().map(|found| LargestBlade {
                peak: found.peak.with_stability(&problem, self.settings),
                ..found
            });
            let levels: Vec<LevelOutcome> = (assessed.zip(self.levels).enumerate())
                .map(|(i, (found, nominal))| tuned.compared(i, &found, *nominal))
                .collect();
            Ok(SampleResult {
                peaks: vec![ModePeaks::default(); levels.len()],
                times: SampleTimes::until_now(begun, to_peaks, &problem.effort, &levels),
                levels,
            })
        });
        solved.unwrap_or_else(|status| self.without_solution(status))
    }

    /// Relative deviations of the blades' frequencies; 0 of a blade that has none. Shape: `[blades]`.
    fn deviations(&self, of: &MistunedDisk, inputs: &[f64]) -> Vec<f64> {
        let mut deviations = vec![0.0; of.ring.n_sectors()];
        for ((input, _), value) in self.design.inputs().iter().zip(inputs) {
            if let Input::BladeFrequency(blade) = input {
                deviations[usize::from(*blade)] = *value;
            }
        }
        deviations
    }

    /// The tuned disk, and both disks with stuck contacts.
    fn tuned(
        &self,
        of: &MistunedDisk,
        tuned: &Applied<'_>,
        levels: &[f64],
        inputs: &[f64],
        place: &[f64],
    ) -> Result<Tuned, ProblemError> {
        let problem = tuned.problem(self.settings.anchor)?;
        let peaks = self.peaks(&problem, levels, place, &Atlas::default())?;
        let stuck = of.disk.with_stuck_contacts(&tuned.contacts);
        let mut stuck = LinearRing::new(&stuck, of.engine_order, self.peak.band)?;
        for ((input, _), value) in self.design.inputs().iter().zip(inputs) {
            if *input == Input::DampingScale {
                stuck.scale_damping(*value);
            }
        }
        let none = vec![0.0; of.ring.n_sectors()];
        let deviations = self.deviations(of, inputs);
        let [nominal, mistuned] = [none, deviations].map(|of| stuck.largest(&of));
        let amplitude =
            |found: Option<LinearLargest>| found.map_or(f64::NAN, |found| found.amplitude);
        Ok(Tuned {
            peaks,
            linear: [amplitude(nominal?), amplitude(mistuned?)],
        })
    }
}

impl Tuned {
    /// Record of the nominal level `nominal`, which is number `i`.
    fn compared(&self, i: usize, found: &LargestBlade, nominal: f64) -> LevelOutcome {
        let LargestBlade { peak, blade } = found;
        let tuned = &self.peaks[i];
        let mut count: WorkCount = peak.count;
        count += tuned.count;
        let amplitude = |of: &Solution| of.amplitude(*blade);
        let mut around = AroundPeak::default();
        if let Some(solution) = &peak.solution {
            let amplitude = amplitude(solution);
            let [linear, mistuned] = self.linear;
            let ratio = |to: f64| Some(amplitude / to).filter(|ratio| ratio.is_finite());
            let with_friction = tuned.peak().map(|tuned| tuned.amplitude(0));
            around.set_mistuned(MistunedRecord {
                blade: in_32_bits(*blade),
                amplification: with_friction.and_then(ratio).into(),
                over_linear: ratio(solution.level * linear).into(),
                linear_amplification: Some(mistuned / linear).filter(|r| r.is_finite()).into(),
            });
        }
        LevelOutcome {
            level: nominal,
            status: peak.status,
            peak: (peak.solution.as_ref()).map(|solution| record(solution, amplitude(solution))),
            around,
            newton_iterations: in_32_bits(count.iterations),
            factorizations: in_32_bits(count.factorizations),
        }
    }
}
