//! The march of the full nonlinear equations from a periodic state and from the same state disturbed along an eigenvector of the
//! period map. The share of their difference in this eigenvector must grow by its multiplier from period to period.

use super::super::time_integration::{March, truncated};
use super::{blades, branch, motion, passing, raised, rig, rig_peaks, settings};
use crate::two_blade::contacts;
use faer::linalg::solvers::DenseSolveCore;
use faer::prelude::*;
use microslip::contact::{ContactParameters, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::newton::{Condition, Iterate, solve};
use microslip::hb::stability::assessment::STEPS;
use microslip::hb::stability::period_map::PeriodMap;
use microslip::hb::stability::{Instability, assess};
use microslip::hb::{Balance, LinearModel, Problem, SliderAnchor, Solution};

/// Steps of the march per period.
const MARCH: usize = 16_000;
/// Disturbance over the amplitude of the response.
const SMALL: f64 = 1e-6;

/// The multiplier of the period map, and that of the march, over some periods.
pub(super) struct Compared {
    pub(super) computed: c64,
    pub(super) marched: c64,
}

impl Compared {
    pub(super) fn error(&self) -> f64 {
        (self.marched / self.computed - 1.0).norm()
    }
}

/// The modal displacements of coordinates of the map: the march has all modes.
fn in_modes(map: &PeriodMap, coordinates: &[f64]) -> Vec<f64> {
    let eta = &map.shapes[0] * Col::from_fn(coordinates.len(), |i| coordinates[i]);
    eta.iter().copied().collect()
}

/// The share of the coordinates in modal displacements and rates, followed by the sliders as they are: shapes have unit mass.
fn in_coordinates(map: &PeriodMap, state: &[f64]) -> Vec<f64> {
    let shapes = &map.shapes[0];
    let modes = shapes.nrows();
    let (motion, sliders) = state.split_at(2 * modes);
    let mut all: Vec<f64> = Vec::new();
    for part in motion.chunks_exact(modes) {
        let of = shapes.transpose() * Col::from_fn(modes, |i| part[i]);
        all.extend(of.iter());
    }
    all.extend(sliders);
    all
}

/// Which of these is the largest, neutral ones left out. Of several that rounding alone tells apart, as of modes that are damped alike,
/// it is the one nearest to `near`.
fn largest(multipliers: &[c64], near: c64) -> usize {
    let neutral = |i: &usize| (multipliers[*i] - 1.0).norm() < 1e-6;
    let all = (0..multipliers.len()).filter(|i| !neutral(i));
    let size = |i: usize| multipliers[i].norm();
    let largest = all.clone().map(size).fold(0.0, f64::max);
    let apart = |i: usize| (multipliers[i] - near).norm();
    let alike = all.filter(|&i| size(i) > (1.0 - 1e-6) * largest);
    let top = alike.min_by(|&i, &j| apart(i).total_cmp(&apart(j)));
    top.expect("a multiplier")
}

/// The largest multiplier and the same by marches over `periods`, after `settle` periods in which the march finds its own periodic
/// state; see [`largest`] for `near`.
pub(super) fn compare(
    balance: &Balance<'_>,
    iterate: &Iterate<'_>,
    [settle, periods]: [usize; 2],
    near: c64,
) -> Compared {
    let motion = motion(balance, iterate);
    let maps = PeriodMap::all(balance.problem, &motion, STEPS).expect("a map");
    let map = &maps[0];
    let eigen = map.matrix.eigen().expect("eigenvalues");
    let width = map.matrix.nrows();
    let multipliers: Vec<c64> = (0..width).map(|i| eigen.S()[i]).collect();
    let top = largest(&multipliers, near);
    let right = eigen.U().to_owned();
    let left = right.partial_piv_lu().inverse();
    let n = map.n_modes;
    let size = (0..n).map(|i| right[(i, top)].norm()).fold(0.0, f64::max);
    let scale = SMALL * iterate.response(balance).norm() / size;
    let vector: Vec<f64> = (0..width).map(|i| scale * right[(i, top)].re).collect();
    let mut base = March::new(balance, iterate, MARCH);
    let mut other = March::new(balance, iterate, MARCH);
    for march in [&mut base, &mut other] {
        (0..settle).for_each(|_| {
            let _ = march.period();
        });
    }
    let sliders: Vec<_> = (map.sliders.iter().copied())
        .zip(vector[2 * n..].iter().copied())
        .collect();
    let [eta, rate] = [&vector[..n], &vector[n..2 * n]].map(|x| in_modes(map, x));
    other.disturb(&eta, &rate, &sliders);
    let share = |base: &March<'_>, other: &March<'_>| -> c64 {
        let states = [other, base].map(|march| march.state(&map.sliders));
        let difference: Vec<f64> = states[0]
            .iter()
            .zip(&states[1])
            .map(|(a, b)| a - b)
            .collect();
        let moved = in_coordinates(map, &difference).into_iter();
        moved.enumerate().map(|(i, d)| left[(top, i)] * d).sum()
    };
    let before = share(&base, &other);
    let mut turns = 0.0;
    let mut last = before;
    for _ in 0..periods {
        let _ = (base.period(), other.period());
        let now = share(&base, &other);
        turns += (now / last / eigen.S()[top]).arg();
        last = now;
    }
    let growth = (last.norm() / before.norm()).powf(1.0 / periods as f64);
    Compared {
        computed: eigen.S()[top],
        marched: c64::from_polar(growth, eigen.S()[top].arg() + turns / periods as f64),
    }
}

/// A state of the lumped blades.
struct State {
    phase: f64,
    /// Damping of the strip (1/s).
    strip: f64,
    level: f64,
    hertz: f64,
    /// Which time the branch passes this frequency.
    nth: usize,
    lifts: bool,
    instability: Option<Instability>,
    /// Periods to settle, periods compared.
    periods: [usize; 2],
    allowed: f64,
}

/// Blades against each other (−1) or together (1) with the damping of the strip (1/s); level (N), frequency (Hz) and which passage.
const fn state(
    (phase, strip): (f64, f64),
    (level, hertz, nth): (f64, f64, usize),
    (lifts, instability): (bool, Option<Instability>),
    (periods, allowed): ([usize; 2], f64),
) -> State {
    State {
        phase,
        strip,
        level,
        hertz,
        nth,
        lifts,
        instability,
        periods,
        allowed,
    }
}

const FOLD: Option<Instability> = Some(Instability::Fold);
const DOUBLING: Option<Instability> = Some(Instability::PeriodDoubling);

/// Stuck, slip, lift-off; stable, middle branches of folds with and without lift-off, and every second period alike. Where a state
/// with lift-off is strongly unstable, the march leaves it after few periods.
const STATES: [State; 13] = [
    state(
        (-1.0, 2000.0),
        (0.1, 400.0, 0),
        (false, None),
        ([0, 5], 1e-3),
    ),
    state(
        (-1.0, 2000.0),
        (10.0, 416.4, 0),
        (false, None),
        ([0, 5], 5e-3),
    ),
    state(
        (1.0, 300.0),
        (10.0, 311.0, 0),
        (false, None),
        ([0, 5], 2e-3),
    ),
    state(
        (-1.0, 2000.0),
        (40.0, 358.5, 1),
        (false, FOLD),
        ([0, 4], 2e-3),
    ),
    state(
        (-1.0, 2000.0),
        (40.0, 357.0, 1),
        (false, FOLD),
        ([0, 4], 2e-3),
    ),
    state(
        (-1.0, 300.0),
        (40.0, 353.0, 1),
        (true, FOLD),
        ([0, 4], 2e-2),
    ),
    state(
        (1.0, 300.0),
        (20.0, 321.38, 1),
        (true, FOLD),
        ([0, 4], 2e-2),
    ),
    state((1.0, 300.0), (10.0, 343.0, 0), (true, None), ([0, 5], 5e-3)),
    state((1.0, 600.0), (40.0, 316.7, 0), (true, None), ([0, 5], 2e-2)),
    state((1.0, 600.0), (40.0, 335.5, 0), (true, None), ([0, 5], 2e-2)),
    state(
        (1.0, 2000.0),
        (40.0, 317.96, 0),
        (true, None),
        ([0, 5], 2e-2),
    ),
    state(
        (-1.0, 2000.0),
        (40.0, 361.0, 0),
        (true, None),
        ([30, 5], 3e-2),
    ),
    state(
        (-1.0, 300.0),
        (80.0, 342.4, 0),
        (true, DOUBLING),
        ([0, 1], 5e-2),
    ),
];

/// Seen to fail without the memory of sliders that stick, and with its effect on contacts that slip turned round.
#[test]
fn disturbances_grow_by_the_multipliers() {
    let failed: Vec<String> = STATES
        .iter()
        .filter_map(|state| {
            let (linear, contacts) = blades(state.phase, state.strip);
            let anchor = SliderAnchor::Unloaded;
            let problem = Problem::new(&linear, contacts, 1.0, anchor).expect("held");
            let band = if state.phase < 0.0 {
                [315.0, 420.0]
            } else {
                [309.0, 350.0]
            };
            let curve = branch(&problem, state.level, band);
            let start = passing(&curve, state.hertz, state.nth);
            let (balance, iterate) = raised(&problem, start, state.hertz, FrictionLaw::Box);
            let verdict = assess(&problem, &motion(&balance, &iterate)).expect("assessed");
            let found = compare(&balance, &iterate, state.periods, verdict.multiplier);
            let open: u32 = iterate.contact.counts.iter().map(|s| s.separated).sum();
            let text = format!(
                "{} N, {} Hz, {open} samples open: {:.5} and {:.5} by the march ({:.1e}), {:?}",
                state.level,
                state.hertz,
                found.computed,
                found.marched,
                found.error(),
                verdict.instability()
            );
            println!("{text}");
            let holds = found.error() < state.allowed
                && verdict.instability() == state.instability
                && (open > 0) == state.lifts;
            (!holds).then_some(text)
        })
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The rig without modes above 60 kHz, forces as they are and turned round, by both laws: by the box law at 20 N, by the circle law at all levels.
/// The widest bound is for contacts that are open for 60 % of the period. Seen to fail with 0.05 there.
#[test]
fn disturbances_of_the_rig_grow_by_the_multipliers() {
    let mut bounded = 0;
    for (turned, law) in [
        (false, FrictionLaw::Box),
        (true, FrictionLaw::Box),
        (false, FrictionLaw::Circle),
        (true, FrictionLaw::Circle),
    ] {
        let model = rig(turned);
        let linear = truncated(&model, 60e3);
        let contacts = contacts(&model, 1.0, 0.6);
        let problem = problem(&linear, contacts);
        for peak in rig_peaks(&problem, &[20.0, 50.0, 100.0], law) {
            let Some((balance, iterate)) = on_harmonics(&problem, &peak, 12, law) else {
                println!(
                    "turned {turned}, {law:?}, {} N: no solution with 12 harmonics",
                    peak.level
                );
                continue;
            };
            let verdict = assess(&problem, &motion(&balance, &iterate)).expect("assessed");
            let found = compare(&balance, &iterate, [0, 3], verdict.multiplier);
            println!(
                "turned {turned}, {law:?}, {} N, open {:.2}: {:.5} and {:.5} by the march ({:.1e})",
                peak.level,
                peak.contact.separated,
                found.computed,
                found.marched,
                found.error()
            );
            let allowed = match (law, turned) {
                (FrictionLaw::Circle, true) => 0.035,
                _ if peak.level < 40.0 => 0.05,
                (FrictionLaw::Circle, false) => 0.07,
                // up to 0.17, printed only
                (FrictionLaw::Box, _) => continue,
            };
            let error = found.error();
            assert!(error < allowed, "{} N: {error:e}", peak.level);
            bounded += 1;
        }
    }
    assert!(bounded >= 5, "{bounded} states");
}

fn problem(linear: &LinearModel, contacts: Vec<ContactParameters<f64>>) -> Problem<'_> {
    Problem::new(linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held")
}

/// The solution at the frequency of `peak` on harmonics up to `highest`.
fn on_harmonics<'p>(
    problem: &'p Problem<'p>,
    peak: &Solution,
    highest: usize,
    law: FrictionLaw,
) -> Option<(Balance<'p>, Iterate<'p>)> {
    let mut settings = settings(3);
    settings.aft.n_time = 256;
    settings.aft.law = law;
    let first = Balance::new(problem, peak.harmonics.clone(), settings.aft);
    let balance = Balance::new(problem, HarmonicSet::up_to(highest), settings.aft);
    let padded = peak.point().padded(&first, &balance);
    let iterate = solve(&balance, padded, Condition::FixedFrequency, settings.newton).ok()?;
    Some((balance, iterate))
}

/// Growth of the difference of all modal displacements over the first periods of two marches, one of them disturbed in all modes.
fn growth(balance: &Balance<'_>, iterate: &Iterate<'_>, periods: i32) -> f64 {
    let mut base = March::new(balance, iterate, MARCH);
    let mut other = March::new(balance, iterate, MARCH);
    let n = balance.problem.model.part(0).n_coordinates();
    let small = 1e-3 * SMALL * iterate.response(balance).norm();
    other.disturb(&vec![small; n], &vec![0.0; n], &[]);
    let apart = |base: &March<'_>, other: &March<'_>| {
        let states = [other, base].map(|march| march.state(&[]));
        let squares = (0..n).map(|i| (states[0][i] - states[1][i]).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let before = apart(&base, &other);
    for _ in 0..periods {
        let _ = (base.period(), other.period());
    }
    (apart(&base, &other) / before).powf(1.0 / f64::from(periods))
}

/// The whole rig with all its modes, up to 2 MHz on its contacts, at 20 N: what the multipliers call stable does not grow in the
/// march, with lift-off under stiff contacts, and what they call unstable grows: there, with the blades together, friction and the
/// normal forces of stiff contacts feed high modes of the strip.
///
/// With the higher modes as a static compliance the first state had a multiplier of 5.9 in modulus.
///
/// Seen to fail with modes up to twice the excitation frequency alone and the others without mass.
#[test]
fn the_whole_rig_is_stable_where_the_multipliers_say_so() {
    let law = FrictionLaw::Box;
    for (turned, scale, mu, stable) in [
        (false, 3.0, 0.5, true),
        (false, 3.0, 0.3, true),
        (true, 10.0, 0.8, false),
    ] {
        let model = rig(turned);
        let linear = LinearModel::new(&model).expect("definite");
        let problem = problem(&linear, contacts(&model, scale, mu));
        let peaks = rig_peaks(&problem, &[0.1, 5.0, 20.0], law);
        let peak = peaks.last().expect("a peak");
        let (balance, iterate) = on_harmonics(&problem, peak, 15, law).expect("a solution");
        let verdict = assess(&problem, &motion(&balance, &iterate)).expect("assessed");
        let grown = growth(&balance, &iterate, 2);
        println!(
            "turned {turned}, {scale} times the stiffness, friction {mu}, open {:.2}: {:.4}, {} above 1; {grown:.3} by the march",
            peak.contact.separated, verdict.multiplier, verdict.n_unstable
        );
        assert_eq!(verdict.is_stable(), stable);
        assert_eq!(grown < 1.5, stable, "{grown}");
    }
}
