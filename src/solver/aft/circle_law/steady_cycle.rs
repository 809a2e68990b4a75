//! Search for the steady cycle of the circle law: the motion of the slider that repeats after one period.
//!
//! A lap is one pass over the excitation period. The search takes the end of each lap and asks for the next one; it does not
//! depend on how a lap is computed.
//!
//! The contact holds the slider z = k_t w in the disc |s − z| ≤ L, which moves with s (sweeping process; Moreau, J. Differ. Equ. 26,
//! 1977). A lap never increases the distance between two sliders, and a disc is strictly convex. Therefore one of two cases is
//! true:
//! - The discs of the period have no point in common. Then there is exactly one steady cycle. It slips, and Newton's method finds
//!   it from any slider.
//! - They have points in common. Then every slider comes to rest in one of these points, and the anchor decides in which. Plain
//!   laps reach it soon, or they creep towards a point where the contact holds the slider at two phases of the period. [`hold`]
//!   solves for that point.

use crate::aft::forces::Periodicity;
use crate::aft::vector::dot;
use crate::aft::vector::size;
use crate::contact::Real;

/// Most laps with Newton steps; after them the search continues with plain laps. Just above the onset of slip across a mean traction
/// a step takes a third of what is left, and every second lap is a plain one: 60 laps for the eighth digit.
const NEWTON_LAPS: u32 = 100;
/// Most laps; after them the cycle counts as not found.
pub(in crate::aft) const MAX_LAPS: u32 = 200;
/// Plain laps from the anchor after which the search first looks for a creeping slider. It looks again whenever their number
/// has doubled.
const PATIENCE: u32 = 6;
/// Where det(I − M) is at most this many rounding errors, no Newton step is made.
const SINGULAR: f64 = 4096.0;
/// Most steps of the search for the point where two phases hold the slider.
const HOLD_STEPS: usize = 80;

/// What the search knows of a lap. Sliders k_t w and tolerances are in N.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct LapEnd<T> {
    pub start: [T; 2],
    pub end: [T; 2],
    /// Derivative M of the end by the start, row-major.
    pub monodromy: [T; 4],
    /// Longest slip of the slider.
    pub longest_slip: T,
    /// Largest traction that counts as rounding.
    pub tolerance: T,
}

impl<T: Real> LapEnd<T> {
    #[inline(always)]
    fn change(&self) -> [T; 2] {
        [self.end[0] - self.start[0], self.end[1] - self.start[1]]
    }

    /// Whether nothing but rounding moved the slider.
    #[inline(always)]
    fn rests(&self) -> bool {
        self.longest_slip <= self.tolerance
    }

    /// Whether the slider ends the lap where it began it, up to rounding.
    #[inline(always)]
    pub(in crate::aft) fn is_periodic(&self) -> bool {
        size(self.change()) <= self.tolerance
    }
}

/// Two phases of the period at which the contact holds a resting slider, and the place where it rests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::aft) struct Hold<I, T> {
    pub slider: [T; 2],
    pub instants: [I; 2],
    /// Directions of the traction at these phases.
    pub directions: [[T; 2]; 2],
}

impl<I: Copy, T: Real> Hold<I, T> {
    /// Motion of the slider (N) that takes away the `excess` (N) of the traction over its limit at the two phases. None where their directions
    /// are parallel.
    pub(in crate::aft) fn moved(&self, excess: [T; 2]) -> Option<[T; 2]> {
        let [a, b] = self.directions;
        let determinant = a[0] * b[1] - a[1] * b[0];
        let least = T::from_f64(SINGULAR) * T::EPSILON;
        (determinant.abs() > least).then(|| {
            let inverse = T::ONE / determinant;
            [
                inverse * (b[1] * excess[0] - a[1] * excess[1]),
                inverse * (a[0] * excess[1] - b[0] * excess[0]),
            ]
        })
    }
}

/// What the search wants next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::aft) enum Next<T> {
    /// A lap from the end of the last one.
    Plain,
    /// A lap from another slider.
    From([T; 2]),
    /// No further lap: the last lap is the steady cycle, or no cycle was found.
    Nothing,
}

/// How the steady cycle was found. This decides what the cycle depends on, and so its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::aft) enum Origin<I, T> {
    /// By laps from the anchor. The cycle is the last of them.
    Anchor,
    /// By Newton's method: it is the only cycle, and depends on no anchor.
    Itself,
    /// The contact holds the slider at two phases.
    Held(Hold<I, T>),
}

