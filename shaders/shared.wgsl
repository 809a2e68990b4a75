// Declarations of every pass. In front of this text stand, generated for one harmonic set and time grid:
//   alias real = f32 or f64
//   HARMONICS   orders above 0            HIGHEST   highest order         N_TIME  samples per period
//   TERMS       terms of Taylor series    STEP      2 pi / N_TIME         LAPS    passes over the period
//   MAX_POINTS, MAX_RUNS, MAX_STICKS      room per direction of a state
//   RESOLUTION  rounding of a share of an interval, and its root
//   BLOCKS      blocks of a derivative    INTERPOLATED  whether closing is located by linear interpolation
// All quantities are forces over the scale of their state: the stick signals k_t u of both directions without their
// means, and the gap function n_0 + k_n v with its mean. Arrays run over states fastest.

const GROUP: u32 = 64u;
// Force coefficients per component, and orders in the spectrum of a mask.
const M: u32 = 2u * HARMONICS + 1u;
const N_ORDERS: u32 = 2u * HIGHEST + 1u;
const TAU: real = 6.283185307179586476925287;

// Signals: directions 0 and 1, then the gap function.
const GAP: u32 = 2u;

const STICK: u32 = 0u;
const SLIP_UP: u32 = 1u;
const SLIP_DOWN: u32 = 2u;
const SEPARATED: u32 = 3u;

// What a state did, in `flags`: a direction moved, or its event did not fit into the room for them.
const MOVED: u32 = 1u;
const OVERFLOW: u32 = 2u;

struct Batch {
    n_states: u32,
}

// Instant at which a motion may change: share of the interval after a sample, signals there, whether the contact is
// open afterwards.
struct Point {
    interval: u32,
    open: u32,
    share: real,
    stick: real,
    gap: real,
}

// Stretch of one motion up to an instant; `slider` is k_t w of a stick and the source where it was set last.
struct Run {
    interval: u32,
    motion: u32,
    share: real,
    slider: real,
    source_motion: u32,
    source_interval: u32,
    source_share: real,
}

@group(0) @binding(0) var<uniform> batch: Batch;
// cos and sin of the N_TIME-th parts of a turn. Shape: [2][N_TIME]
@group(0) @binding(1) var<storage, read> circle: array<real>;
// Shape: [HARMONICS]
@group(0) @binding(2) var<storage, read> orders: array<u32>;
// Dynamic coefficients of the signals. Shape: [3][HARMONICS][cos, sin][state]
@group(0) @binding(3) var<storage, read> coefficients: array<real>;
// Friction coefficient, mean of the gap function, anchors of both directions. Shape: [4][state]
@group(0) @binding(4) var<storage, read> states: array<real>;
// Signals and their rates per interval at the samples. Shape: [6][N_TIME][state]
@group(0) @binding(5) var<storage, read_write> signals: array<real>;
// Shape: [MAX_POINTS][2][state]
@group(0) @binding(6) var<storage, read_write> points: array<Point>;
// Shape: [MAX_RUNS][2][state]
@group(0) @binding(7) var<storage, read_write> runs: array<Run>;
// Runs, and sticks with a source. Shape: [2][2][state]
@group(0) @binding(8) var<storage, read_write> counts: array<u32>;
// Spectra of masks. Shape: [mask][cos, sin][N_ORDERS][state]
@group(0) @binding(9) var<storage, read_write> spectra: array<real>;
// Per stick with a source: sums of the basis over it; basis at the source and the slider's rate by the gap function.
// Shape: [MAX_STICKS][2][2][M + 1][state]
@group(0) @binding(10) var<storage, read_write> sticks: array<real>;
// Force less that of the stuck contact. Shape: [3][M][state]
@group(0) @binding(11) var<storage, read_write> deviations: array<real>;
// Per state: flags and, where it moves, its place among those that do.
@group(0) @binding(12) var<storage, read_write> flags: array<atomic<u32>>;
@group(0) @binding(13) var<storage, read_write> slots: array<u32>;
// States that move, and their number.
@group(0) @binding(14) var<storage, read_write> moving: array<u32>;
@group(0) @binding(15) var<storage, read_write> n_moving: atomic<u32>;
// Derivatives by the signals less those of the stuck contact, of the states that move; box law: T1 by s1, T2 by s2, T1 by
// g, T2 by g, N by g; circle law: T1 by s1, T1 by s2, T2 by s1, T2 by s2, T1 by g, T2 by g, N by g.
// Shape: [slot / GROUP][BLOCKS][M][M][slot % GROUP]
@group(0) @binding(16) var<storage, read_write> tangents: array<real>;

