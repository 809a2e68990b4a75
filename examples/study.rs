use microslip::aft::*;
use microslip::contact::*;
use microslip::ensemble::Ensemble;
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::PeakSettings;
use microslip::hb::resonance::Band;
use microslip::hb::*;
use microslip::model::two_blade::{self, TwoBladeSettings};
use microslip::sampling::*;
use std::f64::consts::TAU;
use std::time::Instant;
fn main() {
    let h: usize = std::env::args().nth(1).map_or(5, |x| x.parse().unwrap());
    let n: u64 = std::env::args().nth(2).map_or(128, |x| x.parse().unwrap());
    let nt: usize = std::env::args().nth(3).map_or(128, |x| x.parse().unwrap());
    let alert = std::env::args().nth(4).map(|x| AlertSettings {
        threshold: 0.01,
        highest_harmonic: x.parse().unwrap(),
    });
    let model = two_blade::build(&TwoBladeSettings::default())
        .unwrap()
        .reduced;
    let e = 15.0;
    let base = vec![
        ContactParameters {
            k_n: 1e9 / e,
            k_t: [2.33e8 / e; 2],
            mu: 0.6,
            n_0: 0.0,
            anchor: [0.0; 2]
        };
        30
    ];
    let lin = LinearModel::folded(&model, &base).unwrap().unwrap();
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
        alert,
    };
    let levels = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0];
    let design = Design::new(
        2026,
        vec![
            (
                Input::StiffnessScale,
                Distribution::new(
                    Shape::LogUniform {
                        low: 0.1,
                        high: 10.0,
                    },
                    None,
                )
                .unwrap(),
            ),
            (
                Input::FrictionCoefficient,
                Distribution::new(
                    Shape::Uniform {
                        low: 0.1,
                        high: 0.8,
                    },
                    None,
                )
                .unwrap(),
            ),
        ],
    )
    .unwrap();
    let ens = Ensemble {
        linear: &lin,
        contacts: &base[..15],
        design: &design,
        levels: &levels,
        settings: &settings,
        peak: PeakSettings {
            band: Band {
                low: 2605.0 * TAU,
                high: 2635.0 * TAU,
            },
            frequency_tolerance: 3e-7,
        },
        curve_samples: 0,
    };
    let t = Instant::now();
    let cpu0 = cpu();
    let marks = std::sync::Mutex::new((0u64, vec![]));
    let out = ens.run(n, || {
        let mut m = marks.lock().unwrap();
        m.0 += 1;
        if m.0.is_power_of_two() && m.0 >= 16 {
            let k = m.0;
            m.1.push((k, t.elapsed().as_secs_f64(), cpu() - cpu0));
        }
    });
    for w in marks.lock().unwrap().1.windows(2) {
        println!(
            "samples {}..{}: {:.1} ms CPU per peak, {:.1} ms wall",
            w[0].0,
            w[1].0,
            (w[1].2 - w[0].2) * 1e3 / ((w[1].0 - w[0].0) * 7) as f64,
            (w[1].1 - w[0].1) * 1e3 / ((w[1].0 - w[0].0) * 7) as f64
        );
    }
    for (k, l) in levels.iter().enumerate() {
        for (name, range) in [
            ("first", 0..32usize.min(out.len())),
            ("rest", 32.min(out.len())..out.len()),
        ] {
            if range.is_empty() {
                continue;
            }
            let mut f: Vec<usize> = out[range.clone()]
                .iter()
                .map(|o| o.levels[k].factorizations)
                .collect();
            f.sort();
            let fail = out[range.clone()]
                .iter()
                .filter(|o| o.levels[k].peak.is_none())
                .count();
            let m = f.len();
            println!(
                "{l} N {name}: facs median {} p90 {} p95 {} max {}  fails {fail}",
                f[m / 2],
                f[m * 9 / 10],
                f[m * 95 / 100],
                f[m - 1]
            );
        }
    }
    if std::env::var("V").is_ok() {
        for o in &out {
            for l in &o.levels {
                if l.factorizations > 25 || l.peak.is_none() {
                    println!(
                        "{} {:?} {} N {:?} its {} facs {}",
                        o.index, o.inputs, l.level, l.status, l.newton_iterations, l.factorizations
                    );
                }
            }
        }
    }
    println!(
        "total {:.1} s wall {:.1} s cpu",
        t.elapsed().as_secs_f64(),
        cpu() - cpu0
    );
}
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let v: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (v[11].parse::<f64>().unwrap() + v[12].parse::<f64>().unwrap()) / 100.0
}
