//! The equations in free modes as arrays of single precision: what all lanes share, and what is a lane's own.
//!
//! A frequency is stored as its distance from a reference, and λ − k²ω² as its value there, which is rounded once: so
//! differences of frequencies keep all digits of single precision.

use crate::hb::equations::free::FreeBalance;
use crate::hb::newton::Point;
use crate::hb::structure::linear::ModalPart;
use crate::linalg::single::rounded;

/// Numbers that a lane's own rows begin with: level, and factor on the damping.
pub(super) const OWN_FIRST: usize = 2;
/// Constants of a contact pair.
pub(super) const CONSTANTS: usize = 7;

/// Places of the arrays in [`LaneSystem::numbers`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SharedPlaces {
    /// Order, λ − k²ω² at the reference frequency, damping. Shape: `[harmonic][1 + 2 modes]`.
    pub spectra: usize,
    /// Cosine and sine of the excitation. Shape: `[2][modes]`.
    pub excitation: usize,
    /// Row of the response, real and imaginary part. Shape: `[2][modes]`.
    pub responses: usize,
    /// K_ref. Shape: `[rows]`.
    pub springs: usize,
    /// Real part of Lᵀ of every part with the mirror images, column by column. Shape: `[part][rows][modes]`.
    pub loads: usize,
    /// Real part of L of every part, column by column. Shape: `[part][modes][rows]`.
    pub shapes: usize,
    /// The same of the imaginary part of L, where a part has one.
    pub imaginary: Option<[usize; 2]>,
    /// G_ref. Shape: `[rows][rows]`.
    pub compliance: usize,
}

/// What all lanes share.
#[derive(Debug, Clone, PartialEq)]
pub struct LaneSystem {
    /// Contact pairs.
    pub(super) n_pairs: usize,
    /// Number of the part of the model of each harmonic above 0.
    pub(super) parts: Vec<usize>,
    /// Modes of a part; parts with fewer are filled up with zeros.
    pub(super) n_modes: usize,
    /// Reference frequency (rad/s).
    pub(super) reference: f64,
    pub(super) numbers: Vec<f32>,
    pub(super) places: SharedPlaces,
    /// Damping that a factor of 1 stands for.
    damping: Vec<f64>,
}

/// One lane at its first point.
#[derive(Debug, Clone)]
pub struct Lane {
    /// Level, factor on the damping, r_ref, constants of the pairs.
    pub(super) own: Vec<f32>,
    pub(super) point: Vec<f32>,
    /// Distance from the reference frequency (rad/s).
    pub(super) detuning: [f32; 1],
}

/// Arrays one after the other.
#[derive(Default)]
struct Arrays(Vec<f32>);

impl Arrays {
    /// Adds an array; its place.
    fn add(&mut self, numbers: impl IntoIterator<Item = f64>) -> usize {
        let place = self.0.len();
        let numbers: Vec<f64> = numbers.into_iter().collect();
        self.0.extend(rounded(&numbers));
        place
    }

    /// Adds Lᵀ and L of all `parts`; their places.
    fn add_shapes(
        &mut self,
        parts: &[ModalPart],
        n_modes: usize,
        value: fn(&faer::c64) -> f64,
    ) -> [usize; 2] {
        let of_parts = parts.iter().map(|part| in_modes(part, n_modes, value));
        let of_parts: Vec<[Vec<f64>; 2]> = of_parts.collect();
        [0, 1].map(|i| self.add(of_parts.iter().flat_map(|both| both[i].iter().copied())))
    }
}

/// Lᵀ of `part` with the mirror images, and L, both column by column and of the real or imaginary parts that `value` takes; filled up to
/// `n_modes` modes with zeros.
fn in_modes(part: &ModalPart, n_modes: usize, value: fn(&faer::c64) -> f64) -> [Vec<f64>; 2] {
    let (rows, modes) = (part.contact.nrows(), part.n_coordinates());
    let entry = |i: usize, j: usize| match j < modes {
        true => value(&part.contact.entry(i, j)),
        false => 0.0,
    };
    let loads = (0..rows).flat_map(|i| (0..n_modes).map(move |j| (i, j)));
    let shapes = (0..n_modes).flat_map(|j| (0..rows).map(move |i| (i, j)));
    [
        loads
            .map(|(i, j)| part.multiplicity * entry(i, j))
            .collect(),
        shapes.map(|(i, j)| entry(i, j)).collect(),
    ]
}

