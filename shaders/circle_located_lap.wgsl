// State of one lap of the slider in the circle law with located events, the twin of aft/circle_law/lap.rs. A lap is one pass over the
// excitation period. Lengths of time count in intervals between samples.

// Row of `signals` with the tractions.
const TRACTION: u32 = 6u;
// First row with the derivatives of the steps of slip.
const STEPS: u32 = 8u;
const SIGNAL_ROWS: u32 = 14u;
const MASKS: u32 = 1u;

// A root of the gap function or an event of the slider, and the jumps of the first two derivatives of the tractions there.
struct Event {
    interval: u32,
    share: real,
    jump: vec2<real>,
    bend: vec2<real>,
}

// Ascending from phase 0. Shape: [MAX_ROOTS][state], [MAX_EVENTS][state]
@group(0) @binding(7) var<storage, read_write> roots: array<Event>;
@group(0) @binding(8) var<storage, read_write> events: array<Event>;
// Roots, events. Shape: [2][state]
@group(0) @binding(10) var<storage, read_write> counts: array<u32>;

const ROOTS_PER_STATE: u32 = MAX_ROOTS;
const EVENTS_PER_STATE: u32 = MAX_EVENTS;
const COUNTS_PER_STATE: u32 = 2u;

const ZERO: vec2<real> = vec2<real>(real(0.0), real(0.0));

// Whether events and tractions are stored, whether derivatives of forces are summed up.
var<private> stores: bool;
var<private> sums_up: bool;
var<private> sums: array<vec2<real>, M>;

// Present motion: whether the contact is open, the slider in stick, the direction of the traction in slip, and their rows.
var<private> open: bool;
var<private> slips: bool;
var<private> slider: vec2<real>;
var<private> half: HalfAngle;
var<private> slider_rows: array<Row, 2>;
var<private> angle: Row;
var<private> instant: Row;

var<private> moves: bool;
var<private> overflows: bool;
// Whether the velocity turns around in an interval between two samples.
var<private> turns: bool;
// Where the present slip began, and the longest slip of the slider.
var<private> slip_from: vec2<real>;
var<private> longest_slip: real;
var<private> n_events: u32;
// Loop iterations so far: a widespread software adapter ends loops silently after 65 535.
var<private> spent: u32;

fn spend(iterations: u32) {
    spent += iterations;
    overflows = overflows || spent > MAX_ITERATIONS;
}

fn event_at(k: u32, state: u32) -> u32 {
    return k * batch.n_states + state;
}
