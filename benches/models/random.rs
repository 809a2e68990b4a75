//! Random models as users may bring them: a chain of masses with friction contacts between its points or to the ground.

use faer::Mat;
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::level_peak::LevelPeak;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, StabilityScope,
};
use microslip::model::{ContactPair, ReducedModel, Response, SparseRow};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Time points of the contact forces of a study that does not say.
pub(crate) const TIME_POINTS: usize = 128;

/// Everything that a search for the peak needs.
pub(crate) struct RandomModel {
    pub(crate) reduced: ReducedModel,
    pub(crate) contacts: Vec<ContactParameters<f64>>,
    /// Excitation level; the force is 1 N at the first mass.
    pub(crate) level: f64,
    pub(crate) law: FrictionLaw,
    /// Time points of the contact forces.
    pub(crate) n_time: usize,
    /// The numbers drawn, in words.
    pub(crate) text: String,
}

impl RandomModel {
    /// 2 to 12 masses of 0.5 to 2 kg, springs of 0.1 to 2 N/m, damping ratios around 0.1 to 2 %, 1 to 6 contacts, half of
    /// them with varying normal load, 40 % with both directions of slip. Over six decades each: contact stiffness
    /// (1e-3 to 1e3 N/m), preload (1e-3 to 1e3 N), friction coefficient (1e-6 to 1) and level (1e-3 to 1e3 N).
    pub(crate) fn of_seed(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut decades = |low: f64, high: f64| 10f64.powf(rng.random_range(low..high));
        let [ratio, preload, mu, level] = [
            decades(-3.0, 3.0),
            decades(-3.0, 3.0),
            decades(-6.0, 0.0),
            decades(-3.0, 3.0),
        ];
        let law = match rng.random_bool(0.5) {
            true => FrictionLaw::Box,
            false => FrictionLaw::Circle,
        };
        let n = rng.random_range(2..=12usize);
        let n_contacts = rng.random_range(1..=6usize);
        let [mass, stiffness] = chain(&mut rng, n);
        let zeta = rng.random_range(0.001..0.02);
        let damping = Mat::from_fn(n, n, |i, j| zeta * (mass[(i, j)] + stiffness[(i, j)]));
        let scales = [ratio, preload, mu];
        let (pairs, contacts): (Vec<ContactPair>, Vec<_>) = (0..n_contacts)
            .map(|number| random_contact(&mut rng, n, number, scales))
            .unzip();
        let mut static_force = vec![0.0; n];
        for (pair, contact) in pairs.iter().zip(&contacts) {
            balance_preload(pair, contact, &mut static_force);
        }
        let unit = |at: usize| (0..n).map(|i| f64::from(u8::from(i == at))).collect();
        Self {
            reduced: ReducedModel {
                name: format!("seed {seed}"),
                dof_names: (0..n).map(|i| i.to_string()).collect(),
                mass,
                damping,
                stiffness,
                retention: None,
                contacts: pairs,
                static_force,
                loads: Vec::new(),
                cosine_force: unit(0),
                sine_force: vec![0.0; n],
                responses: vec![Response {
                    name: "first".into(),
                    row: vec![(0, 1.0)],
                }],
                mirror: None,
            },
            contacts,
            level,
            law,
            n_time: TIME_POINTS,
            text: format!(
                "seed {seed}: {n} masses, {n_contacts} contacts of {ratio:.1e} N/m, preload {preload:.1e} N, mu {mu:.1e}, \
                 level {level:.1e}, {law:?}"
            ),
        }
    }

    /// Ascending natural frequencies of the free and of the stuck structure (rad/s).
    pub(crate) fn frequencies(&self) -> [Vec<f64>; 2] {
        let free = self.reduced.free_frequencies();
        let stuck = self.reduced.stuck_frequencies(&self.contacts);
        [free, stuck].map(|frequencies| frequencies.expect("modes"))
    }

