//! Where the mean loop of a test sticks and where it slips; the same places then serve every loop of the test.

use super::branch::{Straightened, Window, bend_to_reversal, is_straight, slope, window};
use super::half::{Ends, Half, halves};
use super::knee::{Branch, LEAST_POINTS, REACH, fit};
use super::plateau::{level, plateau};
use super::slip_limits::PressureSpread;
use super::start::steeper;
use crate::identify::cycles::mean_loop::MeanLoop;
use crate::identify::cycles::scatter::Batches;

/// Places of a loop.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) struct LoopShape<'m> {
    /// The half down, and the half up.
    pub(in crate::identify) halves: [Half; 2],
    /// Windows of the stick branches, after the reversal at the greatest displacement and at the least.
    pub(in crate::identify) windows: [Option<Window<'m>>; 2],
    /// First and last place of both plateaus, where the whole contact slips.
    pub(in crate::identify) plateaus: Option<[[usize; 2]; 2]>,
    /// Normal force below which T/N is not taken (N).
    pub(in crate::identify) least_normal: f64,
    /// Offset of T without which T/N has the same size at both ends (N).
    pub(super) offset: f64,
}

/// Normal force over its mean, below which the contact may be open and T/N is not taken.
const LEAST_NORMAL: f64 = 0.02;

/// Places of the mean loop of a contact whose pressure is known as `spread` says.
///
/// # Errors
/// Why it is no loop.
pub(in crate::identify) fn shape<'m>(
    cycle: &MeanLoop,
    batches: Batches<'_>,
    spread: PressureSpread<'m>,
) -> Result<LoopShape<'m>, String> {
    found(cycle, batches, spread, Sought::AsSeen)
}

/// Places of the mean loop of a contact that does not slip as a whole, although T/N seems to say so.
///
/// # Errors
/// Why it is no loop.
pub(in crate::identify) fn shape_without_slip<'m>(
    cycle: &MeanLoop,
    batches: Batches<'_>,
) -> Result<LoopShape<'m>, String> {
    found(cycle, batches, PressureSpread::Unknown, Sought::NoSlip)
}

/// What is sought in a loop.
#[derive(Clone, Copy, PartialEq)]
enum Sought {
    /// Plateaus, and a knee where the branches are not straight.
    AsSeen,
    /// A knee of its branches whether they are straight or not.
    Knee,
    /// Branches alone.
    NoSlip,
}

impl<'m> LoopShape<'m> {
    /// Whether the knee of the branches was sought.
    pub(in crate::identify) fn has_knee(&self) -> bool {
        let mut windows = self.windows.iter().flatten();
        windows.any(|window| window.straightened.is_some())
    }

    /// Places of nearly the same mean loop, whose knee is sought again.
    pub(in crate::identify) fn with_own_knee(
        cycle: &MeanLoop,
        batches: Batches<'_>,
        spread: PressureSpread<'m>,
    ) -> Option<Self> {
        found(cycle, batches, spread, Sought::Knee).ok()
    }
}

/// Places of the mean loop, of what is sought.
fn found<'m>(
    cycle: &MeanLoop,
    batches: Batches<'_>,
    spread: PressureSpread<'m>,
    sought: Sought,
) -> Result<LoopShape<'m>, String> {
    let normal = cycle.normal.iter().sum::<f64>() / cycle.samples() as f64;
    if normal <= 0.0 {
        return Err(format!(
            "has a mean normal force of {normal:.4e} N: compression is positive, and must prevail"
        ));
    }
    let least_normal = LEAST_NORMAL * normal;
    let halves = halves(cycle, least_normal);
    let (cycle, loads, ends) = centred(cycle, &halves, least_normal)?;
    let cycle = &cycle;
    let sides_of = |levels| Side::both(halves, levels, loads, batches);
    let windows = |sides: &[Side<'_>; 2]| sides.each_ref().map(|side| side.window(cycle, None));
    let (sides, first) = (sides_of(ends), windows(&sides_of(ends)));
    let stick = stick(cycle, &sides, &first)?;
    let [a, b] = halves.map(|half| plateau(&half, cycle, stick, least_normal));
    let plateaus = a.zip(b).filter(|_| sought != Sought::NoSlip);
    let plateaus = plateaus.map(|(a, b)| [a, b]);
    let levels = match plateaus {
        Some(places) => [0, 1].map(|side| {
            let half = &halves[side];
            level(half, cycle, places[side], least_normal, ends[side])
        }),
        None => ends,
    };
    let (sides, first) = match levels == ends {
        true => (sides, first),
        false => (sides_of(levels), windows(&sides_of(levels))),
    };
    // a known knee is no guess: a straight branch has it, too
    let given = matches!(spread, PressureSpread::Map(_));
    let bends = || plateaus.is_some() && (given || !are_straight(cycle, &sides, &first));
    let known = |windows: [Option<Window<'m>>; 2]| {
        [0, 1].map(|side| windows[side].map(|window| sides[side].known(cycle, window)))
    };
    let windows = match sought == Sought::Knee || bends() {
        true if given => with_knee(cycle, &sides, stick, spread),
        true => better(known(with_knee(cycle, &sides, stick, spread)), known(first)),
        false => known(first),
    };
    Ok(LoopShape {
        halves,
        windows,
        plateaus,
        least_normal,
        offset: loads.offset,
    })
}

