//! Verification of `contact`: closed forms of the contact law through the batch evaluation, and bounds of single steps.

use super::aft::{State, forces_of, relative_difference, settings};
use microslip::aft::Laps;
use microslip::contact::law::{
    anchored_at_closing, box_step, circle_step, closing_instant, normal_force,
};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One state with u₁ = `cosine` cos θ, v = v_mean + v_cosine cos θ and no second direction.
fn one_direction(set: &HarmonicSet, cosine: f64, v: [f64; 2], p: ContactParameters<f64>) -> State {
    let m = set.n_coefficients();
    let mut q = vec![0.0; 3 * m];
    q[1] = cosine;
    (q[2 * m], q[2 * m + 1]) = (v[0], v[1]);
    State { q, p }
}

/// Points per period that suffice for located events.
const FEW: usize = 24;

const LAWS_AND_EVENTS: [(FrictionLaw, Events); 3] = [
    (FrictionLaw::Box, Events::Sampled),
    (FrictionLaw::Circle, Events::Sampled),
    (FrictionLaw::Box, Events::Located),
];

const NO_STIFFNESS: ContactParameters<f64> = ContactParameters {
    k_n: 0.0,
    k_t: [0.0; 2],
    mu: 0.0,
    n_0: 0.0,
    anchor: [0.0; 2],
};

/// Slope of log(error) over −log(points).
fn order_of_convergence(points: &[usize], error: impl Fn(usize) -> f64) -> f64 {
    let x: Vec<f64> = points.iter().map(|&n| -(n as f64).ln()).collect();
    let y: Vec<f64> = points.iter().map(|&n| error(n).ln()).collect();
    let mean = |z: &[f64]| z.iter().sum::<f64>() / z.len() as f64;
    let (mx, my) = (mean(&x), mean(&y));
    let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx) * (x - mx)).sum::<f64>()
}

/// ∫_a^b e^{ikt} dt.
fn phasor_integral(k: f64, a: f64, b: f64) -> [f64; 2] {
    if k == 0.0 {
        [b - a, 0.0]
    } else {
        [
            ((k * b).sin() - (k * a).sin()) / k,
            ((k * a).cos() - (k * b).cos()) / k,
        ]
    }
}

/// Cosine and sine coefficient of odd harmonic h of a Jenkins element under X cos θ (k_t, X, mu N given): slip-free
/// unloading from mu N to −mu N until cos θ* = 1 − 2 mu N/(k_t X), then slip; T(θ + π) = −T(θ).
fn jenkins_coefficients(k_t: f64, x: f64, limit: f64, h: f64) -> [f64; 2] {
    let end = (1.0 - 2.0 * limit / (k_t * x)).acos();
    let terms = [
        (limit - k_t * x, phasor_integral(-h, 0.0, end)),
        (k_t * x / 2.0, phasor_integral(1.0 - h, 0.0, end)),
        (k_t * x / 2.0, phasor_integral(-1.0 - h, 0.0, end)),
        (-limit, phasor_integral(-h, end, std::f64::consts::PI)),
    ];
    let total = |i: usize| -> f64 { terms.iter().map(|(f, z)| f * z[i]).sum() };
    let scale = 2.0 / std::f64::consts::PI;
    // T = Re Σ C e^{ihθ}: sine coefficient −Im C.
    [scale * total(0), -scale * total(1)]
}