// Elements per state of the arrays; the host reads them here.
const COEFFICIENTS_PER_STATE: u32 = 6u * HARMONICS;
const STATES_PER_STATE: u32 = 4u;
const SIGNALS_PER_STATE: u32 = 6u * N_TIME;
const POINTS_PER_STATE: u32 = 2u * MAX_POINTS;
const RUNS_PER_STATE: u32 = 2u * MAX_RUNS;
const COUNTS_PER_STATE: u32 = 4u;
const SPECTRA_PER_STATE: u32 = 14u * N_ORDERS;
const STICKS_PER_STATE: u32 = 4u * MAX_STICKS * (M + 1u);
const DEVIATIONS_PER_STATE: u32 = 3u * M;
const FLAGS_PER_STATE: u32 = 1u;
const SLOTS_PER_STATE: u32 = 1u;
const MOVING_PER_STATE: u32 = 1u;
const TANGENTS_PER_STATE: u32 = BLOCKS * M * M;

// Masks of `spectra`, the first three per direction.
const MASK_MOVED: u32 = 0u;
const MASK_SLIP: u32 = 2u;
const MASK_SLIDER: u32 = 4u;
const MASK_OPEN: u32 = 6u;

// Signal (0 to 2) or its rate (3 to 5) at a sample.
fn sample_of(c: u32, i: u32, state: u32) -> real {
    return signals[(c * N_TIME + i) * batch.n_states + state];
}

// Place of a derivative in `tangents`.
fn tangent_at(slot: u32, block: u32, a: u32, b: u32) -> u32 {
    return ((((slot / GROUP) * BLOCKS + block) * M + a) * M + b) * GROUP + slot % GROUP;
}

fn spectrum_at(mask: u32, trig: u32, order: u32, state: u32) -> u32 {
    return ((mask * 2u + trig) * N_ORDERS + order) * batch.n_states + state;
}

fn stick_at(d: u32, stick: u32, part: u32, row: u32, state: u32) -> u32 {
    return ((((stick * 2u + d) * 2u + part) * (M + 1u)) + row) * batch.n_states + state;
}

fn coefficient(c: u32, h: u32, trig: u32, state: u32) -> real {
    return coefficients[((c * HARMONICS + h) * 2u + trig) * batch.n_states + state];
}

// Entry (a, b) of the Gram matrix of the basis over a mask, per period.
fn gram(mask: u32, a: u32, b: u32, state: u32) -> real {
    let p = order_of(a);
    let q = order_of(b);
    let sine_a = a > 0u && a % 2u == 0u;
    let sine_b = b > 0u && b % 2u == 0u;
    if a == 0u || b == 0u {
        // the constant times one function of the basis
        let trig = select(0u, 1u, sine_a || sine_b);
        let value = spectra[spectrum_at(mask, trig, p + q, state)];
        return select(value + value, value, a == 0u);
    }
    let trig = select(0u, 1u, sine_a != sine_b);
    let sum = spectra[spectrum_at(mask, trig, p + q, state)];
    let distance = spectra[spectrum_at(mask, trig, select(q - p, p - q, p >= q), state)];
    if sine_a == sine_b {
        return select(distance + sum, distance - sum, sine_a);
    }
    // sin(p - q) changes its sign with its argument; cos p sin q has the opposite one
    let signed = select(-distance, distance, p >= q);
    return select(sum - signed, sum + signed, sine_a);
}

fn order_of(a: u32) -> u32 {
    if a == 0u {
        return 0u;
    }
    return orders[(a - 1u) / 2u];
}
