// Declarations of the passes over lanes. A lane is one peak of one sample: a point (displacements r, frequency) and the equations
// there in the modes of the free structure, as in hb/equations/free.rs. In front of this text stand, generated:
//   PAIRS, HARMONICS, MODES  contact pairs, harmonics above 0, modes of each part of the model (filled up with zeros)
//   BLOCKS, ROUNDS           blocks of a tangent, rounds of products; parts of the harmonics, components of the blocks
//   places of arrays         in `numbers` (rows of LANES), `shared` (numbers) and `own` (rows of LANES)
// Vectors of a lane have the order of r: [coefficient][component][pair]. Arrays run over columns fastest. There are one or two
// columns per lane: correction and tangent of a lane are columns `lane` and `lane + LANES`.

const GROUP: u32 = 64u;
const ROWS: u32 = 3u * PAIRS;
const M: u32 = 2u * HARMONICS + 1u;
const N: u32 = M * ROWS;

// One use of a pass.
struct Job {
    lanes: u32,
    // Columns of the arrays at hand, one or two per lane.
    columns: u32,
    // Matrix: rows, columns, place, numbers per part of the model or per inverse.
    rows: u32,
    inner: u32,
    matrix: u32,
    stride: u32,
    // Rows of x and y, and rows to those of the next coefficient.
    x: u32,
    y: u32,
    x_step: u32,
    y_step: u32,
    // Factors on A x and on what y holds.
    alpha: f32,
    keep: f32,
    // Whether x is taken times -i, amplitude by amplitude.
    turns: u32,
    // Number of the pair of directions.
    pair: u32,
}

@group(0) @binding(0) var<uniform> job: Job;
// What all lanes share.
@group(0) @binding(1) var<storage, read> shared_numbers: array<f32>;
// Inverse Jacobians of anchors, column by column, and the one of each tile of lanes.
@group(0) @binding(2) var<storage, read> inverses: array<f32>;
@group(0) @binding(3) var<storage, read> inverse_of: array<u32>;
// What a lane does not change. Shape: [OWN_ROWS][lane]
@group(0) @binding(4) var<storage, read> own: array<f32>;
// Steps of the frequency (rad/s); a lane that rests has not-a-number. Shape: [lane]
@group(0) @binding(5) var<storage, read> steps: array<u32>;
@group(0) @binding(6) var<storage, read_write> numbers: array<f32>;
// What comes back. Shape: [TOLD][lane]
@group(0) @binding(7) var<storage, read_write> told: array<f32>;
// Arrays of the contact passes (shared.wgsl), state = pair * lanes + lane.
@group(0) @binding(8) var<storage, read_write> coefficients: array<f32>;
@group(0) @binding(9) var<storage, read_write> states: array<f32>;
@group(0) @binding(10) var<storage, read> deviations: array<f32>;
@group(0) @binding(11) var<storage, read> flags: array<u32>;
@group(0) @binding(12) var<storage, read> slots: array<u32>;
@group(0) @binding(13) var<storage, read> tangents: array<f32>;

// What a state did, in `flags` (shared.wgsl). A lane takes the forces where the velocity turns around, too: the processor confirms
// its peak with nodes there.
const MOVED: u32 = 1u;
const OVERFLOW: u32 = 2u;

// Rows of `told`.
const SIZE: u32 = 0u;
const RIGHT: u32 = 1u;
const LEFT: u32 = 3u;
const RESPONSE: u32 = 5u;
const UNDECIDED: u32 = 11u;
const FREQUENCY: u32 = 12u;
const TOLD: u32 = 16u;

// Rows of `own`.
const LEVEL: u32 = 0u;
const DAMPING: u32 = 1u;
const CONSTANTS: u32 = REST + ROWS;

// Constants of a pair: stiffness of t1, t2, n, friction coefficient, preload, anchors.
fn constant(i: u32, pair: u32, lane: u32) -> f32 {
    return own[(CONSTANTS + i * PAIRS + pair) * job.lanes + lane];
}

// Number (row, column) of the array at `place` with `columns` columns.
fn at(place: u32, row: u32, column: u32, columns: u32) -> u32 {
    return place * job.lanes + row * columns + column;
}

// D_k, then dZ/dω, of harmonic number h on mode j; each is a complex number (re, im).
fn spectrum(h: u32, j: u32, lane: u32) -> array<vec2<f32>, 2> {
    let k = shared_numbers[SPECTRA + h * (2u * MODES + 1u)];
    let base = shared_numbers[SPECTRA + h * (2u * MODES + 1u) + 1u + j];
    let c = own[DAMPING * job.lanes + lane] * shared_numbers[SPECTRA + h * (2u * MODES + 1u) + 1u + MODES + j];
    let detuning = numbers[DETUNING * job.lanes + lane];
    let omega = REFERENCE_OMEGA + detuning;
    let re = base - k * k * detuning * (REFERENCE_OMEGA + omega);
    let im = k * omega * c;
    let size = re * re + im * im;
    // filled up: no stiffness, no mode
    let inverse = select(vec2<f32>(), vec2<f32>(re, -im) / size, base != 0.0);
    return array<vec2<f32>, 2>(inverse, vec2<f32>(-2.0 * k * k * omega, k * c));
}

// z times the amplitude x_c - i x_s, whose coefficients are (x_c, x_s).
fn turned(z: vec2<f32>, x: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(z.x * x.x + z.y * x.y, z.x * x.y - z.y * x.x);
}

// Spoils results, for tests of what follows from it.
@compute @workgroup_size(GROUP)
fn spoiled(@builtin(global_invocation_id) id: vec3<u32>) {
    numbers[at(job.x, id.y, id.x, job.lanes)] *= job.alpha;
}
