//! How fast a command gets on, and when it will be done.
//!
//! The pace is that of the later half of the time so far. So it forgets a slow start, and does not jump with every part.

use std::collections::VecDeque;
use std::time::Duration;

/// Points of time that are remembered at most; then every other one is forgotten.
const MOST_POINTS: usize = 256;

/// Parts done at points of time.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// Seconds since the start, and parts done then; ascending.
    points: VecDeque<(f64, u64)>,
    /// Seconds since the start at which somebody was told last.
    told: f64,
}

/// Seconds after which somebody is told again.
const TELL_EVERY: f64 = 10.0;

impl Pace {
    /// So many parts are done after this time. Threads may come with their numbers in any order.
    pub(super) fn note(&mut self, time: Duration, done: u64) {
        let before = self.points.back().map_or(0, |(_, before)| *before);
        let done = done.max(before);
        self.points.push_back((time.as_secs_f64(), done));
        if self.points.len() > MOST_POINTS {
            let mut keep = false;
            self.points.retain(|_| {
                keep = !keep;
                keep
            });
        }
    }

    /// Whether nobody was told for long.
    pub(super) fn is_due(&self) -> bool {
        let last = self.points.back();
        last.is_some_and(|(now, _)| now - self.told >= TELL_EVERY)
    }

    /// Somebody is told of the last point.
    pub(super) fn told(&mut self) {
        self.told = self.points.back().map_or(0.0, |(now, _)| *now);
    }

    /// Parts per second over the later half of the time; nothing before two different points of time.
    pub(super) fn per_second(&self) -> Option<f64> {
        let &(now, done) = self.points.back()?;
        let half = self.points.partition_point(|(time, _)| *time <= 0.5 * now);
        let &(then, before) = self.points.get(half.saturating_sub(1))?;
        let rate = (done - before) as f64 / (now - then);
        Some(rate).filter(|rate| rate.is_finite() && *rate > 0.0)
    }

    /// Time until `total` parts are done, and the work so far where it is counted, such as
    /// `about 3m 20s left, 1.500 per second, 5210 Newton iterations`.
    pub(super) fn in_words(&self, total: u64, newton_iterations: u64) -> String {
        let (Some(rate), Some((_, done))) = (self.per_second(), self.points.back()) else {
            return String::new();
        };
        let left = total.saturating_sub(*done) as f64 / rate;
        let left = humantime::format_duration(Duration::from_secs(left.round() as u64));
        let work = match newton_iterations {
            0 => String::new(),
            n => format!(", {n} Newton iterations"),
        };
        format!("about {left} left, {rate:.3} per second{work}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(pace: &mut Pace, seconds: f64, done: u64) {
        pace.note(Duration::from_secs_f64(seconds), done);
    }

    /// Samples that were there at the start are no part of the pace. Seen to fail with the mean since the start.
    #[test]
    fn a_slow_start_is_forgotten() {
        let mut pace = Pace::default();
        assert_eq!(pace.in_words(100, 0), "");
        at(&mut pace, 0.0, 50);
        for i in 1..=10 {
            at(&mut pace, f64::from(i), 50 + i as u64);
        }
        let words = "about 40s left, 1.000 per second";
        assert_eq!(pace.in_words(100, 0), words);
        let work = format!("{words}, 70 Newton iterations");
        assert_eq!(pace.in_words(100, 70), work);
        for i in 1..=200 {
            at(&mut pace, 10.0 + 0.1 * f64::from(i), 60 + i as u64);
        }
        let rate = pace.per_second().unwrap();
        assert!((rate - 10.0).abs() < 0.2, "{rate}");
    }

    /// Seen to fail without the bound.
    #[test]
    fn the_memory_is_bounded() {
        let mut pace = Pace::default();
        for i in 0..100_000 {
            at(&mut pace, 0.001 * f64::from(i), i as u64);
        }
        assert!(pace.points.len() <= MOST_POINTS, "{}", pace.points.len());
        let rate = pace.per_second().unwrap();
        assert!((rate / 1000.0 - 1.0).abs() < 0.05, "{rate}");
    }
}
