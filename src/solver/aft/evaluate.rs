//! Evaluation of a batch on the processor.

use super::batch::{AftBatch, Want};
use super::forces::{AftForces, Periodicity, StateCounts, StateSummary, Tangent, TangentBlock};
use super::plan::AftPlan;
use super::settings::Laps;
use super::vector::size;
use crate::aft::box_law::located::LocatedBox;
use crate::aft::box_law::play::LaneState;
use crate::aft::box_law::tangent::{SegmentScratch, box_tangent};
use crate::aft::circle_law::located::LocatedCircle;
use crate::aft::circle_law::march::{Cycle, march_circle};
use crate::aft::circle_law::steady_cycle::Origin;
use crate::aft::circle_law::tangent::{CircleScratch, circle_tangent};
use crate::aft::lanes::lane::LANES;
use crate::aft::lanes::masks::{MaskScratch, View};
use crate::aft::lanes::motions::Event;
use crate::aft::lanes::workspace::{LapPosition, Workspace};
use crate::contact::{Events, FrictionLaw, Real};
use pulp::{Simd, WithSimd};

/// Buffers of an evaluation; a later one may use them again.
#[derive(Debug, Clone, Default)]
pub struct AftScratch<T> {
    work: Workspace<T>,
    segments: SegmentScratch<T>,
    masks: MaskScratch<T>,
    circle: CircleScratch<T>,
    located: LocatedBox<T>,
    located_circle: LocatedCircle<T>,
}

/// Last events of both directions before the last lap, per lane.
type LastEvents = [[Option<Event>; 2]; LANES];

/// Contact forces, and tangents if wanted, of every state of the batch.
///
/// The result of a state does not depend on the others, bit for bit. Neither does it depend on the processor's
/// instruction set, which is found at run time: every operation rounds once and correctly, fused multiply-adds too
/// (without an instruction for them they are slow). Buffers of `scratch` and `out` are reused.
pub fn evaluate<T: AftReal>(
    plan: &AftPlan<T>,
    batch: &AftBatch<T>,
    want: Want,
    scratch: &mut AftScratch<T>,
    out: &mut AftForces<T>,
) {
    T::run(Evaluation {
        plan,
        batch,
        want,
        scratch,
        out,
    });
}

/// A number that [`evaluate`] takes. What evaluates `f64` is compiled once, with the solver; that of other types where it is called.
pub trait AftReal: Real {
    #[doc(hidden)]
    #[inline]
    fn run(evaluation: Evaluation<'_, Self>) {
        evaluation.run();
    }
}

impl AftReal for f32 {}

impl AftReal for f64 {
    // the same, but a function without type parameters: a crate that calls it does not compile it again
    fn run(evaluation: Evaluation<'_, Self>) {
        evaluation.run();
    }
}

/// The arguments of [`evaluate`].
#[derive(Debug)]
pub struct Evaluation<'a, T> {
    plan: &'a AftPlan<T>,
    batch: &'a AftBatch<T>,
    want: Want,
    scratch: &'a mut AftScratch<T>,
    out: &'a mut AftForces<T>,
}

impl<T: Real> Evaluation<'_, T> {
    /// Calls the function for the law, the way to resolve events, and the instruction set that is found at run time.
    fn run(self) {
        self.out.reset(self.plan, self.batch);
        let (arch, settings) = (self.plan.arch, self.plan.settings());
        match (settings.law, settings.events) {
            (FrictionLaw::Box, Events::Located) => arch.dispatch(Special::<T, false, true>(self)),
            (FrictionLaw::Box, _) => arch.dispatch(Special::<T, false, false>(self)),
            (FrictionLaw::Circle, Events::Located) => arch.dispatch(Special::<T, true, true>(self)),
            (FrictionLaw::Circle, _) => arch.dispatch(Special::<T, true, false>(self)),
        }
    }
}

