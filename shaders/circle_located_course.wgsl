// The signals between two samples, and the events of the slider there, the twin of aft/circle_law/course.rs.

// Taylor polynomials of the signals in the interval `entered`.
var<private> polynomials: array<Polynomial, 3>;
var<private> entered: u32 = N_TIME;

// Computes the polynomials of an interval, unless they are there.
fn enter(interval: u32, state: u32) {
    if entered != interval {
        entered = interval;
        spend(3u * HARMONICS * TERMS);
        for (var c = 0u; c < 3u; c++) {
            polynomials[c] = taylor(c, interval, state);
        }
    }
}

// Value and first three derivatives of a signal in the interval `entered`.
fn signal_jet(c: u32, x: real) -> vec4<real> {
    var jet = vec4<real>(polynomials[c][TERMS - 1u], real(0.0), real(0.0), real(0.0));
    for (var t = TERMS - 1u; t > 0u; t--) {
        jet.w = jet.w * x + jet.z;
        jet.z = jet.z * x + jet.y;
        jet.y = jet.y * x + jet.x;
        jet.x = jet.x * x + polynomials[c][t - 1u];
    }
    jet.z += jet.z;
    jet.w *= real(6.0);
    return jet;
}

// The signals in the interval `entered`, without the basis function of the column.
fn trial_node(share: real) -> Node {
    let first = signal_jet(0u, share);
    let second = signal_jet(1u, share);
    let limit = mu * signal_jet(GAP, share);
    spend(3u * TERMS);
    var node = Node();
    node.interval = entered;
    node.share = share;
    node.event = true;
    node.path = vec2<real>(first.x, second.x);
    node.rate = vec2<real>(first.y, second.y);
    node.bend = vec2<real>(first.z, second.z);
    node.jerk = vec2<real>(first.w, second.w);
    node.limit = limit.x;
    node.limit_rate = limit.y;
    node.limit_bend = limit.z;
    node.limit_jerk = limit.w;
    return node;
}

// The signals in an interval.
fn event_node(interval: u32, share: real, state: u32) -> Node {
    enter(interval, state);
    var node = trial_node(share);
    if column_signal != NO_SIGNAL {
        node.wave = wave_at(interval, part_of_step(share));
    }
    return node;
}

// The signals at root k of the gap function.
fn root_node(k: u32, state: u32) -> Node {
    let root = roots[event_at(k, state)];
    var node = event_node(root.interval, root.share, state);
    node.limit = real(0.0);
    return node;
}

// An event of the slider, if `here`, as a share of its interval.
struct Found {
    share: real,
    here: bool,
}

const NOTHING: Found = Found(real(0.0), false);

// What a search looks for. TOP: where the traction of a sticking contact exceeds its limit most. START: where it reaches the limit.
// END: where slip ends.
const TOP: u32 = 0u;
const START: u32 = 1u;
const END: u32 = 2u;

// Largest error of the cubic between two nodes, as a share of its rise above the ends.
const CUBIC_ERROR: real = real(0.25);

// The function that is zero there, with its slope and curvature.
fn searched_function(what: u32, here: Node, share: real) -> vec3<real> {
    let node = trial_node(share);
    if what == END {
        let step = step_between(here, node);
        let e = after_step(half, slip_map(step)).e;
        let turning = turning_of(node, angle_rates(step, half));
        return vec3<real>(sliding(node, e), sliding_rate(node, e, turning), real(0.0));
    }
    let f = excess(node);
    return select(f, vec3<real>(f.y, f.z, real(0.0)), what == TOP);
}

// First guess, as a share of the step from `here`, of where a resting slider begins to slip. `start` and `end` are the excess at the
// ends of the step; the traction is over its limit at the second one.
fn guess_of_start(here: Node, start: vec3<real>, end: vec3<real>, width: real) -> real {
    let zero = real(0.0);
    let rates = width * vec2<real>(start.y, end.y);
    let held = tolerance * (here.limit + here.limit + tolerance);
    if here.event && start.z < zero {
        // slip ended at `here`, or the contact closed: a double zero, and a cubic or a quartic beyond it
        let fall = real(-0.5) * start.z * width * width;
        return sqrt(fall / (end.x + fall));
    }
    if start.x >= -held && start.y < zero {
        // at the limit at the start of the lap: a zero, and a parabola beyond it
        return rates.x / (rates.x - end.x);
    }
    return crossing_share(vec2<real>(start.x, end.x), rates);
}

// The event between two nodes: where the slider, which rests from `here` on, begins to slip before `next`, or where its slip ends.
// The traction has the direction `after` at `next` if slip goes on until then.
fn event_between(here: Node, next: Node, after: HalfAngle, state: u32) -> Found {
    let zero = real(0.0);
    let one = real(1.0);
    let width = share_of(next, here) - here.share;
    let start = excess(here);
    let end = excess(next);
    let least = tolerance * (next.limit + next.limit + tolerance);
    let rates = width * vec2<real>(start.y, end.y);
    var what = START;
    var guess = zero;
    if slips {
        what = END;
        let last = sliding(next, after.e);
        if last > zero {
            return NOTHING;
        }
        guess = linear_share(sliding(here, half.e), last);
    } else if end.x > least {
        guess = guess_of_start(here, start, end, width);
    } else if end.y < zero && start.y > zero {
        // inside at both ends, and perhaps not between them
        what = TOP;
        guess = turn_share(end.x - start.x, rates);
        let rest = one - guess;
        let top = rest * rest * (one + guess + guess) * start.x + guess * guess * (one + rest + rest) * end.x
            + guess * rest * (rest * rates.x - guess * rates.y);
        // where slip ended at `here` the traction falls from its limit: the cubic starts from an exact maximum
        let rise = max(top - start.x, top - end.x);
        let missed = select(CUBIC_ERROR * rise, zero, here.event);
        if top + missed <= zero {
            return NOTHING;
        }
    } else {
        return NOTHING;
    }
    enter(here.interval, state);
    var high = here.share + width;
    while true {
        var search = search_between(here.share, high, here.share + width * guess);
        let accepted = select(RESOLUTION / STEP, ROOT_OF_RESOLUTION, what == TOP);
        for (var k = 0u; k < MAX_STEPS && !search.done; k++) {
            search = searched(search, searched_function(what, here, search.x), what == START, accepted);
        }
        if what != TOP {
            return Found(search.x, true);
        }
        let highest = excess(trial_node(search.x)).x;
        if highest <= least {
            return NOTHING;
        }
        what = START;
        high = search.x;
        guess *= linear_share(start.x, highest);
    }
    return NOTHING;
}
