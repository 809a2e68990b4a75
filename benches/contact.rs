//! Node-states per second and core of the contact evaluation, and the share of the processor's measured peak.
//!
//! States: random harmonics that decay with the order; half of the samples slip, 3 % are separated, an eighth of the
//! states are stuck, and the circle law takes 3 laps on average.
//!
//! Peak: fused multiply-adds on registers alone, two operations each, with the best instruction set that is found at
//! run time. Operations of the evaluation: the same batch is evaluated once with a number that counts its additions,
//! subtractions, multiplications, divisions and roots. Comparisons, sines and operations on a zero (first terms of sums,
//! rows padded to whole vectors) are not counted. Only the table products multiply and add at once; every other operation
//! counts once and takes the place of two. Every time is the best of several runs, of 64 states each; on a shared machine
//! compare ratios within one run only.
//!
//! Before that: mathematical functions of `libm` against those of the C library; `-- functions` ends there.

mod states;

use microslip::aft::{
    AftBatch, AftForces, AftPlan, AftReal, AftScratch, AftSettings, Laps, Want, evaluate,
};
use microslip::contact::{Events, FrictionLaw, Real};
use microslip::harmonics::HarmonicSet;
use pulp::{Arch, Simd, WithSimd};
use states::batch;
use std::cell::Cell;
use std::hint::black_box;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use std::time::Instant;

const N_STATES: usize = 512;
/// States of one run: few enough that it is seldom interrupted.
const PART: usize = 64;
const HARMONICS: [usize; 5] = [1, 3, 5, 7, 21];
const POINTS: [usize; 4] = [64, 128, 256, 512];
/// Runs of which the fastest counts.
const RUNS: usize = 15;

fn main() {
    functions();
    if std::env::args().any(|a| a == "functions") {
        return;
    }
    let peak = fused_multiply_add_peak();
    println!(
        "peak: {:.1} Gflop/s per core, {:?}",
        peak / 1e9,
        Arch::new()
    );
    println!(
        "{:>3} {:>4} {:<8} {:<13} {:>9} {:>9} {:>7} {:>6}",
        "H", "Nt", "law", "events", "forces/s", "tangent/s", "flop", "peak"
    );
    for h in HARMONICS {
        for n_time in POINTS.into_iter().filter(|n| *n > 4 * h) {
            for (law, events) in [
                (FrictionLaw::Box, Events::Interpolated),
                (FrictionLaw::Box, Events::Located),
                (FrictionLaw::Circle, Events::Interpolated),
                (FrictionLaw::Circle, Events::Located),
            ] {
                let settings = AftSettings {
                    n_time,
                    law,
                    events,
                    laps: Laps::Periodic,
                };
                report(h, settings, peak);
            }
        }
    }
    single_precision();
}

/// One line: node-states per second without and with tangents; for the latter operations and share of the peak.
fn report(h: usize, settings: AftSettings, peak: f64) {
    let set = HarmonicSet::up_to(h);
    let forces = rate::<f64>(&set, settings, Want::Forces);
    let tangents = rate::<f64>(&set, settings, Want::ForcesAndTangents);
    let share = |want, rate: f64| {
        let operations = operations(&set, settings, want);
        (operations, 100.0 * operations * rate / peak)
    };
    let (_, forces_share) = share(Want::Forces, forces);
    let (operations, tangents_share) = share(Want::ForcesAndTangents, tangents);
    println!(
        "{h:>3} {:>4} {:<8} {:<13} {:>7.0} k {:>7.0} k {:>5.1} k {forces_share:>4.1} % {tangents_share:>4.1} %",
        settings.n_time,
        format!("{:?}", settings.law),
        format!("{:?}", settings.events),
        forces / 1e3,
        tangents / 1e3,
        operations / 1e3,
    );
}

fn single_precision() {
    let set = HarmonicSet::up_to(5);
    let settings = AftSettings {
        n_time: 128,
        law: FrictionLaw::Box,
        events: Events::Interpolated,
        laps: Laps::Periodic,
    };
    let rate = rate::<f32>(&set, settings, Want::Forces);
    println!(
        "single precision, H = 5, Nt = 128, box: {:.0} k forces/s",
        rate / 1e3
    );
}

/// Nanoseconds per call of `libm` and of the C library, of the functions that events and samples call.
fn functions() {
    const CALLS: usize = 100_000;
    let phase = |i: usize| std::f64::consts::TAU * (i as f64 + 0.5) / CALLS as f64;
    let points: Vec<f64> = (0..CALLS).map(phase).collect();
    let nanoseconds = |function: fn(f64) -> f64| {
        let sum = || points.iter().map(|&x| function(x)).sum::<f64>();
        let runs = (0..RUNS).map(|_| {
            fastest(|| {
                black_box(sum());
            })
        });
        runs.fold(f64::INFINITY, f64::min) * 1e9 / CALLS as f64
    };
    type Function = fn(f64) -> f64;
    let cases: [(&str, Function, Function); 4] = [
        (
            "sine and cosine",
            |x| {
                let (sine, cosine) = libm::sincos(x);
                sine + cosine
            },
            |x| {
                let (sine, cosine) = x.sin_cos();
                sine + cosine
            },
        ),
        ("exp", libm::exp, f64::exp),
        ("log", libm::log, f64::ln),
        ("hypot", |x| libm::hypot(x, 1.0), |x| x.hypot(1.0)),
    ];
    for (name, own, c) in cases {
        let [own, c] = [own, c].map(nanoseconds);
        let ratio = own / c;
        println!("{name:<16} libm {own:>5.1} ns, C library {c:>5.1} ns, ratio {ratio:.2}");
    }
}

