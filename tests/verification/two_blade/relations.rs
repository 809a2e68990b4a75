//! What is published of the rig in words and numbers, and what the built-in one gives: Gastaldi, Berruti & Gola 2018,
//! doi 10.1007/s40799-018-0248-z. `studies/two-blade-strip/README.md` has the table.

use super::{CLOSE_RIG, K_N, K_T, RIG, one_half, shift};
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::{Band, linear_resonance, linear_response};
use microslip::hb::{
    HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, Solution, StabilityScope,
    Status,
};
use microslip::model::two_blade::{TwoBladeModel, TwoBladeSettings, build};
use microslip::units::{hz_to_rad_s, rad_s_to_hz};
use std::sync::LazyLock;

/// A rig that the relations are asked of.
struct Rig {
    model: &'static TwoBladeModel,
    /// At [`LEVELS`], friction coefficient 0.6.
    peaks: Vec<Peak>,
    /// At 20 N, friction coefficient 0.1.
    weak_friction: Peak,
}

impl Rig {
    fn new(model: &'static TwoBladeModel) -> Self {
        println!("{:?} points per interface", model.settings.contact_nodes);
        let [_, weak_friction] = peaks(model, 0.1, &[0.1, 20.0])
            .try_into()
            .expect("two levels");
        Self {
            model,
            peaks: peaks(model, 0.6, &LEVELS),
            weak_friction,
        }
    }

    /// By how much a friction coefficient of 0.6 lowers the peak at 20 N below that of 0.1.
    fn drop_by_friction(&self) -> f64 {
        1.0 - self.peaks[4].per_force / self.weak_friction.per_force
    }
}

static DEFAULT: LazyLock<Rig> = LazyLock::new(|| Rig::new(&RIG));

/// A rig whose interface has converged: 8 points across the gap change the amplitude at 5 N by 4 %, others by less, and still more along it that at
/// 20 N by 3 %.
static FINE: LazyLock<Rig> = LazyLock::new(|| Rig::new(&FINE_MODEL));
static FINE_MODEL: LazyLock<TwoBladeModel> = LazyLock::new(|| on_grid([5, 8], 1.0));

/// The same with as many points across the gap as along it.
static EVEN: LazyLock<Rig> = LazyLock::new(|| Rig::new(&EVEN_MODEL));
static EVEN_MODEL: LazyLock<TwoBladeModel> = LazyLock::new(|| on_grid([6, 6], 1.0));

/// About as many points as the default rig, closer at the gap.
static CLOSE: LazyLock<Rig> = LazyLock::new(|| Rig::new(&CLOSE_RIG));

/// The rig with as many points, and their spacing at the gap.
fn on_grid(contact_nodes: [usize; 2], contact_spacing_at_gap: f64) -> TwoBladeModel {
    let settings = TwoBladeSettings {
        contact_nodes,
        contact_spacing_at_gap,
        ..TwoBladeSettings::default()
    };
    build(&settings).expect("builds")
}

fn all() -> [&'static Rig; 4] {
    [&DEFAULT, &FINE, &EVEN, &CLOSE]
}

fn all_models() -> [&'static TwoBladeModel; 4] {
    [&RIG, &FINE_MODEL, &EVEN_MODEL, &CLOSE_RIG]
}

/// Published: about 7 Hz at nominal stiffness, twice that at ten times, next to nothing at a tenth. The strip bends over a
/// zone that widens as k^(-1/4), so that a tenth of the stiffness leaves a quarter of the shift, on any fine grid.
#[test]
fn stuck_shift_reproduces_the_published_relations() {
    let shifts = all_models().map(|rig| [0.1, 1.0, 10.0].map(|scale| shift(rig, scale)));
    for [soft, nominal, stiff] in shifts {
        let ratio = stiff / nominal;
        println!("shift {soft:.3} {nominal:.3} {stiff:.3} Hz, ratio {ratio:.3}");
        assert!((nominal - 7.0).abs() < 0.3, "nominal {nominal}");
        assert!((ratio - 2.0).abs() < 0.15, "ratio {ratio}");
        assert!(soft < 2.0, "soft {soft}");
    }
    let [default, fine, even, close] = shifts;
    for coarse in [default, close] {
        for (coarse, fine) in coarse.iter().zip(fine).chain(coarse.iter().zip(even)) {
            assert!((coarse / fine - 1.0).abs() < 0.05, "{coarse} {fine}");
        }
    }
}

/// Published, read as fractions: 0.003 in airfoil bending, 0.13 in neck bending.
/// Seen to fail: with the response point at the tip.
#[test]
fn relative_platform_motion_reproduces_the_published_ratios() {
    for rig in all_models() {
        let [first, second] = rig.relative_platform_motion();
        let ratio = |r: [f64; 3]| r.iter().map(|c| c * c).sum::<f64>().sqrt();
        println!(
            "ratios {:.5} {:.4}; per axis {first:.4?} {second:.4?}",
            ratio(first),
            ratio(second)
        );
        assert!((ratio(first) / 0.003 - 1.0).abs() < 0.2, "{first:?}");
        assert!((ratio(second) / 0.13 - 1.0).abs() < 0.1, "{second:?}");
        assert!(second[0] < 1e-9, "in phase, the platforms move alike in x");
    }
}

