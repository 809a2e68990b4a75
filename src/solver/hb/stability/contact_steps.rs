//! The contact law linearised along a periodic motion, step by step.
//!
//! A step of the march has several samples of the motion. At each sample the slider of a pair moves by the law, and its
//! disturbance by the derivative of the law: dw = P dr + Q dw₋, with the disturbance dr of the displacements and dw₋ of the slider
//! one sample before. The samples of a step together give the mean stiffness, and the slider at the end.

use crate::contact::law::{anchored_at_closing, box_slider, circle_step, closing_instant};
use crate::contact::{ContactParameters, FrictionLaw};

/// Samples of the motion per step of the march.
pub(super) const SAMPLES: usize = 16;

/// Most laps from the anchor to the steady cycle of a slider; the box law takes two.
const MOST_LAPS: usize = 200;

/// Change of a slider in one lap, over its largest displacement, below which it counts as periodic.
const PERIODIC: f64 = 1e-12;

/// Displacements t1, t2, n (m) of one pair at one sample.
pub(super) type Displacement = [f64; 3];

type ByDisplacement = [[f64; 3]; 2];
type BySlider = [[f64; 2]; 2];

const FOLLOWS: ByDisplacement = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const STAYS: BySlider = [[1.0, 0.0], [0.0, 1.0]];

/// Derivatives of one pair over one step of the march.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct PairStep {
    /// Mean derivative of the forces by the displacements (N/m). Shape: force × displacement.
    pub(super) stiffness: [[f64; 3]; 3],
    /// Mean derivative of the tractions by the slider at the start of the step (N/m).
    pub(super) memory: BySlider,
    /// Slider at the end by the displacements at the start, by those at the end, and by the slider at the start.
    pub(super) by_start: ByDisplacement,
    pub(super) by_end: ByDisplacement,
    pub(super) kept: BySlider,
}

/// One pair over the whole period.
#[derive(Debug, Clone)]
pub(super) struct PairSteps {
    /// Shape: `[step]`.
    pub(super) steps: Vec<PairStep>,
    /// Whether the slider slips or opens at least once, by direction.
    pub(super) moves: [bool; 2],
}

/// What the law did at one sample.
struct Sample {
    closed: bool,
    moves: [bool; 2],
    /// P.
    by_displacement: ByDisplacement,
    /// Q.
    kept: BySlider,
}

impl PairSteps {
    /// The steps of a pair that moves as `motion` says over one period. Shape: `motion` `[steps · SAMPLES]`.
    pub(super) fn new(
        p: &ContactParameters<f64>,
        law: FrictionLaw,
        motion: &[Displacement],
    ) -> Self {
        let n = motion.len();
        let mut slider = p.anchor;
        let lap = |slider: &mut [f64; 2]| {
            (0..n).for_each(|i| {
                let _ = advance(p, law, slider, &motion[i], &motion[(i + 1) % n]);
            });
        };
        let size = motion
            .iter()
            .flatten()
            .fold(0.0, |m: f64, r| m.max(r.abs()));
        for laps in 1..=MOST_LAPS {
            let before = slider;
            lap(&mut slider);
            let change = (slider[0] - before[0])
                .abs()
                .max((slider[1] - before[1]).abs());
            if laps > 1 && change <= PERIODIC * size {
                break;
            }
        }
        let mut moves = [false; 2];
        let mut steps: Vec<PairStep> = (0..n / SAMPLES)
            .map(|step| {
                let samples = (0..SAMPLES).map(|i| {
                    let at = step * SAMPLES + i;
                    let sample = advance(p, law, &mut slider, &motion[at], &motion[(at + 1) % n]);
                    (0..2).for_each(|d| moves[d] |= sample.moves[d]);
                    sample
                });
                PairStep::of(p, samples)
            })
            .collect();
        for (d, _) in moves.iter().enumerate().filter(|(_, moves)| !**moves) {
            let forget = |step: &mut PairStep| (0..2).for_each(|row| step.memory[row][d] = 0.0);
            steps.iter_mut().for_each(forget);
        }
        Self { steps, moves }
    }

