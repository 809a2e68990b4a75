//! Several maxima in one band: the highest is the peak.

use super::invariants;
use super::models::aft;
use crate::response::{at_frequencies, over_band};
use crate::two_blade::{K_N, K_T, folded};
use faer::Mat;
use faer::linalg::solvers::Solve;
use faer::prelude::c64;
use microslip::aft::AftSettings;
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::ensemble::Ensemble;
use microslip::ensemble::outcome::SampleOutcome;
use microslip::harmonics::HarmonicSet;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::equations::balance::balance_on;
use microslip::hb::equations::free::StaticReference;
use microslip::hb::peak::anchored::{AnchorInverse, anchored};
use microslip::hb::peak::maxima::PeakChoice;
use microslip::hb::peak::predicted::PeakPrediction;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{Balance, HbSettings, Problem, SliderAnchor, Solution};
use microslip::model::{ReducedModel, SparseRow};
use microslip::study::Study;
use std::f64::consts::TAU;
use std::path::Path;

/// The study of `tests/reference/two-peaks-7dof` with some of its lines replaced.
fn study(changes: &[(&str, &str)]) -> Study {
    let path = Path::new("tests/reference/two-peaks-7dof/study.toml");
    let mut text = std::fs::read_to_string(path).expect("a file");
    for (old, new) in changes {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    Study::parse(path, &text).expect("a study")
}

/// First harmonic of response 0 per unit level of the stuck structure, by the matrices of the study.
struct Receptance {
    matrices: [Mat<f64>; 3],
    force: Vec<f64>,
    response: Vec<f64>,
    /// t1 of every pair with its stiffness (N/m).
    tangential: Vec<(SparseRow, f64)>,
}

/// Of every pair of the study; 50 N on either side of the strip, which two pairs hold at half of its motion.
const NORMAL_FORCE: f64 = 50.0;
const MU: f64 = 0.3;

impl Receptance {
    fn new(model: &ReducedModel, contacts: &[ContactParameters<f64>], scale: f64) -> Self {
        let n = model.mass.nrows();
        let mut stiffness = model.stiffness.clone();
        for (pair, contact) in model.contacts.iter().zip(contacts) {
            let springs = [
                (&pair.t1, contact.k_t[0]),
                (&pair.t2, contact.k_t[1]),
                (&pair.n, contact.k_n),
            ];
            for (row, k) in springs {
                for &(i, a) in row {
                    for &(j, b) in row {
                        stiffness[(i, j)] += scale * k * a * b;
                    }
                }
            }
        }
        let mut response = vec![0.0; n];
        (model.responses[0].row.iter()).for_each(|&(i, a)| response[i] = a);
        Self {
            matrices: [model.mass.clone(), model.damping.clone(), stiffness],
            force: model.cosine_force.clone(),
            response,
            tangential: (model.contacts.iter().zip(contacts))
                .map(|(pair, contact)| (pair.t1.clone(), scale * contact.k_t[0]))
                .collect(),
        }
    }

    /// q̂₁ per unit level.
    fn motion(&self, omega: f64) -> Vec<c64> {
        let [m, c, k] = &self.matrices;
        let n = m.nrows();
        let z = Mat::from_fn(n, n, |i, j| {
            c64::new(k[(i, j)] - omega * omega * m[(i, j)], omega * c[(i, j)])
        });
        let force = Mat::from_fn(n, 1, |i, _| c64::new(self.force[i], 0.0));
        let q = z.partial_piv_lu().solve(force);
        (0..n).map(|i| q[(i, 0)]).collect()
    }

    fn amplitude(&self, omega: f64) -> f64 {
        let q = self.motion(omega);
        let y = q.iter().zip(&self.response).map(|(q, r)| q * r);
        y.sum::<c64>().norm()
    }

    /// Whether no pair slips at this frequency (Hz) and level 1.
    fn sticks(&self, hz: f64) -> bool {
        let q = self.motion(hz * TAU);
        self.tangential.iter().all(|(row, k)| {
            let relative: c64 = row.iter().map(|&(i, a)| q[i] * a).sum();
            k * relative.norm() < MU * NORMAL_FORCE
        })
    }

    /// Frequency (Hz) and amplitude of all maxima between two frequencies, highest first.
    fn maxima(&self, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let step = 0.2;
        let at = |hz: f64| self.amplitude(hz * TAU);
        let grid: Vec<f64> = (0..=((high - low) / step) as usize)
            .map(|i| low + step * i as f64)
            .collect();
        let scan: Vec<f64> = grid.iter().map(|hz| at(*hz)).collect();
        let tops = (1..grid.len() - 1).filter(|&i| scan[i] > scan[i - 1] && scan[i] >= scan[i + 1]);
        let mut maxima: Vec<[f64; 2]> = tops
            .map(|i| {
                // golden section
                let ratio = 0.5 * (5f64.sqrt() - 1.0);
                let [mut a, mut b] = [grid[i - 1], grid[i + 1]];
                for _ in 0..60 {
                    let [c, d] = [b - ratio * (b - a), a + ratio * (b - a)];
                    if at(c) > at(d) { b = d } else { a = c }
                }
                [0.5 * (a + b), at(0.5 * (a + b))]
            })
            .collect();
        maxima.sort_by(|a, b| b[1].total_cmp(&a[1]));
        maxima
    }
}

fn bits(outcomes: &[SampleOutcome]) -> Vec<[u64; 4]> {
    let of = |o: &SampleOutcome| {
        let peak = o.levels[0].peak.expect("a peak");
        let others = o.levels[0].around.others();
        let next = others.first().map_or(0.0, |next| next.amplitude_m);
        let counts = u64::from(o.levels[0].factorizations) + 1000 * others.len() as u64;
        [
            peak.frequency_hz.to_bits(),
            peak.amplitude_m.to_bits(),
            next.to_bits(),
            counts,
        ]
    };
    outcomes.iter().map(of).collect()
}

/// The first ten samples have the same bits from one thread and where only ten are solved.
fn assert_alike_on_one_thread(ensemble: &Ensemble<'_>, outcomes: &[SampleOutcome]) {
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    let part = |samples| {
        let outcomes = ensemble.run(samples, || {});
        outcomes.into_iter().take(10).collect::<Vec<_>>()
    };
    assert_eq!(bits(outcomes), bits(&alone.install(|| part(10))), "threads");
}

/// Stuck, two near-equal maxima in the band: each sample of three seeds against the receptance, the peak and the maximum
/// next to it (very stiff contacts slip at one of them); the same bits from one thread and for fewer samples.
///
/// Seen to fail with the strongest stuck mode alone: 6 of the first 24 samples have the lower maximum, none another beside it; and, of
/// seed 3, without the second search of a mode whose prediction ends at the maximum of another: samples 10 and 18 lack one.
#[test]
fn the_highest_of_two_near_maxima_is_the_peak() {
    let mut errors = [0.0f64; 2];
    let (mut two, mut slipping) = (0, 0);
    for seed in 1..=3 {
        let study = study(&[
            ("[1.0, 50.0]", "[1.0]"),
            ("seed = 1", &format!("seed = {seed}")),
        ]);
        let prepared = study.prepared().expect("a model");
        let ensemble = prepared.ensemble(None);
        let outcomes = ensemble.run(24, || {});
        for outcome in &outcomes {
            let linear = Receptance::new(&prepared.reduced, &prepared.contacts, outcome.inputs[0]);
            let maxima = linear.maxima([700.0, 900.0]);
            let record = &outcome.levels[0];
            let peak = record.peak.expect("a peak");
            let competing = maxima.iter().filter(|top| top[1] > 0.6 * maxima[0][1]);
            if !competing.clone().all(|top| linear.sticks(top[0])) {
                // of two maxima one slips: the peak is no lower than the other
                slipping += 1;
                let stuck = competing.filter(|top| linear.sticks(top[0]));
                let highest = stuck.map(|top| top[1]).fold(0.0, f64::max);
                assert!(
                    peak.amplitude_m > highest * (1.0 - 1e-6),
                    "{outcome:?}: {maxima:?}"
                );
                continue;
            }
            assert_eq!(peak.stick_fraction, 1.0, "nothing slips");
            errors[0] = errors[0].max((peak.frequency_hz / maxima[0][0] - 1.0).abs());
            errors[1] = errors[1].max((peak.amplitude_m / maxima[0][1] - 1.0).abs());
            // where the other mode competes it is reported, too
            if maxima.len() > 1 && maxima[1][1] > 0.6 * maxima[0][1] {
                two += 1;
                let next = record.around.others().first().expect("a second maximum");
                errors[0] = errors[0].max((next.frequency_hz / maxima[1][0] - 1.0).abs());
                errors[1] = errors[1].max((next.amplitude_m / maxima[1][1] - 1.0).abs());
            }
            assert!(
                errors[0] < 1e-6 && errors[1] < 1e-6,
                "seed {seed}, {outcome:?}: {maxima:?}"
            );
        }
        if seed == 1 {
            assert_alike_on_one_thread(&ensemble, &outcomes[..10]);
            let sample_10 = outcomes[10].levels[0].peak.expect("a peak");
            assert!(
                (sample_10.frequency_hz - 824.02).abs() < 0.01,
                "{sample_10:?}"
            );
        }
    }
    println!("largest errors {errors:?}, {two} samples with two maxima, {slipping} slip");
    assert!(
        two > 40 && slipping < 24,
        "{two} samples with a second maximum, {slipping} slip"
    );
}

/// The strip is held by its contacts alone: where they all slip, nothing determines its mean position, and weak
/// springs hold it in the derivatives. Seen to fail without them: 15 of 24 samples are solved at level 50, 22 at level 1, the others end with
/// `non-finite` or `step-too-small`.
#[test]
fn a_strip_that_only_slipping_contacts_hold_is_solved() {
    let study = study(&[]);
    let prepared = study.prepared().expect("a model");
    let ensemble = Ensemble {
        curve_samples: 0,
        ..prepared.ensemble(None)
    };
    for outcome in ensemble.run(24, || {}) {
        for level in &outcome.levels {
            assert!(level.peak.is_some(), "{outcome:?}");
        }
    }
}

/// The peak is the top of the whole curve through the band, where nothing slips and where pairs do.
#[test]
fn the_peak_of_slipping_blades_is_the_top_of_the_curve() {
    let study = study(&[]);
    let prepared = study.prepared().expect("a model");
    let peak = prepared.ensemble(None).peak;
    let mut slips = 0;
    for (scale, level) in [(0.4, 8.0), (1.0, 50.0)] {
        let contacts = prepared.contacts.iter().map(|c| ContactParameters {
            k_n: scale * c.k_n,
            k_t: c.k_t.map(|k| scale * k),
            ..*c
        });
        let problem = Problem::new(
            &prepared.linear,
            contacts.collect(),
            1.0,
            SliderAnchor::Unloaded,
        );
        let problem = problem.expect("held");
        let found = track_peaks(&problem, &study.solver, peak, &[level]).expect("modes");
        let solution = found[0].solution.as_ref().expect("a peak");
        slips += usize::from(solution.contact.slip > 0.0);
        let curve = over_band(&problem, &study.solver, level, peak.band);
        let solved = curve.iter().filter(|s| s.status.has_solution());
        let top = solved.map(|s| s.amplitude(0)).fold(0.0, f64::max);
        let end = curve.last().map(|s| s.omega);
        let share = top / solution.amplitude(0);
        println!(
            "{scale}: {:.2} Hz, top {share}, {} points",
            solution.omega / TAU,
            curve.len()
        );
        assert!(end >= Some(peak.band.high * 0.999), "the curve ends early");
        assert!(share < 1.0 + 1e-3 && share > 0.97, "{share}");
    }
    assert!(slips > 0, "nothing slips");
}

/// At 5 N this pair of blades has a flat top, and a contact bends the curve beside it: two maxima 0.14 Hz and 1.2e-4 of the amplitude
/// apart. `look` is given the equations, where to search, and a dense sweep through both.
fn on_a_flat_top(look: impl FnOnce(&Balance<'_>, &HbSettings, PeakSettings, &[Solution])) {
    let (scale, mu) = (1.3688363656047002, 0.11973887406030667);
    let (linear, mut contacts) = folded(1.0, mu);
    // in this case the pairs share the stiffness equally
    let share = scale / contacts.len() as f64;
    for contact in &mut contacts {
        (contact.k_n, contact.k_t) = (share * K_N, [share * K_T; 2]);
    }
    let problem = Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held");
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(5),
        aft: AftSettings {
            events: Events::Located,
            ..aft(128, FrictionLaw::Box)
        },
        ..invariants::settings(5, FrictionLaw::Box)
    };
    let search = PeakSettings {
        band: Band {
            low: TAU * 2605.0,
            high: TAU * 2635.0,
        },
        frequency_tolerance: 1e-9,
    };
    let omega: Vec<f64> = (0..60)
        .map(|i| TAU * (2625.9 + 0.01 * f64::from(i)))
        .collect();
    let swept = at_frequencies(&problem, &settings, 5.0, &omega, SweepDirection::Upward);
    let balance = balance_on(&problem, settings.harmonics.clone(), &settings);
    look(&balance, &settings, search, &swept);
}

/// Numbers of the two maxima of a sweep, and the largest amplitude (m).
fn tops(swept: &[Solution]) -> (Vec<usize>, f64) {
    let height: Vec<f64> = swept.iter().map(|s| s.amplitude(0)).collect();
    let tops: Vec<usize> = (1..height.len() - 1)
        .filter(|&i| height[i] > height[i - 1] && height[i] > height[i + 1])
        .collect();
    assert_eq!(tops.len(), 2, "maxima of the sweep at {tops:?}");
    (tops, height.iter().copied().fold(0.0, f64::max))
}

/// The peak is the highest point of the sweep.
/// Seen to fail without the search beside flat maxima: the track ends at the lower one.
#[test]
fn the_higher_of_two_maxima_on_a_flat_top_is_the_peak() {
    on_a_flat_top(|balance, settings, search, swept| {
        let found = track_peaks(balance.problem, settings, search, &[5.0]).expect("modes");
        let peak = found[0].solution.as_ref().expect("a peak");
        let (_, highest) = tops(swept);
        let share = peak.amplitude(0) / highest - 1.0;
        assert!((0.0..1e-5).contains(&share), "{share:e}");
    });
}

/// So it is from a prediction at either maximum, with the inverse Jacobian there.
/// Seen to fail with the higher maximum left where it is: the lower one is 1.2e-4 below.
#[test]
fn the_higher_maximum_is_found_with_an_inverse_too() {
    on_a_flat_top(|balance, settings, search, swept| {
        let (tops, highest) = tops(swept);
        let reference = &StaticReference::new(balance.problem);
        for top in tops {
            let start = PeakPrediction::of(&swept[top]);
            let inverse = AnchorInverse::inverse_at(reference, balance, &start.point);
            let anchor = AnchorInverse {
                reference,
                inverse: &inverse.expect("an inverse"),
            };
            let found = anchored(balance, anchor, start, search, settings.newton).expect("a peak");
            let height = found.iterate.response(balance).norm();
            let share = height / highest - 1.0;
            assert!((0.0..1e-5).contains(&share), "from top {top}: {share:e}");
        }
    });
}

/// A mode is named by its number among the stuck frequencies, where it alone is followed and where all are. Seen to fail with the number of
/// another mode.
#[test]
fn a_named_mode_is_followed() {
    let named = |peak: &str| {
        let band = "band_hz = [700, 900]";
        study(&[
            ("[1.0, 50.0]", "[1.0]"),
            (band, &format!("{band}\npeak = {peak}")),
        ])
    };
    let nominal = |study: &Study| {
        let prepared = study.prepared().map_err(|error| error.to_string())?;
        let contacts = prepared.contacts.clone();
        let frequencies = prepared
            .reduced
            .stuck_frequencies(&contacts)
            .expect("modes");
        let ensemble: Ensemble<'_> = prepared.ensemble(None);
        let nominal = ensemble.nominal();
        let found = &nominal.levels[0];
        let peak = found.peak.expect("a peak");
        Ok::<_, String>((
            ensemble.choice,
            (peak, found.around.others().to_vec()),
            found.around.modes().cloned(),
            frequencies,
        ))
    };
    let (choice, (highest, others), modes, stuck) = nominal(&named("\"all\"")).expect("a study");
    let modes = modes.expect("modes of all maxima");
    assert_eq!((choice, modes.unfinished), (PeakChoice::All, 0));
    assert!(!others.is_empty(), "another maximum");
    let mut found = Vec::new();
    for (number, omega) in (1..).zip(stuck) {
        let hz = omega / TAU;
        match nominal(&named(&number.to_string())) {
            Ok((_, (peak, _), none, _)) => {
                assert_eq!(none, None, "one mode is followed");
                assert!((peak.frequency_hz / hz - 1.0).abs() < 3e-3, "{hz} {peak:?}");
                found.push((number, peak.frequency_hz));
            }
            Err(message) => {
                println!("{message}");
                assert!(!(700.0..900.0).contains(&hz), "{hz}");
                assert!(
                    message.contains("study.toml:") && message.contains("frequency.peak"),
                    "{message}"
                );
            }
        }
    }
    let all = [highest.frequency_hz].into_iter();
    let all = all.chain(others.iter().map(|other| other.frequency_hz));
    assert_eq!(modes.of_maxima.len(), 1 + others.len());
    for (hz, of) in all.zip(&modes.of_maxima) {
        let same = |(number, f): &(u32, f64)| *number == of.number && (f / hz - 1.0).abs() < 1e-8;
        assert!(found.iter().any(same), "{hz} {of:?} {found:?}");
    }
}
