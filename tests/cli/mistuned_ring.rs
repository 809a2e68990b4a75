//! Mistuned disks from the user's own sector against a direct solution of the whole ring, whose contacts stick.

use std::f64::consts::TAU;
use std::path::Path;

use faer::prelude::*;
use microslip::ensemble::outcome::SampleOutcome;
use microslip::ensemble::store::read_samples;
use microslip::hb::Status;

use super::succeed;

const SECTORS: usize = 6;
const ENGINE_ORDER: usize = 2;
/// S, square root of the stiffness (rad/s) of a sector of unit masses: a platform and a tip.
const ROOT: [[f64; 2]; 2] = [[20_000.0, -8_000.0], [-8_000.0, 8_000.0]];
const DAMPING_RATIO: f64 = 0.005;
/// Stiffness of the contact between platforms (N/m).
const CONTACT: f64 = 1e7;
/// Points of the band (Hz) at which the ring is solved.
const STEP_HZ: f64 = 0.05;

/// A ring of such sectors in a band.
#[derive(Clone, Copy)]
struct Case {
    /// Stiffness between a platform and the next one (N/m), beside the contact.
    coupling: f64,
    /// Whether the damping is stated by its matrix, 2 ζ S, not by ζ: the same where sectors are not coupled.
    by_matrix: bool,
    band_hz: [f64; 2],
}

fn product(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let entry = |i: usize, j: usize| (0..2).map(|k| a[i][k] * b[k][j]).sum();
    [0, 1].map(|i| [0, 1].map(|j| entry(i, j)))
}

/// The matrix of a sector as a file, with a spring to the next platform. Where sectors are coupled the third degree of freedom is the next
/// platform.
fn text(own: [[f64; 2]; 2], spring: f64, is_coupled: bool) -> String {
    let n = if is_coupled { 3 } else { 2 };
    let mut text = format!("%%MatrixMarket matrix array real general\n{n} {n}\n");
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let of_sector = if i < 2 && j < 2 { own[i][j] } else { 0.0 };
        let of_spring = match (i, j) {
            (1, _) | (_, 1) => 0.0,
            _ if i == j => spring,
            _ => -spring,
        };
        text += &format!("{}\n", of_sector + of_spring);
    }
    text
}

