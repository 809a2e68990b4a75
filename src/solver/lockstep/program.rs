//! The passes of one Newton iteration of many lanes: text of the shaders, places of the arrays, and the order of the passes.

use super::system::{LaneSystem, OWN_FIRST};
use crate::aft::TangentBlock;
use crate::gpu::Fault;
use std::fmt::Write;

/// Lanes of a tile: they share an inverse.
pub(super) const TILE: usize = 64;
/// Rounds of products of one iteration; each gives two directions, one of the correction and one of the tangent.
pub(super) const ROUNDS: usize = 6;
/// Rows of what comes back of a lane: 64 bytes.
pub(super) const TOLD: usize = 16;
/// Rows of the matrix, of a group of a product.
const TILE_ROWS: usize = 64;
/// Lanes of a group that combines directions.
const LANES_OF_GROUP: usize = 16;

/// Places of the arrays of the lanes, in rows of one number per lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LanePlaces {
    pub point: usize,
    pub detuning: usize,
    pub solution: usize,
    force: usize,
    rest_force: usize,
    modal: usize,
    product: usize,
    pub linear: usize,
    first: usize,
    scales: usize,
    directions: usize,
    images: usize,
    /// Rows of all.
    pub end: usize,
}

/// One dispatch of a pass.
#[derive(Debug, Clone)]
pub(super) struct Use {
    pub entry: &'static str,
    pub job: Job,
    pub groups: [usize; 3],
}

/// Arguments of a pass, as `Job` in the shaders.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Job {
    lanes: usize,
    columns: usize,
    matrix: Matrix,
    /// Rows of x and y.
    x: usize,
    y: usize,
    /// Rows to those of the next coefficient.
    steps: [usize; 2],
    alpha: f32,
    keep: f32,
    /// Whether x is taken times −i, amplitude by amplitude.
    turns: bool,
    pair: usize,
}

/// A matrix of [`LaneSystem::numbers`] or of the inverses.
#[derive(Debug, Clone, Copy, Default)]
struct Matrix {
    rows: usize,
    inner: usize,
    place: usize,
    /// Numbers to that of the next part of the model, or to the next inverse.
    stride: usize,
}

impl Job {
    /// Its numbers as the shaders read them.
    pub(super) fn words(&self) -> [u32; 14] {
        let word = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
        let matrix = &self.matrix;
        [
            word(self.lanes),
            word(self.columns),
            word(matrix.rows),
            word(matrix.inner),
            word(matrix.place),
            word(matrix.stride),
            word(self.x),
            word(self.y),
            word(self.steps[0]),
            word(self.steps[1]),
            self.alpha.to_bits(),
            self.keep.to_bits(),
            u32::from(self.turns),
            word(self.pair),
        ]
    }
}

impl Use {
    /// Multiplications and additions of a product with a matrix; 0 for another pass.
    pub(super) fn operations(&self) -> f64 {
        let Matrix { rows, inner, .. } = self.job.matrix;
        2.0 * rows as f64 * inner as f64 * self.job.columns as f64 * self.groups[2] as f64
    }
}

impl LanePlaces {
    pub(super) fn new(system: &LaneSystem) -> Self {
        let (size, rows) = (system.size(), system.rows());
        let mut end = 0;
        let mut take = |rows: usize| {
            end += rows;
            end - rows
        };
        let [point, detuning] = [take(size), take(1)];
        Self {
            point,
            detuning,
            solution: take(2 * size),
            force: take(2 * size),
            rest_force: take(2 * rows),
            modal: take(4 * system.parts.len() * system.n_modes),
            product: take(2 * size),
            linear: take(2 * size),
            first: take(2 * system.n_modes),
            scales: take(system.n_pairs),
            directions: take(2 * size * ROUNDS),
            images: take(2 * size * ROUNDS),
            end,
        }
    }
}