    /// The derivative of the forces by the displacements if that is the same over the whole period and all there is: of a contact
    /// that always sticks, or is always open.
    pub(super) fn constant(&self) -> Option<[[f64; 3]; 3]> {
        let first = self.steps.first()?.stiffness;
        let same = |step: &PairStep| step.stiffness == first && step.memory == BySlider::default();
        self.steps.iter().all(same).then_some(first)
    }
}

impl PairStep {
    /// Whether the slider of a direction is not where it was.
    pub(super) fn moves(&self, d: usize) -> bool {
        self.by_start[d] != [0.0; 3] || self.by_end[d] != [0.0; 3] || self.kept[d] != STAYS[d]
    }

    fn of(p: &ContactParameters<f64>, samples: impl Iterator<Item = Sample>) -> Self {
        let mut step = Self {
            kept: STAYS,
            ..Self::default()
        };
        let weight = 1.0 / SAMPLES as f64;
        for (i, sample) in samples.enumerate() {
            if sample.closed {
                step.stiffness[2][2] += weight;
                step.add_traction(&sample, weight);
            }
            let end = (i + 1) as f64 * weight;
            let (start, last, kept) = (step.by_start, step.by_end, step.kept);
            for (d, row) in sample.kept.iter().enumerate() {
                for (c, direct) in sample.by_displacement[d].iter().enumerate() {
                    step.by_start[d][c] = (1.0 - end) * direct + through(row, &start, c);
                    step.by_end[d][c] = end * direct + through(row, &last, c);
                }
                step.kept[d] = [0, 1].map(|c| through(row, &kept, c));
            }
        }
        // at the end, so that a contact that sticks has its stiffness without rounding
        step.stiffness[2][2] *= p.k_n;
        for (d, k) in p.k_t.into_iter().enumerate() {
            step.stiffness[d] = step.stiffness[d].map(|share| k * share);
            step.memory[d] = step.memory[d].map(|share| k * share);
        }
        step
    }

    /// Adds the share `weight` of dT/k_t = du − dw at a sample.
    fn add_traction(&mut self, sample: &Sample, weight: f64) {
        for (d, row) in sample.kept.iter().enumerate() {
            for (c, follows) in FOLLOWS[d].iter().enumerate() {
                let before = through(row, &self.by_start, c) + through(row, &self.by_end, c);
                let slider = sample.by_displacement[d][c] + before;
                self.stiffness[d][c] += weight * (follows - slider);
            }
            let memory = [0, 1].map(|c| weight * through(row, &self.kept, c));
            (self.memory[d].iter_mut().zip(memory)).for_each(|(m, part)| *m -= part);
        }
    }
}

/// Entry c of the row of a product: Σ row[e] before[e][c].
fn through<const N: usize>(row: &[f64; 2], before: &[[f64; N]; 2], c: usize) -> f64 {
    (row.iter().zip(before))
        .map(|(q, before)| q * before[c])
        .sum()
}

/// Moves the slider (m) from the sample `before` to the sample `now`.
fn advance(
    p: &ContactParameters<f64>,
    law: FrictionLaw,
    slider: &mut [f64; 2],
    before: &Displacement,
    now: &Displacement,
) -> Sample {
    let [gap_before, gap] = [before, now].map(|r| p.n_0 + p.k_n * r[2]);
    let mut sample = Sample {
        closed: gap > 0.0,
        moves: [false; 2],
        by_displacement: [[0.0; 3]; 2],
        kept: STAYS,
    };
    if !sample.closed {
        *slider = [now[0], now[1]];
        sample.follow();
        return sample;
    }
    if gap_before <= 0.0 {
        // the slider was at u₋ + θ (u − u₋) with θ = g₋/(g₋ − g)
        sample.follow();
        let instant = closing_instant(gap_before, gap);
        for d in 0..2 {
            slider[d] = anchored_at_closing(before[d], now[d], instant);
            let way = now[d] - before[d];
            sample.by_displacement[d][2] = -way * p.k_n / (gap - gap_before);
        }
    }
    let limit = p.mu * gap;
    match law {
        FrictionLaw::Box => (0..2).for_each(|d| sample.slip_in(p, d, limit, slider, now)),
        FrictionLaw::Circle => sample.slip_in_plane(p, limit, slider, now),
    }
    sample
}