/// Jenkins element with constant normal load (closed form of its Fourier coefficients and of the dissipated work).
/// Seen to fail with: the slider left where it was after slip.
#[test]
fn jenkins_element_matches_its_fourier_series() {
    let set = HarmonicSet::up_to(5);
    let (k_t, x, limit) = (1.5, 2.0, 1.0);
    let p = ContactParameters {
        k_t: [k_t, 0.0],
        mu: 0.5,
        n_0: limit / 0.5,
        ..NO_STIFFNESS
    };
    let state = one_direction(&set, x, [0.0; 2], p);
    let exact: Vec<[f64; 2]> = (0..3)
        .map(|i| jenkins_coefficients(k_t, x, limit, 2.0 * f64::from(i) + 1.0))
        .collect();
    assert!(
        (exact[0][0] - 0.875_374_217_4).abs() < 1e-9,
        "a1 {}",
        exact[0][0]
    );
    assert!(
        (exact[0][1] + 0.848_826_363_2).abs() < 1e-9,
        "b1 {}",
        exact[0][1]
    );
    for (law, events) in LAWS_AND_EVENTS {
        let error = |n: usize| {
            let s = settings(n, law, events, Laps::Periodic);
            let f = forces_of(&set, s, &state);
            let work = -std::f64::consts::PI * f[2] * x;
            let expected_work = 4.0 * limit * (x - limit / k_t);
            let mut worst = (work - expected_work).abs();
            for (i, e) in exact.iter().enumerate() {
                worst = worst
                    .max((f[4 * i + 1] - e[0]).abs())
                    .max((f[4 * i + 2] - e[1]).abs());
            }
            for even in [0, 3, 4, 7, 8] {
                worst = worst.max(f[even].abs());
            }
            worst
        };
        if events == Events::Located {
            assert!(error(FEW) < 1e-10, "located {:e}", error(FEW));
            continue;
        }
        assert!(error(16_384) < 1e-6, "{law:?} {:e}", error(16_384));
        let order = order_of_convergence(&[128, 256, 512, 1024, 2048, 4096, 8192], error);
        assert!((1.7..2.3).contains(&order), "{law:?}: order {order}");
    }
}

/// Unilateral spring under v_0 + V cos θ with |v_0| < V (closed form of the Fourier coefficients).
/// Seen to fail with: a bilateral spring.
#[test]
fn unilateral_spring_matches_its_fourier_series() {
    let set = HarmonicSet::up_to(4);
    let (k_n, v_0, v) = (2.0, 0.3, 1.0);
    let psi = f64::acos(-v_0 / v);
    let exact = |h: f64| {
        let pair = ((h + 1.0) * psi).sin() / (h + 1.0) + ((h - 1.0) * psi).sin() / (h - 1.0);
        2.0 * k_n / std::f64::consts::PI * (v_0 * (h * psi).sin() / h + v / 2.0 * pair)
    };
    let n_0 = k_n / std::f64::consts::PI * (v_0 * psi + v * psi.sin());
    let n_1 =
        k_n / std::f64::consts::PI * (2.0 * v_0 * psi.sin() + v * (psi + psi.sin() * psi.cos()));
    let exact = [n_0, n_1, exact(2.0), exact(3.0), exact(4.0)];
    let numbers = [
        0.965_488_57,
        1.376_162_34,
        0.368_426_58,
        -0.110_527_97,
        -0.033_895_25,
    ];
    assert!(relative_difference(&exact, &numbers) < 1e-8, "{exact:?}");
    // The mean approach may come from the displacement or from the preload.
    for (mean, preload) in [(v_0, 0.0), (0.0, k_n * v_0), (1.0, k_n * (v_0 - 1.0))] {
        let p = ContactParameters {
            k_n,
            n_0: preload,
            ..NO_STIFFNESS
        };
        let state = one_direction(&set, 0.0, [mean, v], p);
        let error_of = |n: usize, events| {
            let s = settings(n, FrictionLaw::Box, events, Laps::Periodic);
            let f = forces_of(&set, s, &state);
            let found: Vec<f64> = (0..5)
                .map(|h| f[18 + (2 * h as usize).saturating_sub(1)])
                .collect();
            relative_difference(&found, &exact)
        };
        let located = error_of(FEW, Events::Located);
        assert!(located < 1e-10, "located {located:e}");
        let error = |n| error_of(n, Events::Sampled);
        assert!(error(16_384) < 1e-7, "{:e}", error(16_384));
        let order = order_of_convergence(&[128, 256, 512, 1024, 2048, 4096, 8192], error);
        assert!((1.7..2.3).contains(&order), "order {order}");
    }
}