/// Forces that both halves have in common: that below which T/N is not taken, and the offset that was taken out of T.
#[derive(Clone, Copy)]
struct Loads {
    least_normal: f64,
    offset: f64,
}

/// The loop without the offset of T, and T/N at the end of the half down and of the half up. Where the normal force varies T/N is flat on a
/// plateau only without this offset, which the mean of T over the cycle is not.
fn centred(
    cycle: &MeanLoop,
    halves: &[Half; 2],
    least_normal: f64,
) -> Result<(MeanLoop, Loads, [f64; 2]), String> {
    let open = || "has no normal force before its reversals: the contact is open there".to_owned();
    let offset = Ends::of(halves, cycle, least_normal)
        .ok_or_else(open)?
        .offset;
    let mut without = cycle.clone();
    without.tangential.iter_mut().for_each(|t| *t -= offset);
    let ends = halves
        .each_ref()
        .map(|half| half.end_ratio(&without, least_normal));
    let [Some(down), Some(up)] = ends else {
        return Err(open());
    };
    if down + up <= 0.0 {
        return Err("has a tangential force against the displacement: one of them needs the other sign, or this is no hysteresis loop".to_owned());
    }
    let loads = Loads {
        least_normal,
        offset,
    };
    Ok((without, loads, [down, up]))
}

/// Half a cycle with T/N at its ends.
struct Side<'a> {
    half: Half,
    /// T/N at the reversal before, against the motion, and at the end, along it.
    levels: [f64; 2],
    loads: Loads,
    batches: Batches<'a>,
}

impl<'a> Side<'a> {
    /// Both, with T/N at the end of the half down and of the half up.
    fn both(
        halves: [Half; 2],
        [down, up]: [f64; 2],
        loads: Loads,
        batches: Batches<'a>,
    ) -> [Self; 2] {
        [0, 1].map(|side| Self {
            half: halves[side],
            levels: [[up, down], [down, up]][side],
            loads,
            batches,
        })
    }

    /// Share of the swing of the force at each place; none where the normal force is too small. A part of the contact that sticks keeps its
    /// force where the normal force changes: T/N would bend a straight branch.
    fn shares(&self, cycle: &MeanLoop) -> Vec<Option<f64>> {
        let (start, swings) = self.half.swings(cycle, self.levels);
        let ratio = self.half.ratio(cycle, self.loads.least_normal);
        let force = self.half.force(cycle);
        let share = |(place, ratio): (usize, Option<f64>)| {
            let swing = ratio.map(|_| swings[place]).filter(|swing| *swing > 0.0);
            swing.map(|swing| (force[place] + start) / swing)
        };
        ratio.into_iter().enumerate().map(share).collect()
    }

