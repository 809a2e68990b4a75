// Steady cycle of the circle law, the twin of the search in aft/circle_law/steady_cycle.rs: one thread per state. Newton's method on the
// end tractions of a lap finds it; where it does not within a few laps, or finds one that is not unique, the state
// counts as an overflow and the processor decides. `lap_from` is that of the kind of events.

const MAX_LAPS: u32 = 40u;

// Start of the steady cycle; traction that counts as rounding; laps from the anchor whose derivative counts, 0 = that of
// the cycle.
struct Cycle {
    start: vec2<real>,
    tolerance: real,
    laps: u32,
}

@group(0) @binding(6) var<storage, read_write> cycles: array<Cycle>;

const CYCLES_PER_STATE: u32 = 1u;

// Motion of a state over one lap.
struct Lap {
    end: vec2<real>,
    // Derivative of the end traction by the start traction, row by row.
    monodromy: vec4<real>,
    // Whether anything moved the slider, and whether that was hardly more than rounding.
    moves: bool,
    rests: bool,
    // Whether the capacity for events did not suffice.
    overflows: bool,
    // Whether the velocity turns around between two samples, as the processor sees it where it has nodes there.
    turns: bool,
}

// Friction coefficient of the state, and traction that counts as rounding.
var<private> mu: real;
var<private> tolerance: real;

fn stick_signal(i: u32, state: u32) -> vec2<real> {
    return vec2<real>(sample_of(0u, i, state), sample_of(1u, i, state));
}

fn inner(a: vec2<real>, b: vec2<real>) -> real {
    return a.x * b.x + a.y * b.y;
}

fn norm(x: vec2<real>) -> real {
    return sqrt(inner(x, x));
}

// The vector a quarter turn ahead.
fn normal_to(e: vec2<real>) -> vec2<real> {
    return vec2<real>(-e.y, e.x);
}

fn identity_minus_determinant(m: vec4<real>) -> real {
    let one = real(1.0);
    return (one - m.x) * (one - m.w) - m.y * m.z;
}

// x of (I - M) x = b.
fn solve_identity_minus(m: vec4<real>, b: vec2<real>) -> vec2<real> {
    let one = real(1.0);
    let x = vec2<real>((one - m.w) * b.x + m.y * b.y, (one - m.x) * b.y + m.z * b.x);
    return x / identity_minus_determinant(m);
}

fn set_state(state: u32) {
    mu = states[state];
    var largest = vec3<real>(real(0.0), real(0.0), real(0.0));
    for (var i = 0u; i < N_TIME; i++) {
        let s = stick_signal(i, state);
        largest = max(largest, vec3<real>(abs(s.x), abs(s.y), sample_of(GAP, i, state)));
    }
    tolerance = real(128.0) * RESOLUTION * (largest.x + largest.y + mu * largest.z);
}

// The steady cycle that the march found.
fn take_cycle(state: u32) -> Cycle {
    let cycle = cycles[state];
    mu = states[state];
    tolerance = cycle.tolerance;
    return cycle;
}

fn anchor_of(state: u32) -> vec2<real> {
    return vec2<real>(states[2u * batch.n_states + state], states[3u * batch.n_states + state]);
}

fn store_traction(i: u32, state: u32, traction: vec2<real>) {
    signals[(TRACTION * N_TIME + i) * batch.n_states + state] = traction.x;
    signals[((TRACTION + 1u) * N_TIME + i) * batch.n_states + state] = traction.y;
}

fn weight(a: u32) -> real {
    return select(real(2.0), real(1.0), a == 0u) / real(N_TIME);
}

fn basis(a: u32, i: u32) -> real {
    if a == 0u {
        return real(1.0);
    }
    let phase = (order_of(a) * i) % N_TIME;
    return circle[select(phase, N_TIME + phase, a % 2u == 0u)];
}

// Direction of the rows and signal of the columns to the block: T1T1, T1T2, T2T1, T2T2, T1N, T2N.
fn block_of(d: u32, c: u32) -> u32 {
    return select(2u * d + c, 4u + d, c == GAP);
}

@compute @workgroup_size(GROUP)
fn circle_march(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = id.x;
    if state >= batch.n_states {
        return;
    }
    set_state(state);
    let first = lap_from(anchor_of(state), true, state);
    if !first.moves && !first.overflows {
        return;
    }
    var start = first.end;
    var last = real(-1.0);
    var newton = false;
    var settled = false;
    var from_anchor = false;
    var laps = 1u;
    var rests = first.rests;
    var overflows = first.overflows;
    let most = select(MAX_LAPS, LAPS, LAPS > 0u);
    while laps < most && !settled && !overflows {
        laps++;
        let lap = lap_from(start, false, state);
        rests = lap.rests;
        overflows = lap.overflows;
        let change = lap.end - start;
        let now = norm(change);
        let singular = identity_minus_determinant(lap.monodromy) <= ROOT_OF_RESOLUTION;
        from_anchor = singular;
        if LAPS > 0u {
            start = select(lap.end, start, laps == most);
            continue;
        }
        var distance = change;
        if !singular {
            distance = solve_identity_minus(lap.monodromy, change);
        }
        let failed = last >= real(0.0) && now + now > last;
        settled = norm(distance) <= tolerance || (now <= tolerance && failed);
        if settled {
            break;
        }
        if failed || singular {
            last = real(-1.0);
            start = lap.end;
        } else {
            last = now;
            newton = true;
            start += distance;
        }
    }
    let unique = !(newton && (rests || from_anchor));
    let decided = (LAPS > 0u || (settled && unique)) && !overflows;
    atomicStore(&flags[state], MOVED | select(OVERFLOW, 0u, decided) | select(0u, TURNS, first.turns));
    let slot = atomicAdd(&n_moving, 1u);
    slots[state] = slot;
    moving[slot] = state;
    cycles[state] = Cycle(start, tolerance, select(0u, laps, from_anchor || LAPS > 0u));
}