/// The shader text for `system` with tangents of these `blocks`.
pub(super) fn text(system: &LaneSystem, blocks: &[TangentBlock]) -> String {
    let (lane, shared) = (LanePlaces::new(system), &system.places);
    let mut text = String::new();
    for (name, value) in [
        ("PAIRS", system.n_pairs),
        ("HARMONICS", system.parts.len()),
        ("MODES", system.n_modes),
        ("BLOCKS", blocks.len()),
        ("ROUNDS", ROUNDS),
        ("REST", OWN_FIRST),
        ("SPECTRA", shared.spectra),
        ("EXCITATION", shared.excitation),
        ("RESPONSES", shared.responses),
        ("REFERENCE_SPRINGS", shared.springs),
        ("POINT", lane.point),
        ("DETUNING", lane.detuning),
        ("SOLUTION", lane.solution),
        ("FORCE", lane.force),
        ("REST_FORCE", lane.rest_force),
        ("MODAL", lane.modal),
        ("PRODUCT", lane.product),
        ("LINEAR", lane.linear),
        ("FIRST", lane.first),
        ("SCALES", lane.scales),
        ("DIRECTIONS", lane.directions),
        ("IMAGES", lane.images),
    ] {
        // writing to a string cannot fail
        let _ = writeln!(text, "const {name}: u32 = {value}u;");
    }
    let _ = writeln!(text, "const REFERENCE_OMEGA: f32 = {:e};", system.reference);
    let rows: Vec<usize> = blocks.iter().map(|block| block.row_component()).collect();
    let columns: Vec<usize> = blocks
        .iter()
        .map(|block| block.column_component())
        .collect();
    for (name, values) in [
        ("parts", &system.parts),
        ("block_rows", &rows),
        ("block_columns", &columns),
    ] {
        let list: Vec<String> = values.iter().map(|value| format!("{value}u")).collect();
        let (n, list) = (values.len(), list.join(", "));
        let _ = writeln!(
            text,
            "var<private> {name}: array<u32, {n}> = array<u32, {n}>({list});"
        );
    }
    text.push_str(include_str!("../../../shaders/lockstep.wgsl"));
    text.push_str(include_str!("../../../shaders/lockstep_contact.wgsl"));
    text.push_str(include_str!("../../../shaders/lockstep_modes.wgsl"));
    text.push_str(include_str!("../../../shaders/lockstep_directions.wgsl"));
    text
}

/// Passes over `lanes` lanes of a system.
#[derive(Debug)]
pub(super) struct Program<'a> {
    system: &'a LaneSystem,
    places: LanePlaces,
    lanes: usize,
    /// Numbers of an inverse.
    inverse: usize,
    fault: Option<Fault>,
}

impl<'a> Program<'a> {
    pub(super) fn new(system: &'a LaneSystem, lanes: usize, fault: Option<Fault>) -> Self {
        Self {
            places: LanePlaces::new(system),
            inverse: system.size() * system.size(),
            system,
            lanes,
            fault,
        }
    }

    /// Names of the passes.
    pub(super) const PASSES: [&'static str; 11] = [
        "moved",
        "scaled",
        "loaded",
        "rate",
        "product",
        "preconditioned",
        "divided",
        "divided_residual",
        "responded",
        "begun",
        "advanced",
    ];

    /// What spoils their results, for tests.
    pub(super) const SPOILED: &'static str = "spoiled";

    /// From the last iteration to the states of the contact passes.
    pub(super) fn to_contacts(&self) -> Vec<Use> {
        self.with_fault(vec![
            self.simple("moved", 1, self.system.size() + 1, 1),
            self.simple("scaled", 1, self.system.n_pairs, 1),
        ])
    }

    /// From the contact forces to correction, tangent and what comes back.
    pub(super) fn to_directions(&self) -> Vec<Use> {
        let (system, places) = (self.system, &self.places);
        let by_pair = system.n_pairs * system.n_coefficients();
        let harmonics = system.parts.len();
        let mut uses = vec![
            self.rate(places.solution),
            self.simple("loaded", 1, by_pair, 1),
        ];
        uses.extend(self.loads(2 * harmonics));
        uses.push(self.of_lanes("divided_residual", system.n_modes, harmonics));
        uses.extend(self.motion());
        uses.push(self.preconditioned(places.linear, -1.0));
        uses.push(self.over_lanes("begun", 0));
        for pair in 0..ROUNDS {
            let of_pair = 2 * system.size() * pair;
            uses.push(self.rate(places.directions + of_pair));
            uses.extend(self.loads(2 * harmonics));
            uses.push(self.simple("divided", 2, system.n_modes, harmonics));
            uses.extend(self.motion());
            uses.push(self.preconditioned(places.images + of_pair, 1.0));
            uses.push(self.over_lanes("advanced", pair));
        }
        uses.push(self.rate(places.solution));
        uses.extend(self.loads(2));
        uses.push(self.of_lanes("responded", 1, 1));
        self.with_fault(uses)
    }