    fn window<'m>(
        &self,
        cycle: &MeanLoop,
        straightened: Option<Straightened<'m>>,
    ) -> Option<Window<'m>> {
        let shares = self.shares(cycle);
        window(&self.half, cycle, self.batches, &shares, straightened)
    }

    /// By how much the branch is steeper at its start than in this window, where it surely differs.
    fn steeper(&self, cycle: &MeanLoop, window: &Window<'_>) -> Option<f64> {
        if self.batches.rounded {
            return None;
        }
        steeper(&self.half, cycle, self.batches, &self.shares(cycle), window)
    }

    /// The window with what is known of the slope at the reversal: where the branch is steeper before the window, or falls a little inside
    /// it, that may be the slope that is sought. Of a branch with a knee a start that is less steep is an error of the knee.
    fn known<'m>(&self, cycle: &MeanLoop, window: Window<'m>) -> Window<'m> {
        let steeper = self.steeper(cycle, &window).unwrap_or(0.0);
        let apart = match window.straightened {
            Some(_) => steeper.abs(),
            None => steeper.max(bend_to_reversal(&self.half, cycle, self.batches, &window)),
        };
        Window { apart, ..window }
    }

    /// The branch up to well beyond its knee, for a first guess of its slope (N/m).
    fn branch(&self, cycle: &MeanLoop, stick: f64) -> Branch {
        let normal = cycle.normal.iter().sum::<f64>() / cycle.samples() as f64;
        let full = (self.levels[0] + self.levels[1]) * normal / stick;
        let x = self.half.displacement(cycle);
        let last = x
            .partition_point(|x| *x < REACH * full)
            .min(self.half.last(cycle));
        let step = last.div_ceil(MOST_POINTS).max(1);
        let shares = self.shares(cycle);
        let (_, swings) = self.half.swings(cycle, self.levels);
        // a contact that has stuck for a moment before the reversal begins its branch part of the way along it
        let begun = swings[0] * shares.first().copied().flatten().unwrap_or(0.0);
        let points = (0..last).step_by(step);
        let point = |i: usize| Some(((begun + stick * x[i]) / swings[i], shares[i]?));
        let (displacement, share) = points.filter_map(point).unzip();
        Branch {
            displacement,
            share,
        }
    }
}

/// Whether both branches are straight where their slopes are taken: then no knee is needed. A knee of the family would be a guess
/// all the same.
fn are_straight(
    cycle: &MeanLoop,
    sides: &[Side<'_>; 2],
    windows: &[Option<Window<'_>>; 2],
) -> bool {
    let straight = |(side, window): (&Side<'_>, &Option<Window<'_>>)| {
        window.is_some_and(|window| {
            is_straight(&side.half, cycle, side.batches, &window)
                && side.steeper(cycle, &window).is_none_or(|by| by < 0.0)
        })
    };
    sides.iter().zip(windows).all(straight)
}

/// Points of a branch that tell its knee, at most.
const MOST_POINTS: usize = 60;

/// The windows with a knee, but those without one where the start of the branch contradicts the knee and not them.
fn better<'m>(
    knee: [Option<Window<'m>>; 2],
    straight: [Option<Window<'m>>; 2],
) -> [Option<Window<'m>>; 2] {
    let error = |windows: &[Option<Window<'m>>; 2]| -> f64 {
        windows.iter().flatten().map(|window| window.apart).sum()
    };
    match error(&straight) < error(&knee) {
        true => straight,
        false => knee,
    }
}

/// Slope of the stick branches (N/m), of their mean compliance.
fn stick(
    cycle: &MeanLoop,
    sides: &[Side<'_>; 2],
    windows: &[Option<Window<'_>>; 2],
) -> Result<f64, String> {
    let lines = sides
        .iter()
        .zip(windows)
        .map(|(side, w)| slope(&side.half, cycle, &(*w)?));
    let each: Vec<f64> = lines.flatten().map(|line| 1.0 / line.slope).collect();
    if each.is_empty() {
        return Err(
            "has no sample in its stick branches: record more samples per cycle".to_owned(),
        );
    }
    let compliance = each.iter().sum::<f64>() / each.len() as f64;
    if compliance <= 0.0 {
        return Err("has stick branches along which the force falls: one of the signals needs the other sign, or this is no hysteresis loop".to_owned());
    }
    Ok(1.0 / compliance)
}

/// Windows of a loop that slips as a whole, with the knee of its branches.
fn with_knee<'m>(
    cycle: &MeanLoop,
    sides: &[Side<'_>; 2],
    stick: f64,
    spread: PressureSpread<'m>,
) -> [Option<Window<'m>>; 2] {
    let branches = sides.each_ref().map(|side| side.branch(cycle, stick));
    let told = branches
        .iter()
        .all(|branch| branch.share.len() >= LEAST_POINTS);
    let fitted = told.then(|| fit(&branches, spread));
    [0, 1].map(|side| {
        let straightened = fitted.map(|found| Straightened {
            knee: found.knee,
            levels: sides[side].levels,
            offset: sides[side].loads.offset,
            mean: found.mean[side],
            model_error: found.model_error[side],
        });
        sides[side].window(cycle, straightened)
    })
}