/// Search of one state, from the end of its first lap.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Search<I, T> {
    stage: SearchStage<I, T>,
    /// Number of laps so far; at the end of a search by plain laps, that of the laps from the anchor to the cycle.
    pub laps: u32,
    pub origin: Origin<I, T>,
    pub periodicity: Periodicity,
    /// Whether a Newton step was made.
    newton: bool,
    /// Change of the slider over the previous lap, as long as Newton steps are made.
    last: Option<T>,
    /// Slider after the first lap.
    first: [T; 2],
    /// Length of the last Newton step.
    pub step: Option<T>,
}

#[derive(Debug, Clone, Copy)]
enum SearchStage<I, T> {
    Newton,
    /// Plain laps: their number from the anchor.
    Plain(u32),
    /// A lap that tests whether two phases hold the slider. The number of plain laps before it, and the slider at their end.
    Held(Hold<I, T>, u32, [T; 2]),
}

impl<I: Copy, T: Real> Search<I, T> {
    /// From the slider after the first lap.
    pub(in crate::aft) fn new(first: [T; 2]) -> Self {
        Self {
            stage: SearchStage::Newton,
            laps: 1,
            origin: Origin::Anchor,
            periodicity: Periodicity::NotPeriodic,
            newton: false,
            last: None,
            first,
            step: None,
        }
    }

    /// Takes a lap and says which lap is next. `held(slider)` looks for the point towards which a slider creeps that is now at `slider`.
    pub(in crate::aft) fn take(
        &mut self,
        lap: LapEnd<T>,
        held: impl FnOnce([T; 2]) -> Option<Hold<I, T>>,
    ) -> Next<T> {
        self.laps += 1;
        self.step = None;
        match self.stage {
            SearchStage::Newton => self.newton(lap),
            SearchStage::Plain(laps) => self.plain(lap, laps + 1, held),
            SearchStage::Held(hold, laps, end) => {
                if lap.rests() {
                    return self.found(Origin::Held(hold), Periodicity::DependsOnAnchor);
                }
                self.stage = SearchStage::Plain(laps);
                Next::From(end)
            }
        }
    }

    fn newton(&mut self, lap: LapEnd<T>) -> Next<T> {
        let (change, m) = (lap.change(), lap.monodromy);
        let singular = is_singular(m);
        let now = size(change);
        let failed = self.last.is_some_and(|last| now + now > last);
        let step = if singular {
            change
        } else {
            solve_identity_minus(m, change)
        };
        let settled = size(step) <= lap.tolerance || (lap.is_periodic() && failed);
        let finite = now < T::from_f64(f64::INFINITY);
        if (lap.rests() || (settled && singular)) && self.newton {
            // The slider rests, and the anchor decides where: plain laps start from the end of the first lap from the anchor.
            self.stage = SearchStage::Plain(1);
            return Next::From(self.first);
        }
        if settled && (singular || lap.rests()) {
            return self.found(Origin::Anchor, Periodicity::DependsOnAnchor);
        }
        if settled {
            return self.found(Origin::Itself, Periodicity::Unique);
        }
        if self.laps >= MAX_LAPS || !finite {
            return self.found(Origin::Itself, Periodicity::NotPeriodic);
        }
        if failed || singular || self.laps > NEWTON_LAPS {
            self.last = None;
            return Next::Plain;
        }
        (self.last, self.newton) = (Some(now), true);
        self.step = Some(size(step));
        Next::From([lap.start[0] + step[0], lap.start[1] + step[1]])
    }

    /// After a plain lap, which was number `laps` from the anchor.
    fn plain(
        &mut self,
        lap: LapEnd<T>,
        laps: u32,
        held: impl FnOnce([T; 2]) -> Option<Hold<I, T>>,
    ) -> Next<T> {
        if lap.rests() {
            self.laps = laps;
            return self.found(Origin::Anchor, Periodicity::DependsOnAnchor);
        }
        if laps >= MAX_LAPS {
            self.laps = laps;
            return self.found(Origin::Anchor, Periodicity::NotPeriodic);
        }
        self.stage = SearchStage::Plain(laps);
        if laps.is_multiple_of(PATIENCE)
            && (laps / PATIENCE).is_power_of_two()
            && let Some(hold) = held(lap.end)
        {
            self.stage = SearchStage::Held(hold, laps, lap.end);
            return Next::From(hold.slider);
        }
        Next::Plain
    }

    fn found(&mut self, origin: Origin<I, T>, periodicity: Periodicity) -> Next<T> {
        (self.origin, self.periodicity) = (origin, periodicity);
        Next::Nothing
    }
}

