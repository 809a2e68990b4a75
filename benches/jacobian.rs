//! Time of the linear solves of one Newton step over the highest harmonic: growth exponents can be read off one run.
//!
//! States: the two-blade rig at its peak on 3 harmonics, padded with zeros to more; "soft" is its nominal stiffness at
//! 5 N (partly stuck), "stiff" three times that at 20 N (all pairs slip, most lift off). Each time covers setup and two
//! right-hand sides. `dense` and `harmonic_blocks` are what the chosen method replaces (to 1e-8 where it solves to 1e-10).

#![expect(clippy::expect_used, reason = "a benchmark without its state fails")]

use divan::{Bencher, black_box};
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::equations::balance::time_points;
use microslip::hb::newton::{Iterate, Point};
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    Balance, HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, StabilityScope,
};
use microslip::linalg::gcr::{GcrSettings, SearchSpace};
use microslip::model::interface::{InterfaceSettings, StiffnessShare};
use microslip::model::two_blade::{TwoBladeSettings, build};
use microslip::units::hz_to_rad_s;
use std::ops::Range;
use std::sync::LazyLock;

#[path = "../tests/common/compliance_product.rs"]
mod compliance_product;

use compliance_product::add_compliance;

const AFT: AftSettings = AftSettings {
    n_time: 128,
    law: FrictionLaw::Box,
    events: Events::Interpolated,
    laps: Laps::Periodic,
};
const HIGHEST: [usize; 4] = [5, 8, 13, 21];
/// Larger dense factors take too long for a benchmark.
const HIGHEST_DENSE: [usize; 3] = [5, 8, 13];

static SOFT: LazyLock<State> = LazyLock::new(|| State::new(1.0, 0.6, 5.0));
static STIFF: LazyLock<State> = LazyLock::new(|| State::new(3.0, 0.3, 20.0));

fn main() {
    divan::main();
}

/// A peak on 3 harmonics.
struct State {
    problem: Problem<'static>,
    point: Point,
}

impl State {
    /// Stiffness over the nominal one, friction coefficient, excitation level (N).
    fn new(scale: f64, mu: f64, level: f64) -> Self {
        let rig = build(&TwoBladeSettings::default()).expect("the default rig builds");
        let model = Box::leak(Box::new(LinearModel::new(&rig.reduced).expect("definite")));
        let interface = InterfaceSettings {
            normal_stiffness: scale * 1e9,
            tangential_stiffness: scale * 0.233e9,
            friction_coefficient: mu,
            share: StiffnessShare::TributaryArea,
        };
        let contacts = interface.parameters(&rig.reduced.contacts);
        let problem =
            Problem::new(model, contacts, 1.0, SliderAnchor::Unloaded).expect("well posed");
        let settings = HbSettings {
            harmonics: HarmonicSet::up_to(3),
            aft: AFT,
            anchor: SliderAnchor::Unloaded,
            newton: NewtonSettings::default(),
            alert: None,
            stability: StabilityScope::Off,
        };
        let free = rig.free_neck_bending();
        let peak = PeakSettings {
            band: Band {
                low: hz_to_rad_s(free - 8.0),
                high: hz_to_rad_s(free + 22.0),
            },
            frequency_tolerance: 3e-7,
        };
        let found = track_peaks(&problem, &settings, peak, &[level]).expect("definite");
        let solution = found[0].solution.as_ref().expect("peak found");
        let point = Point {
            r: solution.relative.clone(),
            omega: solution.omega,
            level: solution.level,
        };
        Self { problem, point }
    }

    fn balance(&self, highest: usize) -> Balance<'_> {
        let harmonics = HarmonicSet::up_to(highest);
        let aft = time_points(AFT, &harmonics);
        Balance::new(&self.problem, harmonics, aft)
    }

    /// Times `solve`(iterate, balance, right-hand sides).
    fn measure(
        &self,
        bencher: Bencher,
        highest: usize,
        solve: impl Fn(&Iterate<'_>, &Balance<'_>, &[Vec<f64>; 2]),
    ) {
        let balance = self.balance(highest);
        let start = self.point.padded(&self.balance(3), &balance);
        let iterate = Iterate::new(&balance, start);
        let slope = balance.frequency_slope(&iterate.compliance, &iterate.motion);
        let sides = [iterate.residual.clone(), slope];
        bencher.bench_local(|| solve(black_box(&iterate), &balance, &sides));
    }
}