/// Normal load N_0 + N_v cos θ in phase with U cos θ: the loop is a polygon (Griffin and Menq, J. Vib. Acoust. 113,
/// 1991), whose area is the dissipated work. Seen to fail with: the limit mu n_0 in place of mu N.
#[test]
fn variable_normal_load_dissipates_the_area_of_the_polygon() {
    let set = HarmonicSet::up_to(1);
    let (k_t, u, mu, n_0, n_v) = (1.0, 2.0, 0.5, 1.0, 0.6);
    let x_1 = (k_t * u - 2.0 * mu * n_0 - mu * n_v) / (k_t * u + mu * n_v);
    let x_2 = (2.0 * mu * n_0 - mu * n_v - k_t * u) / (k_t * u - mu * n_v);
    let limit = |x: f64| mu * (n_0 + n_v * x);
    let corners = [
        (-1.0, -limit(-1.0)),
        (x_2, limit(x_2)),
        (1.0, limit(1.0)),
        (x_1, -limit(x_1)),
    ];
    let area: f64 = (0..4)
        .map(|i| {
            let ((xa, ya), (xb, yb)) = (corners[i], corners[(i + 1) % 4]);
            u * (xb * ya - xa * yb) / 2.0
        })
        .sum();
    assert!((area - 2.792_838_8).abs() < 1e-7, "area {area}");
    let p = ContactParameters {
        k_n: n_v,
        k_t: [k_t, 0.0],
        mu,
        n_0,
        anchor: [0.0; 2],
    };
    let state = one_direction(&set, u, [0.0, 1.0], p);
    for (law, events) in [
        (FrictionLaw::Box, Events::Interpolated),
        (FrictionLaw::Circle, Events::Interpolated),
        (FrictionLaw::Box, Events::Located),
        (FrictionLaw::Circle, Events::Located),
    ] {
        let error = |n: usize| {
            let s = settings(n, law, events, Laps::Periodic);
            let f = forces_of(&set, s, &state);
            (-std::f64::consts::PI * f[2] * u - area).abs()
        };
        if (law, events) == (FrictionLaw::Box, Events::Located) {
            assert!(error(FEW) < 1e-10, "located {:e}", error(FEW));
            continue;
        }
        assert!(error(16_384) < 1e-6, "{law:?} {:e}", error(16_384));
        let order = order_of_convergence(&[128, 256, 512, 1024, 2048, 4096, 8192], error);
        let expected = match events {
            Events::Located => 1.9..f64::INFINITY,
            _ => 1.7..2.3,
        };
        assert!(expected.contains(&order), "{law:?}: order {order}");
    }
}

