// Declarations of every pass. In front of this text stand, generated for one harmonic set and time grid:
//   alias real = f32 or f64
//   HARMONICS   orders above 0            HIGHEST   highest order         N_TIME  samples per period
//   TERMS       terms of Taylor series    STEP      2 pi / N_TIME         LAPS    passes over the period
//   MAX_...         capacities of a law for what a state may do over a period
//   MAX_ITERATIONS  of the loops of one invocation, where they are counted
//   RESOLUTION  rounding of a share of an interval, and its root
//   BLOCKS      blocks of a derivative    INTERPOLATED  whether closing is located by linear interpolation
// All quantities are forces over the scale of their state: the stick signals k_t u of both directions without their
// means, and the gap function n_0 + k_n v with its mean. Arrays run over states fastest.

const GROUP: u32 = 64u;
// Force coefficients per component.
const M: u32 = 2u * HARMONICS + 1u;
const TAU: real = 6.283185307179586476925287;

// Signals: directions 0 and 1, then the gap function.
const GAP: u32 = 2u;

// What a state did, in `flags`: a direction moved; the device does not decide the state, because its events do not fit into their
// array or its steady cycle was not found; its velocity turns around between two samples, where only the processor has nodes.
const MOVED: u32 = 1u;
const OVERFLOW: u32 = 2u;
const TURNS: u32 = 4u;

struct Batch {
    n_states: u32,
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
// Signals and their rates per interval at the samples, and what a law keeps there. Shape: [SIGNAL_ROWS][N_TIME][state]
@group(0) @binding(5) var<storage, read_write> signals: array<real>;
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
const SIGNALS_PER_STATE: u32 = SIGNAL_ROWS * N_TIME;
const DEVIATIONS_PER_STATE: u32 = 3u * M;
const FLAGS_PER_STATE: u32 = 1u;
const SLOTS_PER_STATE: u32 = 1u;
const MOVING_PER_STATE: u32 = 1u;
const TANGENTS_PER_STATE: u32 = BLOCKS * M * M;

// Whether a state moved and the device decides it (no OVERFLOW): then it has a derivative.
fn moved_and_fitted(state: u32) -> bool {
    return (atomicLoad(&flags[state]) & (MOVED | OVERFLOW)) == MOVED;
}

// Signal (0 to 2) or its rate (3 to 5) at a sample.
fn sample_of(c: u32, i: u32, state: u32) -> real {
    return signals[(c * N_TIME + i) * batch.n_states + state];
}

// Place of a derivative in `tangents`.
fn tangent_at(slot: u32, block: u32, a: u32, b: u32) -> u32 {
    return ((((slot / GROUP) * BLOCKS + block) * M + a) * M + b) * GROUP + slot % GROUP;
}

fn coefficient(c: u32, h: u32, trig: u32, state: u32) -> real {
    return coefficients[((c * HARMONICS + h) * 2u + trig) * batch.n_states + state];
}

fn order_of(a: u32) -> u32 {
    if a == 0u {
        return 0u;
    }
    return orders[(a - 1u) / 2u];
}