    /// The peak with `highest` harmonics in the band that holds all modes, free and stuck, with `budget` iterations per search.
    pub(crate) fn peak(&self, highest: usize, budget: usize) -> LevelPeak {
        self.solved(highest, budget, |problem, settings, peak| {
            let found = track_peaks(problem, settings, peak, &[self.level]);
            found.expect("modes").remove(0)
        })
    }

    /// What `of` makes of the model with these settings and the band of the peak.
    pub(crate) fn solved<T>(
        &self,
        highest: usize,
        budget: usize,
        of: impl Fn(&Problem<'_>, &HbSettings, PeakSettings) -> T,
    ) -> T {
        let newton = NewtonSettings {
            budget,
            ..NewtonSettings::default()
        };
        let settings = HbSettings {
            harmonics: HarmonicSet::up_to(highest),
            aft: AftSettings {
                n_time: self.n_time,
                law: self.law,
                events: Events::Located,
                laps: Laps::Periodic,
            },
            anchor: SliderAnchor::Unloaded,
            newton,
            alert: None,
            stability: StabilityScope::Off,
        };
        let linear = LinearModel::new(&self.reduced).expect("modes");
        let [free, stuck] = self.frequencies();
        let contacts = self.contacts.clone();
        let problem =
            Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded).expect("a held structure");
        problem.effort.grant(settings.newton.budget);
        let peak = PeakSettings {
            band: Band {
                low: 0.5 * free[0],
                high: 1.2 * stuck[stuck.len() - 1],
            },
            frequency_tolerance: 1e-9,
        };
        of(&problem, &settings, peak)
    }
}

/// Mass and stiffness of a chain whose masses are also held by weaker springs to the ground.
fn chain(rng: &mut ChaCha8Rng, n: usize) -> [Mat<f64>; 2] {
    let (mut mass, mut stiffness) = (Mat::zeros(n, n), Mat::zeros(n, n));
    for i in 0..n {
        mass[(i, i)] = rng.random_range(0.5..2.0);
        stiffness[(i, i)] += rng.random_range(0.1..1.0);
        if i > 0 {
            let k = rng.random_range(0.5..2.0);
            for (a, b, sign) in [
                (i, i, 1.0),
                (i - 1, i - 1, 1.0),
                (i, i - 1, -1.0),
                (i - 1, i, -1.0),
            ] {
                stiffness[(a, b)] += sign * k;
            }
        }
    }
    [mass, stiffness]
}

/// The static load carries the preload, as in a structure at rest.
fn balance_preload(pair: &ContactPair, contact: &ContactParameters<f64>, force: &mut [f64]) {
    for &(i, a) in &pair.n {
        force[i] += a * contact.n_0;
    }
}

/// A contact on a chain of n masses, with stiffness, preload and friction coefficient around `scales`.
fn random_contact(
    rng: &mut ChaCha8Rng,
    n: usize,
    number: usize,
    [ratio, preload, mu]: [f64; 3],
) -> (ContactPair, ContactParameters<f64>) {
    let [both, varying] = [0.4, 0.5].map(|p| rng.random_bool(p));
    let rows = [true, both, varying].map(|on| match on {
        true => between_points(rng, n),
        false => SparseRow::new(),
    });
    let [t1, t2, normal] = rows;
    let k_t = ratio * rng.random_range(0.3..3.0);
    let k_n = k_t * rng.random_range(0.5..3.0);
    let contact = ContactParameters {
        k_n: if varying { k_n } else { 0.0 },
        k_t: [k_t, if both { k_t } else { 0.0 }],
        mu,
        n_0: preload * rng.random_range(0.3..3.0),
        anchor: [0.0; 2],
    };
    let pair = ContactPair {
        name: number.to_string(),
        t1,
        t2,
        n: normal,
        area: 1.0,
        interface: 0,
    };
    (pair, contact)
}

/// Relative displacement of two random points, or of one to the ground.
fn between_points(rng: &mut ChaCha8Rng, n: usize) -> SparseRow {
    let (i, j) = (rng.random_range(0..n), rng.random_range(0..n));
    match i == j {
        true => vec![(i, 1.0)],
        false => vec![(i, 1.0), (j, -1.0)],
    }
}