    /// The passes, each one that is to fail followed by what spoils its result.
    fn with_fault(&self, uses: Vec<Use>) -> Vec<Use> {
        let (entry, factor) = match self.fault {
            Some(Fault::WrongPass(entry)) => (entry, 1.3),
            Some(Fault::NoNumbers(entry)) => (entry, f32::NAN),
            _ => return uses,
        };
        let places = &self.places;
        let spoiled = |used: &Use| {
            let (size, modal) = (2 * self.system.size(), places.product - places.modal);
            let (place, rows) = match used.entry {
                "moved" => (places.point, size / 2),
                "scaled" => (places.scales, self.system.n_pairs),
                "loaded" | "rate" => (places.force, size),
                "product" | "divided" => (places.modal, modal),
                "divided_residual" => (places.first, 2 * self.system.n_modes),
                "begun" | "responded" => (places.solution, size),
                _ => (places.linear, size),
            };
            let mut spoil = self.simple(Self::SPOILED, 1, rows, 1);
            (spoil.job.x, spoil.job.alpha) = (place, factor);
            spoil
        };
        let both = uses.into_iter().flat_map(|used| {
            let spoil = (used.entry == entry).then(|| spoiled(&used));
            std::iter::once(used).chain(spoil)
        });
        both.collect()
    }

    /// A thread for each number of arrays with `columns` columns per lane.
    fn simple(&self, entry: &'static str, columns: usize, rows: usize, depth: usize) -> Use {
        let columns = columns * self.lanes;
        let job = Job {
            lanes: self.lanes,
            columns,
            ..Job::default()
        };
        Use {
            entry,
            job,
            groups: [columns / TILE, rows, depth],
        }
    }

    /// A thread for both columns of a lane.
    fn of_lanes(&self, entry: &'static str, rows: usize, depth: usize) -> Use {
        let mut used = self.simple(entry, 1, rows, depth);
        used.job.columns = 2 * self.lanes;
        used
    }

    fn rate(&self, x: usize) -> Use {
        let by_pair = self.system.n_pairs * self.system.n_coefficients();
        let mut used = self.simple("rate", 2, by_pair, 1);
        used.job.x = x;
        used
    }

    fn over_lanes(&self, entry: &'static str, pair: usize) -> Use {
        let mut used = self.simple(entry, 1, 1, 1);
        used.job.pair = pair;
        used.groups = [self.lanes / LANES_OF_GROUP, 1, 1];
        used
    }

    /// y = A x + y, or y = A x, for `batches` coefficients.
    fn product(
        &self,
        matrix: Matrix,
        [x, y]: [usize; 2],
        steps: [usize; 2],
        batches: usize,
    ) -> Use {
        let mut used = self.simple("product", 2, matrix.rows.div_ceil(TILE_ROWS), batches);
        used.job = Job {
            matrix,
            x,
            y,
            steps,
            alpha: 1.0,
            ..used.job
        };
        used
    }

    /// Loads on the modes by the contact forces, for the first `batches` coefficients above 0.
    fn loads(&self, batches: usize) -> Vec<Use> {
        let (modes, rows) = (self.system.n_modes, self.system.rows());
        let of_place = |place| Matrix {
            rows: modes,
            inner: rows,
            place,
            stride: modes * rows,
        };
        let arrays = [self.places.force + 2 * rows, self.places.modal];
        let product = |place| self.product(of_place(place), arrays, [rows, modes], batches);
        let shared = &self.system.places;
        let mut uses = vec![product(shared.loads)];
        uses.extend(
            shared
                .imaginary
                .map(|[loads, _]| turned(product(loads), 1.0)),
        );
        uses
    }

    /// Motion at the contacts by the modes, and by the force on the reference springs.
    fn motion(&self) -> Vec<Use> {
        let (modes, rows) = (self.system.n_modes, self.system.rows());
        let of_place = |place| Matrix {
            rows,
            inner: modes,
            place,
            stride: modes * rows,
        };
        let compliance = Matrix {
            rows,
            inner: rows,
            place: self.system.places.compliance,
            stride: 0,
        };
        let moved = [self.places.modal, self.places.product + 2 * rows];
        let at_rest = [self.places.rest_force, self.places.product];
        let batches = 2 * self.system.parts.len();
        let product = |place| self.product(of_place(place), moved, [modes, rows], batches);
        let shared = &self.system.places;
        let mut uses = vec![
            product(shared.shapes),
            self.product(compliance, at_rest, [0, 0], 1),
        ];
        uses.extend(
            shared
                .imaginary
                .map(|[_, shapes]| turned(product(shapes), -1.0)),
        );
        uses.iter_mut().for_each(|used| used.job.keep = 1.0);
        uses
    }

    fn preconditioned(&self, y: usize, alpha: f32) -> Use {
        let size = self.system.size();
        let matrix = Matrix {
            rows: size,
            inner: size,
            place: 0,
            stride: self.inverse,
        };
        let mut used = self.product(matrix, [self.places.product, y], [0, 0], 1);
        used.entry = "preconditioned";
        used.job.alpha = alpha;
        used
    }
}

/// What an imaginary matrix adds to what the real one has left: y += `sign` (−i) A x.
fn turned(mut used: Use, sign: f32) -> Use {
    used.job.turns = true;
    used.job.alpha = sign;
    used.job.keep = 1.0;
    used
}
