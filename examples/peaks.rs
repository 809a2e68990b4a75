use microslip::aft::*;
use microslip::contact::*;
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::PeakSettings;
use microslip::hb::resonance::Band;
use microslip::hb::track::track_peaks;
use microslip::hb::*;
use microslip::model::two_blade::{self, TwoBladeSettings};
use std::f64::consts::TAU;
use std::time::Instant;
fn main() {
    let h: usize = std::env::args().nth(1).map_or(5, |x| x.parse().unwrap());
    let n: usize = std::env::args().nth(2).map_or(12, |x| x.parse().unwrap());
    let nt: usize = std::env::args().nth(3).map_or(128, |x| x.parse().unwrap());
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
    let levels = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0];
    let mut its = vec![vec![]; 7];
    let mut facs = vec![vec![]; 7];
    let mut fails = 0;
    let t = Instant::now();
    for i in 0..n {
        let u = ((i as f64 + 0.5) * 0.618034).fract();
        let v = ((i as f64 + 0.5) * 0.7548776).fract();
        let scale = 10f64.powf(2.0 * u - 1.0);
        let mu = 0.1 + 0.7 * v;
        let c = base(scale, mu)[..15].to_vec();
        let p = Problem::new(&lin, c, 1.0, SliderAnchor::Unloaded).unwrap();
        let peak = PeakSettings {
            band: Band {
                low: 2605.0 * TAU,
                high: 2635.0 * TAU,
            },
            frequency_tolerance: 3e-7,
        };
        let t0 = Instant::now();
        let r = track_peaks(&p, &settings, peak, &levels).unwrap();
        let mut line = format!(
            "{scale:.3} {mu:.2} {:.0}ms ",
            t0.elapsed().as_secs_f64() * 1e3
        );
        for (k, l) in r.iter().enumerate() {
            its[k].push(l.count.iterations);
            facs[k].push(l.count.factorizations);
            if l.solution.is_none() {
                fails += 1;
                line += &format!("[{} {:?}]", l.level, l.status);
            }
            line += &format!(" {}/{}", l.count.iterations, l.count.factorizations);
            if std::env::var("V").is_ok() {
                if let Some(s) = &l.solution {
                    line += &format!(" ({:.7} {:.9e})", s.omega / TAU, s.amplitude(0) / l.level);
                }
            }
        }
        println!("{line}");
    }
    let total = t.elapsed().as_secs_f64();
    for k in 0..7 {
        its[k].sort();
        facs[k].sort();
        println!(
            "{} N median its {} facs {} p95 {}",
            levels[k],
            its[k][n / 2],
            facs[k][n / 2],
            facs[k][n * 95 / 100]
        );
    }
    println!(
        "per peak {:.1} ms, fails {fails}",
        total * 1e3 / (7 * n) as f64
    );
}
