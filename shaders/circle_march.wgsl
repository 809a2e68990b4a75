// Circle law decided at the samples, the twin of aft/circle.rs: one thread per state. Newton's method on the end tractions
// of a lap finds the steady cycle; where it does not within a few laps, or finds one that is not unique, the state counts
// as an overflow and the processor decides.

const MAX_LAPS: u32 = 40u;

// Start of the steady cycle; laps from the anchor whose derivative counts, 0 = that of the cycle.
struct Cycle {
    start: vec2<real>,
    laps: u32,
}

@group(0) @binding(6) var<storage, read_write> cycles: array<Cycle>;

const CYCLES_PER_STATE: u32 = 1u;

// Radial return, in forces: the slider's place is k_t w.
struct Step {
    traction: vec2<real>,
    slider: vec2<real>,
    direction: vec2<real>,
    ratio: real,
    slips: bool,
    touches: bool,
}

// Motion of a state over one lap.
struct Lap {
    end: vec2<real>,
    // Derivative of the end traction by the start traction, row by row.
    monodromy: vec4<real>,
    slips: bool,
    separates: bool,
    overshoot: real,
}

fn stick_signal(i: u32, state: u32) -> vec2<real> {
    return vec2<real>(sample_of(0u, i, state), sample_of(1u, i, state));
}

fn norm(x: vec2<real>) -> real {
    return sqrt(x.x * x.x + x.y * x.y);
}

fn radial_return(limit: real, margin: real, s: vec2<real>, slider: vec2<real>) -> Step {
    let trial = s - slider;
    let square = trial.x * trial.x + trial.y * trial.y;
    let inside = max(limit - margin, real(0.0));
    var step = Step(trial, slider, vec2<real>(real(0.0), real(0.0)), real(1.0), false, false);
    step.slips = square > limit * limit;
    step.touches = square > inside * inside;
    if step.touches {
        let length = sqrt(square);
        step.direction = trial / length;
        if step.slips {
            step.ratio = limit / length;
            step.traction = step.ratio * trial;
            step.slider = s - step.traction;
        }
    }
    return step;
}

// Instant of closing before a sample as a share of the interval; 0 where the contact does not close there.
fn closing(i: u32, first: bool, state: u32) -> real {
    if !INTERPOLATED || (first && i == 0u) {
        return real(0.0);
    }
    let before = sample_of(GAP, (i + N_TIME - 1u) % N_TIME, state);
    let here = sample_of(GAP, i, state);
    if before <= real(0.0) && here > real(0.0) {
        return before / (before - here);
    }
    return real(0.0);
}

// Derivative of a slip step times a matrix: ratio p p' m with p normal to the direction.
fn slid(direction: vec2<real>, ratio: real, m: vec4<real>) -> vec4<real> {
    let normal = vec2<real>(-direction.y, direction.x);
    let row = ratio * vec2<real>(normal.x * m.x + normal.y * m.z, normal.x * m.y + normal.y * m.w);
    return vec4<real>(normal.x * row.x, normal.x * row.y, normal.y * row.x, normal.y * row.y);
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

// Traction that counts as rounding.
fn rounding(mu: real, state: u32) -> real {
    var largest = vec3<real>(real(0.0), real(0.0), real(0.0));
    for (var i = 0u; i < N_TIME; i++) {
        let s = stick_signal(i, state);
        largest = max(largest, vec3<real>(abs(s.x), abs(s.y), sample_of(GAP, i, state)));
    }
    return real(128.0) * RESOLUTION * (largest.x + largest.y + mu * largest.z);
}

// One lap; the tractions go into the rows of `signals` behind the samples.
fn lap_from(start: vec2<real>, first: bool, mu: real, margin: real, state: u32) -> Lap {
    let zero = real(0.0);
    let one = real(1.0);
    var lap = Lap(start, vec4<real>(one, zero, zero, one), false, false, zero);
    for (var i = 0u; i < N_TIME; i++) {
        let s = stick_signal(i, state);
        let gap = sample_of(GAP, i, state);
        lap.end += closing(i, first, state) * (s - lap.end);
        let step = radial_return(mu * max(gap, zero), margin, s, lap.end);
        lap.end = step.slider;
        if gap <= zero {
            lap.separates = true;
            lap.monodromy = vec4<real>(zero, zero, zero, zero);
        } else {
            lap.slips = lap.slips || step.slips;
            lap.overshoot = max(lap.overshoot, one - step.ratio);
            if step.touches {
                lap.monodromy = slid(step.direction, step.ratio, lap.monodromy);
            }
        }
        signals[(3u * N_TIME + i) * batch.n_states + state] = step.traction.x;
        signals[(4u * N_TIME + i) * batch.n_states + state] = step.traction.y;
    }
    return lap;
}

@compute @workgroup_size(GROUP)
fn circle_march(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let state = id.x;
    if state >= n {
        return;
    }
    let mu = states[state];
    let tolerance = rounding(mu, state);
    let margin = tolerance + tolerance;
    let anchor = vec2<real>(states[2u * n + state], states[3u * n + state]);
    let one_lap = lap_from(anchor, true, mu, margin, state);
    if !one_lap.slips && !one_lap.separates {
        return;
    }
    var start = one_lap.end;
    var last = real(-1.0);
    var newton = false;
    var settled = false;
    var from_anchor = false;
    var laps = 1u;
    var overshoot = one_lap.overshoot;
    let most = select(MAX_LAPS, LAPS, LAPS > 0u);
    while laps < most && !settled {
        laps++;
        let lap = lap_from(start, false, mu, margin, state);
        overshoot = lap.overshoot;
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
            start += change;
        } else {
            last = now;
            newton = true;
            start += distance;
        }
    }
    let rests = newton && overshoot <= ROOT_OF_RESOLUTION;
    let decided = LAPS > 0u || (settled && !rests);
    atomicStore(&flags[state], select(MOVED | OVERFLOW, MOVED, decided));
    let slot = atomicAdd(&n_moving, 1u);
    slots[state] = slot;
    moving[slot] = state;
    // the derivative is that of the laps from the anchor, or that of the steady cycle
    cycles[state] = Cycle(start, select(0u, laps, from_anchor || LAPS > 0u));
}