/// A resonance of the rig.
#[derive(Debug)]
struct Peak {
    /// Frequency over the free neck bending (Hz).
    shift: f64,
    /// Amplitude per unit force (um/N).
    per_force: f64,
    /// Largest amplitude of the first harmonic of a tangential relative displacement (um).
    relative: f64,
    /// Q factor.
    q_factor: f64,
}

/// At the levels that are published or between them, friction coefficient 0.6.
const LEVELS: [f64; 8] = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0, 300.0];

/// Band around the free neck bending.
fn band(rig: &TwoBladeModel) -> Band {
    let free = rig.free_neck_bending();
    Band {
        low: hz_to_rad_s(free - 8.0),
        high: hz_to_rad_s(free + 22.0),
    }
}

/// Peaks at the ascending `levels` (N), at nominal stiffness with 3 harmonics; each solve must converge.
fn peaks(rig: &TwoBladeModel, mu: f64, levels: &[f64]) -> Vec<Peak> {
    let (model, contacts) = one_half(&rig.reduced, 1.0, mu);
    let problem = Problem::new(&model, contacts, 1.0, SliderAnchor::Unloaded).expect("well posed");
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(3),
        aft: AftSettings {
            n_time: 128,
            law: FrictionLaw::Box,
            events: Events::Interpolated,
            laps: Laps::Periodic,
        },
        anchor: SliderAnchor::Unloaded,
        newton: NewtonSettings::default(),
        alert: None,
        stability: StabilityScope::Off,
    };
    let free = rig.free_neck_bending();
    let peak = PeakSettings {
        band: band(rig),
        frequency_tolerance: 3e-7,
    };
    let found = track_peaks(&problem, &settings, peak, levels).expect("definite");
    let reported = found.iter().map(|p| {
        // at 100 N the strip bounces, and the status says so
        let expected = if p.level < 80.0 {
            Status::Converged
        } else {
            Status::BouncingContact
        };
        assert_eq!(p.status, expected, "{} N", p.level);
        let solution = p.solution.as_ref().expect("converged");
        let shift = rad_s_to_hz(solution.omega) - free;
        let per_force = solution.amplitude(0) / p.level * 1e6;
        let peak = Peak {
            shift,
            per_force,
            relative: 1e6 * relative_amplitude(solution),
            q_factor: 0.5 / solution.damping_ratio().expect("dissipates"),
        };
        println!("mu {mu}: {} N {peak:.4?}", p.level);
        peak
    });
    reported.collect()
}

/// Largest amplitude of the first harmonic of a tangential relative displacement (m).
fn relative_amplitude(solution: &Solution) -> f64 {
    let n = solution.relative.len() / solution.harmonics.n_coefficients();
    let tangential = 0..2 * n / 3;
    let amplitude = |q: usize| solution.relative[n + q].hypot(solution.relative[2 * n + q]);
    tangential.map(amplitude).fold(0.0, f64::max)
}

/// Published: amplitude per force falls, then rises; the peak moves from the stuck frequency to the free one. Partial
/// lift-off may lift the amplitude by a few percent before slip sets in.
/// Seen to fail: with a friction coefficient of 0.1 (minimum already at 5 N).
#[test]
fn peaks_move_from_stuck_to_free_through_a_minimum_of_amplitude() {
    for rig in all() {
        let found = &rig.peaks;
        assert!(
            (found[0].shift - shift(rig.model, 1.0)).abs() < 0.05,
            "stuck at 0.1 N"
        );
        assert!(
            found.windows(2).all(|w| w[1].shift < w[0].shift + 1e-3),
            "frequency falls: {found:?}"
        );
        assert!(found[7].shift.abs() < 0.2, "nearly free at 300 N");
        let amplitude: Vec<f64> = found.iter().map(|f| f.per_force).collect();
        let fall = &amplitude[..5];
        assert!(
            fall.windows(2).all(|w| w[1] < 1.05 * w[0]) && fall[4] < 0.75 * fall[0],
            "falls to 20 N: {amplitude:?}"
        );
        assert!(
            amplitude[4..].windows(2).all(|w| w[1] > w[0]),
            "rises from 20 N: {amplitude:?}"
        );
    }
}

/// Published: about 50 % between friction coefficients 0.1 and 0.6 at 20 N, read as the drop from the weaker friction.
/// Seen to fail: at 50 N (17 %).
#[test]
fn friction_coefficient_lowers_the_peak_at_twenty_newton() {
    for rig in all() {
        let drop = rig.drop_by_friction();
        println!("drop {:.1} %", 100.0 * drop);
        assert!((0.33..=0.55).contains(&drop), "{drop}");
    }
}