/// An evaluation for one law and one way to resolve events: the compiler keeps the sliders of a small function in registers, but not
/// those of one that can do everything.
struct Special<'a, T, const CIRCLE: bool, const LOCATED: bool>(Evaluation<'a, T>);

impl<T: Real, const CIRCLE: bool, const LOCATED: bool> WithSimd
    for Special<'_, T, CIRCLE, LOCATED>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(Evaluation {
            plan,
            batch,
            want,
            scratch,
            out,
        }) = self;
        let law = if CIRCLE {
            FrictionLaw::Circle
        } else {
            FrictionLaw::Box
        };
        for first in (0..batch.n_states).step_by(LANES) {
            scratch.work.load(simd, plan, batch, first);
            if LOCATED {
                locate::<S, T, CIRCLE>(simd, plan, batch, first, want, scratch, out);
                continue;
            }
            let (cycle, events) = match law {
                FrictionLaw::Box => march_box(plan, &mut scratch.work, want),
                FrictionLaw::Circle => {
                    let cycle = march_circle(plan, &mut scratch.work);
                    (cycle, LastEvents::default())
                }
            };
            store_forces(simd, plan, &mut scratch.work, first, out);
            for (lane, &events) in events.iter().enumerate().take(batch.n_states - first) {
                out.summaries
                    .push(summary(plan, &scratch.work, &cycle, lane));
                if want == Want::ForcesAndTangents {
                    store_tangent(plan, law, scratch, &cycle, events, lane, out);
                }
            }
        }
    }
}

/// The states of a group from `first` on with located events.
#[inline(always)]
fn locate<S: Simd, T: Real, const CIRCLE: bool>(
    simd: S,
    plan: &AftPlan<T>,
    batch: &AftBatch<T>,
    first: usize,
    want: Want,
    scratch: &mut AftScratch<T>,
    out: &mut AftForces<T>,
) {
    let AftScratch {
        work,
        located,
        located_circle,
        ..
    } = scratch;
    let lanes = 0..LANES.min(batch.n_states - first);
    if CIRCLE {
        located_circle.mark(simd, plan, work);
        for lane in lanes.clone() {
            let place = LaneState::new(plan, batch, work, first, lane);
            located_circle.evaluate(simd, place, want, out);
            located_circle.put_tractions(work, lane);
        }
        store_forces(simd, plan, work, first, out);
        for lane in lanes {
            located_circle.complete(lane, first + lane, out);
        }
    } else {
        located.mark(simd, plan, work);
        for lane in lanes {
            located.evaluate(LaneState::new(plan, batch, work, first, lane), want, out);
        }
    }
}

/// Box law: the period map is a projection, so the second lap is periodic.
#[inline(always)]
fn march_box<T: Real>(
    plan: &AftPlan<T>,
    work: &mut Workspace<T>,
    want: Want,
) -> (Cycle<T>, LastEvents) {
    let laps = match plan.settings().laps {
        Laps::Fixed(n) => n,
        Laps::Periodic => 2,
    };
    let mut events = LastEvents::default();
    let p = &work.parameters;
    let mut z = [0, 1].map(|d| std::array::from_fn(|l| p.k_t[d][l] * p.anchor[d][l]));
    let mut start = z;
    // Forces need nothing of the first lap but its end, unless it is the last.
    let brief = want == Want::Forces && laps > 1;
    let mut count = if brief {
        work.box_lap::<false>(&mut z, LapPosition::First)
    } else {
        work.box_lap::<true>(&mut z, LapPosition::First)
    };
    let stuck: [bool; LANES] =
        std::array::from_fn(|l| count.slip[l] == T::ZERO && work.separated[l] == T::ZERO);
    let all_stuck = stuck.iter().all(|&s| s);
    if all_stuck && brief {
        work.box_lap::<true>(&mut z, LapPosition::First);
    }
    for _ in 1..if all_stuck { 1 } else { laps } {
        if want == Want::ForcesAndTangents {
            update_events(plan, work, &stuck, &mut events);
        }
        start = z;
        count = work.box_lap::<true>(&mut z, LapPosition::Later);
    }
    let mut cycle = Cycle {
        count,
        start,
        laps: stuck.map(|s| {
            if s {
                1
            } else {
                u32::try_from(laps).unwrap_or(u32::MAX)
            }
        }),
        periodicity: [Periodicity::NotPeriodic; LANES],
        origin: [Origin::Anchor; LANES],
        stuck,
    };
    for l in 0..LANES {
        let change = size([0, 1].map(|d| z[d][l] - start[d][l]));
        if change <= work.tolerance[l] {
            cycle.periodicity[l] = box_periodicity(work, &cycle, l);
        }
    }
    (cycle, events)
}

