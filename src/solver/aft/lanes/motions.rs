//! What the samples of a period do, as bits: 64 samples of one state fit into a word, so that a stretch of one motion is
//! found by its first bit that differs.

use super::lane::{LANES, Lane};

/// Samples of a word.
pub(in crate::aft) const WORD: usize = u64::BITS as usize;

/// What a direction does at a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::aft) enum Motion {
    Stick,
    /// T = mu N.
    SlipUp,
    /// T = −mu N.
    SlipDown,
    Separated,
}

impl Motion {
    /// The motion of separated, up and down bits.
    #[inline(always)]
    fn of([separated, up, down]: [bool; 3]) -> Self {
        match (separated, up, down) {
            (true, _, _) => Self::Separated,
            (_, true, _) => Self::SlipUp,
            (_, _, true) => Self::SlipDown,
            _ => Self::Stick,
        }
    }
}

/// Last sample without stick: where the slider was set last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::aft) struct Event {
    pub sample: usize,
    pub motion: Motion,
}

/// [`WORD`] samples; bit i of a lane is sample i. No two of the three motions share a bit, and stick has none.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::aft) struct Word {
    pub separated: Lane<u64>,
    /// Per direction (box law only).
    pub up: [Lane<u64>; 2],
    /// See `up`.
    pub down: [Lane<u64>; 2],
}

impl Word {
    /// Motions from the samples at the upper and at the lower limit: the first that holds of separated, up and down.
    #[inline(always)]
    pub(in crate::aft) fn set_limits(&mut self, upper: [Lane<u64>; 2], lower: [Lane<u64>; 2]) {
        for d in 0..2 {
            for l in 0..LANES {
                self.up[d][l] = upper[d][l] & !self.separated[l];
                self.down[d][l] = lower[d][l] & !(self.separated[l] | upper[d][l]);
            }
        }
    }

    /// Samples of a lane that slip in at least one direction.
    #[inline(always)]
    pub(in crate::aft) fn slips(&self, lane: usize) -> u32 {
        let [first, second] = [0, 1].map(|d| self.up[d][lane] | self.down[d][lane]);
        (first | second).count_ones()
    }

    /// Separated, up and down bits of one lane and direction.
    #[inline(always)]
    fn bits(&self, lane: usize, d: usize) -> [u64; 3] {
        [self.separated[lane], self.up[d][lane], self.down[d][lane]]
    }
}

/// A stretch of samples of one motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::aft) struct Run {
    pub start: usize,
    pub end: usize,
    pub motion: Motion,
}

impl Run {
    /// Where the slider was set last, if it was.
    #[inline(always)]
    pub(in crate::aft) fn event(&self) -> Option<Event> {
        (self.motion != Motion::Stick).then_some(Event {
            sample: self.end - 1,
            motion: self.motion,
        })
    }
}

/// The stretches of one lane and direction over `n` samples, in order.
#[inline(always)]
pub(in crate::aft) fn runs(
    words: &[Word],
    n: usize,
    lane: usize,
    d: usize,
) -> impl Iterator<Item = Run> {
    stretches(n, move |w| words[w].bits(lane, d)).map(|(start, end, bits)| Run {
        start,
        end,
        motion: Motion::of(bits),
    })
}

/// The stretches in contact of one lane over `n` samples, in order, as (start, end).
#[inline(always)]
pub(in crate::aft) fn contacts(
    words: &[Word],
    n: usize,
    lane: usize,
) -> impl Iterator<Item = (usize, usize)> {
    stretches(n, move |w| [words[w].separated[lane]])
        .filter_map(|(start, end, [separated])| (!separated).then_some((start, end)))
}