/// What `run` gives for every sample.
fn outcomes(folder: &Path, case: Case) -> Vec<SampleOutcome> {
    let unit = [[1.0, 0.0], [0.0, 1.0]];
    let damping = ROOT.map(|row| row.map(|x| 2.0 * DAMPING_RATIO * x));
    let (spring, is_coupled) = (case.coupling, case.coupling > 0.0);
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    write("mass.mtx", text(unit, 0.0, is_coupled));
    write(
        "stiffness.mtx",
        text(product(ROOT, ROOT), spring, is_coupled),
    );
    write("damping.mtx", text(damping, 0.0, is_coupled));
    let damping = match case.by_matrix {
        true => "damping = \"damping.mtx\"".to_owned(),
        false => format!("modal_damping_ratio = {DAMPING_RATIO}"),
    };
    let (names, boundary) = match is_coupled {
        true => (
            "\"platform\", \"tip\", \"right\"",
            "left = [\"platform\"]\nright = [\"right\"]\n",
        ),
        false => ("\"platform\", \"tip\"", ""),
    };
    let [low, high] = case.band_hz;
    let study = format!(
        "name = \"ring\"\nseed = 1\nsamples = 24\nlevels = [1.0]\n\
         [model]\nkind = \"cyclic\"\nsector = \"matrices\"\nsectors = {SECTORS}\nblade = [\"platform\", \"tip\"]\n\
         blade_frequency_scatter = 0.05\nmass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"\n{damping}\n\
         dof_names = [{names}]\n{boundary}cosine_force = {{ tip = 1.0 }}\nresponses = [\"tip\"]\n\
         [[model.contact]]\nname = \"gap\"\nt1 = {{ platform = 1.0, \"next:platform\" = -1.0 }}\nk_t1 = {CONTACT:e}\nmu = 0.5\nn_0 = 1e6\n\
         [solver]\nharmonics = 1\nalert = false\n[frequency]\nband_hz = [{low}, {high}]\n\
         [operation]\nspeed_rpm = [6000, 30000]\nengine_orders = [{ENGINE_ORDER}]\n[output]\ncurve_samples = 0\n"
    );
    write("study.toml", study);
    succeed(folder, &["run", "study.toml", "--quiet"]);
    let found = read_samples(&folder.join("results/samples.parquet")).unwrap();
    found.outcomes
}

/// The ring, tuned but for its contacts, and what they add.
struct Ring {
    /// K without contacts (N/m). Shape: 2 SECTORS square.
    stiffness: Mat<f64>,
    /// What the contacts add where they stick.
    contacts: Mat<f64>,
    /// 2 ζ K^(1/2), of unit masses.
    damping: Mat<f64>,
    /// Stiffness of a blade, held by its neighbours.
    blade: [[f64; 2]; 2],
}

impl Ring {
    fn new(coupling: f64) -> Self {
        let n = 2 * SECTORS;
        let springs = |k: f64| {
            let mut all = Mat::<f64>::zeros(n, n);
            for sector in 0..SECTORS {
                let [a, b] = [2 * sector, 2 * ((sector + 1) % SECTORS)];
                all[(a, a)] += k;
                all[(b, b)] += k;
                all[(a, b)] -= k;
                all[(b, a)] -= k;
            }
            all
        };
        let own = product(ROOT, ROOT);
        let mut stiffness = springs(coupling);
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            if i / 2 == j / 2 {
                stiffness[(i, j)] += own[i % 2][j % 2];
            }
        }
        let modes = stiffness.self_adjoint_eigen(faer::Side::Lower).unwrap();
        let (lambda, shapes) = (modes.S(), modes.U());
        let damping = Mat::from_fn(n, n, |i, j| {
            let of_mode =
                |k: usize| 2.0 * DAMPING_RATIO * lambda[k].sqrt() * shapes[(i, k)] * shapes[(j, k)];
            (0..n).map(of_mode).sum::<f64>()
        });
        let mut blade = own;
        blade[0][0] += 2.0 * coupling;
        Self {
            contacts: springs(CONTACT),
            stiffness,
            damping,
            blade,
        }
    }

    /// Amplitudes of all tips (m) at `hertz`, blades deviating by `deviations`.
    fn tips(&self, deviations: &[f64], hertz: f64) -> [f64; SECTORS] {
        let (n, omega) = (2 * SECTORS, TAU * hertz);
        let dynamic = Mat::from_fn(n, n, |i, j| {
            let factor = (1.0 + deviations[i / 2]).powi(2) - 1.0;
            let mut k = self.stiffness[(i, j)] + self.contacts[(i, j)];
            if i / 2 == j / 2 {
                k += factor * self.blade[i % 2][j % 2];
            }
            let inertia = if i == j { omega * omega } else { 0.0 };
            c64::new(k - inertia, omega * self.damping[(i, j)])
        });
        let force = Col::from_fn(n, |i| {
            let phase = -TAU * (ENGINE_ORDER * (i / 2)) as f64 / SECTORS as f64;
            c64::new(phase.cos(), phase.sin()) * (i % 2) as f64
        });
        let moved = dynamic.partial_piv_lu().solve(force);
        std::array::from_fn(|sector| moved[2 * sector + 1].norm())
    }

    /// The largest maximum of a tip inside `band_hz`, if it is above the amplitudes at the ends of the band.
    fn largest(&self, deviations: &[f64], [low, high]: [f64; 2]) -> Option<f64> {
        let places = ((high - low) / STEP_HZ).round() as usize;
        let at = |i: usize| self.tips(deviations, low + STEP_HZ * i as f64);
        let all: Vec<[f64; SECTORS]> = (0..=places).map(at).collect();
        let ends = [all[0], all[places]];
        let at_ends = ends.iter().flatten().fold(0.0_f64, |a, b| a.max(*b));
        let mut inside = 0.0_f64;
        for three in all.windows(3) {
            for ((before, here), after) in three[0].iter().zip(&three[1]).zip(&three[2]) {
                if here > before && here > after {
                    inside = inside.max(*here);
                }
            }
        }
        (inside > at_ends).then_some(inside)
    }
}

/// Compares the samples of a case with the ring; gives the numbers of those with a peak and without.
fn compared(case: Case) -> [usize; 2] {
    let folder = tempfile::tempdir().unwrap();
    let ring = Ring::new(case.coupling);
    let mut seen = [0, 0];
    for outcome in outcomes(folder.path(), case) {
        let [level] = &*outcome.levels else {
            panic!("one level")
        };
        let expected = ring.largest(&outcome.inputs, case.band_hz);
        match (expected, &level.peak) {
            (Some(amplitude), Some(peak)) => {
                let error = (peak.amplitude_m / amplitude - 1.0).abs();
                assert!(error < 1e-4, "sample {}: {error:.1e}", outcome.index);
                seen[0] += 1;
            }
            (None, None) => {
                assert_eq!(
                    level.status,
                    Status::NoPeakInBand,
                    "sample {}",
                    outcome.index
                );
                seen[1] += 1;
            }
            other => panic!("sample {}: {other:?}, {level:?}", outcome.index),
        }
    }
    seen
}

/// The peak is the largest amplitude of all blades, where it is a maximum inside the band, also next to a higher resonance outside it. The
/// second family of modes is at five times the band, and blades deviate by 5 %. Seen to fail with the program before: a damping ratio coupled the sectors
/// of a disk that only contacts couple, so that modes above twice the band were left out (0.6 % of the amplitude); so they were where sectors are coupled (1.4 %);
/// and amplitudes of a point beyond the band left a sample without a peak.
#[test]
fn peaks_are_those_of_the_whole_ring() {
    let mut without = 0;
    for (coupling, by_matrix, band_hz) in [
        (0.0, false, [620.0, 760.0]),
        (0.0, true, [620.0, 760.0]),
        (2e7, false, [780.0, 920.0]),
    ] {
        let seen = compared(Case {
            coupling,
            by_matrix,
            band_hz,
        });
        println!("{coupling:e} N/m, {band_hz:?} Hz: {seen:?}");
        assert!(seen[0] >= 20, "{seen:?}");
        without += seen[1];
    }
    assert!(without > 0, "every disk has a peak in the band");
}