impl Sample {
    /// The slider goes where the surface goes.
    fn follow(&mut self) {
        self.moves = [true; 2];
        self.by_displacement = FOLLOWS;
        self.kept = BySlider::default();
    }

    /// Box law: T = ± mu N in slip.
    fn slip_in(
        &mut self,
        p: &ContactParameters<f64>,
        d: usize,
        limit: f64,
        slider: &mut [f64; 2],
        now: &Displacement,
    ) {
        let [path, held] = [now[d], slider[d]].map(|x| p.k_t[d] * x);
        let placed = box_slider(limit, path, held);
        if placed == held {
            return;
        }
        let sign = (path - held).signum();
        slider[d] = placed / p.k_t[d];
        self.moves[d] = true;
        self.by_displacement[d] = FOLLOWS[d];
        self.by_displacement[d][2] = -sign * p.mu * p.k_n / p.k_t[d];
        self.kept[d] = [0.0; 2];
    }

    /// Circle law: T = L e in slip, e the direction of the trial traction t; dT = e dL + L/|t| (I − e eᵀ) dt.
    fn slip_in_plane(
        &mut self,
        p: &ContactParameters<f64>,
        limit: f64,
        slider: &mut [f64; 2],
        now: &Displacement,
    ) {
        let flexibility = p.k_t.map(|k| if k > 0.0 { 1.0 / k } else { 0.0 });
        let step = circle_step(p.k_t, flexibility, limit, 0.0, [now[0], now[1]], *slider);
        *slider = step.slider;
        if !step.slips {
            return;
        }
        let [t1, t2] = step.trial;
        let length = (t1 * t1 + t2 * t2).sqrt();
        let e = step.trial.map(|t| t / length);
        let (placed, kept) = (self.by_displacement, self.kept);
        for d in 0..2 {
            let turned = |trial: &dyn Fn(usize) -> f64| -> f64 {
                let across = |c: usize| {
                    if c == d {
                        1.0 - e[d] * e[c]
                    } else {
                        -e[d] * e[c]
                    }
                };
                let sum: f64 = (0..2).map(|c| across(c) * p.k_t[c] * trial(c)).sum();
                step.ratio * sum
            };
            for c in 0..3 {
                let limit_slope = if c == 2 { p.mu * p.k_n * e[d] } else { 0.0 };
                let traction = limit_slope + turned(&|i| FOLLOWS[i][c] - placed[i][c]);
                self.by_displacement[d][c] = FOLLOWS[d][c] - flexibility[d] * traction;
            }
            self.kept[d] = [0, 1].map(|c| -flexibility[d] * turned(&|i| -kept[i][c]));
        }
        self.moves = [true; 2];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const STEPS: usize = 24;
    /// Disturbance; displacements are of the size 1.
    const SMALL: f64 = 1e-7;

    fn pair() -> ContactParameters<f64> {
        ContactParameters {
            k_n: 3.0,
            k_t: [2.0, 1.5],
            mu: 0.4,
            n_0: 0.6,
            anchor: [0.0; 2],
        }
    }

    /// Sticks, slips in one and in both directions, opens and closes.
    fn motion() -> Vec<Displacement> {
        let n = STEPS * SAMPLES;
        let at = |i: usize| {
            let phase = TAU * (i as f64 + 0.3) / n as f64;
            [
                0.8 * (phase + 0.4).sin(),
                0.6 * (2.0 * phase).cos(),
                0.5 * phase.cos() + 0.1 * (3.0 * phase).sin(),
            ]
        };
        (0..n).map(at).collect()
    }

    /// A disturbance of the displacements at the start and at the end of a step, and of the slider at its start.
    struct Disturbance {
        start: [f64; 3],
        end: [f64; 3],
        slider: [f64; 2],
    }

    /// Mean forces over a step and the slider at its end.
    fn marched(
        law: FrictionLaw,
        step: usize,
        slider: [f64; 2],
        by: (f64, &Disturbance),
    ) -> [f64; 5] {
        let (p, motion) = (pair(), motion());
        let (size, disturbance) = by;
        let disturbed = |i: usize, share: f64| -> Displacement {
            let (start, end) = (disturbance.start, disturbance.end);
            [0, 1, 2].map(|c| {
                motion[i % motion.len()][c] + size * ((1.0 - share) * start[c] + share * end[c])
            })
        };
        let mut slider = [0, 1].map(|d| slider[d] + size * disturbance.slider[d]);
        let mut out = [0.0; 5];
        for i in 0..SAMPLES {
            let shares = [i, i + 1].map(|i| i as f64 / SAMPLES as f64);
            let at = step * SAMPLES + i;
            let (before, now) = (disturbed(at, shares[0]), disturbed(at + 1, shares[1]));
            let sample = advance(&p, law, &mut slider, &before, &now);
            let tractions = [0, 1].map(|d| p.k_t[d] * (now[d] - slider[d]));
            let normal = (p.n_0 + p.k_n * now[2]).max(0.0);
            if sample.closed {
                for (sum, force) in out.iter_mut().zip([tractions[0], tractions[1], normal]) {
                    *sum += force / SAMPLES as f64;
                }
            }
        }
        [out[0], out[1], out[2], slider[0], slider[1]]
    }

    /// The derivatives of a step are those of the law: central differences of the march with the slider. A disturbance that is the same
    /// at start and end of the step meets all terms, the instant of closing with them; where nothing closes it may change on the way.
    ///
    /// Seen to fail without the term of the closing instant.
    #[test]
    fn steps_are_the_derivative_of_the_march() {
        for law in [FrictionLaw::Box, FrictionLaw::Circle] {
            let (p, motion) = (pair(), motion());
            let pairs = PairSteps::new(&p, law, &motion);
            let mut slider = [0.0; 2];
            let n = motion.len();
            for i in 0..2 * n {
                let _ = advance(&p, law, &mut slider, &motion[i % n], &motion[(i + 1) % n]);
            }
            let (mut closings, mut worst) = (0, 0.0_f64);
            for (step, derivatives) in pairs.steps.iter().enumerate() {
                let open = |i: usize| p.n_0 + p.k_n * motion[i % n][2] <= 0.0;
                let first = step * SAMPLES;
                let closes = (first..first + SAMPLES).any(|i| open(i) && !open(i + 1));
                closings += usize::from(closes);
                for one in 0..8 {
                    let unit = |place: usize| f64::from(u8::from(place == one));
                    let start = [0, 1, 2].map(unit);
                    let end = match closes {
                        true => start,
                        false => [3, 4, 5].map(unit),
                    };
                    let disturbance = Disturbance {
                        start,
                        end,
                        slider: [6, 7].map(unit),
                    };
                    let [more, less] = [SMALL, -SMALL]
                        .map(|size| marched(law, step, slider, (size, &disturbance)));
                    let expected: Vec<f64> = (0..5)
                        .map(|i| (more[i] - less[i]) / (2.0 * SMALL))
                        .collect();
                    let found = applied(derivatives, &disturbance);
                    // the mean stiffness is that of a disturbance that stays
                    let same = disturbance.start == disturbance.end;
                    let compared = if same { 0..5 } else { 3..5 };
                    for i in compared {
                        worst = worst.max((found[i] - expected[i]).abs());
                    }
                }
                for i in first..first + SAMPLES {
                    let _ = advance(&p, law, &mut slider, &motion[i % n], &motion[(i + 1) % n]);
                }
            }
            println!("{law:?}: {closings} steps with a closing, largest error {worst:.1e}");
            assert!(closings > 0 && worst < 1e-6, "{worst:e}");
        }
    }

    /// What the derivatives of a step make of a disturbance.
    fn applied(step: &PairStep, by: &Disturbance) -> [f64; 5] {
        let mut out = [0.0; 5];
        for (out, row) in out.iter_mut().zip(&step.stiffness) {
            *out = (0..3).map(|c| row[c] * by.start[c]).sum();
        }
        for d in 0..2 {
            out[d] += (0..2)
                .map(|c| step.memory[d][c] * by.slider[c])
                .sum::<f64>();
            let moved =
                |c: usize| step.by_start[d][c] * by.start[c] + step.by_end[d][c] * by.end[c];
            let kept = (0..2).map(|c| step.kept[d][c] * by.slider[c]);
            out[3 + d] = (0..3).map(moved).sum::<f64>() + kept.sum::<f64>();
        }
        out
    }
}