/// Stretches over which K bits stay as they are: start, end, bits.
#[inline(always)]
fn stretches<const K: usize>(
    n: usize,
    bits: impl Fn(usize) -> [u64; K],
) -> impl Iterator<Item = (usize, usize, [bool; K])> {
    let mut start = 0;
    std::iter::from_fn(move || {
        if start >= n {
            return None;
        }
        let first = start;
        let of_start = bits(first / WORD).map(|b| b >> (first % WORD) & 1);
        let mut rest = u64::MAX << (first % WORD);
        for w in first / WORD..n.div_ceil(WORD) {
            let mut differs = 0;
            for (word, bit) in bits(w).into_iter().zip(of_start) {
                differs |= word ^ bit.wrapping_neg();
            }
            differs &= rest;
            if differs != 0 {
                start = w * WORD + differs.trailing_zeros() as usize;
                // bits past the last sample may differ
                start = start.min(n);
                return Some((first, start, of_start.map(|b| b != 0)));
            }
            rest = u64::MAX;
        }
        start = n;
        Some((first, n, of_start.map(|b| b != 0)))
    })
}

/// Last event of one lane and direction.
#[inline(always)]
pub(in crate::aft) fn last_event(words: &[Word], lane: usize, d: usize) -> Option<Event> {
    words.iter().enumerate().rev().find_map(|(w, word)| {
        let bits = word.bits(lane, d);
        let bit = (bits[0] | bits[1] | bits[2]).checked_ilog2()?;
        Some(Event {
            sample: w * WORD + bit as usize,
            motion: Motion::of(bits.map(|b| b >> bit & 1 == 1)),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stretches and the last event are those of a march sample by sample, over the ends of words and at a last
    /// word that is not full. Seen to fail with: `rest` not reset after the first word.
    #[test]
    fn stretches_are_those_of_single_samples() {
        let (lane, d, n) = (3, 1, 150_usize);
        // seven samples of one motion, and a long stick over the end of the first word
        let motion = |i: usize| match (i / 7 + i / 70 * (i / 70) + 2 * (i / 83))
            * usize::from(!(40..=111).contains(&i))
            % 5
        {
            1 => Motion::SlipUp,
            2 => Motion::Separated,
            3 => Motion::SlipDown,
            _ => Motion::Stick,
        };
        let mut words = vec![Word::default(); n.div_ceil(WORD)];
        for i in 0..n {
            let (word, bit) = (&mut words[i / WORD], 1 << (i % WORD));
            match motion(i) {
                Motion::Stick => {}
                Motion::SlipUp => word.up[d][lane] |= bit,
                Motion::SlipDown => word.down[d][lane] |= bit,
                Motion::Separated => word.separated[lane] |= bit,
            }
        }
        let mut end = 0;
        for run in runs(&words, n, lane, d) {
            assert_eq!(run.start, end, "no gap between stretches");
            assert!(
                (run.start..run.end).all(|i| motion(i) == run.motion),
                "{run:?}"
            );
            assert!(run.end == n || motion(run.end) != run.motion, "{run:?}");
            end = run.end;
        }
        assert_eq!(end, n, "stretches cover the period");
        let touching: Vec<usize> = contacts(&words, n, lane).flat_map(|(a, b)| a..b).collect();
        let expected: Vec<usize> = (0..n).filter(|&i| motion(i) != Motion::Separated).collect();
        assert_eq!(touching, expected, "stretches in contact");
        let last = (0..n).rev().find(|&i| motion(i) != Motion::Stick);
        let event = last_event(&words, lane, d);
        assert_eq!(event.map(|e| e.sample), last, "last event");
        assert_eq!(
            event.map(|e| e.motion),
            last.map(motion),
            "motion of the last event"
        );
        let none = last_event(&words, lane + 1, d);
        assert_eq!(none, None, "a lane that sticks has no event");
    }

    /// At limit zero a sample is at both limits; out of contact it is at neither. Seen to fail with: `down` not
    /// cleared of `upper`.
    #[test]
    fn motions_share_no_bit() {
        let mut word = Word {
            separated: [0b1100; LANES],
            ..Word::default()
        };
        word.set_limits([[0b0110; LANES]; 2], [[0b1111; LANES]; 2]);
        assert_eq!(
            word.bits(0, 0),
            [0b1100, 0b0010, 0b0001],
            "separated, up, down"
        );
        assert_eq!(word.slips(5), 2, "samples that slip");
    }
}