fn chosen(iterate: &Iterate<'_>, balance: &Balance<'_>, sides: &[Vec<f64>; 2]) {
    let jacobian = iterate.jacobian(balance);
    for b in sides {
        black_box(jacobian.solve(b));
    }
}

#[divan::bench(args = HIGHEST, sample_count = 20)]
fn chosen_soft(bencher: Bencher, highest: usize) {
    SOFT.measure(bencher, highest, chosen);
}

#[divan::bench(args = HIGHEST, sample_count = 20)]
fn chosen_stiff(bencher: Bencher, highest: usize) {
    STIFF.measure(bencher, highest, chosen);
}

#[divan::bench(args = HIGHEST, sample_count = 20)]
fn setup_stiff(bencher: Bencher, highest: usize) {
    STIFF.measure(bencher, highest, |iterate, balance, _| {
        black_box(iterate.jacobian(balance));
    });
}

#[divan::bench(args = HIGHEST_DENSE, sample_count = 3)]
fn dense_stiff(bencher: Bencher, highest: usize) {
    STIFF.measure(bencher, highest, dense);
}

#[divan::bench(args = HIGHEST, sample_count = 3)]
fn harmonic_blocks_stiff(bencher: Bencher, highest: usize) {
    STIFF.measure(bencher, highest, harmonic_blocks);
}

/// Dense LU of I + G dg.
fn dense(iterate: &Iterate<'_>, balance: &Balance<'_>, sides: &[Vec<f64>; 2]) {
    let factors = factors(iterate, balance, 0..iterate.compliance.harmonics.len() + 1);
    for b in sides {
        black_box(factors.solve(ColRef::from_slice(b)));
    }
}

/// Krylov solves preconditioned by the diagonal blocks of the harmonics.
fn harmonic_blocks(iterate: &Iterate<'_>, balance: &Balance<'_>, sides: &[Vec<f64>; 2]) {
    let blocks: Vec<_> = (0..iterate.compliance.harmonics.len() + 1)
        .map(|k| factors(iterate, balance, k..k + 1))
        .collect();
    let jacobian = iterate.jacobian(balance);
    let product = |v: &[f64]| {
        let mut z = v.to_vec();
        let mut rest = z.as_mut_slice();
        for factors in &blocks {
            let (block, after) = rest.split_at_mut(factors.L().nrows());
            factors.solve_in_place(ColMut::from_slice_mut(block));
            rest = after;
        }
        let mut w = z.clone();
        add_compliance(iterate, balance, &jacobian.deviation(&z), &mut w);
        (z, w)
    };
    let settings = GcrSettings {
        tolerance: 1e-8,
        max_iterations: 250,
    };
    for b in sides {
        black_box(SearchSpace::default().solve(product, b, settings));
    }
}

/// LU factors of I + G dg restricted to a range of harmonics.
fn factors(
    iterate: &Iterate<'_>,
    balance: &Balance<'_>,
    harmonics: Range<usize>,
) -> PartialPivLu<f64> {
    let (n, n_pairs, m) = (
        balance.layout.n_relative(),
        balance.layout.n_pairs,
        balance.layout.n_coefficients,
    );
    let first = |k: usize| (2 * k).saturating_sub(1);
    let start = first(harmonics.start);
    let width = first(harmonics.end) - start;
    let mut matrix = Mat::<f64>::identity(width * n, width * n);
    for k in harmonics {
        let deviation = |coefficient: usize| {
            let mut rows = Mat::<f64>::zeros(n, width * n);
            for tangent in &iterate.contact.active {
                for (row, column, values) in &tangent.blocks {
                    let (row, column) = (row * n_pairs, column * n_pairs + tangent.pair);
                    for j in 0..width {
                        rows[(row + tangent.pair, j * n + column)] =
                            values[coefficient * m + start + j];
                    }
                }
            }
            rows
        };
        let mut add = |coefficient: usize, product: Mat<f64>| {
            let mut rows = matrix.subrows_mut((coefficient - start) * n, n);
            rows += product;
        };
        let Some(moving) = k.checked_sub(1) else {
            add(0, &balance.problem.stuck_static.compliance * deviation(0));
            continue;
        };
        let h = &iterate.compliance.harmonics[moving];
        let (cosine, sine) = (deviation(first(k)), deviation(first(k) + 1));
        add(first(k), &h.real * &cosine + &h.imaginary * &sine);
        add(first(k) + 1, &h.real * &sine - &h.imaginary * &cosine);
    }
    matrix.partial_piv_lu()
}