/// Node-states per second.
fn rate<T: AftReal>(set: &HarmonicSet, settings: AftSettings, want: Want) -> f64 {
    let plan = AftPlan::<T>::new(set, settings);
    let batch = batch::<T>(set, N_STATES);
    let (mut scratch, mut out) = (AftScratch::default(), AftForces::default());
    let time = |first: usize| {
        let part = part(&batch, first);
        let (plan, part) = (black_box(&plan), black_box(&part));
        fastest(|| evaluate(plan, part, want, &mut scratch, &mut out))
    };
    N_STATES as f64 / (0..N_STATES).step_by(PART).map(time).sum::<f64>()
}

/// The states from `first` on.
fn part<T: Real>(batch: &AftBatch<T>, first: usize) -> AftBatch<T> {
    let rows = batch.displacement.chunks_exact(batch.n_states);
    AftBatch {
        n_states: PART,
        displacement: rows.flat_map(|row| row[first..][..PART].to_vec()).collect(),
        parameters: batch.parameters[first..][..PART].to_vec(),
    }
}

/// Shortest time of several runs (s).
fn fastest(mut run: impl FnMut()) -> f64 {
    let time = |run: &mut dyn FnMut()| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..RUNS)
        .map(|_| time(&mut run))
        .fold(f64::INFINITY, f64::min)
}

/// Independent sums that hide the time of one fused multiply-add.
const SUMS: usize = 12;
const STEPS: usize = 200_000;

struct MultiplyAdds;

impl WithSimd for MultiplyAdds {
    /// Operations.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let factor = simd.splat_f64s(black_box(0.999_999));
        let term = simd.splat_f64s(black_box(1e-6));
        let mut sums = [simd.splat_f64s(black_box(1.0)); SUMS];
        for _ in 0..STEPS {
            for sum in &mut sums {
                *sum = simd.mul_add_f64s(*sum, factor, term);
            }
        }
        for sum in sums {
            black_box(simd.reduce_sum_f64s(sum));
        }
        (2 * SUMS * STEPS * S::F64_LANES) as f64
    }
}

/// Operations per second of one core.
fn fused_multiply_add_peak() -> f64 {
    let mut operations = 0.0;
    let fastest = fastest(|| operations = Arch::new().dispatch(MultiplyAdds));
    operations / fastest
}

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

/// A double-precision number that counts operations.
#[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd)]
struct Counted(f64);

/// Counts one operation.
fn counted(x: f64) -> Counted {
    OPERATIONS.set(OPERATIONS.get() + 1);
    Counted(x)
}

/// Operations per state of an evaluation; sizes that the lanes divide, so that none is done twice.
fn operations(set: &HarmonicSet, settings: AftSettings, want: Want) -> f64 {
    const N: usize = 64;
    let plan = AftPlan::<Counted>::new(set, settings);
    let batch = batch::<Counted>(set, N);
    let mut out = AftForces::default();
    OPERATIONS.set(0);
    evaluate(&plan, &batch, want, &mut AftScratch::default(), &mut out);
    OPERATIONS.get() as f64 / N as f64
}

macro_rules! counted_operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                let result = self.0 $operator other.0;
                if self.0 == 0.0 || other.0 == 0.0 {
                    Self(result)
                } else {
                    counted(result)
                }
            }
        }
    };
}

counted_operator!(Add, add, +);
counted_operator!(Sub, sub, -);
counted_operator!(Mul, mul, *);
counted_operator!(Div, div, /);

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counted {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl AftReal for Counted {}

impl Real for Counted {
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);
    const EPSILON: Self = Self(f64::EPSILON);

    fn from_f64(x: f64) -> Self {
        Self(x)
    }

    fn to_f64(self) -> f64 {
        self.0
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn sqrt(self) -> Self {
        counted(self.0.sqrt())
    }

    fn sine_cosine(self) -> (Self, Self) {
        let (sin, cos) = self.0.sine_cosine();
        (Self(sin), Self(cos))
    }

    fn table_product<S: Simd, const W: usize>(
        _: S,
        table: &[Self],
        x: &[[Self; W]],
        out: &mut [[Self; W]],
        onto: bool,
    ) {
        for (row, out) in table.chunks_exact(x.len()).zip(out) {
            if !onto {
                *out = [Self::ZERO; W];
            }
            for (&factor, x) in row.iter().zip(x) {
                for (out, &x) in out.iter_mut().zip(x) {
                    *out += factor * x;
                }
            }
        }
    }
}