impl LaneSystem {
    /// The system of `free` around the frequency `reference` (rad/s); none without a first harmonic, whose response defines a peak.
    #[must_use]
    pub fn new(free: &FreeBalance<'_>, reference: f64) -> Option<Self> {
        let (problem, orders) = (free.balance.problem, free.orders());
        let model = problem.model;
        if orders.first() != Some(&1) {
            return None;
        }
        let n_modes = (model.parts.iter()).map(ModalPart::n_coordinates).max()?;
        let filled = |x: &[f64]| -> Vec<f64> {
            let zeros = std::iter::repeat_n(0.0, n_modes - x.len());
            x.iter().copied().chain(zeros).collect()
        };
        let mut arrays = Arrays::default();
        let spectra = orders.iter().flat_map(|&k| {
            let (structure, k) = (&model.part(k).structure, k as f64);
            let base = |l: &f64| l - (k * reference).powi(2);
            let bases: Vec<f64> = structure.lambda.iter().map(base).collect();
            [vec![k], filled(&bases), filled(&structure.damping)].concat()
        });
        let first = model.part(1);
        let force = |of: fn(&faer::c64) -> f64| {
            let values: Vec<f64> = first.force.iter().map(of).collect();
            filled(&values)
        };
        let response = |of: fn(&faer::c64) -> f64| {
            let weights = (0..first.n_coordinates()).map(|j| of(&first.response.entry(0, j)));
            filled(&weights.collect::<Vec<f64>>())
        };
        let n = problem.model.n_relative();
        let is_real = model.parts.iter().all(ModalPart::is_real);
        let mut add = |value| arrays.add_shapes(&model.parts, n_modes, value);
        let [loads, shapes] = add(|z| z.re);
        let imaginary = (!is_real).then(|| add(|z| z.im));
        let compliance = &free.reference.compliance;
        let places = SharedPlaces {
            spectra: arrays.add(spectra),
            excitation: arrays.add([force(|f| f.re), force(|f| -f.im)].concat()),
            responses: arrays.add([response(|w| w.re), response(|w| w.im)].concat()),
            springs: arrays.add(free.reference.stiffness.iter().copied()),
            loads,
            shapes,
            imaginary,
            compliance: arrays.add((0..n).flat_map(|j| compliance.col_as_slice(j)).copied()),
        };
        Some(Self {
            n_pairs: free.balance.layout.n_pairs,
            parts: orders.iter().map(|k| k % model.parts.len()).collect(),
            n_modes,
            reference,
            numbers: arrays.0,
            places,
            damping: first.structure.damping.clone(),
        })
    }

    /// Relative displacements per coefficient.
    pub(super) fn rows(&self) -> usize {
        3 * self.n_pairs
    }

    /// Coefficients of a displacement.
    pub(super) fn n_coefficients(&self) -> usize {
        2 * self.parts.len() + 1
    }

    /// Unknowns of a lane.
    pub(super) fn size(&self) -> usize {
        self.rows() * self.n_coefficients()
    }

    /// Rows of a lane's own numbers.
    pub(super) fn own_rows(&self) -> usize {
        OWN_FIRST + self.rows() + CONSTANTS * self.n_pairs
    }

    /// The lane of `free` at `point`. Its model may differ from that of the system by a factor on the damping and by static loads.
    #[must_use]
    pub fn lane(&self, free: &FreeBalance<'_>, point: &Point) -> Lane {
        let problem = free.balance.problem;
        let damping = &problem.model.part(1).structure.damping;
        let both = damping.iter().zip(&self.damping);
        let largest = both.max_by(|(_, a), (_, b)| a.total_cmp(b));
        let factor = largest.map_or(1.0, |(own, of_all)| own / of_all);
        let contacts = &problem.contacts;
        let constants = [
            contacts.iter().map(|c| c.k_t[0]).collect::<Vec<f64>>(),
            contacts.iter().map(|c| c.k_t[1]).collect(),
            contacts.iter().map(|c| c.k_n).collect(),
            contacts.iter().map(|c| c.mu).collect(),
            contacts.iter().map(|c| c.n_0).collect(),
            contacts.iter().map(|c| c.anchor[0]).collect(),
            contacts.iter().map(|c| c.anchor[1]).collect(),
        ];
        let own = [&[point.level, factor], free.rest(), &constants.concat()].concat();
        Lane {
            own: rounded(&own),
            point: rounded(&point.r),
            detuning: [rounded(&[point.omega - self.reference])[0]],
        }
    }
}

impl Lane {
    /// Whether all its numbers are finite in single precision.
    pub(super) fn is_finite(&self) -> bool {
        let all = self.own.iter().chain(&self.point);
        all.chain(&self.detuning).all(|x| x.is_finite())
    }
}
