use microslip::aft::*;
use microslip::contact::*;
use microslip::ensemble::atlas::*;
use microslip::ensemble::*;
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::PeakSettings;
use microslip::hb::resonance::Band;
use microslip::hb::*;
use microslip::sampling::*;
use microslip::study::Study;
use std::path::Path;
use std::time::Instant;
fn main() {
    let n: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let path = Path::new("tests/reference/blades-strip-oop/study.toml");
    let study = Study::read(path).unwrap();
    let model = study.build_model().unwrap();
    let linear = LinearModel::new(&model.reduced).unwrap();
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(5),
        aft: AftSettings {
            n_time: 256,
            law: FrictionLaw::Circle,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        alert: None,
        ..study.solver.clone()
    };
    let new = |shape| Distribution::new(shape, None).unwrap();
    let factor = || Shape::LogUniform {
        low: 0.1,
        high: 10.0,
    };
    let mu = Shape::Uniform {
        low: 0.1,
        high: 0.9,
    };
    let design = Design::new(
        3,
        vec![
            (Input::NormalStiffnessScale, new(factor())),
            (Input::TangentialStiffnessScale, new(factor())),
            (Input::FrictionCoefficient, new(mu)),
        ],
    )
    .unwrap();
    let [low, high] = study.frequency.band;
    let e = Ensemble {
        linear: &linear,
        contacts: &model.contacts,
        interfaces: &[],
        load_modes: &[],
        design: &design,
        levels: &[0.5],
        settings: &settings,
        peak: PeakSettings {
            band: Band { low, high },
            frequency_tolerance: 1e-6,
        },
        curve_samples: 0,
        backend: Backend::Cpu,
    };
    // serial with the generations of the runner
    let mut atlas = Atlas::default();
    let mut anchors: Vec<Anchor> = vec![];
    let mut first = 0u64;
    let mut times = vec![];
    while first < n {
        let end = (if first == 0 { 8 } else { 2 * first }).min(n);
        for i in first..end {
            let t = Instant::now();
            let (o, a) = e.sample(i, &atlas);
            let s = t.elapsed().as_secs_f64();
            let l = &o.levels[0];
            let p = l.peak.as_ref();
            println!(
                "{i} {:.3} s {} f {} it {:?} stick {:.2} slip {:.2} sep {:.3} f {:.3} a {:.3e} res {:.1e} | {:?}",
                s,
                l.factorizations,
                l.newton_iterations,
                l.status,
                p.map_or(0., |p| p.stick_fraction),
                p.map_or(0., |p| p.slip_fraction),
                p.map_or(0., |p| p.separated_fraction),
                p.map_or(0., |p| p.frequency_hz),
                p.map_or(0., |p| p.amplitude_m),
                p.map_or(0., |p| p.residual),
                o.inputs
            );
            times.push(s);
            anchors.push(a);
        }
        atlas.extend(anchors[first as usize..].iter().cloned());
        first = end;
    }
    let late = &times[times.len() / 2..];
    println!(
        "mean {:.3}, second half {:.3}",
        times.iter().sum::<f64>() / times.len() as f64,
        late.iter().sum::<f64>() / late.len() as f64
    );
}
