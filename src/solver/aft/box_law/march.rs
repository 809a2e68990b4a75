//! A lap of the box law around the period, with events decided or interpolated at the samples.

use crate::aft::lanes::lane::{LANES, Lane};
use crate::aft::lanes::motions::WORD;
use crate::aft::lanes::workspace::{LapCount, LapPosition, Workspace, flag, mark, whole};
use crate::contact::Real;
use crate::contact::law::{anchored_at_closing, box_slider, box_step, closing_instant};
use std::ops::Range;

impl<T: Real> Workspace<T> {
    /// One lap of the box law from the sliders `z` = k_t w (N), which end where the lap ends. Unless it is recorded, it
    /// leaves neither tractions nor motions, and of the counts `slip` tells only whether there is any.
    #[inline(always)]
    pub(in crate::aft) fn box_lap<const RECORD: bool>(
        &mut self,
        z: &mut [Lane<T>; 2],
        lap: LapPosition,
    ) -> LapCount<T> {
        let mut slip = [0; LANES];
        let (mut upper, mut lower) = ([[0; LANES]; 2], [[0; LANES]; 2]);
        for w in 0..self.words.len() {
            // samples at the upper and at the lower limit
            let (mut above, mut below) = ([[0; LANES]; 2], [[0; LANES]; 2]);
            let mut closings = self.closings_of(w, lap);
            // The sliders stay in registers over a stretch without closing.
            let mut start = w * WORD;
            let end = (start + WORD).min(self.samples.len());
            loop {
                let stop = (w * WORD + closings.trailing_zeros() as usize).min(end);
                self.box_stretch::<RECORD>(start..stop, z, &mut above, &mut below);
                if stop == end {
                    break;
                }
                self.anchor(stop, z);
                closings &= closings - 1;
                start = stop;
            }
            let word = &mut self.words[w];
            word.set_limits(above, below);
            for l in 0..LANES {
                slip[l] += word.slips(l);
                for d in 0..2 {
                    upper[d][l] |= above[d][l];
                    lower[d][l] |= below[d][l];
                }
            }
        }
        let some = |bits: [Lane<u64>; 2]| bits.map(|b| b.map(|b| flag(b != 0)));
        LapCount {
            slip: slip.map(whole),
            upper: some(upper),
            lower: some(lower),
            ..LapCount::default()
        }
    }

    /// The samples `stretch` of one word, between which no contact closes.
    #[allow(
        clippy::needless_range_loop,
        reason = "a plain loop over lanes becomes vector code"
    )]
    #[inline(always)]
    fn box_stretch<const RECORD: bool>(
        &mut self,
        stretch: Range<usize>,
        z: &mut [Lane<T>; 2],
        above: &mut [Lane<u64>; 2],
        below: &mut [Lane<u64>; 2],
    ) {
        let p = &self.parameters;
        let first = stretch.start % WORD;
        for (i, s) in self.samples[stretch].iter_mut().enumerate() {
            let limit: Lane<T> = std::array::from_fn(|l| p.mu[l] * s.normal(l));
            for d in 0..2 {
                let mut traction = [T::ZERO; LANES];
                for l in 0..LANES {
                    let path = p.k_t[d][l] * s.u[d][l];
                    (traction[l], z[d][l]) = if RECORD {
                        box_step(limit[l], path, z[d][l])
                    } else {
                        // not clipped, which the lap need not know
                        (path - z[d][l], box_slider(limit[l], path, z[d][l]))
                    };
                }
                if RECORD {
                    s.traction[d] = traction;
                    mark(&mut above[d], first + i, |l| traction[l] >= limit[l]);
                    mark(&mut below[d], first + i, |l| traction[l] <= -limit[l]);
                } else {
                    mark(&mut above[d], first + i, |l| traction[l].abs() >= limit[l]);
                }
            }
        }
    }

    /// Sliders `z` (N) of the contacts that close just before the sample.
    #[allow(
        clippy::needless_range_loop,
        reason = "a plain loop over lanes becomes vector code"
    )]
    #[inline(always)]
    fn anchor(&self, sample: usize, z: &mut [Lane<T>; 2]) {
        let (before, s) = (self.before(sample), &self.samples[sample]);
        for l in 0..LANES {
            let instant = closing_instant(before.gap[l], s.gap[l]);
            for d in 0..2 {
                let path = self.parameters.k_t[d][l] * s.u[d][l];
                z[d][l] = anchored_at_closing(z[d][l], path, instant);
            }
        }
    }
}