/// Circular path of radius R under the circle law: W = 2 pi mu N √(R² − X_c²), X_c = mu N/k_t; first order in 1/Nt,
/// so two Richardson steps. Box law: two independent Jenkins loops, 8 mu N (R − X_c).
/// Seen to fail with: the laws exchanged.
#[test]
fn circular_path_dissipates_the_closed_form() {
    let set = HarmonicSet::up_to(1);
    let (radius, limit, k_t) = (2.0, 0.5, 1.0);
    let p = ContactParameters {
        k_t: [k_t; 2],
        mu: 0.5,
        n_0: limit / 0.5,
        ..NO_STIFFNESS
    };
    let mut state = one_direction(&set, radius, [0.0; 2], p);
    state.q[5] = radius;
    let work = |n: usize, law| {
        let s = settings(n, law, Events::Interpolated, Laps::Periodic);
        let f = forces_of(&set, s, &state);
        std::f64::consts::PI * radius * (f[4] - f[2])
    };
    let circle = std::f64::consts::TAU * limit * f64::sqrt(radius * radius - (limit / k_t).powi(2));
    assert!((circle - 6.083_668).abs() < 1e-6, "{circle}");
    let error = |n| (work(n, FrictionLaw::Circle) - circle).abs();
    let order = order_of_convergence(&[128, 256, 512, 1024, 2048, 4096], error);
    assert!((0.9..1.1).contains(&order), "order {order}");
    let [a, b, c] = [1024, 2048, 4096].map(|n| work(n, FrictionLaw::Circle));
    let extrapolated = (4.0 * (2.0 * c - b) - (2.0 * b - a)) / 3.0;
    assert!(
        (extrapolated / circle - 1.0).abs() < 1e-6,
        "{extrapolated} {circle}"
    );
    let located = |n| {
        let s = settings(n, FrictionLaw::Circle, Events::Located, Laps::Periodic);
        let f = forces_of(&set, s, &state);
        (std::f64::consts::PI * radius * (f[4] - f[2]) / circle - 1.0).abs()
    };
    assert!(located(128) < 1e-5, "located {:e}", located(128));
    let order = (located(32) / located(128)).ln() / 4f64.ln();
    assert!(order > 1.9, "located: order {order}");
    let boxed = 8.0 * limit * (radius - limit / k_t);
    assert!(
        (work(16_384, FrictionLaw::Box) / boxed - 1.0).abs() < 1e-6,
        "box"
    );
}

/// Random walks: 0 <= N, |T| <= mu N, T = k_t (u − w), no traction and a following slider while separated, and the
/// slider moves only when it slips. Seen to fail with: no lower limit in `box_step`.
#[test]
fn single_steps_respect_the_limits() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (k_t, mu) = ([0.7, 1.9], 0.4);
    let flexibility = k_t.map(|k: f64| 1.0 / k);
    let (mut boxed, mut circle) = ([0.0; 2], [0.0; 2]);
    for _ in 0..20_000 {
        let u: [f64; 2] = [rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0)];
        let normal = normal_force(rng.random_range(-1.0..3.0));
        assert!(normal >= 0.0, "pull {normal}");
        let limit = mu * normal;
        let round = 1e-15 * (1.0 + limit);
        for d in 0..2 {
            let path = k_t[d] * u[d];
            let (t, z) = box_step(limit, path, boxed[d]);
            assert!(t.abs() <= limit, "box {t} {limit}");
            assert!((t - (path - z)).abs() < 4.0 * round, "box slider");
            assert!(
                t.abs() == limit || z == boxed[d],
                "box slider moved in stick"
            );
            boxed[d] = z;
        }
        let step = circle_step(k_t, flexibility, limit, 0.0, u, circle);
        let size = step.traction[0].hypot(step.traction[1]);
        assert!(size <= limit + round, "circle {size} {limit}");
        for d in 0..2 {
            let implied = k_t[d] * (u[d] - step.slider[d]);
            assert!(
                (step.traction[d] - implied).abs() < 4.0 * round,
                "circle slider"
            );
            assert!(
                step.slips || step.slider[d] == circle[d],
                "circle slider moved in stick"
            );
        }
        circle = step.slider;
    }
}

/// The slider of a contact that closes at θ stands where the surface was then. Seen to fail with: 1 − θ in place of θ.
#[test]
fn closing_anchors_the_slider_at_the_interpolated_displacement() {
    let (before, now) = (-0.3_f64, 0.9);
    let instant = closing_instant(before, now);
    assert!(
        (before + instant * (now - before)).abs() < 1e-15,
        "gap at the instant {instant}"
    );
    assert!(
        (anchored_at_closing(2.0, 6.0, instant) - 3.0_f64).abs() < 1e-15,
        "anchor"
    );
    for (a, b) in [(0.2, 0.4), (0.2, -0.4), (-0.2, -0.4)] {
        assert_eq!(closing_instant(a, b), 0.0, "no closing from {a} to {b}");
    }
}