/// What three points along the gap change of the amplitude: up to 5 % below 20 N and from 50 N on, and 13 % at 20 N, where friction lowers it most. More
/// points across it do not help.
/// Seen to fail with 5 x 4 points in place of 5 x 8 (6.5 %).
#[test]
fn three_points_along_the_gap_change_the_amplitude_at_twenty_newton() {
    let pairs = DEFAULT.peaks.iter().zip(&FINE.peaks);
    for ((default, fine), level) in pairs.zip(LEVELS) {
        let change = default.per_force / fine.per_force - 1.0;
        println!("{level} N: {:+.1} %", 100.0 * change);
        let allowed = if level == 20.0 {
            0.10..0.16
        } else {
            -0.05..0.05
        };
        assert!(allowed.contains(&change), "{level} N: {change}");
    }
    let across = on_grid([8, 3], 1.0);
    let across = peaks(&across, 0.6, &[0.1, 5.0, 20.0]);
    let change = across[2].per_force / DEFAULT.peaks[4].per_force - 1.0;
    assert!(change.abs() < 0.03, "{change}");
}

/// With 4 x 4 points that are closer at the gap the amplitudes are within 5 % of those of a converged interface, and so is what friction takes
/// from them at 20 N.
/// Seen to fail with the default grid (at 20 N) and, for the shift above, with 4 x 4 points of Gauss' rule itself (at 10 times the stiffness).
#[test]
fn points_closer_at_the_gap_are_within_five_percent_of_the_interface() {
    for fine in [&*FINE, &*EVEN] {
        let pairs = CLOSE.peaks.iter().zip(&fine.peaks);
        for ((close, fine), level) in pairs.zip(LEVELS) {
            let change = close.per_force / fine.per_force - 1.0;
            println!("{level} N: {:+.1} %", 100.0 * change);
            assert!(change.abs() < 0.05, "{level} N: {change}");
        }
        let [close, fine] = [&*CLOSE, fine].map(Rig::drop_by_friction);
        assert!((close / fine - 1.0).abs() < 0.05, "{close} {fine}");
    }
}

/// Published: nearly on the free curve at 300 N, where almost all points lift off; stuck at 0.1 N. Read of the amplitude: its
/// distance from the free one falls below a tenth.
#[test]
fn three_hundred_newton_are_nearly_free() {
    for rig in all() {
        let model = LinearModel::new(&rig.model.reduced).expect("definite");
        let open = vec![0.0; model.n_relative()];
        let free = linear_resonance(&model, &open, band(rig.model)).expect("definite");
        let free = free.expect("in the band").omega;
        let free = 1e6 * linear_response(&model, &open, free).norm();
        let last = rig.peaks[7].per_force;
        println!(
            "free {free:.4} um/N, 300 N {:.1} % below",
            100.0 * (1.0 - last / free)
        );
        assert!((last / free - 1.0).abs() < 0.1, "{last} against {free}");
    }
}

/// Published: relative displacements of about 5 um are expected in the test, at 180 N on a face of 10 x 50 mm. They are
/// below that where all sticks and where friction lowers the amplitude most (20 N), and beyond it near the free curve.
#[test]
fn relative_displacements_are_those_of_the_test() {
    let settings = TwoBladeSettings::default();
    let face = settings.strip_mm[0] * settings.strip_mm[1];
    let contact = 2.0 * settings.strip_overlap_mm() * settings.strip_mm[1];
    let pressure = [face, contact].map(|area| settings.centrifugal_load_n / area);
    println!("pressure {pressure:.3?} MPa of the whole face and of the contact");
    println!("stiffness ratio {}", K_T / K_N);
    assert!((pressure[0] - 0.36).abs() < 1e-12, "{pressure:?}");
    for Rig { peaks, .. } in all() {
        let relative = |i: usize| peaks[i].relative;
        assert!(
            relative(0) < 0.05 && relative(4) < 5.0 && relative(7) > 5.0,
            "{peaks:?}"
        );
    }
}

/// Published, by source of damping: material 3000 to 10000, platform damper 15 to 250. The rig's own damping is Q 2500.
#[test]
fn friction_lowers_the_q_factor() {
    for Rig { peaks, .. } in all() {
        let q: Vec<f64> = peaks.iter().map(|peak| peak.q_factor).collect();
        let lowest = q.iter().copied().fold(f64::INFINITY, f64::min);
        println!("Q {q:.0?}, lowest {lowest:.0}");
        assert!((1500.0..2600.0).contains(&q[0]), "stuck {}", q[0]);
        assert!(
            (0.9 * 2500.0..1.02 * 2500.0).contains(&q[7]),
            "nearly free {}",
            q[7]
        );
        assert!(lowest < 0.6 * q[0], "{q:?}");
    }
}
