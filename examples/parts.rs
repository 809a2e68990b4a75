use microslip::aft::*;
use microslip::contact::*;
use microslip::harmonics::HarmonicSet;
use microslip::hb::newton::Iterate;
use microslip::hb::peak::PeakSettings;
use microslip::hb::resonance::Band;
use microslip::hb::track::track_peaks;
use microslip::hb::*;
use microslip::study::Study;
use std::path::Path;
use std::time::Instant;
fn ms(n: usize, mut f: impl FnMut()) -> f64 {
    (0..n)
        .map(|_| {
            let t = Instant::now();
            f();
            t.elapsed().as_secs_f64() * 1e3
        })
        .fold(1e9, f64::min)
}
fn main() {
    let study = Study::read(Path::new("tests/reference/blades-strip-oop/study.toml")).unwrap();
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
    let [low, high] = study.frequency.band;
    for (kn, kt, mu) in [
        (1., 1., 0.6),
        (0.2, 5.0, 0.2),
        (5., 0.3, 0.4),
        (3., 3., 0.7),
    ] {
        let contacts: Vec<_> = model
            .contacts
            .iter()
            .map(|c| ContactParameters {
                k_n: kn * c.k_n,
                k_t: [kt * c.k_t[0], kt * c.k_t[1]],
                mu,
                ..*c
            })
            .collect();
        let problem = Problem::new(&linear, contacts, 1.0, settings.anchor).unwrap();
        let peak = &track_peaks(
            &problem,
            &settings,
            PeakSettings {
                band: Band { low, high },
                frequency_tolerance: 1e-6,
            },
            &[0.5],
        )
        .unwrap()[0];
        let Some(s) = &peak.solution else {
            println!("none {:?}", peak.status);
            continue;
        };
        let balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
        let at = Iterate::new(&balance, s.point());
        let jac = at.jacobian(&balance);
        println!(
            "active {} compliance {:.2} contact {:.2} (forces {:.2}) motion {:.2} jacobian {:.2} solve {:.2} rate {:.2}",
            at.contact.active.len(),
            ms(5, || drop(balance.compliance(at.point.omega))),
            ms(5, || drop(balance.contact(
                &at.point.r,
                Want::ForcesAndTangents,
                Accuracy::Full
            ))),
            ms(5, || drop(balance.contact(
                &at.point.r,
                Want::Forces,
                Accuracy::Full
            ))),
            ms(5, || drop(balance.motion(
                &at.compliance,
                0.5,
                &at.point.r,
                &at.contact.force
            ))),
            ms(3, || drop(at.jacobian(&balance))),
            ms(3, || drop(jac.solve(&at.residual))),
            ms(3, || drop(at.frequency_rate(&balance, &jac)))
        );
    }
}