/// A periodic direction forgets its start if it separates or slips both ways.
#[inline(always)]
fn box_periodicity<T: Real>(work: &Workspace<T>, cycle: &Cycle<T>, l: usize) -> Periodicity {
    let forgets = |d: usize| {
        work.parameters.k_t[d][l] == T::ZERO
            || (cycle.count.upper[d][l] > T::ZERO && cycle.count.lower[d][l] > T::ZERO)
    };
    if work.separated[l] > T::ZERO || (forgets(0) && forgets(1)) {
        Periodicity::Unique
    } else {
        Periodicity::DependsOnAnchor
    }
}

/// Notes the last events of the lap just marched, before the next lap overwrites it.
#[inline(always)]
fn update_events<T: Real>(
    plan: &AftPlan<T>,
    work: &Workspace<T>,
    stuck: &[bool; LANES],
    events: &mut LastEvents,
) {
    for lane in (0..LANES).filter(|&l| !stuck[l]) {
        let view = View { plan, work, lane };
        for (d, event) in events[lane].iter_mut().enumerate() {
            *event = view.last_event(d).or(*event);
        }
    }
}

#[inline(always)]
fn store_forces<S: Simd, T: Real>(
    simd: S,
    plan: &AftPlan<T>,
    work: &mut Workspace<T>,
    first: usize,
    out: &mut AftForces<T>,
) {
    let (n, m) = (out.n_states, out.n_coefficients);
    let lanes = LANES.min(n - first);
    work.analyse(simd, plan, |c, j, values| {
        out.forces[(c * m + j) * n + first..][..lanes].copy_from_slice(&values[..lanes]);
    });
}

#[inline(always)]
fn summary<T: Real>(
    plan: &AftPlan<T>,
    work: &Workspace<T>,
    cycle: &Cycle<T>,
    lane: usize,
) -> StateSummary {
    let [slip, separated] =
        [cycle.count.slip, work.separated].map(|numbers| numbers[lane].to_f64() as u32);
    StateSummary {
        counts: StateCounts::new(plan.n_time(), slip, separated),
        laps: cycle.laps[lane],
        periodicity: cycle.periodicity[lane],
    }
}

#[inline(always)]
fn store_tangent<T: Real>(
    plan: &AftPlan<T>,
    law: FrictionLaw,
    scratch: &mut AftScratch<T>,
    cycle: &Cycle<T>,
    events: [Option<Event>; 2],
    lane: usize,
    out: &mut AftForces<T>,
) {
    if cycle.stuck[lane] {
        out.tangents.push(Tangent::Stuck);
        return;
    }
    let offset = out.blocks.len();
    out.tangents.push(Tangent::Blocks(offset));
    out.blocks
        .resize(offset + TangentBlock::COUNT * plan.m * plan.m, T::ZERO);
    let blocks = &mut out.blocks[offset..];
    let view = View {
        plan,
        work: &scratch.work,
        lane,
    };
    match law {
        FrictionLaw::Box => box_tangent(view, events, &mut scratch.segments, blocks),
        FrictionLaw::Circle => {
            circle_tangent(view, cycle, &mut scratch.circle, &mut scratch.masks, blocks)
        }
    }
}
