use microslip::aft::*;
use microslip::contact::*;
use microslip::harmonics::HarmonicSet;
use microslip::hb::newton::*;
use microslip::hb::peak::PeakSettings;
use microslip::hb::resonance::Band;
use microslip::hb::track::track_peaks;
use microslip::hb::*;
use microslip::model::two_blade::{self, TwoBladeSettings};
use std::f64::consts::TAU;
use std::time::Instant;
fn time<T>(name: &str, n: usize, mut f: impl FnMut() -> T) {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let t = Instant::now();
        for _ in 0..n {
            std::hint::black_box(f());
        }
        best = best.min(t.elapsed().as_secs_f64() / n as f64);
    }
    println!("{name}: {:.3} ms", best * 1e3);
}
fn main() {
    let h: usize = std::env::args().nth(1).map_or(5, |x| x.parse().unwrap());
    let nt: usize = std::env::args().nth(2).map_or(128, |x| x.parse().unwrap());
    let model = two_blade::build(&TwoBladeSettings::default())
        .unwrap()
        .reduced;
    let base = |scale: f64, mu: f64| {
        let e = 15.0 / scale;
        vec![
            ContactParameters {
                k_n: 1e9 / e,
                k_t: [2.33e8 / e; 2],
                mu,
                n_0: 0.0,
                anchor: [0.0; 2]
            };
            30
        ]
    };
    let lin = LinearModel::folded(&model, &base(1.0, 0.5))
        .unwrap()
        .unwrap();
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(h),
        aft: AftSettings {
            n_time: nt,
            law: FrictionLaw::Box,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        anchor: SliderAnchor::Unloaded,
        newton: NewtonSettings::default(),
        alert: None,
    };
    for scale in [0.3, 1.0, 5.0] {
        for level in [5.0, 20.0] {
            let p = Problem::new(
                &lin,
                base(scale, 0.4)[..15].to_vec(),
                1.0,
                SliderAnchor::Unloaded,
            )
            .unwrap();
            let peak = PeakSettings {
                band: Band {
                    low: 2605.0 * TAU,
                    high: 2635.0 * TAU,
                },
                frequency_tolerance: 3e-7,
            };
            let r = track_peaks(&p, &settings, peak, &[level]).unwrap();
            let s = r[0].solution.as_ref().unwrap();
            let b = Balance::new(&p, settings.harmonics.clone(), settings.aft);
            let it = Iterate::new(
                &b,
                Point {
                    r: s.relative.clone(),
                    omega: s.omega,
                    level,
                },
            );
            println!(
                "--- scale {scale} level {level} active {} of 15",
                it.contact.active.len()
            );
            time("compliance", 20, || b.compliance(s.omega));
            time("contact", 20, || {
                b.contact(&it.point.r, Want::ForcesAndTangents)
            });
            time("residual", 20, || {
                b.residual(&it.compliance, level, &it.point.r, &it.contact.force)
            });
            time("motion", 20, || {
                b.motion(&it.compliance, level, &it.point.r, &it.contact.force)
            });
            time("freq slope", 20, || {
                b.frequency_slope(&it.compliance, &it.motion)
            });
            time("jacobian new", 5, || it.jacobian(&b));
            let j = it.jacobian(&b);
            time("jacobian solve (after first)", 5, || j.solve(&it.residual));
            time("jacobian new+2 solves", 5, || {
                let j = it.jacobian(&b);
                j.solve(&it.residual);
                it.frequency_rate(&b, &j)
            });
        }
    }
}