/// By how much the traction of a resting slider exceeds its limit at one phase.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Touch<I, T> {
    pub instant: I,
    /// |s − z| − L (N).
    pub excess: T,
    pub direction: [T; 2],
}

impl<I, T: Real> Touch<I, T> {
    /// From the traction `t` of a slider that rests.
    #[inline(always)]
    pub(in crate::aft) fn of(instant: I, t: [T; 2], limit: T) -> Self {
        let length = size(t);
        let inverse = if length > T::ZERO {
            T::ONE / length
        } else {
            T::ZERO
        };
        Self {
            instant,
            excess: length - limit,
            direction: t.map(|t| inverse * t),
        }
    }
}

/// The point at which two phases hold a creeping slider that is now at `slider`. Newton's method solves for it; because discs
/// are convex, it approaches the point from outside. Where the excess is positive at a third phase, that phase replaces the one
/// of the two whose direction is nearer. `near` gives the maximum of the excess near a phase, `peaks` all maxima of the period.
pub(in crate::aft) fn hold<I: Copy, T: Real>(
    mut slider: [T; 2],
    tolerance: T,
    near: impl Fn(I, [T; 2]) -> Touch<I, T>,
    peaks: impl Fn([T; 2]) -> Vec<Touch<I, T>>,
) -> Option<Hold<I, T>> {
    let worst = |slider: [T; 2], against: [T; 2]| {
        let opposed = |touch: &Touch<I, T>| dot(against, touch.direction) <= T::ZERO;
        let exceeds = |touch: &Touch<I, T>| touch.excess > tolerance && opposed(touch);
        let larger = |a: Touch<I, T>, b: Touch<I, T>| if b.excess > a.excess { b } else { a };
        peaks(slider).into_iter().filter(exceeds).reduce(larger)
    };
    let first = worst(slider, [T::ZERO; 2])?;
    let [x, y] = first.direction;
    slider = [slider[0] + first.excess * x, slider[1] + first.excess * y];
    let second = worst(slider, first.direction)?;
    let mut instants = [first.instant, second.instant];
    for _ in 0..HOLD_STEPS {
        let [a, b] = instants.map(|instant| near(instant, slider));
        let hold = Hold {
            slider,
            instants: [a.instant, b.instant],
            directions: [a.direction, b.direction],
        };
        let step = hold.moved([a.excess, b.excess])?;
        instants = hold.instants;
        if size(step) > tolerance && a.excess.abs().or_larger(b.excess.abs()) > tolerance {
            slider = [slider[0] + step[0], slider[1] + step[1]];
            continue;
        }
        let Some(other) = worst(slider, [T::ZERO; 2]) else {
            return Some(hold);
        };
        let e = other.direction;
        let nearer = usize::from(dot(e, b.direction) > dot(e, a.direction));
        instants[nearer] = other.instant;
    }
    None
}

/// The samples at which a value is at least that of both neighbours.
pub(in crate::aft) fn tops<T: Real>(samples: usize, value: impl Fn(usize) -> T) -> Vec<usize> {
    let around = |i: usize| [(i + samples - 1) % samples, (i + 1) % samples].map(&value);
    let is_top = |&i: &usize| {
        let (here, [before, after]) = (value(i), around(i));
        here >= before && here >= after
    };
    (0..samples).filter(is_top).collect()
}

/// x of (I − M) x = b.
#[inline(always)]
pub(in crate::aft) fn solve_identity_minus<T: Real>(m: [T; 4], b: [T; 2]) -> [T; 2] {
    let determinant = determinant_of_identity_minus(m);
    let (a, d) = (T::ONE - m[0], T::ONE - m[3]);
    [
        (d * b[0] + m[1] * b[1]) / determinant,
        (a * b[1] + m[2] * b[0]) / determinant,
    ]
}

#[inline(always)]
fn determinant_of_identity_minus<T: Real>(m: [T; 4]) -> T {
    (T::ONE - m[0]) * (T::ONE - m[3]) - m[1] * m[2]
}

#[inline(always)]
pub(in crate::aft) fn is_singular<T: Real>(m: [T; 4]) -> bool {
    determinant_of_identity_minus(m) <= T::from_f64(SINGULAR) * T::EPSILON
}

/// The kind of cycle after a fixed number of laps.
#[inline(always)]
pub(in crate::aft) fn classify<T: Real>(periodic: bool, monodromy: [T; 4]) -> Periodicity {
    match (periodic, is_singular(monodromy)) {
        (false, _) => Periodicity::NotPeriodic,
        (true, true) => Periodicity::DependsOnAnchor,
        (true, false) => Periodicity::Unique,
    }
}
