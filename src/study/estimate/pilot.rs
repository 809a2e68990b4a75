//! A few samples of a study, solved to see what a sample takes; and the nominal one, to see where contacts slip and lift off.
//!
//! The numbers of factorisations behind the estimate of `inspect` are those of the built-in rig. How many harmonics the slip of
//! one's own model takes, and whether its peaks are predicted or searched for, no number tells that is known without a solution.

use crate::Error;
use crate::ensemble::Ensemble;
use crate::ensemble::atlas::Atlas;
use crate::ensemble::outcome::{LevelOutcome, PeakRecord};
use crate::ensemble::runner::{FIRST_ANCHORS, generations};
use crate::harmonics::HarmonicSet;
use crate::hb::{HbSettings, StabilityScope, Status};
use crate::study::settings::read::Study;
use std::time::Instant;

/// Samples of a pilot: the first generation, which starts from nothing near, and the next two.
const SAMPLES: u64 = 10;
/// Processor time after which no other sample of a pilot begins (s).
const LONGEST_S: f64 = 20.0;
/// Time of a sample over the estimate up to which the estimate stands: single samples scatter as much.
const BEYOND: f64 = 2.0;

/// What a pilot has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pilot {
    /// Samples that were solved, without curves.
    pub samples: u64,
    /// Processor time of all of them (s).
    pub processor_time_s: f64,
    /// Mean processor time of one of those that start from others (s); of all where the time is over before, which is an upper bound.
    pub of_later_s: f64,
}

impl Pilot {
    /// Solves the first samples of `study` on this thread; nothing if it has none that starts from others.
    ///
    /// # Errors
    /// Whatever building the model refuses.
    pub(super) fn of(study: &Study) -> Result<Option<Self>, Error> {
        let prepared = study.prepared()?;
        let mut ensemble = prepared.ensemble(None);
        ensemble.curve_samples = 0;
        let clock = ThreadClock::start();
        let (mut atlas, mut samples, mut of_first) = (Atlas::default(), 0, 0.0);
        for generation in generations(SAMPLES.min(study.samples)) {
            let mut anchors = Vec::new();
            for index in generation {
                if clock.seconds() > LONGEST_S {
                    break;
                }
                anchors.push(ensemble.sample(index, &atlas).1);
                samples += 1;
                if samples == FIRST_ANCHORS {
                    of_first = clock.seconds();
                }
            }
            atlas.extend(anchors);
        }
        let processor_time_s = clock.seconds();
        let of_later_s = match samples.saturating_sub(FIRST_ANCHORS) {
            0 => processor_time_s / samples as f64,
            later => (processor_time_s - of_first) / later as f64,
        };
        Ok((study.samples > FIRST_ANCHORS).then_some(Self {
            samples,
            processor_time_s,
            of_later_s,
        }))
    }

    /// By how much an estimate of `seconds` per sample is too low; 1 where it stands.
    pub(super) fn factor(&self, seconds: f64) -> f64 {
        match self.of_later_s / seconds {
            ratio if ratio.is_finite() && ratio > BEYOND => ratio,
            _ => 1.0,
        }
    }
}

/// Levels of a study that cost more than a linear solve, as its nominal peaks on one harmonic tell; one without a peak counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CostlyLevels {
    /// Those at which contacts slip or lift off.
    pub(super) slipping: usize,
    /// Those at which stability is assessed.
    pub(super) assessed: usize,
}

impl CostlyLevels {
    /// # Errors
    /// Whatever building the model refuses.
    pub(super) fn of(study: &Study) -> Result<Self, Error> {
        let all = study.levels.len();
        if study.is_mistuned() && study.solver.stability == StabilityScope::Off {
            return Ok(Self {
                slipping: all,
                assessed: 0,
            });
        }
        let prepared = study.prepared()?;
        let settings = HbSettings {
            harmonics: HarmonicSet::up_to(1),
            alert: None,
            stability: StabilityScope::Off,
            ..study.solver.clone()
        };
        let ensemble = Ensemble {
            settings: &settings,
            ..prepared.ensemble(None)
        };
        let nominal = ensemble.levels(&[], &Atlas::default());
        let count = |is: &dyn Fn(&LevelOutcome) -> bool| nominal.iter().filter(|l| is(l)).count();
        Ok(Self {
            slipping: count(&slips),
            assessed: count(&|level| is_assessed(level, study.solver.stability)),
        })
    }
}

/// Whether contacts slip or lift off at a peak.
fn slips(level: &LevelOutcome) -> bool {
    let moves = |peak: PeakRecord| peak.slip_fraction > 0.0 || peak.separated_fraction > 0.0;
    level.peak.is_none_or(moves)
}

/// Whether the stability of a peak is assessed.
fn is_assessed(level: &LevelOutcome, scope: StabilityScope) -> bool {
    match scope {
        StabilityScope::Off => false,
        StabilityScope::All => true,
        StabilityScope::Bouncing => level.peak.is_none() || level.status == Status::BouncingContact,
        StabilityScope::LiftOff => level.peak.is_none_or(|peak| peak.separated_fraction > 0.0),
    }
}

/// Processor time of this thread; where the system does not tell it, the time of a clock.
struct ThreadClock {
    at_start: Option<f64>,
    clock: Instant,
}

impl ThreadClock {
    fn start() -> Self {
        Self {
            at_start: on_processor(),
            clock: Instant::now(),
        }
    }

    fn seconds(&self) -> f64 {
        let of_clock = self.clock.elapsed().as_secs_f64();
        let both = on_processor().zip(self.at_start);
        both.map_or(of_clock, |(now, before)| now - before)
    }
}

/// Seconds that this thread has been on a processor; Linux alone tells them.
fn on_processor() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * nanoseconds)
}

#[cfg(test)]
mod tests {
    use super::Pilot;

    #[test]
    fn an_estimate_stands_unless_samples_take_much_more() {
        let pilot = Pilot {
            samples: 10,
            processor_time_s: 20.0,
            of_later_s: 2.0,
        };
        assert_eq!(pilot.factor(0.5), 4.0);
        assert_eq!(pilot.factor(1.1), 1.0);
        assert_eq!(pilot.factor(20.0), 1.0);
        assert_eq!(pilot.factor(0.0), 1.0, "an estimate of nothing");
    }
}
